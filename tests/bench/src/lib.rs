//! Measures the firmware's step ports on the emulated board, for `cargo xtask bench`, which builds what is measured.
//!
//! # Design
//! ```text
//! trial: settings and moves --script--> board: the firmware, emulated --edges--> follow: every edge
//!              |                                |                                  |
//!              +---- plans in closed form ------|----------------------------------+
//!                                               |
//!              rates, accuracy, load, stops, starts, moves: one file a measurement
//!                                               |
//!                                  figures: table, JSON, report
//! ```
//! All of this is done on three chips (`chip`): the RP2040 as it is, one with ideal flash, and one with costly misses.
//! Nothing is asserted: a missed target is only marked in the figures. An error is returned only if a run cannot be
//! made.

#![forbid(unsafe_code)]

// All modules print with its macros.
#[macro_use]
extern crate isostep;

mod accuracy;
mod beside;
mod board;
mod candidate;
mod chip;
mod edges;
mod effort;
mod figures;
mod floats;
mod flow;
mod follow;
mod laws;
mod levels;
mod lines;
mod load;
mod measured;
mod micro;
mod moves;
mod outputs;
mod port;
mod progress;
mod rates;
mod report;
mod search;
mod starts;
mod statistics;
mod stops;
mod table;
mod target;
mod trial;

use std::fs;
use std::path::{Path, PathBuf};
use std::thread;

use anyhow::{Context, Result, ensure};

use self::board::{Board, CLOCK_HZ, POLL_HZ};
pub use self::candidate::{Candidate, Model};
use self::chip::Chip;
use self::effort::Effort;
use self::figures::{ChipFigures, Conditions, Figures, MachineFigures, PortFigures};
use self::micro::MicroFigures;
pub use self::port::Port;
use self::trial::{ACCEL_MAX_STEPS_S2, AXES};
use isostep::files::Files;
use isostep::screen::announce;

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
cycles to plan, to compile a segment and to replay a step under each speed law, and how far their speeds are off; and cycles of
a move of 0.2 mm of three axes that flows in a full chain: to read its line, to push it, to plan it and to compile that.
On which chip:
  the chip            the emulated RP2040, flash read through its cache: everything
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
}

impl Args {
    /// Whether the files can be written: it is asked before anything is built.
    ///
    /// # Errors
    /// A file or folder that cannot be written.
    pub fn check(&self) -> Result<()> {
        Files::default().page("--report", &self.report).written("--json", &self.json).check()
    }

    /// The ports that are measured, each of which needs a [`Candidate`].
    #[must_use]
    pub fn ports(&self) -> Vec<Port> {
        self.port.map_or(Port::ALL.to_vec(), |port| vec![port])
    }

    /// The board that is measured.
    #[must_use]
    pub fn model(&self) -> Model {
        self.board
    }

    /// Whether the mathematics is measured too.
    #[must_use]
    pub fn mathematics(&self) -> bool {
        self.port.is_none() && !self.prove
    }

    /// Whether it is the proving image that is measured.
    #[must_use]
    pub fn proves(&self) -> bool {
        self.prove
    }
}

/// What is measured.
pub struct Images {
    /// The firmware with each port.
    pub candidates: Vec<Candidate>,
    /// The firmware that times the mathematics.
    pub mathematics: PathBuf,
    /// The emulated board, which Node runs.
    pub emulator: PathBuf,
}

/// Runs the verb. `folder` is for the files of the runs.
///
/// # Errors
/// A run that cannot be made, or a file that cannot be written.
pub fn run(args: &Args, images: &Images, folder: &Path) -> Result<()> {
    let candidates = &images.candidates;
    let miss_cycles = Board::new(&candidates[0], Chip::AsItIs, folder).miss_cycles()?;
    let on = |chip: Chip| {
        let folder = folder.join(chip.slug());
        fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
        measure_on(chip, images, &folder, args)
    };
    // Two threads may run at once, because no figure depends on how long it takes to measure.
    let (chip, others) = thread::scope(|scope| {
        let others = scope.spawn(|| [Chip::IdealFlash, Chip::CostlyMiss].map(on));
        (on(Chip::AsItIs), others.join())
    });
    let [ideal_flash, miss_costs_twice] = others.expect("a measurement does not panic");
    let figures = Figures {
        conditions: conditions(args, candidates[0].driver, miss_cycles),
        chip: chip?,
        ideal_flash: ideal_flash?,
        miss_costs_twice: miss_costs_twice?,
    };
    print!("{}", table::table(&figures));
    write_files(args, &figures)?;
    ensure!(figures.chip.ports.iter().any(PortFigures::moved), "no move went through on any port");
    Ok(())
}

