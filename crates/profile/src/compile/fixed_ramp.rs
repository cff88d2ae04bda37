//! A ramp at constant acceleration, in whole numbers.

use super::root_and_log2::{LOG2_SHORT_MAX, Root};
use super::u96::{Linear, exponent};

/// Logarithms are in units of 2^-16.
pub(super) const ONE: i32 = 1 << 16;
/// Larger than any logarithm here.
const EVERYTHING: i32 = 128 * ONE;
/// log2 27.
const LOG2_27: i32 = 311_617;
/// log2 of the ticks/s at which [`FIT_ERROR_MAX_S`](crate::FIT_ERROR_MAX_S) is
/// [`FIT_ERROR_MAX_TICKS`](crate::FIT_ERROR_MAX_TICKS): 6,250,000.
const LOG2_LOOSE_HZ: i32 = 1_479_503;
/// log2 of 1/[`BRIEF_S`](crate::BRIEF_S) in Hz: 1,000.
const LOG2_BRIEF_HZ: i32 = 653_117;

/// log2 of the steps of the longest segment. The growth of its intervals is rounded to 2^-32 tick, which makes 2^-7
/// tick over this many steps.
pub(super) const LENGTH_MAX: u32 = 14;

/// log2 of a normal number above 0 in units of 2^-16, at most [`LOG2_SHORT_MAX`] too small: it takes f for log2(1 + f),
/// which is at least f (Mitchell 1962).
pub(super) fn log2_of(x: f64) -> i32 {
    (exponent(x) << 16) + (x.to_bits() << 12 >> 48) as i32
}

/// A step: its instant, and how fast the axis is there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// The instant at which it is due, units of 2^-point tick from the start of the move.
    pub(super) instant: u64,
    /// log2 Q, which rises with the axis's speed there: see [`FixedRamp`].
    pub(super) level: i32,
    /// The time that a step takes at the speed there, s; 0 where nobody asks.
    pub(super) period_s: f32,
}

/// The time from standstill to the x-th half step from the slow end is √(start + slope x).
///
/// # Lengths
/// The time is t = √Q with Q = start + 2 slope k after k steps, so t''' = 3 slope³/Q^(5/2). A quadratic over n steps
/// deviates by t''' (n/2)³/(9 √3), so an error of E ticks allows n³ = 24 √3 E Q^(5/2)/slope³. With Q and the slope in
/// units of u ticks², 6 log2 n = 2 log2(24 √3 E) + 5 log2 Q - 6 log2 slope - log2 u. If E is 1/8, the first term is
/// log2 27.
#[derive(Clone, Copy, Debug)]
pub(super) struct FixedRamp {
    radicand: Linear,
    /// log2 of the slope, never too small.
    slope: i32,
    /// The number to be added to 5 log2 Q to get 6 log2 n, for E = 1/8.
    strict: i32,
    /// The number to be added for the larger E of brief segments.
    loose: i32,
    /// A segment of n steps is brief if log2 n - 1/2 log2 Q is below this.
    brief: i32,
}

impl FixedRamp {
    /// Times are in units of 2^-`point` tick, the radicand in units of 2^(32 - 2 `point`) ticks². `slope_log2` is log2
    /// of the radicand's slope, `hz_log2` that of the ticks/s; both come from [`log2_of`].
    pub(super) fn new(radicand: Linear, slope_log2: i32, point: u8, hz_log2: i32) -> Self {
        let slope = slope_log2 + LOG2_SHORT_MAX;
        let half_unit = (16 - i32::from(point)) * ONE;
        Self {
            radicand,
            slope,
            strict: LOG2_27 - 6 * slope - 2 * half_unit,
            loose: 2 * (hz_log2 - LOG2_LOOSE_HZ).max(0),
            brief: hz_log2 - LOG2_BRIEF_HZ - slope - half_unit,
        }
    }

    /// The step `half_steps` from the slow end; its instant is the time from standstill.
    #[inline(always)]
    pub(super) fn sample(&self, half_steps: u32) -> Sample {
        let Root { root, log2 } = Root::of(self.radicand.at(half_steps));
        Sample { instant: root, level: log2, period_s: 0.0 }
    }

    /// log2 of the steps that a quadratic holds from a step of level `level` on, `most` at most. `length` is that of the
    /// segment before, which had no less to hold: it only grows while speeding up, and only shrinks while slowing down
    /// (`backwards`).
    pub(super) fn length(&self, mut length: u32, most: u32, level: i32, backwards: bool) -> u32 {
        let most = most.min(LENGTH_MAX);
        if backwards {
            length = length.min(most);
            while !self.fits(length as i32, level, level.wrapping_sub(self.loss(length as i32, level))) {
                length -= 1;
            }
        } else {
            // A short ramp is a single segment.
            if length == 0 && self.fits(most as i32, level, level) {
                return most;
            }
            while length < most && self.fits(length as i32 + 1, level, level) {
                length += 1;
            }
        }
        length
    }

    /// True if a quadratic holds 2^`length` steps from a step of level `level` on. `slow` is the level of the slow end.
    #[inline(always)]
    fn fits(&self, length: i32, level: i32, slow: i32) -> bool {
        // There is always a quadratic through three steps.
        if length <= 1 {
            return true;
        }
        let room = self.strict.wrapping_add(slow.wrapping_mul(5)).wrapping_sub(6 * ONE * length);
        // Whether half of the segment is brief.
        let is_half_brief = (ONE * (length - 1)).wrapping_sub(level >> 1) < self.brief;
        room >= 0 || room.wrapping_add(self.loose) >= 0 && is_half_brief
    }

    /// By how much log2 Q falls over the next 2^`length` steps, at most: log2(1 - r) >= -2 r for a ratio r up to a
    /// half.
    #[inline(always)]
    fn loss(&self, length: i32, level: i32) -> i32 {
        // A step has two half steps.
        let ratio = self.slope.wrapping_add(ONE * (length + 1)).wrapping_sub(level);
        if ratio > -ONE {
            return EVERYTHING;
        }
        let doubled = ratio + ONE;
        // 2^(i + f) is at most 2^i (1 + f).
        (ONE + (doubled & (ONE - 1))).wrapping_shr((-(doubled >> 16)).min(31) as u32)
    }
}
