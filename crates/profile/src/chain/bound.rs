//! The highest squared speed at one end of a blend, by that at the other end.
//!
//! An axis with the component u on the one side and u' on the other allows squares P and Q with P - α √(P Q) ≤ c, where
//! α = u'/u and c = 2 reach a/u. The highest P rises with Q and is concave, and so is the least of what all axes allow. So
//! a chord between two of its points is below it. For a level of P the point is easily found: Q is (P - c)²/(α² P). The
//! chords begin at rest, at a few levels between, and end at the highest square. The least of the lines through them is a
//! sum and a product of whole numbers.
//!
//! Levels are in units of 2^-31 of the highest square. All of it is rounded so that no bound is too high.

use super::config::{SQUARE_MAX, Square};
use crate::fixed::product;

/// The number of lines that bound a square.
const LINES: usize = TIMES.len() + 1;
/// The levels at which they meet: so many times that at rest, if that is low.
const TIMES: [u32; 2] = [3, 20];
/// The level of the highest square.
const HIGHEST: u32 = 1 << 31;
/// From this level at rest on, one line is enough.
const HALF: u32 = HIGHEST / 2;
/// The unit of slopes, 2^-24.
const SLOPE_ONE: u32 = 1 << 24;
/// log2 of the steepest slope.
const STEEPEST_LOG2: u32 = 7;
/// Squares of fewer units are too coarse.
const FINE: Square = 1 << 24;

/// The lowest of a few lines.
// Packed, because each block has two of them, and each would end with a gap of four bytes.
#[repr(C, packed(4))]
#[derive(Clone, Copy, Debug)]
pub(super) struct Bound {
    /// The beginnings of the lines, at rest.
    at_rest: [Square; LINES],
    /// In units of 2^-24; 0 for a line that bounds nothing.
    slopes: [u32; LINES],
}

/// An axis that bounds the square on one side of the corner: the sizes of its components there and on the other side, and
/// twice the reach times its acceleration over the highest square. All of these are in the same units.
#[derive(Clone, Copy, Debug)]
pub(super) struct BindingAxis {
    pub(super) own: u32,
    pub(super) other: u32,
    pub(super) room: u32,
}

impl BindingAxis {
    /// True if it allows less than the highest square from rest. If it does, it does not turn.
    fn is_bound(&self) -> bool {
        self.room < self.own
    }

    /// The root of the square on the other side that allows `level`, times that of `level`.
    fn needs(&self, level: u32) -> u32 {
        let wanted = if level == HIGHEST { self.own } else { fraction(self.own, level) + 1 };
        if wanted > self.room { ratio(wanted - self.room, self.other) } else { 0 }
    }
}

impl Bound {
    pub(super) const NONE: Self = Self { at_rest: [0; LINES], slopes: [0; LINES] };

    /// The bound by all axes, up to the highest square. `None` if it is too low at rest.
    #[inline(never)]
    pub(super) fn of<const N: usize>(axes: &[BindingAxis; N], highest: Square) -> Option<Self> {
        let mut bound = Self::NONE;
        let mut rest = HIGHEST;
        for axis in axes.iter().filter(|axis| axis.is_bound()) {
            rest = rest.min(ratio(axis.room, axis.own) - (ratio(axis.room, axis.own) >> 14));
        }
        if rest == HIGHEST {
            return Some(bound);
        }
        // The square on the other side that allows a level.
        let other = |level: u32| {
            let needs = axes.iter().filter(|axis| axis.is_bound()).map(|axis| axis.needs(level));
            squared_over(needs.fold(0, u32::max), level)
        };
        let square = |level: u32| part(highest, level);
        if square(rest) < FINE {
            return None;
        }
        let (mut from, mut level) = (0, rest);
        for (index, times) in TIMES.into_iter().enumerate().filter(|_| rest < HALF) {
            let next = ratio((rest >> 5) * times, (HIGHEST >> 5) + (rest >> 5) * (times - 1)).min(HIGHEST - 1);
            let to = other(next);
            // Where units are too coarse, this point would be no help.
            if next <= level || to >= next {
                continue;
            }
            let run = to.saturating_sub(from).max((next - level) >> STEEPEST_LOG2).max(1);
            let slope = slope(next - level, run);
            let slope = slope - (slope >> 14) - 1;
            bound.at_rest[index] = square(level).saturating_sub(scaled(square(from) + 1, slope));
            (bound.slopes[index], from, level) = (slope, from + run, next);
        }
        let run = other(HIGHEST).min(HIGHEST).saturating_sub(from).max((HIGHEST - level) >> STEEPEST_LOG2).max(1);
        let (knee, slope) = (from + run, slope(HIGHEST - level, run));
        let mut last = slope + (slope >> 14) + 1;
        let mut knee_square = highest;
        if knee < HIGHEST - (HIGHEST >> 14) {
            knee_square = square(knee) + 1;
        } else {
            // Where it is as high at the other end, no rounding makes it lower.
            last = last.min(SLOPE_ONE);
        }
        let fall = scaled(knee_square, last);
        if fall > highest {
            // It would be below 0 at rest. As fast on both sides is always possible.
            last = SLOPE_ONE;
        }
        bound.at_rest[LINES - 1] = highest.saturating_sub(fall);
        bound.slopes[LINES - 1] = last;
        Some(bound)
    }

