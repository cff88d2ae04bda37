//! A corner that no axis exceeds its limits at: a blend.
//!
//! From a place on one block to a place on the next, each axis has one constant acceleration, for a time that all axes
//! share. So a blend is to a corner what a ramp is to a block: every axis has the same interval.

use libm::floor;

use crate::compile::{AxisBlend, Course, Lane, NEAREST_STEPS};
use crate::ramp::constant_accel_time_s;
use crate::sync::{Span, SyncMove, offset};

/// The plan of a corner for `N` axes: from the end of a line of one block to the beginning of a line of the next, each
/// axis at a constant acceleration of its own.
///
/// A step is due where its axis is half a step from a whole one, as on a line. An axis that goes back makes the steps up
/// to where it turns, and then those of its way back. Two edges there that would be nearer to each other than two steps
/// at the axis's top speed are both left out. What is left out ends less than a/(8 v²) steps beyond its edge.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Blend<const N: usize> {
    /// Steps of each axis in the whole move to which it leads, signed by direction.
    pub steps: [i32; N],
    /// Where that move begins and ends beside whole steps.
    offsets: [[i8; N]; 2],
    begin_s: f64,
    duration_s: f64,
    /// Where it ends on the block after the corner, steps of the longest axis of that block.
    end_steps: f64,
    /// Speeds of each axis where it begins and ends, steps/s, signed by direction.
    speeds_steps_s: [[f64; 2]; N],
    /// Where each axis begins and ends, steps from the whole step next to the corner, signed by direction.
    places_steps: [[f64; 2]; N],
    /// How many steps each axis is from the corner where it begins, turns and ends, signed by direction.
    counts: [[i32; 3]; N],
}

/// A block as a blend sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side<'a, const N: usize> {
    pub(crate) span: &'a Span<N>,
    /// The length of the block, steps of the longest axis.
    pub(crate) way_steps: f64,
    /// Where the blend begins or ends, steps of the longest axis from the beginning of the block.
    pub(crate) place_steps: f64,
    /// How fast the longest axis is there, steps/s.
    pub(crate) speed_steps_s: f64,
}

impl<const N: usize> Blend<N> {
    /// The blend from the side before the corner to that after it. `tops_steps_s` are the top speeds of the axes.
    pub(crate) fn new(
        before: &Side<'_, N>,
        after: &Side<'_, N>,
        begin_s: f64,
        duration_s: f64,
        tops_steps_s: impl Fn(usize) -> f64,
    ) -> Self {
        let (before_way, after_way) = (before.way_steps, after.way_steps);
        let (before_ratio, after_ratio) = (1.0 / before_way, 1.0 / after_way);
        let left_ratio = (before_way - before.place_steps) * before_ratio;
        let (gone_ratio, per_s) = (after.place_steps * after_ratio, 1.0 / duration_s);
        let speed_ratios = [before.speed_steps_s * before_ratio, after.speed_steps_s * after_ratio];
        let mut blend = Self {
            steps: after.span.steps,
            offsets: after.span.offsets,
            begin_s,
            duration_s,
            end_steps: after.place_steps,
            speeds_steps_s: [[0.0; 2]; N],
            places_steps: [[0.0; 2]; N],
            counts: [[0; 3]; N],
        };
        for axis in 0..N {
            let [from, to] = [before.span.len(axis), after.span.len(axis)];
            let corner = offset(after.span.offsets[0][axis]);
            let speeds = [from * speed_ratios[0], to * speed_ratios[1]];
            let places = [corner - from * left_ratio, corner + to * gone_ratio];
            let [before_steps, after_steps] = [before, after].map(|side| side.span.steps[axis]);
            let count = |side: &Side<'_, N>| side.span.steps_before(axis, side.place_steps, side.way_steps) as i32;
            let begin = count(before) * before_steps.signum() - before_steps;
            let end = count(after) * after_steps.signum();
            let turn = if from * to < 0.0 {
                // The step nearest to the place where it turns whose edges there are far enough from each other.
                let sign = if from < 0.0 { -1.0 } else { 1.0 };
                let along = |count: i32| if from < 0.0 { -count } else { count };
                let accel = (speeds[1] - speeds[0]).abs() * per_s;
                let top = tops_steps_s(axis);
                let apart_steps = accel / (8.0 * top * top);
                let peak = sign * places[0] + speeds[0] * speeds[0] / (2.0 * accel);
                let nearest = floor(peak - apart_steps + 0.5) as i32;
                along(nearest.max(along(begin)).max(along(end)))
            } else {
                end
            };
            (blend.speeds_steps_s[axis], blend.places_steps[axis]) = (speeds, places);
            blend.counts[axis] = [begin, turn, end];
        }
        blend
    }

    /// When it begins, s from the start of the run.
    #[must_use]
    pub fn begin_s(&self) -> f64 {
        self.begin_s
    }

    /// When it ends, s from the start of the run.
    #[must_use]
    pub fn end_s(&self) -> f64 {
        self.begin_s + self.duration_s
    }

    /// How long it lasts, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// Where it ends on the block after the corner, steps of the longest axis from the beginning of that block.
    #[must_use]
    pub fn end_steps(&self) -> f64 {
        self.end_steps
    }

    /// The plan of no distance with which the move goes on where the blend ends.
    #[must_use]
    pub fn landing(&self) -> SyncMove<N> {
        let span = Span { steps: self.steps, offsets: self.offsets };
        let longest = (0..N).max_by(|one, other| span.len(*one).abs().total_cmp(&span.len(*other).abs()));
        let speed_steps_s = longest.map_or(0.0, |axis| self.speeds_steps_s[axis][1].abs());
        SyncMove::passing(&span, self.end_steps, speed_steps_s, self.end_s())
    }

