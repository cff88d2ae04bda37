//! Explains lost steps: the line and the move, what was asked of the motor there, what it has, and what to set.
//!
//! A rotor slips up to a swing after it was asked for too much. So the plans are searched for what strained the motor
//! most during one swing before: an acceleration, a jump of the speed, or a dead stop. Where the motor would take that alone, it
//! still swings from what came before, and half as much is what to set.

use std::f64::consts::TAU;
use std::fmt;
use std::ops::Range;

use isostep_motion::Config;

use crate::corners;
use crate::drive::Drive;
use crate::lines_of_moves::{self, Source};
use crate::moves::MoveRecord;
use crate::outcome::Outcome;
use crate::record::{Loss, LossCause};

/// Instants of a swing at which plans are looked at.
const INSTANTS: u32 = 32;
/// Swings after which a rotor has come to rest.
const SWINGS: f64 = 4.0;
/// The part of what the motor has that settings leave unused.
const MARGIN: f64 = 0.5;
/// Numbers that differ by no more than this part of them are the same: settings are single floats.
const SAME: f64 = 1e-6;

/// A loss, and what to do about it.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct LossFigures {
    /// The loss.
    #[serde(flatten)]
    pub loss: Loss,
    /// The line of the program, from 1; null if unknown.
    pub line: Option<usize>,
    /// Number of the move, from 1; null in homing and without a move.
    pub move_number: Option<usize>,
    /// The demand on the motor, what it has, and what to set.
    pub remedy: Option<String>,
}

impl fmt::Display for LossFigures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.loss)?;
        match (self.line, self.move_number) {
            (Some(line), Some(number)) => write!(f, ": line {line}, move {number}")?,
            (None, Some(number)) => write!(f, ": move {number}")?,
            _ => {}
        }
        self.remedy.as_ref().map_or(Ok(()), |remedy| write!(f, ": {remedy}"))
    }
}

/// Up to `most` losses of a run, explained.
pub fn explained(outcome: &Outcome, most: usize) -> Vec<LossFigures> {
    if outcome.losses.is_empty() {
        return Vec::new();
    }
    let sources = lines_of_moves::of_moves(outcome);
    outcome.losses.iter().take(most).map(|loss| explain(outcome, &sources, *loss)).collect()
}

fn explain(outcome: &Outcome, sources: &[Option<Source>], loss: Loss) -> LossFigures {
    let strain = move_at(outcome, loss.t_ns).map(|index| worst_strain(outcome, &loss, index));
    let blamed = strain.map(|strain| strain.index).filter(|&index| !outcome.moves[index].homing);
    LossFigures {
        loss,
        line: blamed.and_then(|index| sources[index]).map(|source| source.line),
        move_number: blamed.map(|index| outcome.move_number(index)),
        remedy: strain.and_then(|strain| remedy(outcome, &loss, &strain)),
    }
}

/// The last move to which the axes had come by this instant.
fn move_at(outcome: &Outcome, t_ns: u64) -> Option<usize> {
    outcome.moves.partition_point(|record| record.reached_ns() <= t_ns).checked_sub(1)
}

/// True if steps were lost because the machine was stopped before the end of a move, and not as it was planned.
pub(crate) fn is_by_abrupt_stop(outcome: &Outcome, loss: &Loss) -> bool {
    let is_planned = |index: usize| outcome.moves[index].is_whole() && !outcome.moves[index].homing;
    matches!(loss.cause, LossCause::Overshoot { .. }) && !move_at(outcome, loss.t_ns).is_some_and(is_planned)
}

fn drive(outcome: &Outcome, index: usize, axis: usize) -> Drive {
    outcome.config.mechanics(outcome.config_of(&outcome.moves[index])).drives[axis]
}

/// The strain of a motor.
#[derive(Clone, Copy, Debug)]
struct Strain {
    /// Index of the move.
    index: usize,
    asked: Asked,
    /// The share of what the motor takes; above 1 it slips.
    share: f64,
}

