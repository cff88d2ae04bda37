//! A phase of a move for one axis: when its steps are due, and how many of them make a segment.

use super::cubic::Cubic;
use super::fit::Quadratic;
use super::fixed_ramp::{FixedRamp, Sample};
use super::small_accel::SmallAccel;
use super::u96::Linear;
use crate::segment::Segment;

/// Consecutive steps of an axis that share a law. Steps count from 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Phase {
    pub(super) law: Law,
    /// The instant to which the law's times are added, or from which they are subtracted if `backwards`.
    pub(super) origin: u64,
    /// The step after its last.
    pub(super) end: u32,
    /// The law goes on smoothly to this step, which may be beyond the phase.
    pub(super) reach: u32,
    /// True if it decelerates: then the law's times count back from the end of the move, and its steps from `reach`.
    pub(super) backwards: bool,
    /// Instants are in units of 2^-`point` tick. It is 32, or less if the move is too long for that.
    pub(super) point: u8,
    /// A segment holds 2^`length` steps, or all that are left if they are fewer.
    pub(super) length: u8,
}

/// The time that an odd number of half steps takes.
#[derive(Clone, Copy, Debug)]
pub(super) enum Law {
    /// At constant speed.
    ConstantSpeed(Linear),
    /// At constant acceleration.
    Ramp(FixedRamp),
    /// At an acceleration so small that the formula with the root would lose it.
    SmallAccel(SmallAccel),
    /// At an acceleration that changes evenly.
    Cubic(Cubic),
}

impl Phase {
    /// The step with the number `step`, up to `reach`.
    pub(super) fn sample(&self, step: u32) -> Sample {
        let from_origin = if self.backwards { self.reach.wrapping_sub(step) } else { step };
        let half_steps = from_origin.wrapping_mul(2) | 1;
        let Sample { instant, level } = match &self.law {
            Law::ConstantSpeed(line) => Sample { instant: line.at(half_steps).upper(), level: 0 },
            Law::Ramp(ramp) => ramp.sample(half_steps),
            Law::SmallAccel(small_accel) => Sample { instant: small_accel.time(half_steps), level: 0 },
            Law::Cubic(cubic) => Sample { instant: cubic.time(half_steps), level: 0 },
        };
        let instant =
            if self.backwards { self.origin.wrapping_sub(instant) } else { self.origin.wrapping_add(instant) };
        Sample { instant, level }
    }

    /// The segment that begins at the step with the number `step`, and the step after that segment, if it is known.
    /// `first` is the step itself, if known.
    pub(super) fn segment(&mut self, step: u32, first: Option<Sample>) -> (Segment, Option<Sample>) {
        let first = first.unwrap_or_else(|| self.sample(step));
        let left = self.end.wrapping_sub(step);
        let mut fit = Quadratic { point: self.point.into(), length: 0, first: first.instant, rise: 0, bend: 0 };
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
        if let Law::Cubic(cubic) = &self.law {
            far = self.shorten(step, cubic, &mut fit, far);
        } else if fit.length > 0 && !matches!(self.law, Law::ConstantSpeed(_)) {
            let middle = self.sample_after(step, fit.length - 1);
            let half_rise = middle.instant.wrapping_sub(first.instant);
            fit.bend = fit.rise.wrapping_sub(half_rise).wrapping_sub(half_rise) as i64;
        }
        // The step at the far end is on the quadratic too.
        let steps = if left - 1 <= 1 << fit.length { left } else { 1 << fit.length };
        (fit.segment(steps), Some(far))
    }

    /// Shortens a segment of a cubic until its quadratic is as near as it has to be, and bends it. `far` is the step at its end;
    /// returns that of the shorter one.
    #[inline(never)]
    fn shorten(&self, step: u32, cubic: &Cubic, fit: &mut Quadratic, mut far: Sample) -> Sample {
        while fit.length > 0 {
            let middle = self.sample_after(step, fit.length - 1);
            let half_rise = middle.instant.wrapping_sub(fit.first);
            fit.bend = fit.rise.wrapping_sub(half_rise).wrapping_sub(half_rise) as i64;
            // A quadratic through three steps is exact there. In between it is farthest from a cubic at 0.21 and 0.79 of the way,
            // and from a fourth power at 0.15 and 0.85. A half step is the finest that is tried.
            let sixteenths = if fit.length == 2 { 4 } else { 3 };
            let is_near = |sixteenths: u32| {
                let (before, left) = (u64::from(sixteenths), i64::from(sixteenths * (16 - sixteenths)));
                let instant = fit.first + fit.rise / 16 * before;
                let instant = instant.wrapping_add_signed(-fit.bend / 128 * left).wrapping_sub(self.origin);
                let half_steps = step * 2 + 1 + ((sixteenths << fit.length) >> 3);
                cubic.is_near(half_steps, instant, fit.rise)
            };
            if fit.length == 1 || is_near(sixteenths) && is_near(16 - sixteenths) {
                return far;
            }
            (far, fit.rise, fit.bend) = (middle, half_rise, 0);
            fit.length -= 1;
        }
        far
    }

    fn sample_after(&self, step: u32, length: u32) -> Sample {
        self.sample(step.wrapping_add(1u32.wrapping_shl(length)))
    }

    /// log2 of the steps that a segment from `step` on holds, if `left` steps are left, 2 or more. It is no more than
    /// that takes.
    fn length(&mut self, step: u32, level: i32, left: u32) -> u32 {
        let most = 32_u32.wrapping_sub(left.wrapping_sub(2).leading_zeros());
        if let Law::Ramp(ramp) = &self.law {
            self.length = ramp.length(self.length.into(), most, level, self.backwards) as u8;
        }
        let mut length = most.min(self.length.into());
        while 1u32.wrapping_shl(length) > self.reach.wrapping_sub(step) {
            length = length.wrapping_sub(1);
        }
        length
    }
}