    /// Where an axis is at `t_s` from the start of the run, steps from the whole step next to the corner, signed by direction.
    #[must_use]
    pub fn place_at(&self, axis: usize, t_s: f64) -> f64 {
        let t_s = self.within(t_s);
        let [from_steps_s, _] = self.speeds_steps_s[axis];
        self.places_steps[axis][0] + (from_steps_s + self.accel_steps_s2(axis) * t_s / 2.0) * t_s
    }

    /// How fast an axis is at `t_s` from the start of the run, steps/s, signed by direction.
    #[must_use]
    pub fn speed_at(&self, axis: usize, t_s: f64) -> f64 {
        let t_s = self.within(t_s);
        self.speeds_steps_s[axis][0] + self.accel_steps_s2(axis) * t_s
    }

    /// The time from its beginning, within it, s.
    fn within(&self, t_s: f64) -> f64 {
        (t_s - self.begin_s).max(0.0).min(self.duration_s)
    }

    /// The acceleration of an axis, steps/s², signed by direction.
    #[must_use]
    pub fn accel_steps_s2(&self, axis: usize) -> f64 {
        let [from_steps_s, to_steps_s] = self.speeds_steps_s[axis];
        (to_steps_s - from_steps_s) / self.duration_s
    }

    /// How many steps an axis makes, and how many of them before it turns; if it does not turn, that is all of them.
    #[must_use]
    pub fn step_counts(&self, axis: usize) -> (u32, u32) {
        let [begin, turn, end] = self.counts[axis];
        let out = turn.abs_diff(begin);
        (out + end.abs_diff(turn), out)
    }

    /// How many steps an axis is from the corner where it begins and where it ends, signed by direction.
    #[must_use]
    pub fn ends_steps(&self, axis: usize) -> [i32; 2] {
        let [begin, _, end] = self.counts[axis];
        [begin, end]
    }

    /// The direction of an axis's first step, 1 or -1; 0 if it makes none.
    #[must_use]
    pub fn direction(&self, axis: usize) -> i32 {
        let [begin, turn, end] = self.counts[axis];
        if turn == begin { (end - turn).signum() } else { (turn - begin).signum() }
    }

    /// When an axis makes its `k`-th step, counted from 1, s from the start of the run, by the closed form.
    #[must_use]
    pub fn step_time_s(&self, axis: usize, k: u32) -> f64 {
        let parts = self.axis(axis);
        let (AxisBlend { slow_steps_s, accel_steps_s2, begin_s, end_s, ahead, beyond, .. }, k) = (parts, f64::from(k));
        let time_s = |steps: f64| constant_accel_time_s(steps, slow_steps_s, accel_steps_s2);
        let out = f64::from(parts.out);
        if k <= out { end_s - time_s(out - k + 0.5 + beyond) } else { begin_s + time_s(k - out - 0.5 - ahead) }
    }

    /// Makes `course` hold what the axes have in common, in ticks of 1/`tick_hz` s; `tick_hz` is above 0.
    pub fn lay(&self, course: &mut Course, tick_hz: u32) {
        course.set_clock(self.begin_s, self.duration_s, tick_hz);
    }

    /// Makes `lane` the axis with index `axis`, on the course that [`lay`](Self::lay) has made from this blend.
    pub fn begin_lane(&self, axis: usize, course: &Course, lane: &mut Lane) {
        lane.begin_blend(&self.axis(axis), course);
    }

    /// An axis that slows down, and then speeds up: one of both if it does not turn.
    fn axis(&self, axis: usize) -> AxisBlend {
        let [[from_steps_s, to_steps_s], [from, to]] = [self.speeds_steps_s[axis], self.places_steps[axis]];
        let [begin, turn, end] = self.counts[axis];
        let (accel_steps_s2, end_s) = (self.accel_steps_s2(axis).abs(), self.begin_s + self.duration_s);
        let (out, back) = (turn.abs_diff(begin), end.abs_diff(turn));
        // As on a line, no step is nearer to the slow end than this.
        let near = 0.5 - NEAREST_STEPS;
        if from_steps_s * to_steps_s < 0.0 {
            let turn_s = self.begin_s + from_steps_s.abs() / accel_steps_s2;
            let peak = from_steps_s.signum() * from + from_steps_s * from_steps_s / (2.0 * accel_steps_s2);
            let beyond = (peak - from_steps_s.signum() * f64::from(turn)).max(-near);
            let (begin_s, end_s, ahead) = (turn_s, turn_s, -beyond);
            return AxisBlend { slow_steps_s: 0.0, accel_steps_s2, begin_s, end_s, ahead, beyond, out, back };
        }
        let begin_s = self.begin_s;
        if from_steps_s.abs() > to_steps_s.abs() {
            let beyond = (from_steps_s.signum() * (to - f64::from(end))).max(-near);
            let slow_steps_s = to_steps_s.abs();
            AxisBlend { slow_steps_s, accel_steps_s2, begin_s, end_s, ahead: 0.0, beyond, out, back }
        } else {
            let ahead = (to_steps_s.signum() * (from - f64::from(begin))).min(near);
            let slow_steps_s = from_steps_s.abs();
            AxisBlend { slow_steps_s, accel_steps_s2, begin_s, end_s, ahead, beyond: 0.0, out: 0, back: out + back }
        }
    }
}
