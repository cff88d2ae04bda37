//! Measures the firmware's step ports on the emulated board, for `cargo xtask bench`, which builds what is measured.
//!
//! # Design
//! ```text
//! isostep::measure: rates, edges, load, stops, starts, moves -- board: the emulated board, as they see it --+
//! levels, outputs: a laser's, by the emulator ---------------------------------------------------------- runs: a
//! mathematics: another firmware, on the same chip                                             firmware, emulated
//!              |
//!        figures of each chip -- table, JSON, page
//! ```
//! All of this is done on three chips (`chip`): that of the board as it is, one with ideal flash, and one with costly misses. The
//! mathematics are a firmware for an RP2040.
//! Nothing is asserted: a missed target is only marked in the figures. An error is returned only if a run cannot be
//! made.
//!
//! `least_times` and `prices` are other measurements, made by themselves: how short moves may be planned, and what the figures come to if an
//! RP2350 is slower than is assumed.

#![forbid(unsafe_code)]

// All modules print with its macros.
#[macro_use]
extern crate isostep;

mod board;
mod candidate;
mod chip;
mod edges;
mod effort;
pub mod least_times;
mod levels;
mod lines;
mod mathematics;
mod outputs;
mod page;
mod port;
pub mod prices;
mod runs;

use std::fs;
use std::path::{Path, PathBuf};
use std::thread;

use anyhow::{Context, Result, ensure};
use isostep::files::Files;
use isostep::measure::board::Board;
use isostep::measure::edges::Edges;
use isostep::measure::moves::{Corners, Curve};
use isostep::measure::planned_move::PROVED;
use isostep::measure::rates::Trials;
use isostep::measure::stops::Cause;
use isostep::measure::{Findings, Machine, Ramp, finely, load, moves, rates, starts, stops, table, together};
use isostep::screen::{announce, grouped};
use rp2040_bench::{FLOW_CASES, START_MM};
use serde::Serialize;

use self::board::Emulated;
pub use self::candidate::{Candidate, Model};
use self::chip::Chip;
use self::effort::Effort;
pub use self::port::Port;
use self::runs::{POLL_HZ, Runs};

/// Acceleration of the fastest machines, steps/s2: 1,000,000 steps/s in 0.2 s.
const ACCEL_MAX_STEPS_S2: f64 = 5e6;
/// The ramps of rates, long moves, loads and stops.
const RAMP: Ramp = Ramp { s: 0.2, accel_max_steps_s2: ACCEL_MAX_STEPS_S2 };

/// Measure the firmware's step ports on the emulated board
#[derive(clap::Args)]
#[command(after_help = "\
What is measured, of PioPort and of TimerPort, three axes stepping at once and status polled over USB:
  rates     the highest rate sustained through whole moves, found by bisection: no line refused, no alarm, no gap,
            every edge nearer to its own instant than to its neighbours'; for 1, 2 and 3 axes
  accuracy  every edge of a 10 s move, ramps and cruise, against the closed form of its plan, from the first edge on:
            maximum, p99, histogram, and drift
  load      the share of the time that the core is awake, at a steady rate and in ramps
  stops     from a limit switch, the emergency stop or a second reset byte (the first has the machine brake) to the last
            edge, at random instants of a fixed seed; and from the last edge of an axis whose port faults, too
  These and short moves are measured on a machine with two motors on Y as well, whose motors have to make every step on the
  same cycle.
  starts    from the arrival of a line to the first edge, less what the plan itself takes to its first step: flash's cache
            empty (cold) and right after a move of the same kind (warm); at 5,000,000 steps/s2,
            TimerPort at 1,000,000 to 20,000 steps/s
  levels    lines of pixels of 0.1 mm: how far a laser's level changes from the step that it begins with, at 1,000 moves/s; and how
            many pixels a second are carried, with constant levels (M3) and with levels by speed (M4)
  outputs   from a stop to the last output of the tool off, with a laser that shines and coolant on
