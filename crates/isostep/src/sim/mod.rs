//! `isostep sim`: a G-code program on the controller in virtual time, every edge checked.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use isostep_console::{SettingError, Settings};
use isostep_report::pictures::{self, BothRules};
use isostep_report::remarks;
use isostep_report::ringing::{self, RingingFigures};
use isostep_report::survey::Survey;
use isostep_report::{Figures, Listed, again, timing};
use isostep_sim::drive::{Load, MotorData};
use isostep_sim::flash::FLASH_BYTES;
use isostep_sim::plate::Plate;
use isostep_sim::program::Program;
use isostep_sim::springs::Springs;
use isostep_sim::{
    AXES, Board, Config, Contact, Fault, Flash, NAMES_OF_AXES, Outcome, Port, SwitchFault, lines_of_moves, settings,
};

use crate::files::{self, Files};
use crate::name::as_called;
use crate::profile_options::ProfileOptions;
use crate::stopwatch::Stopwatch;
use crate::{project, pty};

mod judge;
mod print;

/// The program that is run when none is named. An installed tool has it too, so it is a file of this package.
const PARKING: (&str, &str) = ("programs/parking.nc (built in)", include_str!("../../programs/parking.nc"));
/// The user is shown the elapsed time if a run takes at least this long.
const LONG_S: f64 = 1.0;

const EXAMPLES: &str = "\
The tasks are those of the firmware; motors, carriages and switches are simulated, and every STEP edge is checked
against the closed form of its move and the driver's datasheet. Equal runs write equal files, to the byte.

Examples:
  isostep sim                                          the parking gantry: programs/parking.nc, built in
  isostep sim programs/diagonal.nc --report report     pictures: open report/index.html
  isostep sim programs/parking.nc --trace a.csv --vcd a.vcd --json a.json
  isostep sim programs/square.nc --intervals thirds          accelerate, cruise and decelerate for a third of the time each
  isostep sim programs/square.nc --speed-profile s-curve       ramps of limited jerk
  isostep sim programs/parking.nc --switch X=stuck-open    homing fails with its alarm
  isostep sim --fault limit:X@30+0.2 --fault deaf@20+5     somebody presses a switch; a host does not read
  isostep sim --board skr-pico --fault driver-off:X@30     a driver loses its supply
  isostep sim --estop nc --fault broken:e-stop@30          the wire of an emergency stop that opens breaks
  isostep sim my.nc --probe-plate Z,12.5,below         G38 finds a plate 12.5 mm above the switch of Z
  isostep sim my.nc --settings my.txt --start 5,5,5    a machine as its settings say: see below
  isostep sim programs/square.nc --ringing X:8:0.05,Y:6:0.05     loads on springs, and how they swing: docs/ringing.md
  isostep sim my.nc --flash my.flash                       $n=v and G10 hold in the next run too
  isostep sim --pty                                    the machine itself, for any sender: see below";

const SETTINGS_HELP: &str = "\
--settings FILE takes $n=v lines, as senders save them and as `$$` prints them, with blank lines and comments in () or after
a semicolon; what is not in it is as on the default machine. The simulated machine is the one that the settings describe:
  $100-$102, $130-$132, $27, $906   carriages, switches and end stops; belts below 200 steps/mm, otherwise screws
  $3, $4, $5, $8, $23, $905   how drivers and switches are wired, and which axis has a second motor
The first row follows $n=v lines of the program too. Motors are as --motor says, and move what --load says.";

