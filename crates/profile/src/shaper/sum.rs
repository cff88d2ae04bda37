//! The sum of a shaper's impulses.

use libm::floor;

use crate::fixed::is_zero;
use crate::phase::AxisPhase;
use crate::square_root::sqrt;

/// An edge counts as passed so far behind it, steps: beyond what rounding does to a place. It is made at its instant.
const PASSED_STEPS: f64 = 1e-9;
/// A turn that comes as soon as this, s, is that from which a phase begins.
pub(super) const AT_ONCE_S: f64 = 1e-6;

/// The sum of the impulses: a phase, whose acceleration a box makes change.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sum {
    pub(super) phase: AxisPhase,
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
        if self.is_curved() { self.at_by_jerk(t_s) } else { self.phase.at(t_s) }
    }

    #[cold]
    fn at_by_jerk(&self, t_s: f64) -> (f64, f64) {
        let AxisPhase { begin_s, place_steps, speed_steps_s, accel_steps_s2 } = self.phase;
        let past_s = t_s - begin_s;
        let gained_steps_s2 = 0.5 * self.jerk_steps_s3 * past_s;
        let mean_steps_s = speed_steps_s + (0.5 * accel_steps_s2 + gained_steps_s2 * (1.0 / 3.0)) * past_s;
        (place_steps + mean_steps_s * past_s, speed_steps_s + (accel_steps_s2 + gained_steps_s2) * past_s)
    }

    /// The instant at which an axis whose acceleration changes turns first, s after its beginning; infinite if it does not. At
    /// once does not count.
    #[cold]
    pub(super) fn turns_after_s(&self) -> f64 {
        let Self { phase: AxisPhase { speed_steps_s: v, accel_steps_s2: a, .. }, jerk_steps_s3: j } = *self;
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