fn measure_on(chip: Chip, images: &Images, folder: &Path, args: &Args) -> Result<ChipFigures> {
    let effort = if args.quick { Effort::quick(chip) } else { Effort::full(chip) };
    let ports = images.candidates.iter().map(|candidate| measure(candidate, chip, folder, &effort));
    let ports = ports.collect::<Result<Vec<_>>>()?;
    let mathematics = effort.mathematics && args.mathematics();
    Ok(ChipFigures::new(ports, mathematics.then(|| self::mathematics(images, chip, folder)).transpose()?))
}

fn measure(candidate: &Candidate, chip: Chip, folder: &Path, effort: &Effort) -> Result<PortFigures> {
    let port = candidate.port;
    let board = Board::new(candidate, chip, folder);
    let begin = |what: &str| announce(&format!("{}, {}: {what}", port.name(), chip.name()));
    let machine = measure_machine(&board, port, effort)?;
    if effort.starts > 0 {
        begin("starts");
    }
    let starts = starts::measure(&board, port, effort)?;
    begin("levels");
    let levels = levels::measure(&board, port, effort)?;
    begin("outputs");
    let outputs = outputs::measure(&board, port, effort)?;
    let highest_steps_s = rates::highest_steps_s(&machine.rates, AXES);
    // Nothing of a second motor is in flash, so the ideal one shows nothing new. A proving image does not drive it.
    let has_second = chip != Chip::IdealFlash && !candidate.proves;
    let with_second = has_second
        .then(|| measure_machine(&board.with_second(), port, &effort.with_second(highest_steps_s)))
        .transpose()?;
    Ok(PortFigures { port, machine, starts, levels, outputs, with_second })
}

fn measure_machine(board: &Board, port: Port, effort: &Effort) -> Result<MachineFigures> {
    let begin = |what: &str| announce(&format!("{}, {}: {}", port.name(), board.chip.name(), board.named(what)));
    begin("rates");
    let rates = rates::measure(board, port, effort)?;
    begin("accuracy");
    let accuracy = accuracy::measure(board, port, rates::highest_steps_s(&rates, AXES), effort)?;
    if effort.load_s.is_some() {
        begin("load");
    }
    let load = load::measure(board, port, effort)?;
    begin("stops");
    let stops = stops::measure(board, port, accuracy.rate_steps_s, effort)?;
    begin("moves");
    let moves = moves::measure(board, port, effort)?;
    Ok(MachineFigures { has_second: board.has_second, rates, accuracy, load, stops, moves })
}

fn mathematics(images: &Images, chip: Chip, folder: &Path) -> Result<MicroFigures> {
    announce(&format!("mathematics, {}", chip.name()));
    let figures = micro::measure(&images.mathematics, &images.emulator, chip, folder)?;
    eprintln!("    every result of the chip's is this computer's, to the bit");
    Ok(figures)
}

fn conditions(args: &Args, driver: &'static str, miss_cycles: u32) -> Conditions {
    let quick = if args.quick { " --quick" } else { "" };
    let port = args.port.map_or("", |port| if port == Port::Pio { " --port pio" } else { " --port timer" });
    let prove = if args.prove { " --prove" } else { "" };
    let (board, name) = match args.board {
        Model::Pico => ("", "emulated"),
        Model::SkrPico => (" --board skr-pico", "emulated SKR Pico"),
    };
    Conditions {
        command: format!("cargo xtask bench{quick}{board}{port}{prove}"),
        board: name,
        clock_hz: CLOCK_HZ,
        flash: "read through the chip's cache, emulated too",
        miss_cycles,
        build: candidate::build_options(),
        driver,
        poll_hz: POLL_HZ,
        ramp_s: rates::RAMP_S,
        accel_max_steps_s2: ACCEL_MAX_STEPS_S2,
    }
}

fn write_files(args: &Args, figures: &Figures) -> Result<()> {
    if let Some(path) = &args.json {
        isostep::files::write(path, (serde_json::to_string_pretty(figures)? + "\n").as_bytes())?;
    }
    if let Some(folder) = &args.report {
        isostep::files::write_page(folder, &report::page(figures))?;
    }
    Ok(())
}