/// Run a program on the controller in virtual time, or be a machine for any sender
#[derive(clap::Args)]
#[command(after_help = format!("{EXAMPLES}\n\n{SETTINGS_HELP}\n\n{}", pty::HELP))]
pub struct Args {
    /// The G-code program [default: programs/parking.nc, which is built in]
    #[arg(value_name = "FILE.nc", conflicts_with = "pty")]
    program: Option<PathBuf>,
    /// Write every STEP edge as CSV: t_ns,axis,direction,position_steps
    #[arg(long, value_name = "OUT.csv")]
    trace: Option<PathBuf>,
    /// Write every change of the tool's outputs as CSV: t_ns,output,value (pwm as a duty from 0 to 1, enable,
    /// direction, flood and mist as 0 or 1)
    #[arg(long, value_name = "OUT.csv")]
    outputs: Option<PathBuf>,
    /// Write every wire's waveform, and those of the tool's outputs, as a Value Change Dump
    #[arg(long, value_name = "OUT.vcd")]
    vcd: Option<PathBuf>,
    /// Write a page of pictures and tables into this folder
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Write the figures of the run as JSON
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
    /// Seed of everything random: the bounces of the limit switches
    #[arg(long, value_name = "N", default_value_t = Config::default().seed)]
    seed: u64,
    /// Places of the carriages at power-up, in mm from their switches [default: 35,40,15, at most half the travel]
    #[arg(long, value_name = PLACES, value_parser = places, allow_hyphen_values = true)]
    start: Option<[f64; AXES]>,
    /// Distance by which the second motor of an axis is ahead of the first while nothing holds it square, mm
    #[arg(long, value_name = "MM", allow_negative_numbers = true, default_value_t = 0.0)]
    skew: f64,
    /// A faulty limit switch: X, Y or Z = stuck-open or stuck-closed
    #[arg(long, value_name = "AXIS=FAULT", value_parser = switch)]
    switch: Vec<(usize, SwitchFault)>,
    /// Faults and when they happen, any number of times: WHAT@SECONDS, or WHAT@SECONDS+SECONDS for what ends again, where
    /// WHAT is e-stop, broken:e-stop, limit:X, broken:X, chatter:X, stall:X (Y2 is a second motor of Y), hold, start,
    /// probe, starve or deaf; with --board skr-pico also driver-off:X, driver-late:X, driver-garbled:X, driver-hot:X,
    /// driver-overheated:X, driver-shorted:X or driver-open-coil:X. Such as limit:X@1.5+0.2
    #[arg(long, value_name = "WHAT@S+S")]
    fault: Vec<Fault>,
    /// Wiring of the emergency stop: normally open (no), or normally closed (nc), so that a broken wire is a press
    #[arg(long, value_parser = ["no", "nc"], default_value = "no")]
    estop: String,
    /// A plate that the probe touches: an axis, the plate's place in mm above that axis's limit switch, and the side on
    /// which it is touched, there and beyond: below (nearer to the switch) or above. Such as Z,12.5,below
    #[arg(long, value_name = "AXIS,MM,SIDE", allow_hyphen_values = true)]
    probe_plate: Option<Plate>,
    /// The machine's settings: $n=v lines, as senders save them; see below
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    /// The motors: holding torque in N m, inertia of the rotor in g cm2, and the speed up to which the torque is whole, in
    /// revolutions/s. A common NEMA 17 is 0.4,54,12; see docs/motors.md
    #[arg(long, value_name = "NM,GCM2,REV", default_value_t = MotorData::NEMA_17)]
    motor: MotorData,
    /// Load of a motor: X, Y or Z = mm per revolution of the motor, and kg. Such as Y=8,5. Otherwise 2 kg on a belt below
    /// 200 steps/mm, 10 kg on a screw from there on
    #[arg(long, value_name = "AXIS=MM,KG", value_parser = load)]
    load: Vec<(usize, Load)>,
    /// Loads on springs, whose ringing is reported: axis, natural frequency in Hz, damping ratio. They change no edge; see
    /// docs/ringing.md
    #[arg(long, value_name = "AXIS:HZ:RATIO,...")]
    ringing: Option<Springs>,
    /// The width of a laser's beam in mm, at half its maximum: for the picture of what it engraved
    #[arg(long, value_name = "MM", value_parser = beam, default_value_t = Config::default().beam_mm)]
    beam: f64,
    /// The flash that settings are stored in: read at the start if it exists, written at the end, so that they outlive
    /// the run. What it holds is in force rather than what --settings says
    #[arg(long, value_name = "FILE", conflicts_with = "pty")]
    flash: Option<PathBuf>,
    /// List every move, here and in the JSON, however many there are
    #[arg(long, conflicts_with = "pty")]
    moves: bool,
    #[command(flatten)]
    profile: ProfileOptions,
    /// The board: a Pico with bare drivers, or an SKR Pico, with TMC2209 on a UART: M122, $140-$142, and more in docs/console.md
    #[arg(long, value_parser = ["pico", "skr-pico"], default_value = "pico")]
    board: String,
    /// Jumpers of an SKR Pico: the limit inputs of these axes are wired to their drivers' DIAG, high for a stall, and not to
    /// their switches
    #[arg(long, value_name = "X,Y,Z", value_parser = jumpers)]
    diag: Option<[bool; AXES]>,
    /// Step port: hardware in ticks of 8 ns, or tasks in ticks of 1 us
    #[arg(long, value_parser = ["pio", "timer"], default_value = "pio")]
    port: String,
    #[command(flatten)]
    live: pty::Live,
}

