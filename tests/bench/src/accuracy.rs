//! Measures the error of every edge: a long move of three axes with both ramps is compared with its closed form.

use anyhow::Result;
use serde::Serialize;

use super::board::Board;
use super::effort::Effort;
use super::measured::Measured;
use super::port::Port;
use super::progress::Case;
use super::rates::RAMP_S;
use super::statistics::{DriftFigures, ErrorFigures};
use super::trial::{AXES, Machine, Trial};

/// Bars of the histogram.
const BINS: i64 = 80;

/// The errors at one rate.
#[derive(Clone, Debug, Serialize)]
pub struct AccuracyFigures {
    /// The rate of each of the three axes.
    pub rate_steps_s: u32,
    /// The errors in one move.
    pub edges: Measured<MoveErrors>,
}

/// The errors of one move.
#[derive(Clone, Debug, Serialize)]
pub struct MoveErrors {
    /// How long the move takes, s.
    pub move_s: f64,
    /// The errors of all edges.
    pub errors: ErrorFigures,
    /// The drift over the move.
    pub drift: DriftFigures,
    /// The middle of each bin, ns, and the fraction of the edges in that bin.
    pub histogram: Vec<(f64, f64)>,
}

/// Measures a move at the target rate. If that fails, measures a move at the highest rate that was sustained.
pub fn measure(board: &Board, port: Port, sustained_steps_s: Option<u32>, effort: &Effort) -> Result<AccuracyFigures> {
    let target_steps_s = port.target_steps_s();
    let aimed = at(board, port, target_steps_s, effort)?;
    match (&aimed.edges, sustained_steps_s) {
        (Measured::Missing { .. }, Some(less)) if less < target_steps_s => at(board, port, less, effort),
        _ => Ok(aimed),
    }
}

fn at(board: &Board, port: Port, rate_steps_s: u32, effort: &Effort) -> Result<AccuracyFigures> {
    let case = Case::begin(
        board.chip,
        port,
        AXES,
        rate_steps_s,
        &board.named(&format!("one move of {} s", effort.long_move_s)),
    );
    let machine = Machine::new(rate_steps_s, RAMP_S);
    let steps = machine.steps_of(effort.long_move_s - 2.0 * RAMP_S);
    let trial = Trial::new(machine, AXES, steps, false);
    let move_s = trial.duration_s()?;
    let edges = board.follow(&trial)?.map(|followed| MoveErrors {
        move_s,
        errors: followed.errors.figures(),
        drift: followed.drift,
        histogram: followed.errors.histogram(BINS),
    });
    case.end(&edges.words(|MoveErrors { errors, .. }| {
        format!("edges within {:.0} ns, p99 {:.0} ns", errors.max_ns, errors.p99_ns)
    }));
    Ok(AccuracyFigures { rate_steps_s, edges })
}
