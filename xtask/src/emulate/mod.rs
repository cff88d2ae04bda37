//! `cargo xtask emulate`: runs a G-code program on the firmware in an emulated RP2040 or RP2350.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use isostep_controller::least_times;
use isostep_report::compare::{self, Comparison, Jitter, MoveComparison};
use isostep_sim::Config;
use isostep_sim::measure::stray_max_ns;
use isostep_sim::program::Program;

use crate::process::{self, announce};
use crate::variant::{Port, Variant};
use crate::{build, node, workspace};
use isostep::chip::Chip;
use isostep::files::Files;
use isostep::profile_options::ProfileOptions;
use isostep::pty;

#[cfg(unix)]
use isostep::pty::Emulated;

const EXAMPLES: &str = "\
The firmware is the one that `build` makes, unmodified; its STEP edges move carriages that close its switches.

Examples:
  cargo xtask emulate programs/parking.nc --trace b.csv
  cargo xtask emulate programs/parking.nc --port timer      steps by the processor instead of PIO and DMA
  cargo xtask emulate programs/parking.nc --board pico2     a Pico 2
  cargo xtask emulate programs/square.nc --console uart --start 10,20,5
  cargo xtask emulate programs/parking.nc --switch X=stuck-open    homing fails with its alarm
  cargo xtask emulate programs/square.nc --speed-profile sine    ramps of half a wave of a cosine
  cargo xtask emulate programs/square.nc --miss-factor 2     flash's cache costs twice as much where it misses
  cargo xtask emulate programs/square.nc -- --stream counting --poll-hz 4
  cargo xtask emulate --pty --console uart                 the board itself, for any sender: see below";

/// Run a program on the firmware in an emulated RP2040 or RP2350, or be that board for any sender
#[derive(clap::Args)]
#[command(after_help = format!("{EXAMPLES}\n\n{}", pty::HELP))]
pub struct Args {
    /// The G-code program
    #[arg(value_name = "FILE.nc", required_unless_present = "pty", conflicts_with = "pty")]
    program: Option<PathBuf>,
    /// Write every STEP edge as CSV: t_ns,axis,direction,position_steps
    #[arg(long, value_name = "OUT.csv")]
    trace: Option<PathBuf>,
    /// Write STEP, DIR, ENABLE and LED as a Value Change Dump
    #[arg(long, value_name = "OUT.vcd")]
    vcd: Option<PathBuf>,
    /// Write the figures of the run as JSON
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
    /// Write what was said on the console
    #[arg(long, value_name = "FILE")]
    transcript: Option<PathBuf>,
    /// Places of the carriages at power-up, in mm from their switches
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    start: Option<String>,
    /// The console that the program is sent over
    #[arg(long, value_parser = ["usb", "uart"])]
    console: Option<String>,
    /// A faulty limit switch, for example X=stuck-open
    #[arg(long, value_name = "AXIS=FAULT")]
    switch: Vec<String>,
    /// Flash reads like RAM: what its cache does not hold costs nothing
    #[arg(long, conflicts_with = "miss_factor")]
    ideal_flash: bool,
    /// A word that flash's cache does not hold costs N times what it does on the chip
    #[arg(long, value_name = "N", value_parser = factor)]
    miss_factor: Option<f64>,
    #[command(flatten)]
    profile: ProfileOptions,
    #[command(flatten)]
    variant: Variant,
    #[command(flatten)]
    live: pty::Live,
    /// More options of the emulator (`node tests/emulator/run.mjs --help` lists them)
    #[arg(last = true, value_name = "OPTIONS")]
    more: Vec<String>,
}

pub fn run(args: Args) -> Result<()> {
    args.live.check()?;
    let trace = args.trace.clone().unwrap_or_else(|| workspace::target_dir().join("emulated.csv"));
    files(&args, &trace)?.check()?;
    let Some(path) = &args.program else { return live(&args) };
    let name = path.display();
    let program = fs::read(path)
        .with_context(|| format!("{name} cannot be read: name a G-code program, such as programs/parking.nc"))?;
    let sent = sent(path, &program)?;
    node::prepare()?;
    build::firmware(args.variant)?;
    announce(&format!("{name} on the emulated board"));
    let mut command = command(&args);
    command.arg("--program").arg(&sent).arg("--trace").arg(&trace);
    command.args(
        args.profile.settings().iter().flat_map(|(number, value)| ["--set".to_owned(), format!("{number}={value}")]),
    );
    process::run(&mut command)?;
    let comparison = compare(&program, &trace, &args)?;
    let cycle_ns = 1e9 / f64::from(args.variant.chip().clock_hz());
    print!("{}", table(&comparison, port(&args), cycle_ns));
    check_lasting(&comparison, cycle_ns)
}

/// The file whose lines the board gets: of a program with parameters, expressions or O-words one with the lines that it makes.
fn sent(path: &Path, file: &[u8]) -> Result<PathBuf> {
    let program = Program::read(file).with_context(|| path.display().to_string())?;
    if program.made_from().is_none() {
        return Ok(path.to_owned());
    }
    let made = workspace::target_dir().join("emulated.nc");
    fs::write(&made, program.join(&b'\n')).with_context(|| format!("{} cannot be written", made.display()))?;
    Ok(made)
}

