//! The targets of the fuzzers in `tests/fuzz`. The test `corpus` runs the same targets with the stored inputs.
//!
//! A target accepts any bytes, and panics when something that must hold does not.

pub mod console;
pub mod machine;
pub mod planner;
pub mod store;

/// A function that checks some bytes.
pub type Target = fn(&[u8]);

/// Every target, with the name of its fuzzer and of its folder in `tests/fuzz/corpus`.
pub const TARGETS: [(&str, Target); 5] = [
    ("console", console::run),
    ("store", store::run),
    ("planner", planner::run),
    ("blends", planner::run_bent),
    ("machine", machine::run),
];
