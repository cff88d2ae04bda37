//! The command line of the installed tool. `cargo xtask` has one of its own, with the same verbs and more.

use clap::{Parser, Subcommand};

use crate::web;

/// Run, check and stream G-code on a motion controller in virtual time or on a board.
#[derive(Parser)]
#[command(version, after_help = EXAMPLES)]
pub struct Cli {
    /// The verb.
    #[command(subcommand)]
    pub verb: Verb,
}

/// The verbs of the installed tool.
#[derive(Subcommand)]
#[expect(missing_docs, reason = "clap shows what is said of the arguments, where each verb is")]
pub enum Verb {
    #[command(flatten)]
    Shared(crate::Verb),
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
  isostep profile --help               speed profiles: a table, every step as CSV, curves over time
  isostep papers                       what the papers print beside what comes out here
  isostep times parts grbl.csv         how long programs take, beside Grbl's times for them
  isostep homing                       how well homing finds the same place again
  isostep swarm                        random machines, programs and faults: none may break a promise

Building the firmware and flashing a board needs the sources: cargo xtask --help.";