/// The files that are read and written. Every run writes a trace, which is compared with the simulation.
fn files(args: &Args, trace: &PathBuf) -> Result<Files> {
    let more = |option: &str| more_file(&args.more, option);
    for own in ["--trace", "--vcd", "--json", "--transcript"] {
        ensure!(more(own).is_none(), "{own} is an option of this verb: give it before the --");
    }
    Ok(Files::default()
        .read("FILE.nc", &args.program)
        .written("--trace", [trace])
        .written("--vcd", &args.vcd)
        .written("--json", &args.json)
        .written("--transcript", &args.transcript)
        .written("--edges", &more("--edges"))
        .written("--outputs", &more("--outputs"))
        .written("--flash", &more("--flash"))
        .link("--link", &args.live.link))
}

/// The file named by an option that is passed on to the emulator.
fn more_file(more: &[String], option: &str) -> Option<PathBuf> {
    let at = more
        .iter()
        .position(|word| word.strip_prefix(option).is_some_and(|rest| rest.is_empty() || rest.starts_with('=')))?;
    more[at].split_once('=').map(|(_, path)| path).or(more.get(at + 1).map(String::as_str)).map(PathBuf::from)
}

/// Checks that no move began before the previous plan had ended. The bound allows for the error of the first step of
/// both moves, because the start of a move is known only from its first step.
fn check_lasting(comparison: &Comparison, cycle_ns: f64) -> Result<()> {
    let early = (1..).zip(&comparison.moves).find(|(_, each)| {
        let pause_ns = each.pause_ns.unwrap_or_default();
        pause_ns < -2.0 * comparison.all.max_ns.max(cycle_ns)
    });
    if let Some((number, MoveComparison { pause_ns: Some(pause_ns), .. })) = early {
        bail!("move {number} began {:.1} us before the plan of the one before it had ended", -pause_ns / 1e3);
    }
    Ok(())
}

/// Runs the board on a pseudo-terminal.
#[cfg(unix)]
fn live(args: &Args) -> Result<()> {
    node::prepare()?;
    build::firmware(args.variant)?;
    let mut command = command(args);
    command.args(args.trace.iter().flat_map(|path| ["--trace".as_ref(), path.as_os_str()]));
    let has_dtr = args.console.as_deref() != Some("uart");
    let mut board = Emulated::start(&mut command, has_dtr, &args.profile.settings())?;
    pty::serve(&args.live, pty::open(&args.live)?, &mut board)
}

#[cfg(not(unix))]
fn live(_args: &Args) -> Result<()> {
    pty::refuse()
}

/// Compares the board's steps with the plans of the same program in the simulation.
fn compare(program: &[u8], trace: &Path, args: &Args) -> Result<Comparison> {
    let least_times = match args.variant.chip() {
        Chip::Rp2040 => least_times::RP2040,
        Chip::Rp2350 => least_times::RP2350,
    };
    let config = Config { port: port(args), settings: args.profile.machine(), least_times, ..Config::default() };
    let simulated = isostep_sim::run(program, &config)?;
    let traced = compare::read(fs::File::open(trace)?)?;
    compare::compare(&simulated, &traced).context("the board and the simulation differ")
}

/// The same port, simulated.
fn port(args: &Args) -> isostep_sim::Port {
    match args.variant.port {
        Port::Pio => isostep_sim::Port::Pio,
        Port::Timer => isostep_sim::Port::Timer,
    }
}

fn table(comparison: &Comparison, port: isostep_sim::Port, cycle_ns: f64) -> String {
    let clock_mhz = 1e3 / cycle_ns;
    let mut text = format!(
        "\nEvery step, direction and position is as in the simulation. Emulated, at {clock_mhz:.0} MHz: step instants, from the start\n\
         that the median of a run's first move says, against the closed form; and how far apart the accelerating, cruising and decelerating intervals of\n\
         the axes are, each measured from the axis's own edges (a clock cycle is {cycle_ns:.3} ns; -: the edges do not tell). Pause: from\n\
         the end of one plan to the start of the next:\n  \
         move    steps    median ns    p99 ns    max ns  apart ns  pause us\n",
    );
    for (number, each) in (1..).zip(&comparison.moves) {
        let apart = each.apart_ns.map_or("-".to_owned(), |apart_ns| format!("{apart_ns:.1}"));
        let pause = each.pause_ns.map_or("-".to_owned(), |pause_ns| format!("{:.1}", pause_ns / 1e3));
        text += &format!("{number:>6} {} {apart:>9} {pause:>9}\n", columns(&each.jitter));
    }
    text + &format!("   all {}\n", columns(&comparison.all)) + &planned_otherwise(&comparison.moves, port)
}