And what the mathematics of a move costs on the chip, beside the step generators of the literature over the same ramp:
cycles to plan, to compile a segment and to replay a step under each speed profile, and how far their speeds are off; and cycles of
a move of 0.2 mm of three axes that flows in a full chain: to read its line, to push it, to plan it and to compile that.
On which chip:
  the chip            that of the board, emulated, flash read through its cache: everything; of a Pico 2 without the mathematics
  ideal flash         flash reads like RAM: everything again (fewer stops), shown beneath a figure where it is another;
                      --quick: rates, accuracy, stops and starts
  miss costs twice  what flash's cache does not hold costs twice as much: what has a target (fewer stops), a column of
                      the targets; --quick: without the mathematics
The firmware is built for a TMC2209, whose least pulses (100 ns) limit the rate only above 4,000,000 steps/s. Equal
builds give equal figures.
Figures are printed beside their targets; a target that is not met is no error.

What planning and compiling a move cost on this computer: cargo bench -p isostep-profile

Examples:
  cargo xtask bench                                  everything, half an hour or more
  cargo xtask bench --quick                          shorter moves, fewer rates, some five minutes
  cargo xtask bench --port timer --json timer.json
  cargo xtask bench --quick --board pico2            an RP2350, whose core has assumed timing
  cargo xtask bench --prices --board pico2           the same if its core or its flash is slower than assumed, some ten minutes
  cargo xtask bench --least-times                    how short moves may be, beside what the firmware is configured with
  cargo xtask bench --quick --prove                  of the image for `isostep prove`, whose figures have to be the same
  cargo xtask bench --report bench                   pictures: open bench/index.html")]
pub struct Args {
    /// Write the figures as JSON
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
    /// Write a page of pictures and tables into this folder
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Measure less, in less time: three axes only, rates of one digit, moves of 1 s
    #[arg(long)]
    quick: bool,
    /// The board
    #[arg(long, value_enum, default_value_t, conflicts_with = "prove")]
    board: Model,
    /// Only this port, and not the mathematics
    #[arg(long)]
    port: Option<Port>,
    /// Measure the image that measures itself, to hold it beside the one that people use; without the mathematics
    #[arg(long)]
    prove: bool,
    /// Find the times that moves have to last for the board to keep up, beside those of its image; nothing else
    #[arg(long, conflicts_with_all = ["json", "report", "quick", "port", "prove"])]
    least_times: bool,
    /// Find what the figures of a Pico 2 come to if its core or its flash is slower than is assumed; nothing else
    #[arg(long, conflicts_with_all = ["json", "report", "quick", "port", "prove", "least_times"])]
    prices: bool,
}

impl Args {
    /// Checks that the files can be written, before anything is built.
    ///
    /// # Errors
    /// A file or folder that cannot be written, or prices of a chip whose timing is not assumed.
    pub fn check(&self) -> Result<()> {
        let is_assumed = self.board.chip() == isostep::chip::Chip::Rp2350;
        ensure!(
            is_assumed || !self.prices,
            "--prices: the timing of an RP2040's core is not assumed, and what flash costs is a column of `cargo xtask bench`: \
             give --board pico2"
        );
        Files::default().page("--report", &self.report).written("--json", &self.json).check()
    }

    /// The ports that are measured, each of which needs a [`Candidate`].
    #[must_use]
    pub fn ports(&self) -> Vec<Port> {
        if self.least_times || self.prices {
            vec![Port::Pio]
        } else {
            self.port.map_or(Port::ALL.to_vec(), |port| vec![port])
        }
    }

    /// The board that is measured.
    #[must_use]
    pub fn model(&self) -> Model {
        self.board
    }

    /// The mathematics is measured too. Its firmware is for an RP2040.
    #[must_use]
    pub fn mathematics(&self) -> bool {
        self.port.is_none()
            && !self.prove
            && !self.least_times
            && !self.prices
            && self.board.chip() == isostep::chip::Chip::Rp2040
    }

