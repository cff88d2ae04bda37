//! The rules that the record of a run must keep, whatever was done to the machine.

use isostep_motion::{AXES, Axis};

use crate::losses;
use crate::measure::limits;
use crate::moves::MoveRecord;
use crate::outcome::Outcome;
use crate::record::{Loss, LossCause};
use crate::verify::{self, shaped};

/// The distance that one motor may go farther than the other: a step under way.
const OFF_SQUARE_MAX_STEPS: i32 = 1;

/// A broken promise, and what was found instead.
pub type Broken = (&'static str, String);

/// Judges a run at whose end the axes in `homed` count as homed. If faults of switches or motors have deceived the
/// machine, it cannot know that its position is wrong.
pub(super) fn judge(outcome: &Outcome, homed: [bool; AXES], is_deceived: bool) -> Result<(), Broken> {
    steps(outcome)?;
    limits(outcome)?;
    if is_deceived { Ok(()) } else { no_loss(outcome).and_then(|()| positions(outcome, homed)) }
}

/// Judges the steps of a run: no driver may misread an edge, counts are those of the edges, every edge is where the closed
/// form has it, paths are straight, axes equal, and moves as long as their plans.
///
/// # Errors
/// The first promise that is broken.
pub fn steps(outcome: &Outcome) -> Result<(), Broken> {
    timing(outcome)?;
    if outcome.motor_steps != outcome.counted_steps {
        let found = format!("says {:?}, made {:?}", outcome.motor_steps, outcome.counted_steps);
        return Err(("counts are those of the edges", found));
    }
    moves(outcome)?;
    shaped_runs(outcome)
}

/// No driver may misread an edge, at any instant.
pub(super) fn timing(outcome: &Outcome) -> Result<(), Broken> {
    match outcome.violations.first() {
        Some(violation) => Err(("driver timing kept", violation.to_string())),
        None => Ok(()),
    }
}

/// Every edge is at its closed-form instant, counts are exact, paths straight, axes equal, and moves as long as their
/// plans.
fn moves(outcome: &Outcome) -> Result<(), Broken> {
    let tolerance_ns = outcome.config.port.tolerance_ns();
    for check in verify::moves(outcome) {
        let record = &outcome.moves[check.index];
        let at = || format!("move {} from {:.6} s", check.index + 1, record.begin_ns() as f64 * 1e-9);
        if check.exact == Some(false) && record.is_whole() {
            let found = format!("{:?} of {:?} steps of {}", check.emitted_steps, record.planned_steps(), at());
            return Err(("steps are made as planned", found));
        }
        if check.error_max_ns() > tolerance_ns {
            return Err(("every step at its instant", format!("{:.0} ns off in {}", check.error_max_ns(), at())));
        }
        if !check.is_straight() {
            return Err(("paths straight within half a step", format!("{:?} in {}", check.path_deviation, at())));
        }
        if !check.is_equal() {
            return Err(("equal intervals on every axis", format!("{:?} s apart in {}", check.apart_s(), at())));
        }
    }
    for pair in outcome.moves.windows(2).filter(|pair| pair[0].is_whole()) {
        let (pause_ns, flows) = (pair[0].pause_ns(&pair[1]), pair[0].run == pair[1].run);
        // The end of a plan is computed in floating point.
        if pause_ns <= -1.0 || flows && pause_ns >= 1.0 {
            let found = format!("{pause_ns} ns from one to the next at {:.6} s", pair[1].begin_ns() as f64 * 1e-9);
            return Err(("every move as long as its plan", found));
        }
    }
    Ok(())
}

/// The same for shaped runs, each as a whole.
fn shaped_runs(outcome: &Outcome) -> Result<(), Broken> {
    for check in shaped::runs(outcome) {
        if check.error_max_ns() > outcome.config.port.tolerance_ns() {
            return Err(("every step of a shaped run at its instant", format!("{:?}", check.worst)));
        }
        if !check.is_exact() {
            return Err(("the steps of a shaped run are made as planned", format!("{check:?}")));
        }
    }
    Ok(())
}

/// Each axis stays within its speed, acceleration and jerk, measured by its edges alone, and corners are not taken too
/// fast.
fn limits(outcome: &Outcome) -> Result<(), Broken> {
    let top = |record: &MoveRecord, axis: usize, _t_s: f64| outcome.config_of(record).limits[axis].top_speed_steps_s;
    let ratios = limits::of_run(outcome, top);
    if ratios.are_within() { Ok(()) } else { Err(("limits kept, by the edges", format!("{ratios:?} of them"))) }
}

/// Steps are lost only by abrupt stops, and at the end stops if the machine does not know its position.
fn no_loss(outcome: &Outcome) -> Result<(), Broken> {
    let is_excused = |loss: &&Loss| loss.cause == LossCause::EndStop || losses::is_by_abrupt_stop(outcome, loss);
    match outcome.losses.iter().find(|loss| !is_excused(loss)) {
        Some(loss) => Err(("no step lost", loss.to_string())),
        None => Ok(()),
    }
}

/// An axis that counts as homed is at the position that the machine reports.
fn positions(outcome: &Outcome, homed: [bool; AXES]) -> Result<(), Broken> {
    // Without soft limits, the axis may have been sent to an end stop.
    let at_end_stop = |axis: Axis| {
        let mut losses = outcome.losses.iter().filter(|loss| loss.axis == axis as usize);
        let is_blocked = losses.any(|loss| loss.cause == LossCause::EndStop) || outcome.ahead_steps[axis as usize] != 0;
        !outcome.config.settings.soft_limits && is_blocked
    };
    let is_elsewhere =
        |axis: &Axis| homed[*axis as usize] && outcome.drift_steps[*axis as usize] != 0 && !at_end_stop(*axis);
    let second = outcome.second.filter(|second| homed[second.axis as usize] && !at_end_stop(second.axis));
    if let Some(second) = second.filter(|second| second.drift_steps != 0) {
        let found =
            format!("the second motor of {} is {} steps from where it should be", second.axis, second.drift_steps);
        return Err(("an axis that counts as homed is where it says", found));
    }
    if let Some(second) = second.filter(|second| second.off_square_steps.abs() > OFF_SQUARE_MAX_STEPS) {
        let found = format!("{} is {} steps out of square", second.axis, second.off_square_steps);
        return Err(("a squared axis is as square as its offset says", found));
    }
    match Axis::ALL.into_iter().find(is_elsewhere) {
        Some(axis) => {
            let found = format!("{axis} is {} steps from where it should be", outcome.drift_steps[axis as usize]);
            Err(("an axis that counts as homed is where it says", found))
        }
        None => Ok(()),
    }
}
