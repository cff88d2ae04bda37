//! Square root and binary logarithm of a 96-bit number.

use super::u96::{U96, right};
use crate::square_root::root_of_mantissa;

/// A number's root and logarithm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Root {
    /// √(2^32 x), at most 2^-54 of it too small.
    pub(super) root: u64,
    /// log2 x in units of 2^-16, at most [`LOG2_SHORT_MAX`] too small.
    pub(super) log2: i32,
}

/// The distance by which a logarithm may fall short, in its units: 0.087.
pub(super) const LOG2_SHORT_MAX: i32 = 5_702;

impl Root {
    /// The root and the logarithm of `x`, which is above 0.
    #[inline(always)]
    pub(super) fn of(x: U96) -> Self {
        let (zeros, mantissa) = x.normalised();
        let root = root_of_mantissa(mantissa);
        let halved = zeros / 2;
        let root = if halved < 32 { right(root, halved) } else { right(root >> 32, halved - 32) };
        Self { root, log2: mitchell(zeros, mantissa) }
    }
}

/// log2 from the bits of the number itself: log2(1 + f) is at least f and at most f + 0.087 (Mitchell 1962).
#[inline(always)]
fn mitchell(zeros: u32, mantissa: u64) -> i32 {
    let leading = (mantissa >> 32) as u32;
    let odd = (leading >> 31) ^ 1;
    // 94 is one too small; the first bit, which is 1, adds the missing one.
    ((94 - zeros as i32 - odd as i32) << 16) + (leading << odd >> 15) as i32
}

#[cfg(test)]
mod tests {
    use isostep_trials::cases;
    use proptest::prelude::*;

    use super::Root;
    use crate::compile::u96::U96;

    /// √(2^32 x) rounded down.
    fn exact(x: u128) -> u64 {
        (x << 32).isqrt() as u64
    }

    fn check(x: u128) {
        let got = Root::of(U96::new(x));
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

    proptest! {
        #![proptest_config(ProptestConfig { cases: cases(10_000, 100_000), failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn roots_are_those_of_whole_numbers(bits: u128, zeros in 32..128u32) {
            check((bits >> zeros).max(1));
        }
    }
}
