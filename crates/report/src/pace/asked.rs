//! The demands of a move: its direction, its speed, and the allowed speed at the corner to the next move.

use isostep_console::Rate;
use isostep_motion::{AXES, Axis};

use isostep_sim::MoveRecord;
use isostep_sim::Outcome;
use isostep_sim::lines_of_moves::Source;

/// Speeds are equal if they differ by less than this fraction of the faster one.
pub const SAME: f64 = 1e-6;
/// Half the difference of two directions. If it is less than this, it is rounding and not a corner.
const STRAIGHT: f64 = 1e-12;

/// A path that turns by more than this reverses, and stops: a cosine of -0.999999.
const BACK_DEG: f64 = 179.9;

/// The limit of the speed of a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// The feed that the line asks for.
    Feed,
    /// The top speed of the axis with this index.
    Axis(usize),
}

/// The demands of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// Unit vector of the path, along the motors.
    pub direction: [f64; AXES],
    /// The same along the axes.
    pub along: [f64; AXES],
    /// Distance along the path per step of the longest axis, mm.
    pub mm_per_step: f64,
    /// The speed along the path that it would have without ramps, mm/s.
    pub mm_s: f64,
    /// The limit of this speed.
    pub limit: Limit,
}

impl Asked {
    /// The demands of a move of `outcome`. Without a source, its speed is the planned one, or as fast as its axes allow.
    pub fn new(outcome: &Outcome, record: &MoveRecord, source: Option<&Source>) -> Self {
        let distance_mm: [f64; AXES] =
            std::array::from_fn(|axis| record.plan.axis_steps(axis) / outcome.steps_per_mm[axis]);
        let length_mm = distance_mm.iter().map(|mm| mm * mm).sum::<f64>().sqrt();
        let direction = distance_mm.map(|mm| mm / length_mm);
        let mm_per_step = length_mm / record.plan.distance_steps();
        let tops = (0..AXES).filter(|&axis| direction[axis] != 0.0);
        let tops = tops.map(|axis| (top_mm_s(outcome, axis) / direction[axis].abs(), axis));
        let along = outcome.kinematics.along_axes(direction);
        let tops = tops.chain(axis_tops_mm_s(outcome, along));
        let (top_mm_s, axis) = tops.min_by(|one, other| one.0.total_cmp(&other.0)).unwrap_or((f64::INFINITY, 0));
        let feed_mm_s = match source.map(|source| source.rate) {
            Some(Rate::Feed { mm_min }) => f64::from(mm_min) / 60.0,
            Some(Rate::Rapid) => f64::INFINITY,
            None => cruise_steps_s(record).map_or(f64::INFINITY, |steps_s| steps_s * mm_per_step),
        };
        let by_axis = top_mm_s <= feed_mm_s * (1.0 + SAME);
        let (mm_s, limit) = if by_axis { (top_mm_s, Limit::Axis(axis)) } else { (feed_mm_s, Limit::Feed) };
        Self { direction, along, mm_per_step, mm_s, limit }
    }

    /// True if `mm_s` is no slower than the speed asked for.
    pub fn is_reached(&self, mm_s: f64) -> bool {
        mm_s >= self.mm_s * (1.0 - SAME)
    }

    /// The angle by which the path turns from this move to the next, degrees.
    pub fn turn_deg(&self, next: &Self) -> f64 {
        // Accurate for small angles; a computation from the cosine is not.
        2.0 * self.half_difference(next).min(1.0).asin().to_degrees()
    }

    /// True if the path goes back at the corner to the next move.
    pub fn is_back(&self, next: &Self) -> bool {
        self.turn_deg(next) > BACK_DEG
    }

    /// The allowed speed at the corner to the next move, by the rule in [`corners`](isostep_sim::corners), mm/s, and the axis that
    /// limits it.
    pub fn corner(&self, next: &Self, outcome: &Outcome) -> (f64, usize) {
        let half = self.half_difference(next);
        let across_mm_s2 = |axis: usize| {
            let limits = outcome.limits[axis];
            let mm_s2 = limits.accel_steps_s2.min(limits.decel_steps_s2) / outcome.steps_per_mm[axis];
            mm_s2 * 2.0 * half / (next.direction[axis] - self.direction[axis]).abs()
        };
        let bends = (0..AXES).filter(|&axis| next.direction[axis] != self.direction[axis]);
        let weakest = bends.min_by(|&one, &other| across_mm_s2(one).total_cmp(&across_mm_s2(other)));
        let Some(axis) = weakest.filter(|_| half >= STRAIGHT) else { return (f64::INFINITY, 0) };
        let sine = (1.0 - half * half).max(0.0).sqrt();
        let mm_s = (across_mm_s2(axis) * outcome.junction_deviation_mm * sine * (1.0 + sine)).sqrt() / half;
        (mm_s, axis)
    }

    /// Half the length of the difference of both directions: the sine of half the angle by which the path turns.
    pub fn half_difference(&self, next: &Self) -> f64 {
        let squares = (0..AXES).map(|axis| (next.direction[axis] - self.direction[axis]).powi(2));
        squares.sum::<f64>().sqrt() / 2.0
    }

    /// The axis that limits the acceleration if `speeds_up`, otherwise the deceleration.
    pub fn weakest_axis(&self, outcome: &Outcome, speeds_up: bool) -> usize {
        let mm_s2 = |axis: usize| {
            let limits = outcome.limits[axis];
            let steps_s2 = if speeds_up { limits.accel_steps_s2 } else { limits.decel_steps_s2 };
            steps_s2 / outcome.steps_per_mm[axis] / self.direction[axis].abs()
        };
        let moving = (0..AXES).filter(|&axis| self.direction[axis] != 0.0);
        moving.min_by(|&one, &other| mm_s2(one).total_cmp(&mm_s2(other))).unwrap_or(0)
    }
}

/// The speed along the path that a move would have without ramps, mm/s: the feed of the first line that it is made for, or what the
/// top speeds of its axes allow. Infinite if it goes nowhere on a line.
pub fn asked_mm_s(outcome: &Outcome, record: &MoveRecord) -> f64 {
    let source = record.asked.first().and_then(|asked| Source::of(asked, &outcome.program));
    Asked::new(outcome, record, source.as_ref()).mm_s
}

/// What the top speeds of the axes that two motors move each allow along a path, mm/s, and the index of the axis.
fn axis_tops_mm_s(outcome: &Outcome, along: [f64; AXES]) -> impl Iterator<Item = (f64, usize)> {
    let of_two = |axis: &usize| outcome.kinematics.is_shared(Axis::ALL[*axis]);
    let axes = (0..AXES).filter(of_two).filter(move |&axis| along[axis] != 0.0);
    axes.map(move |axis| {
        let top_mm_s = outcome.axis_limits[axis].top_speed_steps_s / outcome.axis_steps_per_mm[axis];
        (top_mm_s / along[axis].abs(), axis)
    })
}

/// The top speed of an axis at the end of the run, mm/s.
pub fn top_mm_s(outcome: &Outcome, axis: usize) -> f64 {
    outcome.limits[axis].top_speed_steps_s / outcome.steps_per_mm[axis]
}

/// The speed of the longest axis while it cruises, steps/s; `None` if it does not.
fn cruise_steps_s(record: &MoveRecord) -> Option<f64> {
    let profiles = record.parts.iter().chain([&record.plan]).map(|plan| plan.profile);
    let cruising = profiles.filter(|profile| profile.t_cruise_s() > 0.0);
    cruising.map(|profile| profile.cruise_speed_steps_s()).reduce(f64::max)
}