#[derive(Clone, Copy, Debug)]
enum Asked {
    /// An acceleration at a speed.
    Accel { mm_s2: f64, mm_s: f64 },
    /// A jump of the speed where the move begins: from standstill, or at a corner.
    Jump { mm_s: f64, from_rest: bool },
    /// A stop at once, from a speed: at a switch, by a reset, or by a fault.
    Stop { mm_s: f64 },
}

/// The greatest strain of the motor within a swing before the loss, while moves up to the one at `last` were made. If the motor
/// takes that, one that it did not take, and after which it still swings.
fn worst_strain(outcome: &Outcome, loss: &Loss, last: usize) -> Strain {
    let worst = worst_within(outcome, loss, last, 1.0);
    let before = if worst.share < 1.0 { worst_within(outcome, loss, last, SWINGS) } else { worst };
    if before.share < 1.0 { worst } else { before }
}

/// The same within so many swings.
fn worst_within(outcome: &Outcome, loss: &Loss, last: usize, swings: f64) -> Strain {
    let axis = loss.axis;
    let swing_s = swings * TAU / drive(outcome, last, axis).natural_rad_s();
    let begin_ns = loss.t_ns.saturating_sub((swing_s * 1e9) as u64);
    let mut worst = strain(outcome, axis, last, Asked::Accel { mm_s2: 0.0, mm_s: 0.0 });
    let mut add = |index: usize, asked: Asked| {
        let other = strain(outcome, axis, index, asked);
        if other.share > worst.share {
            worst = other;
        }
    };
    for part in 0..=INSTANTS {
        let t_ns = begin_ns + (loss.t_ns - begin_ns) * u64::from(part) / u64::from(INSTANTS);
        if let Some(index) = move_at(outcome, t_ns) {
            accel(outcome, &outcome.moves[index], axis, t_ns).into_iter().for_each(|asked| add(index, asked));
        }
    }
    let before = move_at(outcome, begin_ns);
    let stops = before.unwrap_or(0)..=last;
    stops.for_each(|index| {
        stop(outcome, axis, index, begin_ns..loss.t_ns).into_iter().for_each(|asked| add(index, asked))
    });
    (before.map_or(0, |index| index + 1)..=last).for_each(|index| add(index, jump(outcome, axis, index)));
    worst
}

/// The dead stop of an axis at the end of a move, if it has one within this time.
fn stop(outcome: &Outcome, axis: usize, index: usize, within_ns: Range<u64>) -> Option<Asked> {
    let record = &outcome.moves[index];
    let edges = outcome.edges_of(record);
    let t_ns = edges.iter().rfind(|edge| edge.axis == axis)?.t_ns;
    match accel(outcome, record, axis, t_ns)? {
        Asked::Accel { mm_s, .. } if !record.is_whole() && within_ns.contains(&t_ns) => Some(Asked::Stop { mm_s }),
        _ => None,
    }
}

fn strain(outcome: &Outcome, axis: usize, index: usize, asked: Asked) -> Strain {
    let drive = drive(outcome, index, axis);
    let share = match asked {
        Asked::Accel { mm_s2: 0.0, .. } => 0.0,
        Asked::Accel { mm_s2, mm_s } => mm_s2.abs() / drive.accel_mm_s2(mm_s).max(f64::MIN_POSITIVE),
        Asked::Jump { mm_s, .. } | Asked::Stop { mm_s } => mm_s / drive.jump_mm_s(),
    };
    Strain { index, asked, share }
}

