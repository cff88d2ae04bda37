//! The closeness of the axes to their limits in shaped runs, by their edges alone.
//!
//! A shaped axis is where the mean of several motions is, so it keeps every limit that all of them keep. One of these may
//! slow down while another speeds up the other way: so an acceleration is compared with the higher of both limits. An axis
//! is measured from turn to turn, and from jump to jump: where its speed jumps at a corner, it jumps once for each impulse.
//! A box makes an acceleration of a jump, for as long as it lasts: that is not measured.

use std::ops::RangeInclusive;

use isostep_motion::AXES;

use super::limits::{self, Ends, LimitRatios};
use crate::corners;
use crate::moves::MoveRecord;
use crate::outcome::Outcome;
use crate::places;

/// The highest values of each axis over all shaped runs of the program, each as a fraction of its limit.
pub fn ratios(outcome: &Outcome) -> [LimitRatios; AXES] {
    let mut highest = [LimitRatios::default(); AXES];
    for (_, run) in outcome.runs().filter(|(_, run)| run[0].shaping.is_some()) {
        for (axis, highest) in highest.iter_mut().enumerate() {
            *highest = highest.max(of_axis(outcome, run, axis));
        }
    }
    highest
}

fn of_axis(outcome: &Outcome, run: &[MoveRecord], axis: usize) -> LimitRatios {
    let own = limits::either_way(&outcome.config_of(&run[0]).limits[axis]);
    let off_s = outcome.config.port.tolerance_ns() * 1e-9;
    let ends = Ends { at_rest: [false; 2] };
    let (jumps_s, ramps_s) = (jumps_s(outcome, run, axis), ramps_s(outcome, run, axis));
    let edges = outcome.edges_of_run(run).iter().filter(|edge| edge.axis == axis).map(|edge| {
        let t_s = (edge.t_ns as f64 - run[0].start_ns as f64) * 1e-9;
        (t_s, (edge.direction, jumps_s.partition_point(|jump_s| *jump_s <= t_s)))
    });
    let is_of_jump = |t_s: f64| ramps_s.iter().any(|ramp_s| ramp_s.contains(&t_s));
    let edges: Vec<_> = edges.filter(|(t_s, _)| !is_of_jump(*t_s)).collect();
    let ratios = edges.chunk_by(|one, next| one.1 == next.1).map(|edges| {
        let times_s: Vec<_> = edges.iter().map(|(t_s, _)| *t_s).collect();
        limits::ratios(&times_s, off_s, &own, outcome.config_of(&run[0]).speed_profile, ends, |_| own.top_speed_steps_s)
    });
    ratios.fold(LimitRatios::default(), LimitRatios::max)
}

/// When the speed of an axis jumps at corners, unshaped, s from the start of the run.
fn corners_s(outcome: &Outcome, run: &[MoveRecord], axis: usize) -> impl Iterator<Item = f64> {
    let is_jump =
        move |pair: &&[MoveRecord]| corners::jumps_mm_s(outcome, [&pair[0], &pair[1]])[axis] > corners::NO_JUMP_MM_S;
    run.windows(2).filter(is_jump).map(|pair| pair[1].begin_s())
}

/// The result of a box on the jumps of an axis's speed, s from the start of the run.
fn ramps_s(outcome: &Outcome, run: &[MoveRecord], axis: usize) -> Vec<RangeInclusive<f64>> {
    let (first, last) = (&run[0], &run[run.len() - 1]);
    let ends_s = first.shaping.as_ref().and_then(|shaping| shaping.impulses[axis].box_ends_s());
    let Some([from_s, to_s]) = ends_s else { return Vec::new() };
    let exit_steps_s = last.last_part().profile.exit_speed_steps_s();
    let begin_s = (first.plan.profile.entry_speed_steps_s() > 0.0).then(|| first.begin_s());
    let end_s = (exit_steps_s > 0.0).then(|| last.plan_s - last.lasts_s());
    let jumping_s = corners_s(outcome, run, axis).chain(begin_s).chain(end_s);
    jumping_s.map(|jump_s| jump_s + from_s..=jump_s + to_s).collect()
}

/// When the speed of an axis may jump, in order, s from the start of the run: at its ends and at corners, once for each
/// impulse.
fn jumps_s(outcome: &Outcome, run: &[MoveRecord], axis: usize) -> Vec<f64> {
    let (first, last) = (&run[0], &run[run.len() - 1]);
    let corners_s = corners_s(outcome, run, axis);
    let jumping_s: Vec<f64> = corners_s.chain([first.begin_s(), last.plan_s - last.lasts_s()]).collect();
    let delays_s = first.shaping.iter().flat_map(|shaping| places::delays_s(shaping, outcome.kinematics, axis));
    let mut jumps_s: Vec<_> =
        delays_s.flat_map(|delay_s| jumping_s.iter().map(move |begin_s| begin_s + delay_s)).collect();
    jumps_s.sort_by(f64::total_cmp);
    jumps_s
}
