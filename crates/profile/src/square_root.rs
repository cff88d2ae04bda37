//! Square roots for a core that has no divider and whose products have 32 bits.
//!
//! The number is scaled to an m from 1/4 to 1, and y = 1/√m is computed: a table gives a seed of 7 bits, a third-order
//! step (y (1 + r/2 + 3 r²/8) with r = 1 - m y²) makes 15 bits of it, and a Newton step 28 bits. Then s = m y is the
//! root to 28 bits, and s + (m - s²) y/2 is the root to twice as many. Every step except the third-order one errs
//! downwards, so m - s² is never negative.

use crate::fixed::product;

/// The seeds: y in units of 2^-7 for each m that starts with the seven bits of the index. There is none for an m below
/// 1/4.
static SEEDS: [u8; 128] = seeds();

const fn seeds() -> [u8; 128] {
    let mut seeds = [0; 128];
    let mut index = 32;
    while index < seeds.len() {
        // 2^7/√((index + 1/2)/2^7), doubled so that it can be rounded.
        let doubled = ((1 << 24) / (2 * index as u32 + 1)).isqrt();
        seeds[index] = if doubled > 510 { 255 } else { doubled.div_ceil(2) as u8 };
        index += 1;
    }
    seeds
}

/// The square root of a float, rounded to the nearest. It equals `libm`'s to the last bit, and takes a tenth of the
/// time.
pub(crate) fn sqrt(x: f64) -> f64 {
    let bits = x.to_bits();
    if !(f64::MIN_POSITIVE.to_bits()..f64::INFINITY.to_bits()).contains(&bits) {
        // These numbers are rare or have no root: zeros, subnormal and negative numbers, infinity and NaN.
        return libm::sqrt(x);
    }
    // The mantissa, scaled by an even power of 2 to the range from 1/4 to 1.
    let is_even = (bits >> 52) as u32 & 1 == 1;
    let mantissa = (bits | 1 << 52) << 11;
    let m = if is_even { mantissa >> 1 } else { mantissa };
    let below = root_of_mantissa(m) >> 11;
    // The root is above `below` by less than 1.5. So m less the square is below 2^64, and its lower 64 bits are all of
    // it. The root is nearer to the next number if this rest is more than s, because (s + 1/2)² is s² + s + 1/4.
    let (upper, lower) = ((below >> 32) as u32, below as u32);
    let square = product(lower, lower).wrapping_add(u64::from(upper.wrapping_mul(lower)) << 33);
    let rest = (m << 42).wrapping_sub(square);
    let nearest = below + u64::from(rest > below);
    // This exponent is one too small; the first bit of `nearest` adds the missing one.
    let exponent = (bits >> 53) + 510 + u64::from(is_even);
    f64::from_bits((exponent << 52) + nearest)
}

/// √(x/2^62), at most 2^-23 of it off. `x` is above 0.
pub(crate) fn root_f32(x: u64) -> f32 {
    // The number, scaled by an even power of 2 to the range from 1/4 to 1.
    let zeros = x.leading_zeros() & !1;
    let m = (x << zeros >> 32) as u32;
    // The root, in units of 2^-(30 + zeros/2).
    let root = (product(m, inverse_root(m)) >> 32) as u32;
    f32::from_bits((root as f32).to_bits().wrapping_sub((30 + zeros / 2) << 23))
}

/// 2^32 √m, at most 2^-54 of it too small. The first two bits of m must not both be 0.
#[inline(always)]
pub(crate) fn root_of_mantissa(m: u64) -> u64 {
    let high = (m >> 32) as u32;
    let y = inverse_root(high);
    let s = (product(high, y) >> 32) as u32;
    // The rest is in units of 2^-64 and below 2^38.
    let rest = m.wrapping_sub(product(s, s) << 2);
    (u64::from(s) << 33).wrapping_add(product((rest >> 6) as u32, y) >> 26)
}

/// 2^31/√(m/2^32) for an m of 2^30 or more, at most 2^-27 too small and never too large.
#[inline(always)]
fn inverse_root(m: u32) -> u32 {
    let seed = u32::from(SEEDS[(m >> 25) as usize]);
    // 1 - m y², in units of 2^-32. m y² is near 1, so the digits before its point are not needed.
    let lack = (m >> 14).wrapping_mul(seed * seed).wrapping_neg() as i32;
    let lack_squared = (lack >> 16) * (lack >> 16);
    let correction = (lack >> 4).wrapping_add(lack_squared.wrapping_mul(3) >> 6);
    let y = (seed << 8).wrapping_add_signed((seed as i32).wrapping_mul(correction) >> 21);
    let lack = ((product(m, y.wrapping_mul(y)) >> 30) as u32).wrapping_neg() as i32;
    // One less, because 1 - m y² was rounded up.
    (y << 16).wrapping_add_signed((y as i32).wrapping_mul(lack >> 3) >> 14).wrapping_sub(1)
}

#[cfg(test)]
mod tests {
    use isostep_trials::cases;
    use proptest::prelude::*;

    use super::{inverse_root, root_f32, sqrt};

    fn check(x: f64) {
        assert_eq!(sqrt(x).to_bits(), x.sqrt().to_bits(), "the root of {x:e}");
    }

    #[test]
    fn roots_of_squares_and_their_neighbours_are_rounded_to_the_nearest() {
        for root in (1..1 << 20).map(f64::from).chain((0..1 << 16).map(|less| f64::from(u32::MAX - less))) {
            // The square must have 53 bits at most, so that it is exact.
            let root = if root < 67_108_864.0 { root } else { (root / 64.0).trunc() };
            assert_eq!(sqrt(root * root), root);
            check((root * root).next_up());
            check((root * root).next_down());
        }
    }

    #[test]
    fn roots_of_what_is_rare() {
        for x in [0.0, -0.0, f64::MIN_POSITIVE, f64::MIN_POSITIVE.next_down(), f64::MAX, f64::INFINITY, 5e-324] {
            check(x);
        }
        assert!(sqrt(-1.0).is_nan() && sqrt(f64::NAN).is_nan() && sqrt(f64::NEG_INFINITY).is_nan());
    }

    /// The whole range of each seed, at a stride that hits every seed some 13,000 times.
    #[test]
    fn inverse_roots_are_never_too_large() {
        for m in (1 << 30..=u32::MAX).step_by(2_503).chain([1 << 30, u32::MAX]) {
            let exact = 2_147_483_648.0 / (f64::from(m) / 4_294_967_296.0).sqrt();
            let short = exact - f64::from(inverse_root(m));
            assert!((0.0..=32.0).contains(&short), "{m:#x}: short by {short}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: cases(20_000, 1_000_000), failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn roots_are_rounded_to_the_nearest(bits in 0..f64::INFINITY.to_bits()) {
            check(f64::from_bits(bits));
        }

        #[test]
        fn short_roots_are_near(bits in 1..=u64::MAX, zeros in 0..64u32) {
            let x = (bits >> zeros).max(1);
            let exact = (x as f64 / 4_611_686_018_427_387_904.0).sqrt();
            let error = f64::from(root_f32(x)) / exact - 1.0;
            prop_assert!(error.abs() <= f64::from(f32::EPSILON), "{x:#x}: {error:e}");
        }

        /// Roots that are halfway between two floats, or nearly so.
        #[test]
        fn roots_near_half_a_unit_are_rounded_to_the_nearest(root in 1.0..4.0f64, off in -2..=2i64) {
            let half_up = root * root + root * f64::EPSILON / 2.0;
            check(f64::from_bits(half_up.to_bits().wrapping_add_signed(off)));
        }
    }
}
