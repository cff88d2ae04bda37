//! A phase of one axis in fixed point: when its steps are due, and how many of them make a segment.

use super::cubic::Cubic;
use super::fit::Quadratic;
use super::fixed_ramp::{FixedRamp, Sample};
use super::small_accel::SmallAccel;
use super::u96::Linear;
use crate::segment::Segment;

/// Consecutive steps of an axis that share a formula. Steps count from 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct FixedPhase {
    pub(super) formula: Formula,
    /// The instant to which the formula's times are added, or from which they are subtracted if `backwards`.
    pub(super) origin: u64,
    /// The step after its last.
    pub(super) end: u32,
    /// The formula goes on smoothly to this step, which may be beyond the phase.
    pub(super) reach: u32,
    /// True if it decelerates: then the formula's times count back from the end of the move, and its steps from `reach`.
    pub(super) backwards: bool,
    /// Instants are in units of 2^-`point` tick. It is 32, or less if the move is too long for that.
    pub(super) point: u8,
    /// A segment holds 2^`length` steps, or all that are left if they are fewer.
    pub(super) length: u8,
}

/// The time that an odd number of half steps takes.
#[derive(Clone, Copy, Debug)]
pub(super) enum Formula {
    /// At constant speed.
    ConstantSpeed(Linear),
    /// At constant acceleration.
    Ramp(FixedRamp),
    /// At an acceleration so small that the formula with the root would lose it.
    SmallAccel(SmallAccel),
    /// At an acceleration that changes evenly.
    Cubic(Cubic),
}

impl FixedPhase {
    /// The step with the number `step`, up to `reach`.
    pub(super) fn sample(&mut self, step: u32) -> Sample {
        let from_origin = if self.backwards { self.reach.wrapping_sub(step) } else { step };
        let half_steps = from_origin.wrapping_mul(2) | 1;
        let Sample { instant, level, period_s } = match &mut self.formula {
            Formula::ConstantSpeed(line) => Sample { instant: line.at(half_steps).upper(), level: 0, period_s: 0.0 },
            Formula::Ramp(ramp) => ramp.sample(half_steps),
            Formula::SmallAccel(small_accel) => {
                Sample { instant: small_accel.time(half_steps), level: 0, period_s: 0.0 }
            }
            Formula::Cubic(cubic) => cubic.sample(half_steps),
        };
        let instant =
            if self.backwards { self.origin.wrapping_sub(instant) } else { self.origin.wrapping_add(instant) };
        Sample { instant, level, period_s }
    }

    /// The segment that begins at the step with the number `step`, and the step after that segment, if it is known.
    /// `first` is the step itself, if known.
    pub(super) fn segment(&mut self, step: u32, first: Option<Sample>) -> (Segment, Option<Sample>) {
        let first = first.unwrap_or_else(|| self.sample(step));
        let left = self.end.wrapping_sub(step);
        let mut fit = Quadratic { point: self.point.into(), length: 0, first: first.instant, rise: 0, curvature: 0 };
        if left == 1 {
            return (fit.segment(1), None);
        }
        fit.length = self.length(step, first.level, left);
        let mut far = self.sample_after(step, fit.length);
        fit.rise = far.instant.wrapping_sub(first.instant);
        while fit.is_too_long() {
            if fit.length == 0 {
                fit.rise = 0;
                return (fit.segment(1), Some(far));
            }
            fit.length -= 1;
            far = self.sample_after(step, fit.length);
            fit.rise = far.instant.wrapping_sub(first.instant);
        }
        if let Formula::Cubic(_) = self.formula {
            far = self.shorten(step, first, &mut fit, far);
        } else if fit.length > 0 && !matches!(self.formula, Formula::ConstantSpeed(_)) {
            let middle = self.sample_after(step, fit.length - 1);
            fit.bend(middle.instant.wrapping_sub(first.instant));
        }
        // The step at the far end is on the quadratic too.
        let steps = if left - 1 <= 1 << fit.length { left } else { 1 << fit.length };
        (fit.segment(steps), Some(far))
    }

    pub(super) fn sample_after(&mut self, step: u32, length: u32) -> Sample {
        self.sample(step.wrapping_add(1u32.wrapping_shl(length)))
    }

    /// log2 of the steps that a segment from `step` on holds, if `left` steps are left, 2 or more. It is no more than
    /// that takes.
    fn length(&mut self, step: u32, level: i32, left: u32) -> u32 {
        let most = 32_u32.wrapping_sub(left.wrapping_sub(2).leading_zeros());
        match &self.formula {
            Formula::Ramp(ramp) => {
                self.length = ramp.length(self.length.into(), most, level, self.backwards) as u8;
            }
            Formula::Cubic(cubic) => self.length = cubic.length(level),
            Formula::ConstantSpeed(_) | Formula::SmallAccel(_) => (),
        }
        let mut length = most.min(self.length.into());
        while 1u32.wrapping_shl(length) > self.reach.wrapping_sub(step) {
            length = length.wrapping_sub(1);
        }
        length
    }
}