/// Says which moves have steps so far from the simulation's plan that it is not the board's, and how near those of all others are.
fn planned_otherwise(moves: &[MoveComparison], port: isostep_sim::Port) -> String {
    let is_otherwise = |each: &MoveComparison| each.jitter.max_ns > stray_max_ns(port);
    let Some(first) = moves.iter().position(is_otherwise) else { return String::new() };
    let (otherwise, as_planned): (Vec<&MoveComparison>, Vec<_>) = moves.iter().partition(|each| is_otherwise(each));
    let max_ns = as_planned.iter().map(|each| each.jitter.max_ns).fold(0.0, f64::max);
    format!(
        "\n{} of {} moves, the first of them {}, are planned otherwise than in the simulation, where no line takes time to read: the board\n\
         knew fewer of the moves that follow when their run began. So they are somewhat slower, and what comes behind them in the run is later.\n\
         The steps of all other moves are within {max_ns:.1} ns of the closed form.\n",
        otherwise.len(),
        moves.len(),
        first + 1,
    )
}

fn columns(jitter: &Jitter) -> String {
    let Jitter { steps, median_ns, p99_ns, max_ns } = jitter;
    format!("{steps:>8} {median_ns:>12.1} {p99_ns:>9.1} {max_ns:>9.1}")
}

fn command(args: &Args) -> Command {
    let mut command = Command::new("node");
    command.arg(workspace::emulator_dir().join("run.mjs")).arg("--elf").arg(args.variant.elf());
    let files = [("--vcd", &args.vcd), ("--json", &args.json), ("--transcript", &args.transcript)];
    for (flag, path) in files {
        command.args(path.iter().flat_map(|path| [flag.as_ref(), path.as_os_str()]));
    }
    for (flag, value) in [("--start", &args.start), ("--console", &args.console)] {
        // The flag and its value are one argument, because a position may begin with a minus.
        command.args(value.iter().map(|value| format!("{flag}={value}")));
    }
    command.args(args.switch.iter().flat_map(|switch| ["--switch", switch]));
    command.args(args.ideal_flash.then_some("--ideal-flash"));
    command.args(args.miss_factor.iter().map(|factor| format!("--miss-factor={factor}")));
    command.args(["--board", args.variant.board.name(), "--driver", args.variant.driver_name()]);
    command.args(["--estop", args.variant.contact_name()]);
    command.args(&args.more);
    command
}

/// Parses a factor in the range that the emulated board accepts.
fn factor(text: &str) -> Result<f64, String> {
    let factor = text.parse().ok().filter(|factor| (0.0..=1_000.0).contains(factor));
    factor.ok_or_else(|| "give a number from 0 to 1000".to_owned())
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: Args,
    }

    fn options(line: &[&str]) -> Option<Vec<String>> {
        let args = Line::try_parse_from(["emulate", "a.nc"].iter().chain(line)).ok()?.args;
        Some(command(&args).get_args().map(|arg| arg.to_string_lossy().into_owned()).collect())
    }

    fn compared(max_ns: f64) -> MoveComparison {
        let jitter = Jitter { steps: 10, median_ns: 2.0, p99_ns: max_ns, max_ns };
        MoveComparison { jitter, apart_ns: None, pause_ns: None }
    }

    #[test]
    fn moves_that_the_board_plans_otherwise_are_told_and_the_others_stand_for_themselves() {
        let said = |max_ns: &[f64]| {
            let moves: Vec<_> = max_ns.iter().copied().map(compared).collect();
            planned_otherwise(&moves, isostep_sim::Port::Pio)
        };
        assert_eq!(said(&[4.1, 3.9]), "");
        let told = said(&[4.1, 1.4e6, 1.4e6, 3.9]);
        assert!(told.contains("2 of 4 moves, the first of them 2, are planned otherwise"), "{told}");
        assert!(told.contains("all other moves are within 4.1 ns"), "{told}");
    }

    #[test]
    fn the_board_is_told_what_flash_costs() {
        let has = |line: &[&str], option: &str| options(line).unwrap().iter().any(|each| each == option);
        assert!(has(&["--ideal-flash"], "--ideal-flash") && !has(&[], "--ideal-flash"));
        assert!(has(&["--miss-factor", "2"], "--miss-factor=2"));
        for wrong in
            [["--miss-factor", "-1"].as_slice(), &["--miss-factor", "x"], &["--ideal-flash", "--miss-factor", "2"]]
        {
            assert!(options(wrong).is_none(), "{wrong:?}");
        }
    }

    #[test]
    fn a_move_that_was_cut_short_is_an_error() {
        let jitter = Jitter { steps: 1, median_ns: 0.0, p99_ns: 0.0, max_ns: 4.0 };
        let after = |pause_ns| {
            let each = |pause_ns| MoveComparison { jitter, apart_ns: None, pause_ns };
            check_lasting(&Comparison { moves: vec![each(None), each(Some(pause_ns))], all: jitter }, 8.0)
        };
        assert!(after(0.0).is_ok() && after(-16.0).is_ok() && after(1e6).is_ok());
        let error = after(-25_000.0).unwrap_err().to_string();
        assert_eq!(error, "move 2 began 25.0 us before the plan of the one before it had ended");
    }
}
