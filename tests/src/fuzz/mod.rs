//! What the fuzzers in `fuzz/` do with bytes. The test `corpus` does the same with the bytes that are kept of them.
//!
//! A target takes whatever bytes there are, and panics where something that must hold does not.

pub mod console;
pub mod machine;
pub mod planner;
pub mod store;

/// What is done with bytes.
pub type Target = fn(&[u8]);

/// Every target, by the name of its fuzzer and of its folder of `fuzz/corpus`.
pub const TARGETS: [(&str, Target); 4] =
    [("console", console::run), ("store", store::run), ("planner", planner::run), ("machine", machine::run)];