/// Runs the verb.
pub fn run(args: Args) -> Result<()> {
    args.live.check()?;
    files(&args).check()?;
    if args.live.pty {
        return live(&args);
    }
    let (name, program) = program(&args)?;
    let config = config(&args)?;
    let again = config.replay(if args.program.is_some() { &name } else { "" });
    println!("{name} in virtual time\nSEED={}  again: {}", config.seed, as_called(&again));
    let flash = args.flash.as_deref().map_or(Ok(Flash::blank()), stored)?;
    config.check()?;
    // Settings stored by an earlier run would be in force, but they are not known here.
    match &args.flash {
        Some(path) if path.exists() => tell_weak_motors(&config, &config.settings),
        _ => tell_beforehand(&program, &config),
    }
    let stopwatch = Stopwatch::start();
    let outcome = run_shown(program, &config, flash.clone()).with_context(|| name.clone())?;
    let mut figures = Figures::listing(&name, &outcome, if args.moves { Listed::All } else { Listed::Some });
    figures.replay = again;
    figures.ringing_unshaped = unshaped(&args, &outcome)?;
    print::print(&figures, args.moves);
    judge::print(&outcome);
    write_files(&args, &outcome, &figures)?;
    if let Some(path) = &args.flash {
        files::write(path, &flash.bytes())?;
    }
    tell_effort(&stopwatch);
    judge::judge(&figures, &outcome)
}

/// The program and its name.
fn program(args: &Args) -> Result<(String, Program)> {
    match &args.program {
        Some(path) => Ok((project::shown(path), lines(path)?)),
        None => Ok((PARKING.0.to_owned(), Program::read(PARKING.1.as_bytes())?)),
    }
}

/// The files that are read and written.
fn files(args: &Args) -> Files {
    Files::default()
        .read("FILE.nc", &args.program)
        .read("--settings", &args.settings)
        .written("--trace", &args.trace)
        .written("--outputs", &args.outputs)
        .written("--vcd", &args.vcd)
        .written("--json", &args.json)
        .written("--flash", &args.flash)
        .page("--report", &args.report)
        .link("--link", &args.live.link)
}

/// Prints the time and memory that the run took on this computer, if it was more than a moment.
fn tell_effort(stopwatch: &Stopwatch) {
    let elapsed_s = stopwatch.elapsed_s();
    if elapsed_s >= LONG_S {
        let memory = peak_memory_mb().map_or(String::new(), |mb| format!(" and {mb} MB of memory"));
        eprintln!("    it took {elapsed_s:.1} s{memory}");
    }
}

/// The peak memory of this process, MB, where the system reports it (Linux).
fn peak_memory_mb() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let kb = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.trim().strip_suffix("kB")?;
    kb.trim().parse::<u64>().ok().map(|kb| kb / 1_000)
}

/// Runs the program, and shows a progress bar if that takes long.
fn run_shown(program: Program, config: &Config, flash: Flash) -> Result<Outcome, isostep_sim::SimError> {
    let bar = ProgressBar::new(program.len() as u64).with_style(
        ProgressStyle::with_template("  {bar:20} line {pos} of {len}, {msg} of machine time, {eta} left")
            .expect("a template of ours"),
    );
    let outcome = isostep_sim::run_watched(program, config, flash, &mut |progress| {
        bar.set_position(progress.answered as u64);
        bar.set_message(format!("{:.0} s", progress.t_ns as f64 * 1e-9));
    });
    bar.finish_and_clear();
    outcome
}

