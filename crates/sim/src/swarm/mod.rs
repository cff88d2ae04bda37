//! A swarm of worlds: random machines, programs and faults, each from one seed, and what must be true in all of them.
//!
//! # Design
//! A seed makes a [`Scenario`]: a machine and a sequence of acts on the whole controller with its consoles. While the
//! acts are executed, the world is checked. When all faults have ended, the machine is brought to where it moves again,
//! because it must always be possible to resume. Anything that is not as it must be is a [`Failure`]. A failure is
//! reduced by leaving out acts as long as the same promise is broken. The seed and the remaining acts describe the
//! failure completely, in one line.

mod drivers;
pub mod judge;
mod lines;
mod random;
mod reset;
mod runner;
mod scenario;
mod shrink;
mod talk;

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};

pub use self::drivers::Failing;
use self::runner::Runner;
pub use self::scenario::{Act, Scenario};
pub use self::shrink::shrink;

/// A broken promise.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// The promise. Failures of one kind have the same text.
    pub promise: &'static str,
    /// What was found instead.
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

#[cfg(test)]
mod tests;
