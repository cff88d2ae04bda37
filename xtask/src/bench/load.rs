//! What steps cost the core: three axes at a steady rate, and in ramps alone.

use anyhow::Result;
use serde::Serialize;

use super::board::{Board, Moving};
use super::effort::Effort;
use super::measured::Measured;
use super::progress::Case;
use super::rates::RAMP_S;
use super::trial::{AXES, Machine, Ramp, Trial};
use super::variant::Port;

/// The load at one rate.
#[derive(Clone, Debug, Serialize)]
pub struct LoadFigures {
    /// Of each of the three axes.
    pub rate_steps_s: u32,
    /// All the way at the rate.
    pub cruising: Measured<Moving>,
    /// Half the way up to the rate and half the way down.
    pub ramping: Measured<Moving>,
}

/// At each of the port's rates.
pub fn measure(board: &Board, port: Port, effort: &Effort) -> Result<Vec<LoadFigures>> {
    port.load_rates_steps_s().iter().map(|&rate_steps_s| at(board, port, rate_steps_s, effort)).collect()
}

fn at(board: &Board, port: Port, rate_steps_s: u32, effort: &Effort) -> Result<LoadFigures> {
    let case = Case::begin(port, AXES, rate_steps_s, "load");
    let cruising = moving(board, rate_steps_s, Ramp::None, effort.load_s)?;
    let ramping = moving(board, rate_steps_s, Ramp::FromRest(RAMP_S), 0.0)?;
    let percent = |moving: &Moving| format!("{:.1} %", moving.load * 100.0);
    case.end(&format!("cruising {}, in ramps {}", cruising.words(percent), ramping.words(percent)));
    Ok(LoadFigures { rate_steps_s, cruising, ramping })
}

fn moving(board: &Board, rate_steps_s: u32, ramp: Ramp, cruise_s: f64) -> Result<Measured<Moving>> {
    let machine = Machine::new(rate_steps_s, ramp);
    let steps = machine.steps_of(cruise_s);
    let trial = Trial::new(machine, AXES, steps, false);
    Ok(board.run(&trial.script(), trial.duration_s()?)?.map(|summary| summary.moving))
}
