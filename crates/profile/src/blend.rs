//! A corner that no axis exceeds its limits at: a blend.
//!
//! From a place on one block to a place on the next, each axis has one constant acceleration, for a time that all axes
//! share. So a blend is to a corner what a ramp is to a block: every axis has the same interval.
//!
//! Before that, it may go straight on at constant speed, on what little is left of the block: the approach. Planned and
//! compiled as a line of its own, that would take as long as a whole move.

use libm::floor;

use crate::fixed::{is_negative, is_zero};
use crate::phase::{AxisPhase, CountedPhase, turn, turns};
use crate::sync::{MoveSteps, SyncMove, offset};

/// The plan of a corner for `N` axes: from the end of a line of one block to the beginning of a line of the next, each
/// axis at a constant acceleration of its own, after an approach at constant speed.
///
/// A step is due where its axis is half a step from a whole one, as on a line. An axis that goes back makes the steps up
/// to where it turns, and then those of its way back. Two edges there that would be nearer to each other than two steps
/// at the axis's top speed are both left out. What is left out ends less than a/(8 v²) steps beyond its edge.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Blend<const N: usize> {
    /// Steps of each axis in the whole move to which it leads, signed by direction.
    pub steps: [i32; N],
    /// The places where that move begins and ends beside whole steps.
    offsets: [[i8; N]; 2],
    begin_s: f64,
    /// The time that the approach lasts, and the corner itself.
    approach_s: f64,
    corner_s: f64,
    /// Speeds of each axis where it begins and ends, steps/s, signed by direction.
    speeds_steps_s: [[f64; 2]; N],
    /// The places where each axis is where the approach and the corner end, steps from the whole step next to the corner, signed
    /// by direction.
    places_steps: [[f64; 2]; N],
    /// The number of steps that each axis is from the corner where it begins, has approached, turns and ends, signed by
    /// direction.
    counts: [[i32; 4]; N],
}

/// A block as a blend sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side<'a, const N: usize> {
    pub(crate) move_steps: &'a MoveSteps<N>,
    /// The steps of each axis for a step of the longest one, signed by direction.
    pub(crate) shares: [f64; N],
    /// The number of steps of each axis that are due on this block before the blend begins, or when it ends.
    pub(crate) counts: [u32; N],
    /// The distance of the corner from the place where the blend begins or ends, approach apart, steps of the longest axis.
    pub(crate) corner_steps: f64,
    /// The speed of the longest axis there, steps/s.
    pub(crate) speed_steps_s: f64,
}

/// The instant at which a blend begins, and the times that its parts last, s.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Times {
    pub(crate) begin_s: f64,
    pub(crate) approach_s: f64,
    pub(crate) corner_s: f64,
}

impl<const N: usize> Blend<N> {
    /// The blend from the side before the corner to that after it. `tops_steps_s` are the top speeds of the axes.
    pub(crate) fn new(
        before: &Side<'_, N>,
        after: &Side<'_, N>,
        times: Times,
        tops_steps_s: impl Fn(usize) -> f64,
    ) -> Self {
        let Times { begin_s, approach_s, corner_s } = times;
        let mut blend = Self {
            steps: after.move_steps.steps,
            offsets: after.move_steps.offsets,
            begin_s,
            approach_s,
            corner_s,
            speeds_steps_s: [[0.0; 2]; N],
            places_steps: [[0.0; 2]; N],
            counts: [[0; 4]; N],
        };
        for axis in 0..N {
            let [from, to] = [before.shares[axis], after.shares[axis]];
            let [before_steps, after_steps] = [before, after].map(|side| side.move_steps.steps[axis]);
            let begin = before.counts[axis] as i32 * before_steps.signum() - before_steps;
            let end = after.counts[axis] as i32 * after_steps.signum();
            let corner = offset(after.move_steps.offsets[0][axis]);
            if is_zero(from) && is_zero(to) {
                (blend.places_steps[axis], blend.counts[axis]) = ([corner; 2], [begin, begin, end, end]);
                continue;
            }
            let speeds_steps_s = [from * before.speed_steps_s, to * after.speed_steps_s];
            blend.speeds_steps_s[axis] = speeds_steps_s;
            let places = [corner - from * before.corner_steps, corner + to * after.corner_steps];
            blend.places_steps[axis] = places;
            // It may begin or end at rest, in whatever direction it was to go.
            let [from_steps_s, to_steps_s] = speeds_steps_s;
            let turn = if turns(from_steps_s, to_steps_s) {
                let accel = blend.accel_steps_s2(axis);
                turn(places[0], from_steps_s, accel, [begin, end], tops_steps_s(axis))
            } else {
                end
            };
            let is_back = is_negative(if is_zero(from_steps_s) { to_steps_s } else { from_steps_s });
            let approached = if is_zero(approach_s) { begin } else { nearest(places[0], is_back) };
            let approached = if is_back { approached.min(begin).max(turn) } else { approached.max(begin).min(turn) };
            blend.counts[axis] = [begin, approached, turn, end];
        }
        blend
    }

    /// The instant at which it begins, s from the start of the run.
    #[must_use]
    pub fn begin_s(&self) -> f64 {
        self.begin_s
    }

    /// The instant at which it ends, s from the start of the run.
    #[must_use]
    pub fn end_s(&self) -> f64 {
        self.corner_begins_s() + self.corner_s
    }

    /// The instant at which its approach ends and its corner begins, s from the start of the run.
    #[must_use]
    pub fn corner_begins_s(&self) -> f64 {
        if is_zero(self.approach_s) { self.begin_s } else { self.begin_s + self.approach_s }
    }

    /// The time that the corner lasts, without the approach, s.
    #[must_use]
    pub fn corner_s(&self) -> f64 {
        self.corner_s
    }