/// The acceleration of an axis by the plan of a move, and its speed; `None` after the plan. A shaper only spreads it out.
fn accel(outcome: &Outcome, record: &MoveRecord, axis: usize, t_ns: u64) -> Option<Asked> {
    let t_s = t_ns.saturating_sub(record.start_ns) as f64 * 1e-9 - record.delay_s();
    let part = record.parts.iter().rev().find(|part| part.begin_s() <= t_s).unwrap_or(&record.plan);
    let steps_per_mm = outcome.config_of(record).steps_per_mm[axis];
    let share = record.plan.axis_steps(axis).abs() / record.plan.distance_steps() / steps_per_mm;
    (part.begin_s()..=record.plan_s).contains(&t_s).then(|| Asked::Accel {
        mm_s2: part.profile.accel_at(t_s - (part.end_s() - part.profile.duration_s())) * share,
        mm_s: part.speed_at(t_s) * share,
    })
}

/// The jump of an axis's speed at the beginning of a move. A shaper makes several of it, the largest as its largest weight.
fn jump(outcome: &Outcome, axis: usize, index: usize) -> Asked {
    let record = &outcome.moves[index];
    let weights = record.shaping.iter().flat_map(|shaping| shaping.impulses[axis].iter().map(|(weight, _)| weight));
    let share = weights.reduce(f64::max).unwrap_or(1.0);
    match index.checked_sub(1).map(|before| &outcome.moves[before]).filter(|before| before.run == record.run) {
        Some(before) => {
            Asked::Jump { mm_s: share * corners::jumps_mm_s(outcome, [before, record])[axis], from_rest: false }
        }
        None => {
            let share = share * record.plan.axis_steps(axis).abs() / record.plan.distance_steps();
            let entry = record.plan.profile.entry_speed_steps_s() * share;
            Asked::Jump { mm_s: entry / outcome.config_of(record).steps_per_mm[axis], from_rest: true }
        }
    }
}

fn remedy(outcome: &Outcome, loss: &Loss, strain: &Strain) -> Option<String> {
    use LossCause::{Bound, Disabled, DriverOff, EndStop, Overshoot, Stalled};
    let record = &outcome.moves[strain.index];
    let config = outcome.config_of(record);
    let drive = drive(outcome, strain.index, loss.axis);
    // What is set is less than what is set already.
    let most = if strain.share < 1.0 { MARGIN } else { f64::INFINITY };
    match (loss.cause, strain.asked) {
        (Disabled | DriverOff | EndStop | Stalled | Bound, _) => None,
        (_, Asked::Stop { mm_s }) if record.homing => Some(homing_remedy(config, loss.axis, &drive, mm_s, most)),
        (Overshoot { .. }, _) if is_by_abrupt_stop(outcome, loss) => Some(stop_remedy(&drive)),
        (_, Asked::Stop { .. }) => Some(stop_remedy(&drive)),
        (_, Asked::Jump { mm_s, from_rest }) => Some(jump_remedy(config, loss.axis, &drive, (mm_s, from_rest), most)),
        (_, Asked::Accel { mm_s2: 0.0, .. }) => None,
        (_, Asked::Accel { mm_s2, mm_s }) => Some(accel_remedy(config, loss.axis, &drive, (mm_s2, mm_s), most)),
    }
}

fn stop_remedy(drive: &Drive) -> String {
    format!("an abrupt stop loses nothing up to {:.0} mm/s: home again ($H)", drive.jump_mm_s())
}

/// Homing stops at once at its switch: the seek by `$25`, unless it has room to brake, the latch by `$24`.
fn homing_remedy(config: &Config, axis: usize, drive: &Drive, mm_s: f64, most: f64) -> String {
    let (takes_mm_s, homing) = (drive.jump_mm_s(), config.homing);
    let is_seek = mm_s > homing.latch_mm_s.min(homing.seek_mm_s) * (1.0 + SAME);
    let (number, set_mm_s) = if is_seek { (25, homing.seek_mm_s) } else { (24, homing.latch_mm_s) };
    let set = rounded((MARGIN * takes_mm_s).min(most * set_mm_s) * 60.0);
    let is_squared = config.squared.is_some_and(|squared| squared.axis as usize == axis);
    let may_brake = is_seek && !is_squared && !homing.by_stall[axis];
    let or = if may_brake { ", or give it room behind the switch ($906)" } else { "" };
    format!(
        "homing stops it at its switch at once, from {mm_s:.0} mm/s, and the motor takes {takes_mm_s:.0}: set ${number} to {set} mm/min or less{or}"
    )
}

