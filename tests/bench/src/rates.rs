//! Measures the highest rate that a port sustains, in moves there and back, from rest through both ramps.

use anyhow::Result;
use serde::Serialize;

use super::board::Board;
use super::effort::Effort;
use super::measured::Measured;
use super::port::Port;
use super::progress::Case;
use super::search::{self, Found};
use super::statistics::ErrorFigures;
use super::trial::{Machine, Trial};

/// Time from rest to the rate, s. The ramp is longer where this time would need more than the highest acceleration.
pub const RAMP_S: f64 = 0.2;

/// The result for a number of axes.
#[derive(Clone, Debug, Serialize)]
pub struct RateFigures {
    /// Axes that move at once, at the same rate.
    pub axes: usize,
    /// The highest rate of each axis that was sustained; null if even the lowest rate failed.
    pub highest_steps_s: Option<u32>,
    /// The errors over the whole moves at that rate.
    pub errors: Option<ErrorFigures>,
    /// The next higher rate.
    pub next_steps_s: Option<u32>,
    /// Why the next higher rate was not sustained.
    pub why_not: Option<String>,
}

/// Searches the highest rate for each number of axes.
pub fn measure(board: &Board, port: Port, effort: &Effort) -> Result<Vec<RateFigures>> {
    let each = effort.axes.iter().map(|&axes| {
        let found = search::highest(&effort.rates, |rate| sustained(board, port, axes, rate, effort.cruise_s))?;
        Ok(figures(axes, found))
    });
    each.collect()
}

/// The highest rate sustained by this number of axes at once, steps/s of each.
pub fn highest_steps_s(figures: &[RateFigures], axes: usize) -> Option<u32> {
    figures.iter().find(|figures| figures.axes == axes)?.highest_steps_s
}

fn figures(axes: usize, found: Found<ErrorFigures, String>) -> RateFigures {
    let (highest_steps_s, errors) = found.highest.unzip();
    let (next_steps_s, why_not) = found.next.unzip();
    RateFigures { axes, highest_steps_s, errors, next_steps_s, why_not }
}

/// Tries a rate. It is sustained if every line is accepted, no alarm occurs, the driver's timing is kept, and every
/// edge is nearer to its own instant than to those of its neighbours.
fn sustained(
    board: &Board,
    port: Port,
    axes: usize,
    rate_steps_s: u32,
    cruise_s: f64,
) -> Result<Result<ErrorFigures, String>> {
    let case = Case::begin(board.chip, port, axes, rate_steps_s, &board.named("there and back"));
    let machine = Machine::new(rate_steps_s, RAMP_S);
    let steps = machine.steps_of(cruise_s);
    let verdict = match board.follow(&Trial::new(machine, axes, steps, true))? {
        Measured::Figure(followed) => in_place(followed.figures(), rate_steps_s),
        Measured::Missing { why_not } => Err(why_not),
    };
    case.end(&match &verdict {
        Ok(figures) => format!("sustained, edges within {:.0} ns", figures.max_ns),
        Err(why) => format!("not sustained: {why}"),
    });
    Ok(verdict)
}

fn in_place(errors: ErrorFigures, rate_steps_s: u32) -> Result<ErrorFigures, String> {
    let half_period_ns = 0.5e9 / f64::from(rate_steps_s);
    if errors.max_ns <= half_period_ns {
        return Ok(errors);
    }
    Err(format!("an edge was {:.0} ns from its instant, above half a period ({half_period_ns:.0} ns)", errors.max_ns))
}
