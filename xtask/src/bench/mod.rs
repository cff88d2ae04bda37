//! `cargo xtask bench`: what the firmware's step ports carry, on the emulated board.
//!
//! # Design
//! ```text
//! trial: settings and moves --script--> board: the firmware, emulated --edges--> follow: every edge
//!              |                                |                                  |
//!              +---- plans in closed form ------|----------------------------------+
//!                                               |
//!                   rates, accuracy, load, stops: one file a measurement
//!                                               |
//!                                  figures: table, JSON, report
//! ```
//! Nothing is asserted: a target that is not met is a figure like any other. Only a run that cannot be made is an error.

mod accuracy;
mod board;
mod edges;
mod effort;
mod figures;
mod follow;
mod load;
mod measured;
mod progress;
mod rates;
mod report;
mod search;
mod statistics;
mod stops;
mod table;
mod trial;
mod variant;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use self::board::{Board, CLOCK_HZ, POLL_HZ};
use self::effort::Effort;
use self::figures::{Conditions, Figures, PortFigures};
use self::trial::{ACCEL_MAX_STEPS_S2, AXES};
use self::variant::{DRIVER, Port, Variant};
use crate::process::announce;
use crate::{node, workspace};

/// Measure the firmware's step ports on the emulated board
#[derive(clap::Args)]
#[command(after_help = "\
What is measured, of PioPort and of TimerPort, three axes stepping at once and status polled over USB:
  rates     the highest rate sustained through whole moves, found by bisection: no line refused, no alarm, no gap,
            every edge nearer to its own instant than to its neighbours'; for 1, 2 and 3 axes
  accuracy  every edge of a 10 s move, ramps and cruise, against the closed form of its plan, from the first edge on:
            maximum, p99, histogram, and drift
  load      the share of the time that the core is awake, at a steady rate and in ramps
  stops     from a limit switch, the emergency stop or a reset byte to the last edge, at random instants of a fixed seed
The firmware is built for a TMC2209, whose least pulses (100 ns) do not limit the rate. Equal builds give equal figures.
Figures are printed beside their targets; a target that is not met is no error.

What planning and compiling a move cost on this computer: cargo bench -p isostep-profile

Examples:
  cargo xtask bench                                  everything, some minutes
  cargo xtask bench --quick                          shorter moves, fewer rates, below two minutes
  cargo xtask bench --port timer --json timer.json
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
    /// Only this port
    #[arg(long)]
    port: Option<Port>,
}

/// Runs the verb.
pub fn run(args: Args) -> Result<()> {
    let ports = args.port.map_or(Port::ALL.to_vec(), |port| vec![port]);
    let folder = workspace::target_dir().join("bench");
    fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    node::prepare()?;
    let variants = variant::build(&ports, &folder)?;
    let effort = if args.quick { Effort::quick() } else { Effort::full() };
    let ports = variants.iter().map(|variant| measure(variant, &folder, &effort)).collect::<Result<Vec<_>>>()?;
    let targets = ports.iter().flat_map(PortFigures::targets).collect();
    let figures = Figures { conditions: conditions(&args), ports, targets };
    print!("{}", table::table(&figures));
    write_files(&args, &figures)?;
    ensure!(figures.ports.iter().any(PortFigures::moved), "no move went through on any port");
    Ok(())
}

fn measure(variant: &Variant, folder: &Path, effort: &Effort) -> Result<PortFigures> {
    let port = variant.port;
    let board = Board::new(variant, folder);
    announce(&format!("{}: rates", port.name()));
    let rates = rates::measure(&board, port, effort)?;
    // The rate that is aimed at, or as much of it as there is.
    let target = port.target_steps_s();
    let rate = rates::highest_steps_s(&rates, AXES).map_or(target, |highest| highest.min(target));
    announce(&format!("{}: accuracy", port.name()));
    let accuracy = accuracy::measure(&board, port, rate, effort)?;
    announce(&format!("{}: load", port.name()));
    let load = load::measure(&board, port, effort)?;
    announce(&format!("{}: stops", port.name()));
    let stops = stops::measure(&board, port, rate, effort)?;
    Ok(PortFigures { port, rates, accuracy, load, stops })
}

fn conditions(args: &Args) -> Conditions {
    let quick = if args.quick { " --quick" } else { "" };
    let port = args.port.map_or("", |port| if port == Port::Pio { " --port pio" } else { " --port timer" });
    Conditions {
        command: format!("cargo xtask bench{quick}{port}"),
        board: "emulated",
        clock_hz: CLOCK_HZ,
        build: variant::build_options(),
        driver: DRIVER,
        poll_hz: POLL_HZ,
        ramp_s: rates::RAMP_S,
        accel_max_steps_s2: ACCEL_MAX_STEPS_S2,
    }
}

fn write_files(args: &Args, figures: &Figures) -> Result<()> {
    if let Some(path) = &args.json {
        write(path, &(serde_json::to_string_pretty(figures)? + "\n"))?;
    }
    if let Some(folder) = &args.report {
        fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
        for (name, text) in report::files(figures) {
            write(&folder.join(name), &text)?;
        }
    }
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<()> {
    fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))?;
    println!("wrote {}", path.display());
    Ok(())
}