    /// The highest square, if that at the other end is `square`.
    pub(super) fn at(&self, square: Square) -> Square {
        let mut lowest = SQUARE_MAX as Square;
        for (at_rest, slope) in self.at_rest.into_iter().zip(self.slopes) {
            if slope != 0 {
                lowest = lowest.min(at_rest + scaled(square, slope));
            }
        }
        lowest
    }

    /// The lowest square at the other end that allows `square`, apart from rounding; no higher than that.
    // Seldom needed: in a hold, and where a change came too late.
    #[cold]
    pub(super) fn least_for(&self, square: Square) -> Square {
        let needed = |(at_rest, slope): (Square, u32)| match square.saturating_sub(at_rest) {
            _ if slope == 0 => 0,
            0 => 0,
            rise => (rise as f64 / f64::from(slope) * f64::from(SLOPE_ONE)) as Square + 1,
        };
        self.at_rest.into_iter().zip(self.slopes).map(needed).max().unwrap_or(0).min(square)
    }
}

/// The part `level` of `value`, in units of 2^-31, rounded down.
fn fraction(value: u32, level: u32) -> u32 {
    (product(value, level) >> 31) as u32
}

/// root²/level, 1 at most, rounded up.
fn squared_over(root: u32, level: u32) -> u32 {
    if root <= level {
        return fraction(root, ratio(root, level)) + 1;
    }
    let inverse = ratio(level, root);
    ratio(root, inverse - (inverse >> 14) - 1)
}

/// a/b in units of 2^-31, 1 at most. It is as large or larger by 2^-14 of itself at most.
fn ratio(a: u32, b: u32) -> u32 {
    if a >= b {
        return HIGHEST;
    }
    // By 16 bits of the divisor, because a 32-bit division is fast.
    let zeros = b.leading_zeros();
    let (a, b) = (a << zeros, b << zeros >> 16);
    let (upper, rest) = (a / b, a % b);
    ((upper << 15) + (((rest << 16) / b) >> 1) + 1).min(HIGHEST)
}

/// a/b in units of 2^-24, within 2^-14 of itself. It is no steeper than the steepest.
fn slope(a: u32, b: u32) -> u32 {
    let (a_zeros, b_zeros) = (a.leading_zeros(), b.leading_zeros());
    let quotient = (a << a_zeros) / (b << b_zeros >> 16);
    let shift = 8 + b_zeros as i32 - a_zeros as i32;
    if shift < 0 { quotient >> shift.unsigned_abs().min(31) } else { quotient << shift }
}

/// The part `level` of a square, rounded down.
fn part(square: Square, level: u32) -> Square {
    (product((square >> 32) as u32, level) << 1) + (product(square as u32, level) >> 31)
}

/// `square` times `slope`, the largest square at most.
fn scaled(square: Square, slope: u32) -> Square {
    let upper = product((square >> 32) as u32, slope);
    if upper >> 54 == 0 { (upper << 8).wrapping_add(product(square as u32, slope) >> 24) } else { SQUARE_MAX as Square }
}

#[cfg(test)]
mod tests {
    use isostep_trials::cases;
    use proptest::prelude::*;

    use super::{BindingAxis, Bound, Square};

    const UNIT: f64 = 1.0 / 2_147_483_648.0;

    /// Components and rooms over many orders of magnitude, such that no axis needs more than its room at the highest square.
    fn axis() -> impl Strategy<Value = BindingAxis> {
        (1_u32 << 30..=1 << 31, 0_u32..=1 << 31, 0_u32..31, 0_u32..31, any::<bool>(), any::<bool>()).prop_map(
            |(large, less, small, more, swaps, is_near)| {
                let near = if is_near { large - (less >> small).min(large) } else { less.min(large) };
                let (own, other) = if swaps { (near, large) } else { (large, near) };
                BindingAxis { own, other, room: own.abs_diff(other).max(1).saturating_add(less >> more) }
            },
        )
    }

    /// By how much an axis exceeds its room, in units of the highest square: p u - q u' times p.
    fn excess(axis: &BindingAxis, from: f64, to: f64) -> f64 {
        let [own, other, room] = [axis.own, axis.other, axis.room].map(|units| f64::from(units) * UNIT);
        (from * own - (from * to).sqrt() * other) / room - 1.0
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: cases(10_000, 100_000), failure_persistence: None, ..ProptestConfig::default() })]

        /// No axis exceeds its room, and no square falls where that at the other end is the same.
        #[test]
        fn bounds_are_below_what_axes_allow(axes in [axis(), axis(), axis()], at in prop::collection::vec(0_u32..31, 8), highest in 40_u32..62) {
            let highest: Square = (1 << highest) - 1;
            let Some(bound) = Bound::of(&axes, highest) else { return Ok(()) };
            for shift in at {
                let to = highest >> shift;
                let from = bound.at(to).min(highest);
                let [from_ratio, to_ratio] = [from, to].map(|square| square as f64 / highest as f64);
                for axis in &axes {
                    let excess = excess(axis, from_ratio, to_ratio);
                    prop_assert!(excess <= 1e-6, "{axes:?}: from {from_ratio} to {to_ratio}: {excess}");
                }
                prop_assert!(from >= to.min(highest - (highest >> 12)), "{axes:?}: from {from_ratio} to {to_ratio}");
            }
        }
    }
}