fn jump_remedy(config: &Config, axis: usize, drive: &Drive, (mm_s, from_rest): (f64, bool), most: f64) -> String {
    let takes_mm_s = drive.jump_mm_s();
    let start_mm_s = config.limits[axis].start_speed_steps_s / config.steps_per_mm[axis];
    let set = if from_rest || mm_s <= 2.0 * start_mm_s {
        format!("${} to {} mm/min", 910 + axis, rounded((MARGIN * takes_mm_s).min(most * start_mm_s) * 60.0))
    } else {
        // The largest jump that a deviation allows: see corners. It is as the root of the deviation.
        let accel_mm_s2 =
            config.limits[axis].accel_steps_s2.min(config.limits[axis].decel_steps_s2) / config.steps_per_mm[axis];
        let deviation_mm = (MARGIN * takes_mm_s).powi(2) / (8.0 * accel_mm_s2);
        format!("$11 to {} mm", rounded(deviation_mm.min(most * most * config.junction_deviation_mm)))
    };
    format!("its speed jumps by {mm_s:.0} mm/s there, {}: set {set} or less", takes(format!("{takes_mm_s:.0}"), most))
}

fn accel_remedy(config: &Config, axis: usize, drive: &Drive, (mm_s2, mm_s): (f64, f64), most: f64) -> String {
    let limits = config.limits[axis];
    let top_mm_s = (limits.top_speed_steps_s / config.steps_per_mm[axis]).min(drive.top_mm_s());
    let is_own_decel = mm_s2 < 0.0 && limits.decel_steps_s2 != limits.accel_steps_s2;
    let (number, set_steps_s2) =
        if is_own_decel { (920 + axis, limits.decel_steps_s2) } else { (120 + axis, limits.accel_steps_s2) };
    let set_mm_s2 = (MARGIN * drive.accel_mm_s2(top_mm_s)).min(most * set_steps_s2 / config.steps_per_mm[axis]);
    let accel = format!("${number} to {} mm/s2", rounded(set_mm_s2));
    let set = if mm_s <= drive.top_mm_s() {
        accel
    } else {
        let is_steep = mm_s2.abs() > set_mm_s2;
        let also = if is_steep { format!(", and {accel}") } else { String::new() };
        format!("${} to {} mm/min{also}", 110 + axis, rounded(top_mm_s * 60.0))
    };
    let verb = if mm_s2 < 0.0 { "decelerates" } else { "accelerates" };
    let takes = takes(format!("{:.0}", drive.accel_mm_s2(mm_s).max(0.0)), most);
    format!("it {verb} by {:.0} mm/s2 at {mm_s:.0} mm/s there, {takes}: set {set} or less", mm_s2.abs())
}

/// The load that the motor takes; `most` is finite if that is more than was asked of it.
fn takes(value: String, most: f64) -> String {
    let why = if most.is_finite() { ", but less while it still swings" } else { "" };
    format!("and the motor takes {value}{why}")
}

/// Rounded down to two digits.
fn rounded(value: f64) -> String {
    let unit = 10.0_f64.powi(value.log10().floor() as i32 - 1);
    let digits = usize::try_from(-(unit.log10().round() as i32)).unwrap_or(0);
    format!("{:.digits$}", (value / unit * (1.0 + SAME)).floor() * unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_to_set_is_rounded_down() {
        for (value, text) in [(1_799.0, "1700"), (99.9, "99"), (0.012_99, "0.012"), (0.2, "0.20"), (5.0, "5.0")] {
            assert_eq!(rounded(value), text);
        }
    }
}
