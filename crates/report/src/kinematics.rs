//! Speed, acceleration and speed jumps of each axis, compared with their limits. Measured from the edges within moves,
//! in shaped runs from turn to turn; jumps at corners are as planned, before they are shaped.

use std::fmt;

use isostep_motion::{AXES, Axis, Kinematics};
use serde::Serialize;

use isostep_sim::Outcome;
use isostep_sim::corners;
use isostep_sim::measure::across::{self, Window};
use isostep_sim::measure::limits::{self, Ends, LimitRatios};
use isostep_sim::measure::shaped;

/// A value and its limit, both in the same unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OfLimit {
    /// The highest value found.
    pub found: f64,
    /// Its limit.
    pub limit: f64,
}

/// The largest jump of an axis's speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct JumpFigures {
    /// Size of the jump, mm/s.
    pub mm_s: f64,
    /// The same, mm/min.
    pub mm_min: f64,
    /// Number of the move at whose beginning it is, from 1.
    pub move_number: usize,
    /// The line of this move in the program, from 1, if known.
    pub line: Option<usize>,
}

/// The motion of an axis in a program. Homing is excluded because it stops abruptly at switches.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct AxisFigures {
    /// Name of the axis.
    pub axis: String,
    /// Speed, measured from the edges within each move, that is without corners; accurate to 1 %: mm/s.
    pub speed_mm_s: OfLimit,
    /// Acceleration, measured in the same manner, mm/s².
    pub accel_mm_s2: OfLimit,
    /// Deceleration, measured in the same manner, mm/s².
    pub decel_mm_s2: OfLimit,
    /// Largest planned jump at a corner; null if no move follows another without a stop.
    pub jump: Option<JumpFigures>,
    /// Largest jump that the corner rule allows, mm/s: see [`corners`].
    pub jump_limit_mm_s: f64,
}

/// What crossed belts make of the axes: they are moved by two motors each, of which [`AxisFigures`] tell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct BeltFigures {
    /// The highest accelerations of X and Y, measured from the edges of both motors, corners included, as fractions of their limits.
    pub accel_ratios: [f64; 2],
}

impl fmt::Display for BeltFigures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y] = self.accel_ratios.map(|ratio| 100.0 * ratio);
        write!(
            f,
            "with $907=1 X and Y are here the motors of X and Y, each of which moves both axes, and speeds are those of the belts; of its own \
             acceleration X has {x:.1} % at most, Y {y:.1} %"
        )
    }
}

/// The figures of belts; `None` if each axis has its own motor.
pub fn belts(outcome: &Outcome) -> Option<BeltFigures> {
    if outcome.kinematics == Kinematics::Cartesian {
        return None;
    }
    let mut accel_ratios = [0.0_f64; 2];
    for Window { axis, ratio, .. } in across::windows_of_axes(outcome) {
        accel_ratios[axis] = accel_ratios[axis].max(ratio);
    }
    Some(BeltFigures { accel_ratios })
}

/// The figures of every axis, compared with the limits at the end of the run; `lines` are the lines of all moves.
pub fn axes(outcome: &Outcome, lines: &[Option<usize>]) -> [AxisFigures; AXES] {
    let (ratios, jumps) = (ratios(outcome), corners::largest_jumps(outcome));
    std::array::from_fn(|axis| {
        let (limits, steps_per_mm) = (outcome.limits[axis], outcome.axis_steps_per_mm[axis]);
        let of = |share: f64, limit_steps: f64| {
            let limit = limit_steps / steps_per_mm;
            OfLimit { found: share * limit, limit }
        };
        AxisFigures {
            axis: Axis::ALL[axis].to_string(),
            speed_mm_s: of(ratios[axis].speed, limits.top_speed_steps_s),
            accel_mm_s2: of(ratios[axis].accel, limits.accel_steps_s2),
            decel_mm_s2: of(ratios[axis].decel, limits.decel_steps_s2),
            jump: jumps[axis].map(|jump| JumpFigures {
                mm_s: jump.mm_s * outcome.turned_mm(axis),
                mm_min: jump.mm_s * outcome.turned_mm(axis) * 60.0,
                move_number: outcome.move_number(jump.index),
                line: lines[jump.index],
            }),
            jump_limit_mm_s: corners::most_mm_s(outcome, axis) * outcome.turned_mm(axis),
        }
    })
}

/// The highest values over all moves of the program, each as a fraction of its limit.
fn ratios(outcome: &Outcome) -> [LimitRatios; AXES] {
    let off_s = outcome.config.port.tolerance_ns() * 1e-9;
    let mut highest = shaped::ratios(outcome);
    for record in outcome.program_moves().filter(|record| record.shaping.is_none()) {
        for (axis, times_s) in limits::line_times_s(outcome, record).iter().enumerate() {
            let own = &outcome.limits[axis];
            // The entry and exit speeds of a move are checked as corners.
            let ends = Ends { at_rest: [false; 2] };
            let ratios = limits::ratios(times_s, off_s, own, outcome.speed_profile, ends, |_| own.top_speed_steps_s);
            highest[axis] = highest[axis].max(ratios);
        }
    }
    highest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Figures;
    use isostep_sim::{Config, run};

    /// Moves at 40 mm/s with 50 mm/s², corners by `$11=0.01`.
    #[test]
    fn an_axis_comes_to_its_limits_and_jumps_at_its_corner() {
        let program = b"G61 G91 G1 F2400 X40\nX40\n(an edge)\nY30\n";
        let outcome = run(program, &Config::default()).unwrap();
        let [x, y, z] = Figures::new("example", &outcome).axes;
        for OfLimit { found, limit } in [x.accel_mm_s2, x.decel_mm_s2, y.accel_mm_s2, y.decel_mm_s2] {
            assert!(limit == 50.0 && (found / limit - 1.0).abs() < 0.02, "{found} of {limit}");
        }
        assert!((x.speed_mm_s.found / 40.0 - 1.0).abs() < 0.011 && x.speed_mm_s.limit == 48.0, "{x:?}");
        let jump = x.jump.unwrap();
        let corner_mm_s = (50.0 * 0.01 / (1.0 - 0.5_f64.sqrt())).sqrt();
        assert!((jump.mm_s / corner_mm_s - 1.0).abs() < 1e-6, "{jump:?}");
        assert_eq!((jump.move_number, jump.line), (3, Some(4)));
        assert!((x.jump_limit_mm_s - 2.0).abs() < 1e-6);
        assert_eq!((z.speed_mm_s.found, z.accel_mm_s2.found, z.jump.unwrap().mm_s), (0.0, 0.0, 0.0));
    }
}
