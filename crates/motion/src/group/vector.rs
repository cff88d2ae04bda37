//! A little mathematics of vectors, in which speed and room count for more than the last digits.

use crate::axes::AXES;

/// A vector on all axes, mm or without a unit.
pub(super) type Vector = [f32; AXES];

// These two are called rather than inlined, and take slices: so they are loops, and what calls them is short.

/// Adds a multiple of a vector.
#[cold]
pub(super) fn add(to: &mut [f32], times: f32, what: &[f32]) {
    for (to, what) in to.iter_mut().zip(what) {
        if what.to_bits() != 0 {
            *to += times * what;
        }
    }
}

/// The scalar product of two vectors.
#[inline(never)]
pub(super) fn dot(one: &[f32], other: &[f32]) -> f32 {
    let mut sum = 0.0;
    for (one, other) in one.iter().zip(other) {
        if one.to_bits() != 0 {
            sum += one * other;
        }
    }
    sum
}

/// 1/√x, for an x above 0 and far from the least and the greatest number; at most 5e-6 of it off.
///
/// Half of the exponent is a first guess, and each step of Newton's method has twice as many digits right.
#[cold]
pub(super) fn inverse_root(x: f32) -> f32 {
    let mut y = f32::from_bits(0x5f37_5a86 - (x.to_bits() >> 1));
    for _ in 0..2 {
        y *= 1.5 - 0.5 * x * y * y;
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_inverse_root_is_good_to_five_digits() {
        let mut x = 1e-12_f32;
        while x < 1e12 {
            let off = f64::from(inverse_root(x)) * f64::from(x).sqrt() - 1.0;
            assert!(off.abs() < 5e-6, "{x}: {off}");
            x *= 1.003;
        }
    }
}