/// Prints beforehand what in the program will not work on this machine, and where a person would have to act.
fn tell_beforehand(program: &Program, config: &Config) {
    let survey = Survey::of(program, &config.settings, config.start_mm);
    tell_weak_motors(config, &survey.settings);
    if let Some(outside) = &survey.outside {
        eprintln!("warning: {}", remarks::outside(outside));
    }
    if let Some(words) = remarks::dark_dwells(&survey) {
        eprintln!("warning: {words}");
    }
    if survey.moves > 0 && survey.ends_at.is_none() {
        let tool = if survey.leaves_tool_on { ", and leaves the spindle on (M3, M4)" } else { "" };
        println!("note: it ends without M2 or M30, so its modes stay in force{tool}");
    }
}

/// Runs the machine on a pseudo-terminal. Its record is kept only if an output file needs it.
#[cfg(unix)]
fn live(args: &Args) -> Result<()> {
    let files = [&args.trace, &args.outputs, &args.vcd, &args.report, &args.json];
    let config = Config { keep_record: files.iter().any(|file| file.is_some()), ..config(args)? };
    config.check()?;
    tell_weak_motors(&config, &config.settings);
    let mut machine = pty::simulated::Simulated::new(config);
    pty::serve(&args.live, pty::open(&args.live)?, &mut machine)?;
    let outcome = machine.sim().outcome();
    if !outcome.config.keep_record {
        return Ok(());
    }
    let mut figures = Figures::new("what the senders sent", &outcome);
    // The senders are not ours: it is up to them to report refused lines.
    figures.verdicts.retain(|verdict| !verdict.promise.starts_with("every line accepted"));
    print::print_checks(&figures);
    write_files(args, &outcome, &figures)
}

#[cfg(not(unix))]
fn live(_args: &Args) -> Result<()> {
    pty::refuse()
}

/// Reads a program as the lines that are sent.
pub fn lines(path: &Path) -> Result<Program> {
    Program::read(&read(path)?).with_context(|| project::shown(path))
}

/// Reads a program as lines, each as it is written.
pub fn raw_lines(path: &Path) -> Result<Program> {
    Program::read_raw(&read(path)?).with_context(|| project::shown(path))
}

/// Reads a program as bytes.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    let shown = path.display();
    ensure!(!path.is_dir(), "{shown} is a folder: name a G-code program in it");
    fs::read(path).map_err(|error| match error.kind() {
        ErrorKind::NotFound => anyhow!("{shown} does not exist: name a G-code program, such as my.nc"),
        _ => anyhow!("{shown} cannot be read: {error}"),
    })
}

/// The flash that an earlier run has stored; blank if there is none.
fn stored(path: &Path) -> Result<Flash> {
    let shown = path.display();
    match fs::read(path) {
        Ok(bytes) if bytes.len() == FLASH_BYTES => Ok(Flash::with(bytes)),
        Ok(bytes) => bail!(
            "{shown}: {} bytes, but the flash of settings has {FLASH_BYTES}: give a file that an earlier run wrote, or a new name",
            bytes.len()
        ),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(Flash::blank()),
        Err(error) => Err(anyhow!("{shown} cannot be read: {error}")),
    }
}

fn config(args: &Args) -> Result<Config> {
    let mut config = Config { seed: args.seed, motor: args.motor, keep_waves: args.vcd.is_some(), ..Config::default() };
    config.board = Board::ALL.into_iter().find(|board| board.to_string() == args.board).unwrap_or_default();
    config.driver = config.board.driver();
    config.diag = args.diag.unwrap_or_default();
    ensure!(
        config.board == Board::SkrPico || args.diag.is_none(),
        "--diag: the drivers of a {} have no UART: use --board skr-pico",
        config.board
    );
    config.port = if args.port == "timer" { Port::Timer } else { Port::Pio };
    let machine = match &args.settings {
        None => config.settings,
        Some(path) => {
            let settings = read_settings(path, &config)?;
            config.settings_file = Some((project::shown(path), settings));
            settings
        }
    };
    config.settings = args.profile.over(machine).context("--speed-profile")?;
    let middle_mm = timing::middle_mm(&config.settings);
    config.start_mm =
        args.start.unwrap_or_else(|| std::array::from_fn(|axis| config.start_mm[axis].min(middle_mm[axis])));
    config.beam_mm = args.beam;
    config.springs = args.ringing.unwrap_or_default();
    for &(axis, load) in &args.load {
        config.loads[axis] = Some(load);
    }
    for &(axis, fault) in &args.switch {
        config.switches[axis] = fault;
    }
    config.emergency_contact = if args.estop == "nc" { Contact::NormallyClosed } else { Contact::NormallyOpen };
    config.gantry.skew_mm = args.skew;
    config.plate = args.probe_plate;
    config.faults.clone_from(&args.fault);
    Ok(config)
}

