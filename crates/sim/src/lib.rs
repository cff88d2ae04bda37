//! The controller on the host, in virtual time, in a simulated world that detects its errors.
//!
//! # Design
//! ```text
//!            sender --bytes-- link --- Controller::serve          the tasks of the firmware,
//!                                          |                      unchanged, on `executor`
//!                                  coordinator, axes, limits      and `time`
//!                                          |
//!                                        pins                     embedded-hal
//!                                          |
//!   world:  driver inputs -> motor -> carriage -> limit switch    what the edges do
//!              |              |          |
//!          violations     lost steps   end stops                  what they must not
//! ```
//! - [`executor`] and [`time`] make a run a function of its tasks: no wall clock, no threads, no hash order.
//! - [`world`] checks every edge as it happens: the timing of the [`driver`], the torque of the motor ([`drive`]), the
//!   end stops.
//! - [`drivers`] models TMC2209s, registers and all.
//! - [`verify`] checks every move afterwards, against the closed form of its plan, and a shaped run as a whole ([`places`]). [`measure`] finds the intervals of
//!   each axis from its edges alone, and how close it came to its limits. [`corners`] computes how much its speed jumps
//!   from move to move.
//! - [`losses`] explains lost steps: the line, what the motor has, and what to set.
//! - [`trace`] and [`vcd`] write the results; equal runs give equal bytes. Figures and pictures of a run are made by the
//!   crate isostep-report.
//! - [`homing`] homes an axis many times, to measure how accurately its zero is found.
//! - [`analysis`] computes derivatives, and models what a profile's acceleration does to a carriage that oscillates.
//!
//! [`run`] runs a whole program. [`Sim`] is the same machine, run step by step for dialogues.
//!
//! ```
//! use isostep_sim::{Config, run, verify};
//!
//! let outcome = run(b"G21 G91\nG0 X10 Y4\nG0 Z0.02\n", &Config::default())?;
//! assert_eq!(outcome.position_steps, [500, 200, 1]);
//! let verdicts = verify::verdicts(&outcome, &verify::moves(&outcome).collect());
//! assert!(verdicts.iter().all(|verdict| verdict.kept));
//! # Ok::<(), isostep_sim::SimError>(())
//! ```
#![forbid(unsafe_code)]

pub mod analysis;
mod carriage;
pub mod config;
pub mod corners;
pub mod drive;
pub mod driver;
pub mod drivers;
pub mod executor;
pub mod faults;
pub mod flash;
pub mod homing;
pub mod lines_of_moves;
pub mod link;
pub mod losses;
pub mod measure;
mod mechanics;
mod motor;
mod moves;
mod outcome;
pub mod pin;
pub mod places;
mod plant;
pub mod plate;
pub mod port;
pub mod program;
mod record;
pub mod settings;
mod sim;
pub mod springs;
pub mod stream;
mod suffering;
pub mod swarm;
pub mod time;
pub mod tool;
pub mod trace;
pub mod vcd;
pub mod verify;
pub mod vfd;
pub mod world;

pub use isostep_console::Error as ConsoleError;
pub use isostep_motion::{AXES, Axis, Contact, Motor, State};

/// The letters of the axes, for a sentence.
pub const NAMES_OF_AXES: &str = match AXES {
    2 => "X or Y",
    3 => "X, Y or Z",
    _ => "X, Y, Z or A",
};

pub use config::{Board, Config, Gantry, Port, StartOutside, Streaming};
pub use executor::RunError;
pub use faults::Fault;
pub use flash::Flash;
pub use moves::MoveRecord;
pub use outcome::Outcome;
pub use plant::{SwitchFault, UnknownFault};
pub use sim::{Came, Progress, Silencer, Sim, SimError, Stimulus, Streamed, run, run_watched, run_with};

/// The examples of the README are run as those here are.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