    /// The least times are measured, and nothing else.
    #[must_use]
    pub fn least_times(&self) -> bool {
        self.least_times
    }

    /// What the figures come to on a slower chip is measured, and nothing else.
    #[must_use]
    pub fn prices(&self) -> bool {
        self.prices
    }

    /// It is the proving image that is measured.
    #[must_use]
    pub fn proves(&self) -> bool {
        self.prove
    }
}

/// The measurements.
pub struct Images {
    /// The firmware with each port.
    pub candidates: Vec<Candidate>,
    /// The firmware that times the mathematics.
    pub mathematics: PathBuf,
    /// The emulated board, which Node runs.
    pub emulator: PathBuf,
}

/// The results of a whole run.
#[derive(Serialize)]
struct Figures {
    /// The command that prints them.
    command: String,
    /// The conditions on which every figure depends, in words.
    conditions: String,
    /// On the real chip.
    chip: Findings,
    /// On a chip with flash that reads like RAM.
    ideal_flash: Findings,
    /// On a chip on which a word that is not in flash's cache takes twice as long.
    miss_costs_twice: Findings,
}

/// Runs the verb. `folder` is for the files of the runs.
///
/// # Errors
/// A run that cannot be made, or a file that cannot be written.
pub fn run(args: &Args, images: &Images, folder: &Path) -> Result<()> {
    let candidates = &images.candidates;
    let miss_cycles = Runs::new(&candidates[0], Chip::AsItIs, folder).miss_cycles()?;
    let on = |chip: Chip| {
        let folder = folder.join(chip.slug());
        fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
        on_chip(chip, images, &folder, args)
    };
    // Two threads may run at once, because no figure depends on how long it takes to measure.
    let (chip, others) = thread::scope(|scope| {
        let others = scope.spawn(|| [Chip::IdealFlash, Chip::CostlyMiss].map(on));
        (on(Chip::AsItIs), others.join())
    });
    let [ideal_flash, miss_costs_twice] = others.expect("a measurement does not panic");
    let figures = Figures {
        command: command(args),
        conditions: conditions(args, candidates[0].driver, miss_cycles),
        chip: chip?,
        ideal_flash: ideal_flash?,
        miss_costs_twice: miss_costs_twice?,
    };
    print!("\n{} Command: {}\n\n", figures.conditions, figures.command);
    print!("{}", table::text(page::HEAD, page::rows(&figures)));
    println!("\nPlanning and compiling on this computer: cargo bench -p isostep-profile");
    if let Some(path) = &args.json {
        isostep::files::write(path, (serde_json::to_string_pretty(&figures)? + "\n").as_bytes())?;
    }
    if let Some(folder) = &args.report {
        isostep::files::write_page(folder, &page::page(&figures))?;
    }
    let moved =
        |port: &Port| figures.chip.figure(&format!("{}.rate.3", port.key())).is_some_and(|rate| rate.value.is_some());
    ensure!(args.ports().iter().any(moved), "no move went through on any port");
    Ok(())
}

fn on_chip(chip: Chip, images: &Images, folder: &Path, args: &Args) -> Result<Findings> {
    let effort = if args.quick { Effort::quick(chip) } else { Effort::full(chip) };
    let mut found = Findings::default();
    for candidate in &images.candidates {
        measure(candidate, Runs::new(candidate, chip, folder), &effort, &mut found)?;
    }
    if effort.mathematics && args.mathematics() {
        announce(&format!("mathematics, {}", chip.name()));
        mathematics::measure(&images.mathematics, &images.emulator, chip, folder, &mut found)?;
        eprintln!("    every result of the chip's is this computer's, to the bit");
    }
    Ok(found)
}

