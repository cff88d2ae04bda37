//! The highest rate at which axes step at once, through whole moves, by bisection.

use anyhow::Result;

use super::super::course::{Machine, PROVED};
use super::super::edges::{self, Fault};
use super::super::proof::{Better, Figure};
use super::{Bench, PADS};

const RAMP_S: f64 = 0.1;
const CRUISE_S: f64 = 0.05;
/// No port on this chip makes more: a pulse and its pause take 26 cycles.
const RATE_MAX: u32 = 4_000_000;

pub fn measure(bench: &mut Bench) -> Result<()> {
    let step = bench.how.effort.rate_step;
    for axes in 1..=PROVED {
        // In steps of the search: the lower one works, the upper one does not.
        let (mut works, mut fails) = (0, RATE_MAX / step + 1);
        while fails - works > 1 {
            let middle = (works + fails) / 2;
            bench.progress.step(&format!(
                "highest rate of {axes} axes: trying {} steps/s",
                crate::screen::grouped((middle * step).into())
            ));
            if sustains(bench, axes, middle * step)? { works = middle } else { fails = middle }
        }
        let figure =
            Figure::new(format!("rate.{axes}"), format!("highest rate of {axes} axes at once, of each"), "steps/s")
                .measured(f64::from(works * step), format!("{} steps/s", crate::screen::grouped(step.into())))
                .flattered_by("one window in the middle of each move and its end are looked at, not every edge")
                .compared(Better::Higher, 0.0, f64::from(step));
        bench.add(figure);
    }
    Ok(())
}

/// Whether a move at this rate is accepted, ends without an alarm, and loses no edge.
fn sustains(bench: &mut Bench, axes: usize, rate_steps_s: u32) -> Result<bool> {
    let machine = Machine::new(rate_steps_s, RAMP_S);
    // The board may refuse the rate, which is an answer; if it is gone, the next line says so.
    if bench.set_up(&machine).is_err() {
        bench.settle()?;
        return Ok(false);
    }
    let steps = machine.steps_of(CRUISE_S);
    let course = machine.course(std::array::from_fn(|axis| if axis < axes { steps } else { 0 }))?;
    for course in [course.clone(), course.back()] {
        let skip = course.steps_by(0, course.duration_s() / 2.0);
        let moved = bench.stamped(&course, PADS, skip);
        let Ok((stamps, None)) = moved else {
            bench.settle()?;
            return Ok(false);
        };
        let windows = bench.windows(&[0, 1, 2][..axes], &stamps, skip);
        let is_broken = |fault: &Fault| !matches!(fault, Fault::OutOfLine { .. } | Fault::Far { .. });
        if edges::judge(&course, &windows).faults.iter().any(is_broken) {
            return Ok(false);
        }
    }
    Ok(true)
}
