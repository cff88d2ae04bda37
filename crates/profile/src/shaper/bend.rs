//! A bend: the motion of a shaped axis for a while, and the steps that it makes meanwhile.

use libm::floor;

use super::leg::Leg;
use crate::fixed::{is_negative, is_zero};
use crate::square_root::sqrt;

/// An edge counts as passed so far behind it, steps: beyond what rounding does to a place. It is made at its instant.
const PASSED_STEPS: f64 = 1e-9;
/// A turn that comes as soon as this, s, is that from which a bend begins.
pub(super) const AT_ONCE_S: f64 = 1e-6;

/// A part of shaped motion of one axis, at constant acceleration, in which the axis may turn; or at constant jerk, in which it
/// does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    /// Its motion from its beginning on; its place is counted from the same whole step as `counts`.
    pub leg: Leg,
    /// The instant at which it ends, s from the start of the run.
    pub end_s: f64,
    /// The place where the axis is then, steps.
    pub end_place_steps: f64,
    /// Its speed then, steps/s, signed by direction.
    pub end_speed_steps_s: f64,
    /// The jerk, steps/s³.
    pub jerk_steps_s3: f64,
    /// The whole step where the axis begins, where it turns, and where it ends. If it does not turn, the second is the third.
    pub counts: [i32; 3],
}

impl Bend {
    /// The number of steps that the axis makes, and how many of them before it turns; if it does not turn, that is all of them.
    #[must_use]
    pub fn step_counts(&self) -> (u32, u32) {
        let [begin, turn, end] = self.counts;
        let out = turn.abs_diff(begin);
        (out + end.abs_diff(turn), out)
    }

    /// The direction of the first step, 1 or -1; 0 if there is none.
    #[must_use]
    pub fn direction(&self) -> i32 {
        let [begin, turn, end] = self.counts;
        if turn == begin { (end - turn).signum() } else { (turn - begin).signum() }
    }
}

/// The sum of the impulses: a leg, whose acceleration a box makes change.
#[derive(Clone, Copy)]
pub(super) struct Sum {
    pub(super) leg: Leg,
    /// Steps/s³.
    pub(super) jerk_steps_s3: f64,
}

impl Sum {
    pub(super) fn is_curved(&self) -> bool {
        !is_zero(self.jerk_steps_s3)
    }

    /// The place and the speed of the axis at `t_s` from the start of the run.
    #[inline(always)]
    pub(super) fn at(&self, t_s: f64) -> (f64, f64) {
        if self.is_curved() { self.at_by_jerk(t_s) } else { self.leg.at(t_s) }
    }

    #[inline(never)]
    fn at_by_jerk(&self, t_s: f64) -> (f64, f64) {
        let Leg { begin_s, place_steps, speed_steps_s, accel_steps_s2 } = self.leg;
        let past_s = t_s - begin_s;
        let gained_steps_s2 = 0.5 * self.jerk_steps_s3 * past_s;
        let mean_steps_s = speed_steps_s + (0.5 * accel_steps_s2 + gained_steps_s2 * (1.0 / 3.0)) * past_s;
        (place_steps + mean_steps_s * past_s, speed_steps_s + (accel_steps_s2 + gained_steps_s2) * past_s)
    }

    /// The instant at which an axis whose acceleration changes turns first, s after its beginning; infinite if it does not. At
    /// once does not count.
    #[inline(never)]
    pub(super) fn turns_after_s(&self) -> f64 {
        let Self { leg: Leg { speed_steps_s: v, accel_steps_s2: a, .. }, jerk_steps_s3: j } = *self;
        let square = a * a - 2.0 * j * v;
        if square < 0.0 {
            return f64::INFINITY;
        }
        let far = -(a + sqrt(square).copysign(a));
        if is_zero(far) {
            return f64::INFINITY;
        }
        let counts = |t_s: f64| if t_s > AT_ONCE_S { t_s } else { f64::INFINITY };
        let (one_s, other_s) = (counts(far / j), counts(2.0 * v / far));
        if one_s < other_s { one_s } else { other_s }
    }
}

/// True if an axis that begins and ends with these speeds turns on the way.
pub(crate) fn turns(from_steps_s: f64, to_steps_s: f64) -> bool {
    is_negative(from_steps_s) != is_negative(to_steps_s) && !is_zero(from_steps_s) && !is_zero(to_steps_s)
}

/// The step nearest to the place where an axis turns whose two edges there, out and back, are no nearer to each other than
/// two steps at its top speed. `counts` are the whole steps where it begins and ends.
pub(crate) fn turn(place_steps: f64, from_steps_s: f64, accel: f64, counts: [i32; 2], top_steps_s: f64) -> i32 {
    let (accel, is_back) = (accel.abs(), from_steps_s < 0.0);
    let along = |count: i32| if is_back { -count } else { count };
    let apart_steps = accel / (8.0 * top_steps_s * top_steps_s);
    let peak = if is_back { -place_steps } else { place_steps } + from_steps_s * from_steps_s / (2.0 * accel);
    along((floor(peak - apart_steps + 0.5) as i32).max(along(counts[0])).max(along(counts[1])))
}

/// The last step whose edge an axis has passed at a place.
pub(super) fn passed(place_steps: f64, is_back: bool) -> i32 {
    if is_back { -whole(0.5 - PASSED_STEPS - place_steps) } else { whole(place_steps + (0.5 - PASSED_STEPS)) }
}

/// The whole number at or below a place. Above 0 a conversion does that, and it is far quicker.
fn whole(place_steps: f64) -> i32 {
    const ABOVE: i32 = 1 << 20;
    if (place_steps.to_bits() >> 52) & 0x7FF < 0x3FF + 20 {
        (place_steps + f64::from(ABOVE)) as i32 - ABOVE
    } else {
        floor(place_steps) as i32
    }
}
