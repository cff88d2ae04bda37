//! The highest rate at which axes step at once, in moves there and back, from rest through both ramps.

use anyhow::Result;

use super::board::{Board, Measured};
use super::errors::Errors;
use super::figure::{Better, Figure, Findings};
use super::planned_move::{Machine, Ramp};
use super::search;
use crate::screen::grouped;

/// The moves in which a rate is tried.
#[derive(Clone, Copy, Debug)]
pub struct Trials<'a> {
    /// Numbers of axes that move at once, in ascending order.
    pub axes: &'a [usize],
    /// The rates to choose from, in ascending order, steps/s.
    pub rates: &'a [u32],
    /// The ramps of each move.
    pub ramp: Ramp,
    /// Duration of its cruise, s.
    pub cruise_s: f64,
}

/// Finds the highest rate of each number of axes by bisection. Returns that of the last one, steps/s; `None` if even the
/// lowest failed.
///
/// # Errors
/// When the board is gone.
pub fn measure(board: &mut dyn Board, found: &mut Findings, trials: &Trials) -> Result<Option<u32>> {
    let mut last = None;
    for &axes in trials.axes {
        let result = search::highest(trials.rates, |rate| sustained(board, trials, axes, rate))?;
        last = result.highest.as_ref().map(|(rate, _)| *rate);
        let unit_ns = board.method().unit_ns;
        let number = format!("{axes} {}", if axes == 1 { "axis" } else { "axes" });
        let figure =
            Figure::new(format!("rate.{axes}"), format!("highest rate of {number} at once, of each"), "steps/s");
        let Some((rate, errors)) = result.highest else {
            found.add(figure.missing(result.next.map_or_else(String::new, |(_, why)| why)));
            continue;
        };
        let (step, finely) = result.next.map_or((0, "none higher was tried".to_owned()), |(next, why)| {
            let [apart, next_words] = [next - rate, next].map(|rate| grouped(rate.into()));
            (next - rate, format!("{apart} steps/s; not {next_words}: {why}"))
        });
        found.add(figure.measured(rate.into(), finely).flattered_by(board.method().rates).compared(
            Better::Higher,
            0.0,
            step.into(),
        ));
        let what = format!("farthest edge from the closed form in these moves of {number}");
        found.add(
            Figure::new(format!("rate.{axes}.edges"), what, "ns")
                .measured(errors.max_ns(), super::finely(unit_ns))
                .compared(Better::Lower, 0.0, unit_ns),
        );
    }
    Ok(last)
}

/// Tries a rate. It is sustained if every line is accepted, no alarm comes, no edge is lost, and every edge is nearer to its
/// own instant than to those of its neighbours.
fn sustained(board: &mut dyn Board, trials: &Trials, axes: usize, rate_steps_s: u32) -> Result<Measured<Errors>> {
    let tried = format!("{axes} x {} steps/s, there and back", grouped(rate_steps_s.into()));
    board.note(&tried);
    let machine = Machine::new(rate_steps_s, trials.ramp);
    let there = machine.straight(axes, trials.cruise_s)?;
    let followed = board.follow(&machine, &[there.clone(), there.back()])?;
    let sustained = followed.and_then(|followed| in_place(followed.errors, rate_steps_s));
    board.note(&match &sustained {
        Ok(errors) => format!("{tried}: sustained, edges within {:.0} ns", errors.max_ns()),
        Err(why) => format!("{tried}: not sustained: {why}"),
    });
    Ok(sustained)
}

fn in_place(errors: Errors, rate_steps_s: u32) -> Measured<Errors> {
    let half_period_ns = 0.5e9 / f64::from(rate_steps_s);
    if errors.max_ns() <= half_period_ns {
        return Ok(errors);
    }
    Err(format!("an edge was {:.0} ns from its instant, above half a period ({half_period_ns:.0} ns)", errors.max_ns()))
}
