//! Compares durations with those of Ruckig, a published planner of time-optimal moves with limited jerk (L. Berscheid
//! and T. Kröger, "Jerk-limited Real-time Trajectory Generation with Arbitrary Target States", RSS 2021), as ported to
//! Rust.
//!
//! No move of ours may last longer. If one is shorter, one of the two planners is wrong, and ours is then checked to be
//! right. Rounding makes Ruckig lose its solution in moves that are hardly more than one ramp: it then goes back and
//! forth, or finds no move.

use isostep_profile::Profile;
use rsruckig::daov_stack;
use rsruckig::prelude::{InputParameter, Ruckig, ThrowErrorHandler, Trajectory};

use super::case::{Case, count, is_one_case, over_cases};
use super::limits::is_right;

/// Ruckig takes a position as reached within 1e-8 of about its distance.
const TOLERANCE: f64 = 1e-6;
/// The largest fraction of the moves that Ruckig may miss.
const MISSED_MAX: f64 = 0.01;

#[derive(Default)]
struct Compared {
    /// Our duration divided by Ruckig's, where both have the same move.
    ratios: Vec<f64>,
    /// The number of Ruckig's moves that are longer.
    longer: usize,
    /// The number of moves that Ruckig does not find.
    not_found: usize,
}

#[test]
fn as_fast_as_ruckig() {
    let mut all = Compared::default();
    for part in over_cases(count(), compare) {
        all.ratios.extend(part.ratios);
        all.longer += part.longer;
        all.not_found += part.not_found;
    }
    if !is_one_case() {
        all.report();
        let missed = all.longer + all.not_found;
        assert!(missed as f64 <= MISSED_MAX * count() as f64, "Ruckig misses {missed} moves");
    }
}

fn compare(compared: &mut Compared, case: &Case) {
    let profile = case.s_curve();
    let Some(theirs_s) = ruckig_duration_s(case, &profile) else {
        compared.not_found += 1;
        return;
    };
    let ratio = profile.duration_s() / theirs_s;
    assert!(ratio <= 1.0 + TOLERANCE, "{} s is more than Ruckig's {theirs_s} s", profile.duration_s());
    if ratio < 1.0 - TOLERANCE {
        compared.longer += 1;
        is_right(case, &profile);
    } else {
        compared.ratios.push(ratio);
    }
}

/// Ruckig's tolerances are absolute, so it gets the move in units of about its distance and duration. The units are
/// powers of two, so no digit changes.
fn ruckig_duration_s(case: &Case, profile: &Profile) -> Option<f64> {
    let per_step = case.distance_steps.log2().round().exp2().recip();
    let unit_s = profile.duration_s().log2().round().exp2();
    let speed = per_step * unit_s;
    let accel = speed * unit_s;
    let mut input = InputParameter::<1>::new(None);
    input.target_position[0] = case.distance_steps * per_step;
    input.current_velocity[0] = case.entry_steps_s * speed;
    input.target_velocity[0] = case.exit_steps_s * speed;
    input.max_velocity[0] = case.limits.top_speed_steps_s * speed;
    input.max_acceleration[0] = case.limits.accel_steps_s2 * accel;
    input.min_acceleration = Some(daov_stack![-case.limits.decel_steps_s2 * accel]);
    input.max_jerk[0] = case.limits.jerk_steps_s3 * accel * unit_s;
    let mut trajectory = Trajectory::new(None);
    Ruckig::<1, ThrowErrorHandler>::new(None, 1.0).calculate(&input, &mut trajectory).ok()?;
    Some(trajectory.get_duration() * unit_s)
}

impl Compared {
    fn report(&mut self) {
        self.ratios.sort_by(f64::total_cmp);
        let last = self.ratios.len() - 1;
        println!("Duration over Ruckig's, less 1, of {} random S-curves (computed on the host):", self.ratios.len());
        for (name, ratio) in [("least", 0.0), ("1 %", 0.01), ("median", 0.5), ("99 %", 0.99), ("most", 1.0)] {
            println!("{name:>8} {:+.1e}", self.ratios[(last as f64 * ratio) as usize] - 1.0);
        }
        println!("missed by Ruckig: {} longer by more than {TOLERANCE:e}, {} not found", self.longer, self.not_found);
    }
}
