//! Corners: how much the speed of an axis jumps where one move follows another without a stop.
//!
//! # The largest jump that the rule allows
//! A corner is taken at v² = a δ s/(1 - s). Here δ is `$11`, s is the sine of half the angle between the reversed
//! direction of the first move and the direction of the second, and a is the acceleration that the axes have across the
//! corner (`chain::corner` of the profile). Let Δ be the difference of both directions. Its length is D = 2 √(1 - s²).
//! Axis i jumps by v |Δᵢ|, and a is at most Aᵢ D/|Δᵢ| for the acceleration Aᵢ of the axis. So
//!
//! (v |Δᵢ|)² ≤ Aᵢ δ D |Δᵢ| s/(1 - s) ≤ Aᵢ δ D² s/(1 - s) = 4 Aᵢ δ s (1 + s) ≤ 8 Aᵢ δ.
//!
//! A machine with a start speed may stop from it and begin with it, and takes corners no slower. There an axis may
//! change from its start speed in one direction to its start speed in the other.

use isostep_motion::AXES;

use crate::moves::MoveRecord;
use crate::outcome::Outcome;

/// A jump of the speed that is rounding, mm/s.
pub const NO_JUMP_MM_S: f64 = 1e-6;

/// A jump of an axis's speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// Size of the jump, mm/s.
    pub mm_s: f64,
    /// Index in [`Outcome::moves`] of the move at whose beginning the speed jumps.
    pub index: usize,
}

/// The largest planned jump of each axis in the program; `None` if no move follows another without a stop.
pub fn largest_jumps(outcome: &Outcome) -> [Option<Jump>; AXES] {
    let mut largest = [None::<Jump>; AXES];
    for (before, pair) in outcome.moves.windows(2).enumerate() {
        if pair[0].homing || pair[0].run != pair[1].run {
            continue;
        }
        for (axis, mm_s) in jumps_mm_s(outcome, [&pair[0], &pair[1]]).into_iter().enumerate() {
            if largest[axis].is_none_or(|jump| mm_s > jump.mm_s) {
                largest[axis] = Some(Jump { mm_s, index: before + 1 });
            }
        }
    }
    largest
}

/// The largest jump of an axis that the settings at the end of the run allow, mm/s: see above.
pub fn most_mm_s(outcome: &Outcome, axis: usize) -> f64 {
    let (limits, steps_per_mm) = (outcome.limits[axis], outcome.steps_per_mm[axis]);
    let accel_mm_s2 = limits.accel_steps_s2.min(limits.decel_steps_s2) / steps_per_mm;
    let to_and_fro_mm_s = 2.0 * limits.start_speed_steps_s / steps_per_mm;
    (8.0 * accel_mm_s2 * outcome.junction_deviation_mm).sqrt().max(to_and_fro_mm_s)
}

/// The jump of each axis from the end of one move to the beginning of the next.
pub fn jumps_mm_s(outcome: &Outcome, [before, after]: [&MoveRecord; 2]) -> [f64; AXES] {
    if after.blend.is_some() {
        return [0.0; AXES];
    }
    let last = before.last_part().profile;
    let from = velocity_steps_s(before, last.exit_speed_steps_s());
    let to = velocity_steps_s(after, after.plan.profile.entry_speed_steps_s());
    std::array::from_fn(|axis| (to[axis] - from[axis]).abs() / outcome.steps_per_mm[axis])
}

/// The velocity of each axis when the longest one has this speed.
fn velocity_steps_s(record: &MoveRecord, speed_steps_s: f64) -> [f64; AXES] {
    std::array::from_fn(|axis| speed_steps_s * record.plan.axis_steps(axis) / record.plan.distance_steps())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Config, run};

    /// All axes have 2,000 mm/s², 80 steps/mm and 200 mm/s.
    fn simulated(program: &str) -> Outcome {
        let mut config = Config::default();
        let settings = &mut config.settings;
        (settings.steps_per_mm, settings.max_rate_mm_min) = ([80.0; AXES], [12_000.0; AXES]);
        (settings.accel_mm_s2, settings.decel_or_0_mm_s2) = ([2_000.0; AXES], [0.0; AXES]);
        settings.soft_limits = false;
        (settings.junction_deviation_mm, settings.blend_deviation_mm) = (0.01, 0.0);
        run(program.as_bytes(), &config).unwrap()
    }

    fn assert_near(found: f64, expected: f64) {
        assert!((found - expected).abs() <= 1e-6 * expected, "{found} for {expected}");
    }

    /// s = √½, and across the corner both axes together have √2 A: v² = A δ/(1 - √½).
    #[test]
    fn a_right_angle_jumps_by_the_speed_that_it_is_taken_at() {
        let outcome = simulated("G91 G1 F12000 X20\nX20\nY20\n");
        let [x, y, z] = largest_jumps(&outcome).map(Option::unwrap);
        let corner_mm_s = (2_000.0 * 0.01 / (1.0 - 0.5_f64.sqrt())).sqrt();
        assert_near(x.mm_s, corner_mm_s);
        assert_near(y.mm_s, corner_mm_s);
        assert_eq!((x.index, y.index, z.mm_s), (2, 2, 0.0));
    }

    /// If Y bends only a little, s is nearly 1 and the jump is nearly all that the rule allows.
    #[test]
    fn the_least_bend_jumps_by_the_most() {
        let outcome = simulated("G91 G1 F12000 X20 Y0.1\nX20 Y-0.1\n");
        let [_, y, _] = largest_jumps(&outcome).map(Option::unwrap);
        let most_mm_s = most_mm_s(&outcome, 1);
        assert_near(most_mm_s, (8.0_f64 * 2_000.0 * 0.01).sqrt());
        // At full speed: 200 mm/s * 2 * 0.005.
        assert!(y.mm_s < most_mm_s && y.mm_s > 1.99, "{y:?}");
        // Here the rule limits the jump, not the feed.
        let outcome = simulated("G91 G1 F12000 X20 Y1\nX20 Y-1\n");
        let [_, y, _] = largest_jumps(&outcome).map(Option::unwrap);
        assert!(y.mm_s < most_mm_s && y.mm_s > 0.99 * most_mm_s, "{y:?} of {most_mm_s}");
    }

    #[test]
    fn a_straight_chain_has_no_jump() {
        let outcome = simulated(&format!("G91 G1 F6000\n{}", "X0.5 Y0.25 Z-0.125\n".repeat(40)));
        assert_eq!(outcome.moves.len(), 40);
        for jump in largest_jumps(&outcome) {
            assert!(jump.unwrap().mm_s < 1e-9, "{jump:?}");
        }
    }

    #[test]
    fn moves_that_do_not_follow_each_other_have_no_corner() {
        let outcome = simulated("G91 G1 F6000 X5\nG4 P0.1\nY5\n");
        assert_eq!(largest_jumps(&outcome), [None; AXES]);
    }

    /// At a reversal, the jump is twice the start speed.
    #[test]
    fn a_start_speed_turns_an_axis_at_once() {
        let outcome = simulated("$910=300\nG91 G1 F6000 X5\nX-5\n");
        let [x, ..] = largest_jumps(&outcome).map(Option::unwrap);
        assert_near(x.mm_s, 10.0);
        assert!(x.mm_s <= most_mm_s(&outcome, 0), "{x:?}");
    }
}
