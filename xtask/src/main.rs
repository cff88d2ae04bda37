//! The commands of the project, run as `cargo xtask VERB`. One file per verb; `screen`, `files`, `workspace`, `toolchain`, `tools`,
//! `node`, `firmware`, `flight`, `footprint`, `laws`, `pace`, `parallel`, `remarks`, `uf2`, `variant`, `process`, `stopwatch` and
//! `timing` are what the verbs share.

// First, as its macros are what all of them print with.
#[macro_use]
mod screen;

mod audit;
mod bench;
mod build;
mod check;
#[cfg(unix)]
mod clients;
mod console;
mod emulate;
mod files;
mod firmware;
mod flash;
mod flight;
mod footprint;
mod fuzz;
mod homing;
mod laws;
mod lint;
mod mutants;
mod node;
mod pace;
mod papers;
mod parallel;
mod process;
mod profile;
mod pty;
mod remarks;
mod setup;
mod sim;
mod size;
mod stopwatch;
mod swarm;
mod test;
mod times;
mod timing;
mod toolchain;
mod tools;
mod touch;
mod uf2;
mod variant;
mod workspace;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Build, flash, run and test Isostep.
#[derive(Parser)]
#[command(bin_name = "cargo xtask", after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

const EXAMPLES: &str = "\
Examples:
  cargo xtask sim programs/parking.nc --report report    run a program in virtual time, with pictures
  cargo xtask check my.nc                                what would become of a program; nothing moves
  cargo xtask build                                      firmware as ELF and UF2, and its sizes
  cargo xtask flash                                      put it on a Pico
  cargo xtask emulate programs/parking.nc --trace b.csv  run a program on the emulated board
  cargo xtask sim --pty                                  a machine without hardware, for any sender of G-code
  cargo xtask console                                    talk to the board, or to that machine
  cargo xtask test --fast                                host tests only
  cargo xtask test                                       everything, the emulated board included
  cargo xtask bench --quick                              rates, edge errors, load and stops of the step ports
  cargo xtask profile --help                             speed laws: a table, every step as CSV, curves over time
  cargo xtask papers                                     what the papers print beside what comes out here
  cargo xtask swarm                                      random machines, programs and faults: none may break a promise
  cargo xtask times parts grbl.csv                       how long programs take, beside Grbl's times for them
  cargo xtask homing                                     how well homing finds the same place again
  cargo xtask fuzz console --minutes 10                  look for bytes that break the console
  cargo xtask mutants console --sample 20                see whether the tests notice 20 wrong consoles

Every verb prepares what it needs by itself; `cargo xtask setup` does only that.";

#[derive(Subcommand)]
enum Verb {
    Setup(setup::Args),
    Build(build::Args),
    Flash(flash::Args),
    Size(size::Args),
    Sim(sim::Args),
    Check(check::Args),
    Emulate(emulate::Args),
    Console(console::Args),
    Test(test::Args),
    Bench(bench::Args),
    Profile(profile::Args),
    Papers(papers::Args),
    Times(times::Args),
    Swarm(swarm::Args),
    Homing(homing::Args),
    Lint(lint::Args),
    Audit(audit::Args),
    Fuzz(fuzz::Args),
    Mutants(mutants::Args),
}

fn main() -> ExitCode {
    let outcome = match Cli::parse().verb {
        Verb::Setup(args) => setup::run(args),
        Verb::Build(args) => build::run(args),
        Verb::Flash(args) => flash::run(args),
        Verb::Size(args) => size::run(args),
        Verb::Sim(args) => sim::run(args),
        Verb::Check(args) => check::run(args),
        Verb::Emulate(args) => emulate::run(args),
        Verb::Console(args) => console::run(args),
        Verb::Test(args) => test::run(args),
        Verb::Bench(args) => bench::run(args),
        Verb::Profile(args) => profile::run(args),
        Verb::Papers(args) => papers::run(args),
        Verb::Times(args) => times::run(args),
        Verb::Swarm(args) => swarm::run(args),
        Verb::Homing(args) => homing::run(args),
        Verb::Lint(args) => lint::run(args),
        Verb::Audit(args) => audit::run(args),
        Verb::Fuzz(args) => fuzz::run(args),
        Verb::Mutants(args) => mutants::run(args),
    };
    // Not `fn main() -> Result`: that prints a backtrace where RUST_BACKTRACE is set, which no user of a tool wants.
    match outcome.and_then(|()| screen::finish()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
