//! A ramp at constant acceleration, in whole numbers.

use super::phase::Knot;
use super::root::{LOG2_SHORT_MAX, Root, log2};
use super::wide::{Line, Wide};

/// Logarithms are in units of 2^-16.
const ONE: i32 = 1 << 16;
/// 2 log2(3 √3).
const LOG2_27: i32 = 311_617;
/// log2(10^9 / (8 * 20)): at this rate, ticks/s, 20 ns are 1/8 tick.
const LOG2_LOOSE_HZ: i32 = 1_479_503;
/// log2 of the segments a second that are [brief](crate::BRIEF_S).
const LOG2_BRIEF_HZ: i32 = 653_117;

/// The time to the x-th half step from standstill is √(start + slope x), start being what the slow end lacks to standstill.
///
/// # Lengths
/// A quadratic through a function's values at 0, n/2 and n strays from it between by t''' (n/2)³/(9 √3), with the
/// third derivative where it is largest, at the slow end. Let Q be the radicand there, in units of u ticks², and S the
/// slope: t''' = 3 (2 S)³/(8 Q^(5/2)) u^(1/2), so that E ticks hold n³ = 24 √3 E Q^(5/2)/(S³ u^(1/2)), or, by
/// logarithms, 6 log2 n = 2 log2(24 √3 E) + 5 log2 Q - 6 log2 S - log2 u.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ramp {
    radicand: Line,
    /// log2 S, never too small.
    slope: i32,
    /// What 5 log2 Q is added to for E = 1/8.
    strict: i32,
    /// What more there is for the larger E of brief segments.
    loose: i32,
    /// A segment of n steps is brief if log2 n - 1/2 log2 Q is below this.
    brief: i32,
}

impl Ramp {
    /// Times are in units of 2^-`point` tick, the radicand in units of 2^(32 - 2 `point`) ticks².
    pub(super) fn new(radicand: Line, point: u8, tick_hz: f64) -> Self {
        let slope = log2(radicand.slope) + LOG2_SHORT_MAX;
        let hz = log2(Wide::new(tick_hz as u128));
        let half_unit = (16 - i32::from(point)) * ONE;
        Self {
            radicand,
            slope,
            strict: LOG2_27 - 6 * slope - 2 * half_unit,
            loose: 2 * (hz - LOG2_LOOSE_HZ).max(0),
            brief: hz - LOG2_BRIEF_HZ - slope - half_unit,
        }
    }

    /// The step `half_steps` from the slow end; its instant is the time from standstill.
    #[inline]
    pub(super) fn knot(&self, half_steps: u32) -> Knot {
        let Root { root, log2 } = Root::of(self.radicand.at(half_steps));
        Knot { instant: root, level: log2 }
    }

    /// Whether a quadratic holds 2^`length` steps from one of level `level` on, speeding up or, `backwards`, slowing down.
    #[inline]
    pub(super) fn fits(&self, length: i32, level: i32, backwards: bool) -> bool {
        // A quadratic through all of the steps.
        if length <= 1 {
            return true;
        }
        let loss = if backwards { self.loss(length, level) } else { 0 };
        let room = self.strict.wrapping_add((level - loss).wrapping_mul(5)).wrapping_sub(6 * ONE * length);
        room >= 0 || room.wrapping_add(self.loose) >= 0 && ONE * (length - 1) - level / 2 < self.brief
    }

    /// How much of log2 Q the next 2^`length` steps lose, at most: log2(1 - r) >= -2 r of a share r up to a half.
    #[inline]
    fn loss(&self, length: i32, level: i32) -> i32 {
        // Two half steps a step.
        let share = self.slope + ONE * (length + 1) - level;
        if share > -ONE {
            return 64 * ONE;
        }
        let doubled = share + ONE;
        // 2^(i + f) is 2^i (1 + f) at most.
        (ONE + (doubled & (ONE - 1))) >> (-(doubled >> 16)).min(31)
    }
}
