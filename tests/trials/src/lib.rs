//! How many random cases the tests try: a few in every run of the tests, and all of them in `cargo xtask test --all`.

use std::env;

/// When it is set, all cases are tried.
pub const ALL_VARIABLE: &str = "ISOSTEP_ALL_CASES";

/// How many cases a test tries: `few`, or `all` in a run that tries all of them.
#[must_use]
pub fn cases(few: u32, all: u32) -> u32 {
    assert!(few <= all, "{few} of {all} cases");
    if is_all() { all } else { few }
}

/// From one case of a sweep to the next that a test tries: `few`, or 1 in a run that tries all of them.
#[must_use]
pub fn stride(few: usize) -> usize {
    if is_all() { 1 } else { few }
}

fn is_all() -> bool {
    env::var_os(ALL_VARIABLE).is_some()
}