fn measure(candidate: &Candidate, runs: Runs, effort: &Effort, found: &mut Findings) -> Result<()> {
    let (port, chip) = (candidate.port, runs.chip);
    announce(&format!("{}, {}", port.name(), chip.name()));
    let mut of_port = Findings::default();
    let highest_steps_s = machine(runs, port, effort, &mut of_port)?;
    if effort.starts > 0 {
        starts::measure(&mut emulated(runs, port, effort), &mut of_port, effort.starts)?;
    }
    levels::measure(&runs, &mut of_port, effort.moves)?;
    outputs::measure(&runs, &mut of_port, effort.stops)?;
    found.add_part(port.key(), port.name(), of_port);
    // Nothing of a second motor is in flash, so the ideal one shows nothing new. A proving image does not drive it.
    if chip != Chip::IdealFlash && !candidate.proves {
        let mut of_machine = Findings::default();
        machine(runs.with_second(), port, &effort.with_second(highest_steps_s), &mut of_machine)?;
        found.add_part(&format!("{}.second", port.key()), &format!("{}, two motors on Y", port.name()), of_machine);
    }
    Ok(())
}

fn emulated<'a>(runs: Runs<'a>, port: Port, effort: &Effort) -> Emulated<'a> {
    Emulated { runs, port, load_s: effort.load_s.unwrap_or_default() }
}

/// Measures a port on a machine with or without a second motor. Returns the highest rate of all axes at once, steps/s.
fn machine(runs: Runs, port: Port, effort: &Effort, found: &mut Findings) -> Result<Option<u32>> {
    let mut board = emulated(runs, port, effort);
    let trials = Trials { axes: effort.axes, rates: &effort.rates, ramp: RAMP, cruise_s: effort.cruise_s };
    let highest_steps_s = rates::measure(&mut board, found, &trials)?;
    // A move at the target rate; if that fails, one at the highest rate that was sustained too.
    let mut rate_steps_s = port.target_steps_s();
    if !long_move(&mut board, found, rate_steps_s, effort)?
        && let Some(less) = highest_steps_s.filter(|rate| *rate < rate_steps_s)
    {
        rate_steps_s = less;
        long_move(&mut board, found, rate_steps_s, effort)?;
    }
    if effort.load_s.is_some() {
        load::measure(&mut board, found, port.load_rates_steps_s())?;
    }
    stops::measure(&mut board, found, causes(port, runs.has_second), rate_steps_s, effort.stops)?;
    // Those of the slower port take the longest of all, and a third of them shows the rate too.
    let is_figure = port == Port::Pio || (runs.chip == Chip::AsItIs && !runs.has_second);
    let curve = curve(if is_figure { effort.moves } else { effort.moves / 3 }, port.moves_feed_mm_min());
    moves::measure(&mut board, found, &curve, &Corners::ALL)?;
    for (key, target) in port.targets() {
        found.promise(&key, target);
    }
    Ok(highest_steps_s)
}

/// A port that faults is measured without a second motor, which has its words from the same one. A TimerPort does not run dry:
/// its steps come too late.
fn causes(port: Port, has_second: bool) -> &'static [Cause] {
    match (has_second, port) {
        (true, _) => &[Cause::FirstMotor, Cause::SecondMotor, Cause::EmergencyStop, Cause::SecondReset],
        (false, Port::Pio) => &[Cause::LimitSwitch, Cause::EmergencyStop, Cause::SecondReset, Cause::DryPort],
        (false, Port::Timer) => &[Cause::LimitSwitch, Cause::EmergencyStop, Cause::SecondReset, Cause::LateStep],
    }
}

