//! Measures boards: one set of measurements, statistics, figures and tables over every [`Board`].
//!
//! ```text
//! planned_move: a move, as lines and in closed form -- board: makes it, and tells what it saw -- a file for each measurement
//!                                                                                              |
//!                                          errors: statistics -- figure: value, resolution, promise -- table
//! ```
//! There are two boards. One has the proving image, whose own PIO samples its pins ([`crate::prove`]). The other is emulated,
//! and its emulator tells every edge (`tests/bench`).

pub mod board;
pub mod edges;
pub mod errors;
pub mod figure;
pub mod load;
pub mod moves;
pub mod planned_move;
pub mod rates;
pub mod search;
pub mod starts;
pub mod stops;
pub mod table;

pub use self::board::{Board, Measured, Method};
pub use self::figure::{Better, EdgeErrors, Figure, Findings};
pub use self::planned_move::{Machine, PlannedMove, Ramp};

use crate::screen::grouped;

/// A time of a few cycles, in words: a cycle of some chips is no whole number of ns.
pub fn finely(ns: f64) -> String {
    format!("{} ns", (ns * 100.0).round() / 100.0)
}

/// A rate of three axes at once, in words.
pub fn together(rate_steps_s: u32) -> String {
    format!("{} x {} steps/s", planned_move::PROVED, grouped(rate_steps_s.into()))
}
