//! The load of the core with three axes at a steady rate, and in ramps.
//!
//! Two moves have the same ramps, and one of them also has a cruise. The difference of their cycles is the cost of the
//! cruise.

use anyhow::Result;
use serde::Serialize;

use super::board::{Board, Moving};
use super::effort::Effort;
use super::measured::Measured;
use super::port::Port;
use super::progress::Case;
use super::rates::RAMP_S;
use super::trial::{AXES, Machine, Trial};

/// The load at one rate.
#[derive(Clone, Debug, Serialize)]
pub struct LoadFigures {
    /// The rate of each of the three axes.
    pub rate_steps_s: u32,
    /// The load at the rate.
    pub cruising: Measured<Moving>,
    /// The load on the ramps up to the rate and down again, each over half the distance.
    pub ramping: Measured<Moving>,
}

/// Measures at each of the port's rates, or not at all if `effort` says so.
pub fn measure(board: &Board, port: Port, effort: &Effort) -> Result<Vec<LoadFigures>> {
    let Some(cruise_s) = effort.load_s else { return Ok(Vec::new()) };
    port.load_rates_steps_s().iter().map(|&rate_steps_s| at(board, port, rate_steps_s, cruise_s)).collect()
}

fn at(board: &Board, port: Port, rate_steps_s: u32, cruise_s: f64) -> Result<LoadFigures> {
    let case = Case::begin(board.chip, port, AXES, rate_steps_s, &board.named("load"));
    let ramping = moving(board, rate_steps_s, 0.0)?;
    let whole = moving(board, rate_steps_s, cruise_s)?;
    let cruising = match (&whole, &ramping) {
        (Measured::Figure(whole), Measured::Figure(ramping)) => Measured::Figure(whole.less(ramping)),
        (missing @ Measured::Missing { .. }, _) | (_, missing) => missing.clone(),
    };
    let percent = |moving: &Moving| format!("{:.1} %", moving.load * 100.0);
    case.end(&format!("cruising {}, in ramps {}", cruising.words(percent), ramping.words(percent)));
    Ok(LoadFigures { rate_steps_s, cruising, ramping })
}

fn moving(board: &Board, rate_steps_s: u32, cruise_s: f64) -> Result<Measured<Moving>> {
    let machine = Machine::new(rate_steps_s, RAMP_S);
    let steps = machine.steps_of(cruise_s);
    let trial = Trial::new(machine, AXES, steps, false);
    Ok(board.run(&trial.script(), trial.duration_s()?)?.map(|summary| summary.moving))
}
