//! A swarm of worlds: random machines, programs and faults, each from one seed, and what must be true in all of them.
//!
//! # Design
//! A seed makes a [`Scenario`]: a machine and a sequence of acts on the whole controller with its consoles. While the
//! acts are executed, the world is checked. When all faults have ended, the machine is brought to where it moves again,
//! because it must always be possible to resume. Anything that is not as it must be is a [`Failure`]. A failure is
//! reduced by leaving out acts as long as the same promise is broken. The seed and the remaining acts describe the
//! failure completely, in one line.

mod drivers;
mod drives;
pub mod judge;
mod lines;
mod reset;
mod runner;
mod scenario;
mod spindle;
mod talk;
mod vfd;

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};

use oorandom::Rand64;

pub use self::drivers::Failing;
use self::runner::Runner;
pub use self::scenario::{Act, Scenario};

/// The largest number of runs of a scenario to reduce a failure.
const RUNS_MAX: u32 = 300;

/// A broken promise.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// The promise. Failures of one kind have the same text.
    pub promise: &'static str,
    /// The observation instead.
    pub found: String,
    /// Index of the act after which it was found.
    pub act: Option<usize>,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.promise, self.found)
    }
}

/// The amount that was simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Amount {
    /// Virtual time, ns.
    pub virtual_ns: u64,
    /// Number of faults: of switches, links, power, motors and the processor; and stops, resets and stimuli between
    /// critical sections.
    pub faults: u64,
    /// Lines sent.
    pub lines: u64,
    /// Steps made.
    pub steps: u64,
    /// Critical sections at whose ends an interruption was possible.
    pub sections: u64,
}

impl Amount {
    /// The sum of both.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            virtual_ns: self.virtual_ns + other.virtual_ns,
            faults: self.faults + other.faults,
            lines: self.lines + other.lines,
            steps: self.steps + other.steps,
            sections: self.sections + other.sections,
        }
    }
}

/// Executes a scenario.
///
/// # Errors
/// The first failure. A panic of the controller is a failure too.
pub fn run(scenario: &Scenario) -> Result<Amount, Failure> {
    match catch_unwind(AssertUnwindSafe(|| Runner::new(scenario).run())) {
        Ok(result) => result,
        Err(panic) => {
            let words = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
            Err(Failure { promise: "no panic", found: words.unwrap_or("a panic").to_owned(), act: None })
        }
    }
}

/// Reduces a failure: the smallest set of acts found, by index, that breaks the same promise as all acts together.
#[must_use]
pub fn shrink(scenario: &Scenario, failure: &Failure) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..failure.act.map_or(scenario.acts.len(), |act| act + 1)).collect();
    let mut runs = 0;
    let mut breaks = |kept: &[usize]| {
        runs += 1;
        let again = run(&scenario.keeping(kept));
        (runs, again.is_err_and(|other| other.promise == failure.promise))
    };
    if !breaks(&kept).1 {
        // The failure needs acts that come after the one at which it was found.
        kept = (0..scenario.acts.len()).collect();
    }
    let mut size = kept.len().div_ceil(2);
    while size > 0 {
        let mut from = 0;
        let before = kept.len();
        while from < kept.len() {
            let without: Vec<_> = kept[..from].iter().chain(kept.iter().skip(from + size)).copied().collect();
            match breaks(&without) {
                (RUNS_MAX.., _) => return kept,
                (_, true) => kept = without,
                (_, false) => from += size,
            }
        }
        // With single acts, repeat until none can be left out.
        size = if size == 1 && kept.len() < before { 1 } else { size / 2 };
    }
    kept
}

/// Random numbers in the forms that a scenario needs.
struct Random(Rand64);

impl Random {
    fn below(&mut self, end: u64) -> u64 {
        self.0.rand_range(0..end)
    }

    /// True in one of `cases` cases.
    fn one_in(&mut self, cases: u64) -> bool {
        self.below(cases) == 0
    }

    fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len() as u64) as usize]
    }

    /// A number from `least` to `most`, with a logarithmic distribution.
    fn between(&mut self, least: f64, most: f64) -> f64 {
        least * (most / least).powf(self.0.rand_float())
    }
}

#[cfg(test)]
mod tests;
