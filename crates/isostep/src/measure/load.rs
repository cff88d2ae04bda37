//! The core's load while three axes cruise and in ramps, and how long an interrupt waits meanwhile.

use anyhow::Result;

use super::board::Board;
use super::figure::{Better, Figure, Findings};
use super::together;
use crate::screen::grouped;

/// The load of the core at one rate.
#[derive(Clone, Debug)]
pub struct Load {
    /// While three axes cruise.
    pub cruising: Awake,
    /// On the ramps to the rate and down again, where these can be measured alone.
    pub ramping: Option<Awake>,
    /// The longest time for which an interrupt waited, where that is measured, us.
    pub waited_us: Option<f64>,
    /// The resolution of the share of the time, in words.
    pub resolution: String,
}

/// The share of the time in which the core is awake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Awake {
    /// The fraction of the time.
    pub ratio: f64,
    /// Cycles for each step, where steps are counted: planning and console are among them.
    pub cycles_per_step: Option<f64>,
}

/// Measures at each of these rates.
///
/// # Errors
/// When the board is gone.
pub fn measure(board: &mut dyn Board, found: &mut Findings, rates_steps_s: &[u32]) -> Result<()> {
    let mut waited_us: Option<f64> = None;
    for &rate_steps_s in rates_steps_s {
        board.note(&format!("load of the core at {}", together(rate_steps_s)));
        let (key, rate) = (format!("load.{rate_steps_s}"), grouped(rate_steps_s.into()));
        let cruising = format!("core awake while 3 axes cruise at {rate} steps/s");
        let load = match board.load(rate_steps_s)? {
            Ok(load) => load,
            Err(why_not) => {
                found.add(Figure::new(key, cruising, "%").missing(why_not));
                continue;
            }
        };
        add(found, &key, &cruising, load.cruising, &load.resolution, board.method().load);
        if let Some(ramping) = load.ramping {
            let what = format!("core awake on the ramps of 3 axes to {rate} steps/s and down again");
            add(found, &format!("{key}.ramps"), &what, ramping, &load.resolution, "");
        }
        waited_us = load.waited_us.map(|us| waited_us.unwrap_or(0.0).max(us)).or(waited_us);
    }
    if let Some(us) = waited_us {
        let what = "longest time for which an interrupt waited, in these moves";
        let figure = Figure::new("mask", what, "us").measured(us, "a cycle of the clock, a look each 20,011 cycles");
        let flatters = "a look each 20,011 cycles may miss the longest; programming the flash, at rest, is not in it";
        found.add(figure.flattered_by(flatters).compared(Better::Lower, 0.2, 0.5));
    }
    Ok(())
}

fn add(found: &mut Findings, key: &str, what: &str, awake: Awake, resolution: &str, flatters: &str) {
    let percent = (awake.ratio * 1e4).round() / 100.0;
    let figure = Figure::new(key, what, "%").measured(percent, resolution).flattered_by(flatters);
    found.add(figure.compared(Better::Lower, 0.1, 0.5));
    if let Some(cycles) = awake.cycles_per_step {
        let figure = Figure::new(format!("{key}.cycles"), format!("{what}: cycles for each step"), "cycles");
        found.add(figure.measured(cycles, resolution).compared(Better::Lower, 0.1, 1.0));
    }
}
