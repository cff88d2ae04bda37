//! The binary. It only parses the arguments and runs a verb of the library.

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use isostep::{exit, name, web};

/// Run, check and stream G-code on a motion controller in virtual time or on a board.
#[derive(Parser)]
#[command(version, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    #[command(flatten)]
    Shared(isostep::Verb),
    Web(web::Args),
}

const EXAMPLES: &str = "\
Examples:
  isostep sim my.nc --report report    run a program in virtual time, with pictures
  isostep check my.nc                  what would become of a program; nothing moves
  isostep sim --pty                    a machine without hardware, for any sender of G-code
  isostep console                      talk to the board, or to that machine
  isostep web --port                   a page to operate the board, and to try programs
  isostep prove                        measure this very board, beside the emulated one
  isostep profile --help               speed laws: a table, every step as CSV, curves over time
  isostep papers                       what the papers print beside what comes out here
  isostep times parts grbl.csv         how long programs take, beside Grbl's times for them
  isostep homing                       how well homing finds the same place again
  isostep swarm                        random machines, programs and faults: none may break a promise

Building the firmware and flashing a board needs the sources: cargo xtask --help.";

fn main() -> ExitCode {
    name::parse::<Cli>(name::BINARY).map_or_else(
        |code| code,
        |cli| {
            exit(match cli.verb {
                Verb::Shared(verb) => verb.run(),
                Verb::Web(args) => web::run(args),
            })
        },
    )
}
