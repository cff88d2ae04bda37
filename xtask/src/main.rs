//! The commands of the project, run as `cargo xtask VERB`. Each verb that needs the sources has a file or folder:
//! build, flash, emulate, test and others. `bench` is in the package `isostep-bench`, and the other verbs are in the package `isostep`. `workspace`,
//! `toolchain`, `other_chip`, `publish`, `tools`, `node`, `python`, `oracle`, `firmware`, `board_words`, `footprint`, `uf2`, `variant`, `process` and `cpu` are
//! shared by the verbs.

// All modules print with its macros.
#[macro_use]
extern crate isostep;

mod audit;
mod bench;
mod board_words;
mod build;
#[cfg(unix)]
mod clients;
#[cfg(test)]
mod commands;
mod cpu;
mod dist;
mod emulate;
mod firmware;
mod flash;
mod footprint;
mod fuzz;
mod hot;
mod lint;
mod mutants;
mod oldest;
mod oracle;
mod other_chip;
mod prove;
mod publish;
mod python;
mod setup;
mod size;
mod test;
mod toolchain;
mod tools;
mod uf2;
mod variant;
#[cfg(unix)]
mod vfd;
mod web;
mod workspace;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use xtask_first::{node, process};

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
  cargo xtask dist                                       UF2 files for others, with checksums and licences
  cargo xtask emulate programs/parking.nc --trace b.csv  run a program on the emulated board
  cargo xtask sim --pty                                  a machine without hardware, for any sender of G-code
  cargo xtask web                                        a page with that machine, for any browser
  cargo xtask console                                    talk to the board, or to that machine
  cargo xtask prove                                      measure this very board, beside the emulated one
  cargo xtask test --fast                                host tests only
  cargo xtask test                                       every test, the emulated board included; --all: what a release needs too
  cargo xtask bench --quick                              rates, edge errors, load and stops of the step ports
  cargo xtask profile --help                             speed profiles: a table, every step as CSV, curves over time
  cargo xtask papers                                     what the papers print beside what comes out here
  cargo xtask swarm                                      random machines, programs and faults: none may break a promise
  cargo xtask times parts grbl.csv                       how long programs take, beside Grbl's times for them
  cargo xtask homing                                     how well homing finds the same place again
  cargo xtask fuzz console --minutes 10                  look for bytes that break the console
  cargo xtask mutants console --sample 20                see whether the tests notice 20 wrong consoles

Every verb prepares what it needs by itself; `cargo xtask setup` does only that.";

#[derive(Subcommand)]
enum Verb {
    /// Those of the installable tool.
    #[command(flatten)]
    Tool(isostep::Verb),
    Setup(setup::Args),
    Build(build::Args),
    Flash(flash::Args),
    Size(size::Args),
    Dist(dist::Args),
    Emulate(emulate::Args),
    Test(test::Args),
    Bench(bench::Args),
    Lint(lint::Args),
    Audit(audit::Args),
    Fuzz(fuzz::Args),
    Mutants(mutants::Args),
    Web(web::Args),
}

fn main() -> ExitCode {
    let cli = match isostep::name::parse::<Cli>("cargo xtask") {
        Ok(cli) => cli,
        Err(code) => return code,
    };
    isostep::exit(match cli.verb {
        Verb::Setup(args) => setup::run(args),
        Verb::Build(args) => build::run(args),
        Verb::Flash(args) => flash::run(args),
        Verb::Size(args) => size::run(args),
        Verb::Dist(args) => dist::run(args),
        Verb::Emulate(args) => emulate::run(args),
        Verb::Test(args) => test::run(args),
        Verb::Bench(args) => bench::run(args),
        Verb::Lint(args) => lint::run(args),
        Verb::Audit(args) => audit::run(args),
        Verb::Fuzz(args) => fuzz::run(args),
        Verb::Mutants(args) => mutants::run(args),
        Verb::Web(args) => web::run(args),
        // It needs images, which this can build.
        Verb::Tool(isostep::Verb::Prove(args)) => prove::run(args),
        Verb::Tool(verb) => verb.run(),
    })
}