/// Reads settings from a file, for a machine with the step port and the motor driver of `config`.
pub fn read_settings(path: &Path, config: &Config) -> Result<Settings> {
    let text = read_as_settings(path)?;
    let name = project::shown(path);
    settings::read(&name, &text, config.port, config.driver).map_err(|refused| match refused.reason {
        settings::Reason::Setting(SettingError::Unknown { .. }) => anyhow!(
            "{refused}. `isostep check --settings {name}` says what becomes of another controller's settings, line by line"
        ),
        _ => refused.into(),
    })
}

/// The bytes of a file of settings.
pub fn read_as_settings(path: &Path) -> Result<Vec<u8>> {
    let name = project::shown(path);
    let text = fs::read(path).map_err(|error| match error.kind() {
        ErrorKind::NotFound => anyhow!("{name} does not exist: name a file of $n=v lines, such as $$ prints them"),
        _ => anyhow!("{name} cannot be read: {error}"),
    })?;
    ensure!(text.len() != FLASH_BYTES, "{name} is the flash of an earlier run: give it with --flash");
    Ok(text)
}

/// Prints beforehand which axes are configured for more than their motors can do, by the initial settings or by those
/// that the program leaves behind.
fn tell_weak_motors(config: &Config, left: &Settings) {
    let mut reported = settings::beyond_motors(&config.settings, config);
    reported.extend(settings::beyond_motors(left, config));
    reported.sort_unstable();
    reported.dedup();
    reported.iter().for_each(|reported| eprintln!("warning: {reported}"));
}

/// Parses the width of a beam, mm.
fn beam(text: &str) -> Result<f64, String> {
    let width = text.parse().ok().filter(|width| (0.001..=20.0).contains(width));
    width.ok_or_else(|| "a width from 0.001 to 20 mm, such as 0.1".to_owned())
}

fn load(text: &str) -> Result<(usize, Load), String> {
    let (axis, load) = text.split_once('=').ok_or("an axis and its load, such as Y=8,5")?;
    Ok((axis_index(axis)?, load.parse()?))
}

fn axis_index(axis: &str) -> Result<usize, String> {
    let index = remarks::AXIS_NAMES.iter().position(|name| name.eq_ignore_ascii_case(axis));
    index.ok_or_else(|| format!("`{axis}` is no axis: use {NAMES_OF_AXES}"))
}

/// Parses the format of `--diag`: axes, of which the board has jumpers for the first three.
fn jumpers(text: &str) -> Result<[bool; AXES], String> {
    let mut wired = [false; AXES];
    for axis in text.split(',') {
        let index = axis_index(axis)?;
        if index >= Board::JUMPERS {
            return Err(format!("the board has no jumper for {axis}: use X, Y or Z"));
        }
        wired[index] = true;
    }
    Ok(wired)
}

fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let number = |text: &str| text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
    numbers?.try_into().ok()
}

/// The format of `--start`, for its help.
pub const PLACES: &str = match AXES {
    2 => "X,Y",
    3 => "X,Y,Z",
    _ => "X,Y,Z[,A]",
};

