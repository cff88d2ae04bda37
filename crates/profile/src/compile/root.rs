//! Square root and binary logarithm of a 96-bit number, for a core that neither divides nor multiplies to 64 bits.
//!
//! The root goes by way of y = 1/√m, m being the number scaled into 1/4 to 1: a seed of 7 bits from a table, a
//! third-order step (y (1 + r/2 + 3 r²/8) with r = 1 - m y²) to 15 bits, a Newton step to 28. Then s = m y is the root
//! to as many, and s + (m - s²) y/2 to twice as many. Every step but the third-order one errs to below, so m - s² is
//! never negative.

use super::wide::{Wide, right};
use crate::fixed::product;

/// The seeds: y in units of 2^-7 for each m that starts with the seven bits of the index. An m below 1/4 has none.
static SEEDS: [u8; 128] = seeds();

const fn seeds() -> [u8; 128] {
    let mut seeds = [0; 128];
    let mut index = 32;
    while index < seeds.len() {
        // 2^7/√((index + 1/2)/2^7), doubled to round it.
        let doubled = ((1 << 24) / (2 * index as u32 + 1)).isqrt();
        seeds[index] = if doubled > 510 { 255 } else { doubled.div_ceil(2) as u8 };
        index += 1;
    }
    seeds
}

/// A number's root and logarithm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Root {
    /// √(2^32 x); at most 2^-54 of it too small.
    pub(super) root: u64,
    /// log2 x in units of 2^-16; at most [`LOG2_SHORT_MAX`] too small.
    pub(super) log2: i32,
}

/// How far a logarithm may fall short, in its units: 0.087.
pub(super) const LOG2_SHORT_MAX: i32 = 5_702;

impl Root {
    /// Of `x`, which is above 0.
    #[inline(always)]
    pub(super) fn of(x: Wide) -> Self {
        let (zeros, mantissa) = x.normalised();
        let root = root(mantissa);
        let halved = zeros / 2;
        let root = if halved < 32 { right(root, halved) } else { right(root >> 32, halved - 32) };
        Self { root, log2: mitchell(zeros, mantissa) }
    }
}

/// By the bits of the number itself: log2(1 + f) is f at least and f + 0.087 at most (Mitchell 1962).
#[inline(always)]
fn mitchell(zeros: u32, mantissa: u64) -> i32 {
    let leading = (mantissa >> 32) as u32;
    let odd = (leading >> 31) ^ 1;
    // The first bit, which is 1, adds the one that 94 lacks.
    ((94 - zeros as i32 - odd as i32) << 16) + (leading << odd >> 15) as i32
}

/// 2^32 √m of an m that starts in its first two bits.
#[inline(always)]
fn root(m: u64) -> u64 {
    let high = (m >> 32) as u32;
    let y = inverse_root(high);
    let s = (product(high, y) >> 32) as u32;
    // In units of 2^-64; below 2^38.
    let rest = m.wrapping_sub(product(s, s) << 2);
    (u64::from(s) << 33).wrapping_add(product((rest >> 6) as u32, y) >> 26)
}

/// 2^31/√(m/2^32) of an m from 2^30 up, at most 2^-27 too small and never too large.
#[inline(always)]
fn inverse_root(m: u32) -> u32 {
    let seed = u32::from(SEEDS[(m >> 25) as usize]);
    // What m y² lacks to 1, in units of 2^-32; what is near a whole number needs no digits before its point.
    let lack = (m >> 14).wrapping_mul(seed * seed).wrapping_neg() as i32;
    let lack_squared = (lack >> 16) * (lack >> 16);
    let gain = (lack >> 4).wrapping_add(lack_squared.wrapping_mul(3) >> 6);
    let y = (seed << 8).wrapping_add_signed((seed as i32).wrapping_mul(gain) >> 21);
    let lack = ((product(m, y.wrapping_mul(y)) >> 30) as u32).wrapping_neg() as i32;
    // One less, since what m y² lacks was rounded up.
    (y << 16).wrapping_add_signed((y as i32).wrapping_mul(lack >> 3) >> 14).wrapping_sub(1)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{Root, inverse_root};
    use crate::compile::wide::Wide;

    /// √(2^32 x) rounded down.
    fn exact(x: u128) -> u64 {
        (x << 32).isqrt() as u64
    }

    fn check(x: u128) {
        let got = Root::of(Wide::new(x));
        let short = i128::from(exact(x)) - i128::from(got.root);
        let bound = i128::from(exact(x) >> 54) + 1;
        assert!((0..=bound).contains(&short), "{x:#x}: {:#x} for {:#x}", got.root, exact(x));
        let log2 = (x as f64).log2() - f64::from(got.log2) / 65_536.0;
        assert!((-1e-12..=0.0871).contains(&log2), "{x:#x}: log2 short by {log2}");
    }

    #[test]
    fn roots_of_squares_powers_and_their_neighbours() {
        for bit in 1..96 {
            for x in [(1 << bit) - 1, 1 << bit, (1 << bit) + 1] {
                check(x);
            }
        }
        check(1);
        check((1 << 96) - 1);
        (1..10_000).for_each(|x| check(x * x));
    }

    /// Each seed's whole range, at a stride that hits every seed some 13,000 times.
    #[test]
    fn inverse_roots_are_never_too_large() {
        for m in (1 << 30..=u32::MAX).step_by(2_503).chain([1 << 30, u32::MAX]) {
            let exact = 2_147_483_648.0 / (f64::from(m) / 4_294_967_296.0).sqrt();
            let short = exact - f64::from(inverse_root(m));
            assert!((0.0..=32.0).contains(&short), "{m:#x}: short by {short}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 100_000, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn roots_are_those_of_whole_numbers(bits: u128, zeros in 32..128u32) {
            check((bits >> zeros).max(1));
        }
    }
}
