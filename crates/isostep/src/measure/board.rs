//! The board under test, as the measurements see it.

use anyhow::Result;

use super::errors::{DriftFigures, Errors};
use super::load::Load;
use super::moves::{Carried, Stream};
use super::planned_move::{Machine, PlannedMove};
use super::starts::Starts;
use super::stops::{Cause, Stops};

/// A result of a board, or in words why there is none.
pub type Measured<T> = Result<T, String>;

/// A board that moves and can be looked at. Each call begins with a machine at rest and without an alarm, and ends so. An
/// error is returned only if the board is gone, or the user has interrupted.
pub trait Board {
    /// The resolution of its figures, and what flatters them.
    fn method(&self) -> Method;

    /// Shows what is measured now, or what has come out.
    fn note(&mut self, what: &str);

    /// Makes these moves one after the other, and compares the edges that are seen with the closed form.
    ///
    /// # Errors
    /// When the board is gone.
    fn follow(&mut self, machine: &Machine, moves: &[PlannedMove]) -> Result<Measured<Followed>>;

    /// Measures the core's load with three axes at a rate.
    ///
    /// # Errors
    /// When the board is gone.
    fn load(&mut self, rate_steps_s: u32) -> Result<Measured<Load>>;

    /// Stops `count` moves of three axes.
    ///
    /// # Errors
    /// When the board is gone.
    fn stops(&mut self, cause: Cause, rate_steps_s: u32, count: u32) -> Result<Measured<Stops>>;

    /// Starts `count` moves of three axes with flash's cache empty, and as many right after a move of the same kind.
    ///
    /// # Errors
    /// When the board is gone.
    fn starts(&mut self, count: u32) -> Result<Measured<Starts>>;

    /// Sends the lines of a stream as far ahead as the window of characters allows.
    ///
    /// # Errors
    /// When the board is gone.
    fn stream(&mut self, stream: &Stream) -> Result<Measured<Carried>>;
}

/// The edges of some moves, compared with the closed form.
#[derive(Clone, Debug, Default)]
pub struct Followed {
    /// The errors of the edges that were seen.
    pub errors: Errors,
    /// The drift in the first move, where every edge is seen.
    pub drift: Option<DriftFigures>,
}

/// The resolution of a board's figures, and the reasons why they look better than they are, in words.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// The unit of an edge's instant, ns.
    pub unit_ns: f64,
    /// Event from which a start is timed.
    pub start_from: &'static str,
    /// Reasons for edges.
    pub edges: &'static str,
    /// Reasons for the highest rates.
    pub rates: &'static str,
    /// Reasons for the load.
    pub load: &'static str,
    /// Reasons for starts.
    pub starts: &'static str,
    /// Reasons for short moves.
    pub moves: &'static str,
}
