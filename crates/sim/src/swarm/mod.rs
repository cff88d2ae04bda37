//! A swarm of worlds: random machines, programs and faults, each from one seed, and what must be true in all of them.
//!
//! # Design
//! A seed makes a [`Scenario`]: a machine, and acts one after the other, on the whole controller with its consoles. While they are
//! carried out the world is looked at, and when all faults have gone the machine is led on to where it moves again: what can be
//! resumed must be resumable. What is not as it must be is a [`Failure`]. A failure is made small by leaving out acts, as long as the
//! same goes wrong; the seed and the acts that are kept say all of it, in one line.

mod judge;
mod lines;
mod runner;
mod scenario;
mod shrink;

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};

use self::runner::Runner;
pub use self::scenario::{Act, Scenario};
pub use self::shrink::shrink;

/// What was not as it must be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// The promise that was not kept: failures of one kind are told alike.
    pub promise: &'static str,
    /// What was found instead.
    pub found: String,
    /// The act after which it was found, an index.
    pub act: Option<usize>,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.promise, self.found)
    }
}

/// How much was simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Amount {
    /// Virtual time, ns.
    pub virtual_ns: u64,
    /// Faults that came: of switches, links, power, motors, the processor; and stops, resets and stimuli between critical sections.
    pub faults: u64,
    /// Lines sent.
    pub lines: u64,
    /// Steps made.
    pub steps: u64,
    /// Critical sections at whose ends tasks may have been interrupted.
    pub sections: u64,
}

impl Amount {
    /// Both together.
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

/// Carries out a scenario.
///
/// # Errors
/// What was not as it must be, first; a panic of the controller's is a failure, too.
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
