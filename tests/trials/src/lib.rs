//! The random cases that the tests try: a few in every run of the tests, and all of them in `cargo xtask test --all`.
//!
//! They begin at a number that stands in `.cargo/config.toml`, and that every change of importance raises: so the tests go
//! on to cases that nobody has tried. Proptest reads it too. A test that fails prints the line that repeats it.

use std::env;
use std::ops::Range;
use std::thread;

/// When it is set, all cases are tried.
pub const ALL_VARIABLE: &str = "ISOSTEP_ALL_CASES";
/// The number from which the cases follow.
const WINDOW_VARIABLE: &str = "PROPTEST_RNG_SEED";

/// The number of cases that a test tries: `few`, or `all` in a run that tries all of them.
#[must_use]
pub fn cases(few: u32, all: u32) -> u32 {
    assert!(few <= all, "{few} of {all} cases");
    // The harness shows it if the test fails.
    println!("again: {}", again());
    if is_all() { all } else { few }
}

/// The numbers of `count` cases: of the window 2 of 100 they are 200 to 299.
///
/// # Panics
/// When the number of the window is none.
#[must_use]
pub fn window(count: impl Into<u64>) -> Range<u64> {
    let count = count.into();
    let first = window_number() * count;
    first..first + count
}

/// From one case of a sweep to the next that a test tries: `few`, or 1 in a run that tries all of them.
#[must_use]
pub fn stride(few: usize) -> usize {
    if is_all() { 1 } else { few }
}

fn is_all() -> bool {
    env::var_os(ALL_VARIABLE).is_some()
}

fn window_number() -> u64 {
    let text = env::var(WINDOW_VARIABLE).unwrap_or_else(|_| "0".to_owned());
    text.parse().unwrap_or_else(|_| panic!("{WINDOW_VARIABLE} is {text}: give a whole number"))
}

/// The command that tries the same cases of this test. The harness names a test's thread after it, and cargo says which package
/// it tests.
fn again() -> String {
    let package = env::var("CARGO_PKG_NAME").unwrap_or_default();
    let all = if is_all() { format!("{ALL_VARIABLE}=1 ") } else { String::new() };
    let thread = thread::current();
    let test = thread.name().unwrap_or_default();
    format!("{all}{WINDOW_VARIABLE}={} cargo test -p {package} -- --exact {test}", window_number())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_is_repeated_by_the_line_that_it_prints() {
        let all = if is_all() { "ISOSTEP_ALL_CASES=1 " } else { "" };
        let seed = window_number();
        let test = "tests::a_failure_is_repeated_by_the_line_that_it_prints";
        assert_eq!(again(), format!("{all}PROPTEST_RNG_SEED={seed} cargo test -p isostep-trials -- --exact {test}"));
    }

    #[test]
    fn windows_follow_each_other() {
        assert_eq!(window(100_u32), 100 * window_number()..100 * (window_number() + 1));
    }
}
