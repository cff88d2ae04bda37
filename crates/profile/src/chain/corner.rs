//! The speed at which a corner may be taken.

use core::array::from_fn;

use super::config::{ChainConfig, ONE, SQUARE_MAX, Square};
use crate::fixed::{is_zero, product};
use crate::square_root::root_f32;

/// The components of the unit vector along a path, in units of 2^-61. So sums and differences of two are exact.
pub(super) type UnitVector<const N: usize> = [i64; N];

/// Directions count as the same if no component of their difference is as large as this, 2e-12, which allows for
/// rounding only.
const SAME: u64 = 1 << 22;
/// Directions count as opposite if half the length of their sum is below this: a cosine of -0.999999, as in Grbl.
const OPPOSITE: f32 = 7.071_068e-4;
/// Half the length of their difference is above this then.
const NEARLY_OPPOSITE: f32 = 0.999;

/// The direction of a path with these components, of which `per_mm` is the inverse of the length.
pub(super) fn direction<const N: usize>(mm: &[f64; N], per_mm: f64) -> UnitVector<N> {
    let mut direction = [0; N];
    for (component, mm) in direction.iter_mut().zip(mm).filter(|(_, mm)| !is_zero(**mm)) {
        *component = in_units(mm * per_mm);
    }
    direction
}

/// A component of a unit vector, rounded towards 0.
fn in_units(component: f64) -> i64 {
    let bits = component.to_bits();
    // As a mantissa from 1 to 2 whose first bit is 2^63.
    let mantissa = (bits | 1 << 52) << 11;
    let shift = 1_025_u32.wrapping_sub((bits >> 52 & 0x7ff) as u32);
    let size = mantissa.checked_shr(shift).unwrap_or(0) as i64;
    if component < 0.0 { -size } else { size }
}

/// True if both directions count as the same.
pub(super) fn is_straight<const N: usize>([before, after]: [&UnitVector<N>; 2]) -> bool {
    (0..N).all(|axis| after[axis].abs_diff(before[axis]) < SAME)
}

/// The squared speed at a corner by Grbl's rule. On a circle that deviates from the corner by the configured distance,
/// this speed needs the acceleration that the axes have across the corner. `None` if the machine has to stop there.
///
/// v² = a deviation s/(1 - s), where s is the sine of half the angle between the reversed direction before the corner
/// and the direction after it: half the length of both directions' sum. Let h be half the length of their difference,
/// so that h² = 1 - s². Then s/(1 - s) is s (1 + s)/h², which does not cancel. The acceleration a is the smallest of
/// what the axes may do, each divided by its component of the difference's direction.
pub(super) fn square<const N: usize>([before, after]: [&UnitVector<N>; 2], config: &ChainConfig<N>) -> Option<Square> {
    let difference = Short::<N>::of(&from_fn(|axis| after[axis].abs_diff(before[axis])));
    let Some(difference) = difference else { return Some(SQUARE_MAX as Square) };
    let sine = sine([before, after]);
    if sine < OPPOSITE || config.twice_deviation_mm == 0.0 {
        return None;
    }
    // The inverse of the acceleration that the axes have across the corner.
    let mut across_s2_mm = 0.0;
    for (axis, s2_mm) in config.corner_s2_mm.iter().enumerate() {
        let own_s2_mm = difference.component(axis).map_or(0.0, |own| s2_mm * own);
        if own_s2_mm > across_s2_mm {
            across_s2_mm = own_s2_mm;
        }
    }
    // Dividing by the half length stands for half/half². 24 bits are enough, because the result is only a bound.
    let mm2_s2 = config.twice_deviation_mm * sine * (1.0 + sine) / (across_s2_mm * difference.half_length());
    Some(config.scale.square(f64::from(mm2_s2)))
}

/// The sine of half the angle between the reversed direction before a corner and the direction after it.
fn sine<const N: usize>([before, after]: [&UnitVector<N>; 2]) -> f32 {
    let sum = Short::<N>::of(&from_fn(|axis| after[axis].wrapping_add(before[axis]).unsigned_abs()));
    sum.map_or(0.0, |sum| sum.half_length())
}

/// True if the path goes straight back, where half the length of the directions' difference is `half_length`.
pub(super) fn is_reversal<const N: usize>(directions: [&UnitVector<N>; 2], half_length: f32) -> bool {
    half_length > NEARLY_OPPOSITE && sine(directions) < OPPOSITE
}

/// The sizes of a vector's components, to the 30 leading bits of the largest.
pub(super) struct Short<const N: usize> {
    components: [u32; N],
    /// The components are in units of 2^-`point`.
    point: u32,
}

impl<const N: usize> Short<N> {
    /// `None` if all are smaller than [`SAME`].
    pub(super) fn of(components: &[u64; N]) -> Option<Self> {
        let all = components.iter().fold(0, |all, component| all | component);
        if all < SAME {
            return None;
        }
        let zeros = all.leading_zeros();
        Some(Self { components: components.map(|component| (component << zeros >> 34) as u32), point: 27 + zeros })
    }

    /// A component; `None` for 0.
    pub(super) fn component(&self, axis: usize) -> Option<f32> {
        let component = self.components[axis];
        (component != 0).then(|| scaled(component as f32, self.point))
    }

    /// The largest component, each weighed by a ratio in units of 2^-16, 1 at most.
    pub(super) fn most(&self, weights: &[u32; N]) -> u32 {
        let weighed = |(&own, &weight): (&u32, &u32)| match weight {
            ONE => own,
            _ => (product(own, weight) >> 16) as u32 + 1,
        };
        self.components.iter().zip(weights).map(weighed).fold(0, u32::max)
    }

    /// A component as a float.
    pub(super) fn scaled(&self, component: u32) -> f32 {
        scaled(component as f32, self.point)
    }

    /// A component in units of 2^-`point`, rounded down, the largest number at most.
    pub(super) fn in_units(&self, component: u32, point: u32) -> u32 {
        let shift = self.point as i32 - point as i32;
        if shift >= 0 {
            component.checked_shr(shift.unsigned_abs()).unwrap_or(0)
        } else if component.leading_zeros() >= shift.unsigned_abs() {
            component << shift.unsigned_abs()
        } else {
            u32::MAX
        }
    }

    pub(super) fn half_length(&self) -> f32 {
        let square = self.components.iter().fold(0_u64, |sum, &own| sum.wrapping_add(product(own, own)));
        // The root is in units of 2^-31, and half of it is asked for.
        scaled(root_f32(square), self.point.wrapping_sub(30))
    }
}

/// `x` in units of 2^-`point`, modulo 2^32 a negative one too; neither is below 2^-126.
fn scaled(x: f32, point: u32) -> f32 {
    f32::from_bits(x.to_bits().wrapping_sub(point << 23))
}