/// Parses the format of `--start`: a number of mm for each axis. A starts at its default if it is left out.
pub fn places(text: &str) -> Result<[f64; AXES], String> {
    let of_three = || {
        let mut start_mm = Config::default().start_mm;
        start_mm.get_mut(..3)?.copy_from_slice(&numbers::<3>(text)?);
        Some(start_mm)
    };
    let wanted = if AXES == 2 { "two numbers of mm, such as 35,40" } else { "three numbers of mm, such as 35,40,15" };
    numbers(text).or_else(of_three).ok_or_else(|| wanted.to_owned())
}

fn switch(text: &str) -> Result<(usize, SwitchFault), String> {
    let (axis, fault) = text.split_once('=').ok_or("an axis and its fault, such as X=stuck-open")?;
    let index = axis_index(axis)?;
    fault.parse().map(|fault| (index, fault)).map_err(|error: isostep_sim::UnknownFault| error.to_string())
}

/// The swinging of loads on springs in the same program without shapers, if it is shaped. A flash may hold settings that are in
/// force rather than those known here.
fn unshaped(args: &Args, outcome: &Outcome) -> Result<Vec<RingingFigures>> {
    let Some((program, config)) = again::unshaped(outcome).filter(|_| args.flash.is_none()) else {
        return Ok(Vec::new());
    };
    let other = run_shown(program, &config, Flash::blank()).context("the same program without shapers")?;
    Ok(ringing::figures(&other, &lines_of_moves::of_moves(&other)))
}

/// The same program by the other rule at corners, if the report has something to compare. A flash may hold settings that
/// are in force rather than those known here.
fn other_rule(args: &Args, outcome: &Outcome) -> Result<Option<Outcome>> {
    let other = again::other_rule(outcome).filter(|_| args.flash.is_none() && !args.live.pty);
    let run = |(program, config)| run_shown(program, &config, Flash::blank());
    other.map(run).transpose().context("the same program by the other rule at corners")
}

fn write_files(args: &Args, outcome: &Outcome, figures: &Figures) -> Result<()> {
    if let Some(path) = &args.trace {
        files::write_by(path, |out| isostep_sim::trace::write(&outcome.edges, out))?;
    }
    if let Some(path) = &args.outputs {
        files::write_by(path, |out| isostep_sim::trace::write_tool(&outcome.tool, out))?;
    }
    if let Some(path) = &args.vcd {
        files::write_by(path, |out| {
            isostep_sim::vcd::write(&outcome.waves, &outcome.tool, outcome.limits_high_at_start, out)
        })?;
    }
    if let Some(path) = &args.json {
        files::write_by(path, |out| Ok(serde_json::to_writer_pretty(out, figures)?))?;
        if figures.moves.len() < figures.moves_total {
            println!("  with {} of its {} moves; --moves has all", figures.moves.len(), figures.moves_total);
        }
    }
    if let Some(folder) = &args.report {
        let both = BothRules::of(outcome, other_rule(args, outcome)?);
        files::write_page(folder, &pictures::page(outcome, &both, figures))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_switches_are_read() {
        assert_eq!(places("1, 2.5,-3"), Ok([1.0, 2.5, -3.0]));
        assert!(places("1,2").unwrap_err().contains("35,40,15") && places("nan,1,1").is_err());
        assert_eq!(switch("y=stuck-closed"), Ok((1, SwitchFault::StuckClosed)));
        assert!(switch("Q=stuck-open").unwrap_err().contains("use X, Y or Z"));
        assert_eq!("0.4, 54,12".parse(), Ok(MotorData::NEMA_17));
        assert!("0,1,1".parse::<MotorData>().unwrap_err().contains("0.4,54,12") && load("Y=8").is_err());
        assert_eq!(load("y=40,2").unwrap(), (1, Load::preset(80.0, 0.0)));
        assert_eq!(beam("0.25"), Ok(0.25));
        assert!(beam("0").unwrap_err().contains("such as 0.1") && beam("x").is_err());
        assert!(load("Q=40,2").unwrap_err().contains("use X, Y or Z"));
        assert_eq!(jumpers("y,X"), Ok(std::array::from_fn(|axis| axis < 2)));
        assert!(jumpers("").is_err() && jumpers("X,Q").unwrap_err().contains("use X, Y or Z"));
        assert!(switch("X=loose").unwrap_err().contains("use stuck-open"));
    }
}
