//! The random cases that the tests try: a few when a person runs the tests, more in CI, and all of them in `cargo xtask test --all`.
//!
//! They begin at a number that stands in `.cargo/config.toml`, and that every change of importance raises: so the tests go
//! on to cases that nobody has tried. Proptest reads it too. A test that fails prints the line that repeats it.

use std::env;
use std::ops::Range;
use std::thread;

/// The amount of cases: `more` or `all`. Without it few are tried.
pub const AMOUNT_VARIABLE: &str = "ISOSTEP_CASES";
/// The number from which the cases follow.
const WINDOW_VARIABLE: &str = "PROPTEST_RNG_SEED";

/// The share of the cases of CI that are few.
const FEW: u32 = 8;

/// How many cases are tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Amount {
    /// As many as a person likes to wait for: an eighth of those of CI.
    Few,
    /// Those of CI.
    More,
    /// All.
    All,
}

impl Amount {
    /// The amount of this run.
    ///
    /// # Errors
    /// What to set the variable to, when it is something else.
    pub fn of_run() -> Result<Self, String> {
        match env::var(AMOUNT_VARIABLE).as_deref() {
            Err(_) | Ok("") => Ok(Self::Few),
            Ok("more") => Ok(Self::More),
            Ok("all") => Ok(Self::All),
            Ok(text) => Err(format!("{AMOUNT_VARIABLE} is {text}: give more or all, or nothing for a few")),
        }
    }

    /// The value of the variable for this amount.
    #[must_use]
    pub const fn value(self) -> &'static str {
        match self {
            Self::Few => "",
            Self::More => "more",
            Self::All => "all",
        }
    }

    const fn cases(self, more: u32, all: u32) -> u32 {
        match self {
            Self::Few => more.div_ceil(FEW),
            Self::More => more,
            Self::All => all,
        }
    }
}

/// The number of cases that a test tries: `more` in CI, an eighth of them when a person runs it, or `all`.
#[must_use]
pub fn cases(more: u32, all: u32) -> u32 {
    assert!(more <= all, "{more} of {all} cases");
    // The harness shows it if the test fails.
    println!("again: {}", again());
    amount().cases(more, all)
}

/// The number of cases of a test that counts what it has met, and needs `least` for that, whoever runs it; or `all`.
#[must_use]
pub fn cases_that_count(least: u32, all: u32) -> u32 {
    cases(least, all).max(least)
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

/// From one case of a sweep to the next that a test tries: `more` in CI, twice as far when a person runs it, or 1 if all are tried.
#[must_use]
pub fn stride(more: usize) -> usize {
    match amount() {
        Amount::Few => 2 * more,
        Amount::More => more,
        Amount::All => 1,
    }
}

/// The amount of this run, which a test cannot do without.
fn amount() -> Amount {
    Amount::of_run().unwrap_or_else(|why| panic!("{why}"))
}

fn window_number() -> u64 {
    let text = env::var(WINDOW_VARIABLE).unwrap_or_else(|_| "0".to_owned());
    text.parse().unwrap_or_else(|_| panic!("{WINDOW_VARIABLE} is {text}: give a whole number"))
}

/// The command that tries the same cases of this test. The harness names a test's thread after it, and cargo says which package
/// it tests.
fn again() -> String {
    let package = env::var("CARGO_PKG_NAME").unwrap_or_default();
    let amount = match amount() {
        Amount::Few => String::new(),
        amount => format!("{AMOUNT_VARIABLE}={} ", amount.value()),
    };
    let thread = thread::current();
    let test = thread.name().unwrap_or_default();
    format!("{amount}{WINDOW_VARIABLE}={} cargo test -p {package} -- --exact {test}", window_number())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_is_repeated_by_the_line_that_it_prints() {
        let amount = match amount() {
            Amount::Few => "",
            Amount::More => "ISOSTEP_CASES=more ",
            Amount::All => "ISOSTEP_CASES=all ",
        };
        let seed = window_number();
        let test = "tests::a_failure_is_repeated_by_the_line_that_it_prints";
        assert_eq!(again(), format!("{amount}PROPTEST_RNG_SEED={seed} cargo test -p isostep-trials -- --exact {test}"));
    }

    #[test]
    fn a_person_waits_for_an_eighth_of_the_cases_of_ci_and_for_one_at_least() {
        let of = |more, all| [Amount::Few, Amount::More, Amount::All].map(|amount| amount.cases(more, all));
        assert_eq!([of(0, 1), of(1, 2), of(500, 10_000)], [[0, 0, 1], [1, 1, 2], [63, 500, 10_000]]);
    }

    #[test]
    fn windows_follow_each_other() {
        assert_eq!(window(100_u32), 100 * window_number()..100 * (window_number() + 1));
    }
}
