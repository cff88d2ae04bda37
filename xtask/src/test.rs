//! `cargo xtask test`: runs all tests, the fast ones first.

use std::process::Command;

use anyhow::{Result, anyhow};

#[cfg(unix)]
use crate::clients::{cncjs, grbl_streamer, missing};
use crate::footprint::Footprint;
use crate::process::{self, announce};
use crate::toolchain::cargo;
use crate::variant::{Driver, Port, Variant};
use crate::{build, node, workspace};
use isostep::stopwatch::Stopwatch;

/// Run the tests: host, emulator, firmware size, emulated board, real senders
#[derive(clap::Args)]
#[command(after_help = "\
The stages stop at the first that fails:
  host tests       unit, property and end-to-end tests in virtual time
  emulator tests   the emulated board's own, and the step program on it as on a published emulator
  firmware         its build, and its size budgets
  emulated board   the firmware, unmodified, in an emulated RP2040
  real senders     grbl-streamer from PyPI streams programs to the simulated machine and to the emulated board, as over a
                   serial port, with a laser and a spindle too; skipped without Python 3, unless --senders asks for it

Examples:
  cargo xtask test --all                 every random case, not a few of each kind
  cargo xtask test --fast                the host tests alone
  cargo xtask test --senders             the real senders alone
  cargo xtask test --senders --cncjs     with cncjs, of which 230 MB are installed into target/clients")]
pub struct Args {
    /// All random cases, of which otherwise a few are tried
    #[arg(long)]
    all: bool,
    /// Only the host tests
    #[arg(long)]
    fast: bool,
    /// Only the real senders
    #[arg(long, conflicts_with = "fast")]
    senders: bool,
    /// cncjs from npm too, after the others
    #[arg(long)]
    cncjs: bool,
}

type Stage = (&'static str, fn(Cases) -> Result<()>);

/// How many random cases are tried.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Cases {
    Few,
    All,
}

impl Cases {
    /// `cargo test` that tries so many.
    fn cargo_test(self) -> Command {
        let mut tests = cargo("test");
        if self == Self::All {
            tests.env(isostep_trials::ALL_VARIABLE, "1");
        }
        tests
    }
}

/// This is the only stage that needs more than Rust and Node.
const SENDERS: Stage = ("real senders", senders);

const STAGES: [Stage; 5] = [
    ("host tests", host),
    ("emulator tests", emulator),
    ("firmware", firmware),
    ("emulated board", emulated_board),
    SENDERS,
];

pub fn run(args: Args) -> Result<()> {
    let stages = match args {
        Args { fast: true, .. } => &STAGES[..1],
        Args { senders: true, .. } => &STAGES[STAGES.len() - 1..],
        Args { .. } => &STAGES[..],
    };
    let more: &[Stage] = if args.cncjs { &[("cncjs", |_| cncjs())] } else { &[] };
    let cases = if args.all { Cases::All } else { Cases::Few };
    let mut summary = String::new();
    let mut failure = None;
    for (name, stage) in stages.iter().chain(more) {
        if failure.is_some() {
            summary += &format!("{name:<16} not run\n");
            continue;
        }
        if *name == SENDERS.0
            && !args.senders
            && let Some(remedy) = missing()
        {
            summary += &format!("{name:<16} skipped: {remedy}\n");
            continue;
        }
        announce(name);
        let stopwatch = Stopwatch::start();
        let outcome = stage(cases);
        let verdict = if outcome.is_ok() { "ok" } else { "FAILED" };
        summary += &format!("{name:<16} {verdict:<8}{:>6.1} s\n", stopwatch.elapsed_s());
        failure = outcome.err().map(|error| anyhow!("{name}: {error:#}"));
    }
    print!("\n{summary}");
    failure.map_or(Ok(()), Err)
}

fn host(cases: Cases) -> Result<()> {
    process::run(&mut cases.cargo_test())?;
    // What a firmware without them has, see `Variant`. Tests that need these laws are not built.
    let crates = ["profile", "motion", "console", "controller"].map(|name| format!("--package=isostep-{name}"));
    process::run(cases.cargo_test().args(crates).args([
        "--no-default-features",
        "--lib",
        "--test=dialect",
        "--test=examples",
    ]))
}

fn emulator(cases: Cases) -> Result<()> {
    node::prepare()?;
    process::run(&mut node::npm("test"))?;
    // These tests are ignored by a plain `cargo test`, which must work without Node.
    process::run(cases.cargo_test().args(["--package", "isostep-tests", "--test", "step_program", "--", "--ignored"]))
}

/// The firmware with the other step port, tested like the default one.
const TIMER_PORT_ELF: &str = "timer-port";
const TIMER_PORT: Variant = Variant { port: Port::Timer, driver: Driver::Drv8825, without_paper_laws: false };

fn firmware(_: Cases) -> Result<()> {
    build::kept_firmware(TIMER_PORT, TIMER_PORT_ELF)?;
    let footprint = Footprint::new(&build::firmware(Variant::default())?);
    print!("{}", footprint.table());
    footprint.check()
}

fn emulated_board(cases: Cases) -> Result<()> {
    // These tests are ignored by a plain `cargo test`, which must work without Node and does not build firmware.
    let mut tests = cases.cargo_test();
    tests.env("ISOSTEP_ELF", workspace::firmware_elf());
    tests.env("ISOSTEP_TIMER_PORT_ELF", build::kept_elf(TIMER_PORT_ELF));
    process::run(tests.args(["--package", "isostep-tests", "--test", "emulated", "--", "--ignored"]))
}

fn senders(_: Cases) -> Result<()> {
    grbl_streamer()
}

/// Does nothing: real senders need the machine on a pseudo-terminal.
#[cfg(not(unix))]
fn grbl_streamer() -> Result<()> {
    announce("none: Windows has no pseudo-terminals");
    Ok(())
}

#[cfg(not(unix))]
fn missing() -> Option<&'static str> {
    None
}

#[cfg(not(unix))]
use grbl_streamer as cncjs;