    /// The plan of no distance with which the move goes on where the blend ends, `end_steps` of the longest axis from the
    /// beginning of the move.
    #[must_use]
    pub fn landing(&self, end_steps: f64) -> SyncMove<N> {
        let move_steps = MoveSteps { steps: self.steps, offsets: self.offsets };
        let longest = (0..N).max_by(|one, other| move_steps.len(*one).abs().total_cmp(&move_steps.len(*other).abs()));
        let speed_steps_s = longest.map_or(0.0, |axis| self.speeds_steps_s[axis][1].abs());
        SyncMove::passing(&move_steps, end_steps, speed_steps_s, self.end_s())
    }

    /// The place where an axis is at `t_s` from the start of the run, steps from the whole step next to the corner, signed by
    /// direction.
    #[must_use]
    pub fn place_at(&self, axis: usize, t_s: f64) -> f64 {
        let t_s = self.within(t_s);
        let [from_steps_s, _] = self.speeds_steps_s[axis];
        let bent_steps_s = if t_s > 0.0 { self.accel_steps_s2(axis) * t_s / 2.0 } else { 0.0 };
        self.places_steps[axis][0] + (from_steps_s + bent_steps_s) * t_s
    }

    /// The speed of an axis at `t_s` from the start of the run, steps/s, signed by direction.
    #[must_use]
    pub fn speed_at(&self, axis: usize, t_s: f64) -> f64 {
        self.speeds_steps_s[axis][0] + self.accel_steps_s2(axis) * self.within(t_s).max(0.0)
    }

    /// The time from where the corner begins, within the blend, s.
    fn within(&self, t_s: f64) -> f64 {
        (t_s - self.corner_begins_s()).max(-self.approach_s).min(self.corner_s)
    }

    /// The acceleration of an axis at the corner, steps/s², signed by direction.
    #[must_use]
    pub fn accel_steps_s2(&self, axis: usize) -> f64 {
        let [from_steps_s, to_steps_s] = self.speeds_steps_s[axis];
        (to_steps_s - from_steps_s) * (1.0 / self.corner_s)
    }

    /// The number of steps that an axis makes, and how many of them before it turns; if it does not turn, that is all of them.
    #[must_use]
    pub fn step_counts(&self, axis: usize) -> (u32, u32) {
        let [begin, _, turn, end] = self.counts[axis];
        let out = turn.abs_diff(begin);
        (out + end.abs_diff(turn), out)
    }

    /// The number of steps that an axis is from the corner where it begins and where it ends, signed by direction.
    #[must_use]
    pub fn ends_steps(&self, axis: usize) -> [i32; 2] {
        let [begin, .., end] = self.counts[axis];
        [begin, end]
    }

    /// The direction of an axis's first step, 1 or -1; 0 if it makes none.
    #[must_use]
    pub fn direction(&self, axis: usize) -> i32 {
        let [begin, _, turn, end] = self.counts[axis];
        if turn == begin { (end - turn).signum() } else { (turn - begin).signum() }
    }

    /// The instant at which an axis makes its `k`-th step, counted from 1, s from the start of the run, by the closed form.
    #[must_use]
    pub fn step_time_s(&self, axis: usize, k: u32) -> f64 {
        let approach = self.approach(axis);
        let approached = approach.step_counts().0;
        if k <= approached { approach.step_time_s(k) } else { self.corner(axis).step_time_s(k - approached) }
    }

    /// The phases of an axis, in order: the approach and the corner. Places and counts are from the whole step next to the corner.
    #[must_use]
    pub fn counted_phase(&self, axis: usize, index: usize) -> Option<CountedPhase> {
        match index {
            0 => Some(self.approach(axis)),
            1 => Some(self.corner(axis)),
            _ => None,
        }
    }

    /// An approach that lasts no time has any place.
    #[inline(never)]
    pub(crate) fn approach(&self, axis: usize) -> CountedPhase {
        let [begin, approached, ..] = self.counts[axis];
        let (end_s, end_place_steps, speed_steps_s) =
            (self.corner_begins_s(), self.places_steps[axis][0], self.speeds_steps_s[axis][0]);
        let phase = if is_zero(self.approach_s) {
            AxisPhase::rest(end_s, 0.0)
        } else {
            let place_steps = end_place_steps - speed_steps_s * (end_s - self.begin_s);
            AxisPhase { speed_steps_s, ..AxisPhase::rest(self.begin_s, place_steps) }
        };
        let counts = [begin, approached, approached];
        CountedPhase { phase, end_s, end_place_steps, end_speed_steps_s: speed_steps_s, jerk_steps_s3: 0.0, counts }
    }

    #[inline(never)]
    pub(crate) fn corner(&self, axis: usize) -> CountedPhase {
        let [_, approached, turn, end] = self.counts[axis];
        let [place_steps, end_place_steps] = self.places_steps[axis];
        let [speed_steps_s, end_speed_steps_s] = self.speeds_steps_s[axis];
        let begin_s = self.corner_begins_s();
        let phase = AxisPhase { begin_s, place_steps, speed_steps_s, accel_steps_s2: self.accel_steps_s2(axis) };
        let counts = [approached, turn, end];
        CountedPhase {
            phase,
            end_s: begin_s + self.corner_s,
            end_place_steps,
            end_speed_steps_s,
            jerk_steps_s3: 0.0,
            counts,
        }
    }
}

/// The step whose edge is the next before a place, halves counting as passed in the direction of the axis.
fn nearest(place_steps: f64, is_back: bool) -> i32 {
    if is_back { -(floor(0.5 - place_steps) as i32) } else { floor(place_steps + 0.5) as i32 }
}
