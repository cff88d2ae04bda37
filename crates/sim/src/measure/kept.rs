//! How close the moves of a run came to the limits in force. Each axis is measured by its edges alone; corners are
//! checked by their planned speeds. Of shaped runs see [`shaped`].

use isostep_motion::{AXES, Config, Finish};

use super::limits::{self, Ends, LimitRatios};
use super::shaped;
use crate::moves::MoveRecord;
use crate::outcome::Outcome;
use crate::verify;

/// Tolerance for floating-point rounding.
const ROUNDING: f64 = 1e-6;

/// How close all moves came to their limits. `speed_limit` is the speed limit of an axis in a move at a time in s from
/// the start of its run, steps/s; it never decreases. Of a shaped run it is the top speed.
pub fn ratios(outcome: &Outcome, speed_limit: impl Fn(&MoveRecord, usize, f64) -> f64) -> LimitRatios {
    let off_s = outcome.config.port.tolerance_ns() * 1e-9;
    let mut highest = shaped::ratios(outcome).into_iter().fold(LimitRatios::default(), LimitRatios::max);
    for record in outcome.moves.iter().filter(|record| record.shaping.is_none()) {
        let config = outcome.config_of(record);
        let times_s = verify::axis_times_s(record, &outcome.edges[record.edges.clone()]);
        let [begins, ends] = are_rests(record, config);
        // A stopped move ends abruptly, not at rest.
        let ends = Ends { at_rest: [begins, ends && matches!(record.finish, Finish::Done | Finish::Held)] };
        for (axis, times_s) in times_s.iter().enumerate() {
            let times_s = &times_s[times_s.len().min(record.blend_steps(axis) as usize)..];
            let (own, law) = (&config.limits[axis], config.speed_law);
            highest = highest.max(limits::ratios(times_s, off_s, own, law, ends, |t_s| speed_limit(record, axis, t_s)));
        }
    }
    let corners = outcome.moves.windows(2).filter(|pair| pair[0].run == pair[1].run);
    let corner =
        corners.map(|pair| corner_ratio([&pair[0], &pair[1]], outcome.config_of(&pair[0]))).fold(0.0, f64::max);
    LimitRatios { corner, ..highest }
}

/// The length of a path of these steps, mm.
pub fn path_mm(steps: [i32; AXES], config: &Config) -> f64 {
    length_mm(std::array::from_fn(|axis| f64::from(steps[axis]) / config.steps_per_mm[axis]))
}

/// The speed of a move at its start and its end, along its path.
pub fn speeds_mm_s(record: &MoveRecord, config: &Config) -> [f64; 2] {
    let mm_per_step = length_mm(way_mm(record, config)) / record.plan.distance_steps();
    let last = record.parts.last().unwrap_or(&record.plan);
    [record.plan.speed_at(record.plan.begin_s()), last.profile.exit_speed_steps_s()].map(|steps| steps * mm_per_step)
}

/// Whether a move begins and ends at the start speed or slower.
pub fn are_rests(record: &MoveRecord, config: &Config) -> [bool; 2] {
    let start_mm_s = start_mm_s(record, config);
    let [begins, ends] = speeds_mm_s(record, config).map(|speed_mm_s| speed_mm_s <= start_mm_s * (1.0 + ROUNDING));
    [begins && record.blend.is_none(), ends && !record.ends_in_blend]
}

/// How far a move goes along each axis, mm.
pub fn way_mm(record: &MoveRecord, config: &Config) -> [f64; AXES] {
    std::array::from_fn(|axis| record.plan.axis_steps(axis) / config.steps_per_mm[axis])
}

fn length_mm(way_mm: [f64; AXES]) -> f64 {
    way_mm.into_iter().map(|mm| mm * mm).sum::<f64>().sqrt()
}

/// The start speed along a path.
fn start_mm_s(record: &MoveRecord, config: &Config) -> f64 {
    let path_mm = length_mm(way_mm(record, config));
    let steps = |axis: usize| record.plan.axis_steps(axis).abs();
    let moving = (0..AXES).filter(|axis| steps(*axis) > 0.0);
    let starts = moving.map(|axis| config.limits[axis].start_speed_steps_s * path_mm / steps(axis));
    starts.fold(f64::INFINITY, f64::min)
}

/// The speed at a corner as a fraction of that allowed by Grbl's rule. Both moves must have the same speed there, or
/// both must be at rest. Otherwise the result is infinite.
fn corner_ratio(moves: [&MoveRecord; 2], config: &Config) -> f64 {
    if moves[0].ends_in_blend {
        return 0.0;
    }
    let [[_, out_mm_s], [in_mm_s, _]] = moves.map(|record| speeds_mm_s(record, config));
    let [[_, stops], [starts, _]] = moves.map(|record| are_rests(record, config));
    if stops && starts {
        return 0.0;
    }
    let is_one = (out_mm_s / in_mm_s - 1.0).abs() < ROUNDING;
    if is_one { in_mm_s / corner_mm_s(moves, config) } else { f64::INFINITY }
}

/// The highest speed at which the corner between two moves may be taken.
fn corner_mm_s(moves: [&MoveRecord; 2], config: &Config) -> f64 {
    let [before, after] = moves.map(|record| {
        let way_mm = way_mm(record, config);
        way_mm.map(|mm| mm / length_mm(way_mm))
    });
    let across: [f64; AXES] = std::array::from_fn(|axis| after[axis] - before[axis]);
    let length = across.iter().map(|part| part * part).sum::<f64>().sqrt();
    if length < 1e-9 {
        return f64::INFINITY;
    }
    let moving = (0..AXES).filter(|axis| across[*axis] != 0.0);
    let accels = moving.map(|axis| {
        let limits = &config.limits[axis];
        limits.accel_steps_s2.min(limits.decel_steps_s2) / config.steps_per_mm[axis] * length / across[axis].abs()
    });
    let accel_mm_s2 = accels.fold(f64::INFINITY, f64::min);
    // The sine of half the angle between the reversed first path and the second path.
    let sine = (1.0 - length * length / 4.0).max(0.0).sqrt();
    // A corner may always be taken at the start speed.
    let start_mm_s = moves.map(|record| start_mm_s(record, config)).into_iter().fold(f64::INFINITY, f64::min);
    (accel_mm_s2 * config.junction_deviation_mm * sine / (1.0 - sine)).sqrt().max(start_mm_s)
}