/// Compares every edge of a long move of three axes, from the first one on, with its closed form. Returns whether it went
/// through.
fn long_move(board: &mut Emulated, found: &mut Findings, rate_steps_s: u32, effort: &Effort) -> Result<bool> {
    let machine = Machine::new(rate_steps_s, RAMP);
    let planned = machine.straight(PROVED, effort.long_move_s - 2.0 * RAMP.s)?;
    let edges = Edges {
        key: format!("edges.{rate_steps_s}"),
        of: format!("{}, a move of {:.1} s", together(rate_steps_s), planned.duration_s()),
        unit_ns: board.method().unit_ns,
        flatters: board.method().edges,
        made: planned.edges(),
    };
    board.note(&format!("edges, {}", edges.of));
    let followed = match board.follow(&machine, &[planned])? {
        Ok(followed) => followed,
        Err(why_not) => {
            found.add(edges.worst().missing(&*why_not));
            found.add(edges.figure("p99", "99 % of the edges within", "ns").missing(why_not));
            return Ok(false);
        }
    };
    let mut add = |key: &str, what: &str, unit: &str, value: f64, finely: &str| {
        found.add(edges.figure(key, what, unit).measured(value, finely));
    };
    let [earliest_ns, latest_ns] = followed.errors.extremes_ns();
    let unit = finely(edges.unit_ns);
    add("earliest", "earliest edge", "ns", earliest_ns, &unit);
    add("latest", "latest edge", "ns", latest_ns, &unit);
    if let Some(drift) = followed.drift {
        let mean = "a mean of many edges";
        add("drift", "drift", "ns/s", drift.slope_ns_s, mean);
        let ends = grouped(drift.end_edges);
        add("ends", &format!("the last {ends} edges less the first {ends}"), "ns", drift.last_less_first_ns, mean);
    }
    edges.add(found, followed.errors, None);
    Ok(true)
}

/// The short moves whose mathematics is timed too, at a feed that the core can hardly keep.
fn curve(moves: usize, feed_mm_min: f64) -> Curve {
    let mut path = rp2040_bench::Path::new(&FLOW_CASES[0]);
    let (mut lines, mut steps, mut made) = (Vec::new(), Vec::new(), 0);
    for _ in 0..moves {
        let from = path.place_steps();
        lines.push(String::from_utf8_lossy(path.next_line().bytes()).trim_end().to_owned());
        made += from.iter().zip(path.place_steps()).map(|(&from, to)| u64::from(to.abs_diff(from))).sum::<u64>();
        steps.push(made);
    }
    Curve { begin_mm: [START_MM; PROVED], feed_mm_min, lines, steps }
}

fn command(args: &Args) -> String {
    let quick = if args.quick { " --quick" } else { "" };
    let board = if args.board == Model::default() { String::new() } else { format!(" --board {}", args.board.name()) };
    let port = args.port.map_or("", |port| if port == Port::Pio { " --port pio" } else { " --port timer" });
    let prove = if args.prove { " --prove" } else { "" };
    format!("cargo xtask bench{quick}{board}{port}{prove}")
}

fn conditions(args: &Args, driver: &str, miss_cycles: u32) -> String {
    let board = match args.board {
        Model::Pico => "emulated",
        Model::Pico2 => "emulated Pico 2, the timing of whose core is assumed",
        Model::SkrPico => "emulated SKR Pico",
    };
    let rest = if args.board == Model::Pico2 { " The mathematics are measured on an RP2040 alone." } else { "" };
    format!(
        "All figures: {board}, {}, flash read through the chip's cache, emulated too ({miss_cycles} cycles for a word \
         that it does not hold), {}; driver {}, status polled over USB at {POLL_HZ} Hz; from rest in {} s, at most {} steps/s2.{rest}",
        args.board.clocked(),
        candidate::build_options(),
        driver.to_uppercase(),
        RAMP.s,
        grouped(ACCEL_MAX_STEPS_S2 as u64),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_has_its_moves_and_their_steps() {
        let curve = curve(8, 60_000.0);
        assert_eq!(curve.lines[0], "G1X500.180Y500.004Z500.080");
        // A move of 0.2 mm has 14.4, 0.3 and 6.4 steps.
        assert_eq!((curve.lines.len(), curve.steps.len(), curve.steps[0]), (8, 8, 14 + 6));
    }
}
