//! The tool that users of Isostep run on a computer: programs on a machine in virtual time, a terminal for a board,
//! speed profiles and the papers' figures. The binary `isostep` only calls this library; `cargo xtask` offers the same
//! verbs.
//!
//! Each verb of [`Verb`] has a file or folder. The other modules are shared by the verbs.

// Declared first, because all other modules print with its macros.
#[macro_use]
pub mod screen;

pub mod boot_loader;
pub mod check;
pub mod chip;
pub mod cli;
pub mod console;
pub mod files;
pub mod flight;
pub mod homing;
pub mod measure;
pub mod name;
pub mod papers;
pub mod parallel;
pub mod profile;
pub mod profile_options;
mod project;
pub mod prove;
pub mod pty;
pub mod sim;
pub mod stopwatch;
pub mod swarm;
pub mod times;
pub mod web;

use std::process::ExitCode;

use anyhow::Result;
use clap::Subcommand;

/// The verbs that need no sources of the firmware; but for [`web`], which `cargo xtask` has with a page that it builds.
#[derive(Subcommand)]
#[expect(missing_docs, reason = "clap shows what is said of the arguments, where each verb is")]
pub enum Verb {
    Sim(Box<sim::Args>),
    Check(check::Args),
    Console(console::Args),
    Prove(prove::Args),
    Profile(profile::Args),
    Papers(papers::Args),
    Times(times::Args),
    Homing(homing::Args),
    Swarm(swarm::Args),
}

impl Verb {
    /// Runs the verb. Results go to the standard output and to the files named in the arguments.
    ///
    /// # Errors
    /// An error's text says what went wrong and what to do about it.
    pub fn run(self) -> Result<()> {
        match self {
            Self::Sim(args) => sim::run(*args),
            Self::Check(args) => check::run(args),
            Self::Console(args) => console::run(args),
            Self::Prove(args) => prove::run(args),
            Self::Profile(args) => profile::run(args),
            Self::Papers(args) => papers::run(args),
            Self::Times(args) => times::run(args),
            Self::Homing(args) => homing::run(args),
            Self::Swarm(args) => swarm::run(args),
        }
    }
}

/// Prints a verb's error, if any, and returns the exit code of the process. `fn main() -> Result` is not used because
/// it prints a backtrace when `RUST_BACKTRACE` is set, which users of a tool do not need.
pub fn exit(outcome: Result<()>) -> ExitCode {
    match outcome.and_then(|()| screen::finish()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{}", name::as_called(&format!("error: {error:#}")));
            ExitCode::FAILURE
        }
    }
}
