//! Unsigned numbers of 96 bits, the width that the instants of a move need, and linear functions in them.

use crate::fixed::product;

/// A 96-bit number, by its 32-bit digits. Sums and products are modulo 2^96.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct U96 {
    pub(super) top: u32,
    pub(super) middle: u32,
    pub(super) bottom: u32,
}

impl U96 {
    pub(super) fn new(value: u128) -> Self {
        Self { top: (value >> 64) as u32, middle: (value >> 32) as u32, bottom: value as u32 }
    }

    /// All but the last 32 bits.
    #[inline(always)]
    pub(super) fn upper(self) -> u64 {
        u64::from(self.top) << 32 | u64::from(self.middle)
    }

    #[inline(always)]
    fn lower(self) -> u64 {
        u64::from(self.middle) << 32 | u64::from(self.bottom)
    }

    /// The number of its first bits that are 0, less one if that number is odd (94 at most), and its first 64 bits without
    /// these.
    #[inline(always)]
    pub(super) fn normalised(self) -> (u32, u64) {
        let (skipped, [first, second, third]) = match self {
            Self { top: 0, middle: 0, bottom } => (64, [bottom, 0, 0]),
            Self { top: 0, middle, bottom } => (32, [middle, bottom, 0]),
            Self { top, middle, bottom } => (0, [top, middle, bottom]),
        };
        let zeros = even_zeros(first);
        let upper = joined(first, second, zeros);
        (skipped + zeros, u64::from(upper) << 32 | u64::from(joined(second, third, zeros)))
    }
}

/// The number of its first bits that are 0, less one if that number is odd; 30 at most. This is shorter than a call of the
/// compiler's routine.
#[inline(always)]
fn even_zeros(mut digit: u32) -> u32 {
    let mut zeros = 0;
    for bits in [16, 8, 4, 2] {
        if digit >> (32 - bits) == 0 {
            digit <<= bits;
            zeros += bits;
        }
    }
    zeros
}

/// The first 32 bits of two digits after the first `bits` bits are dropped; `bits` is 31 at most.
#[inline(always)]
pub(super) fn joined(first: u32, second: u32, bits: u32) -> u32 {
    first.wrapping_shl(bits) | (second >> 1).wrapping_shr(31 ^ bits)
}

// Shifts of 64 bits by 31 bits at most. The compiler would call a routine that shifts by any number.

#[inline(always)]
pub(super) fn left(value: u64, bits: u32) -> u64 {
    let lower = value as u32;
    u64::from(joined((value >> 32) as u32, lower, bits)) << 32 | u64::from(lower.wrapping_shl(bits))
}

#[inline(always)]
pub(super) fn right(value: u64, bits: u32) -> u64 {
    let upper = (value >> 32) as u32;
    u64::from(upper.wrapping_shr(bits)) << 32 | u64::from(lower_of_right(upper, value as u32, bits))
}

#[inline(always)]
pub(super) fn right_signed(value: i64, bits: u32) -> i64 {
    let upper = (value >> 32) as u32;
    i64::from((upper as i32).wrapping_shr(bits)) << 32 | i64::from(lower_of_right(upper, value as u32, bits))
}

#[inline(always)]
fn lower_of_right(upper: u32, lower: u32, bits: u32) -> u32 {
    (upper << 1).wrapping_shl(31 ^ bits) | lower.wrapping_shr(bits)
}

/// start + slope x, for whole x.
#[derive(Clone, Copy, Debug)]
pub(super) struct Linear {
    pub(super) start: U96,
    pub(super) slope: U96,
}

impl Linear {
    #[inline(always)]
    pub(super) fn at(&self, x: u32) -> U96 {
        let Self { start, slope } = self;
        let bottom = product(slope.bottom, x);
        let middle = product(slope.middle, x);
        let (sum, carry) = start.lower().overflowing_add(bottom);
        let (sum, carry_too) = sum.overflowing_add(middle << 32);
        let top = start.top.wrapping_add(slope.top.wrapping_mul(x)).wrapping_add((middle >> 32) as u32);
        U96 {
            top: top.wrapping_add(u32::from(carry)).wrapping_add(u32::from(carry_too)),
            middle: (sum >> 32) as u32,
            bottom: sum as u32,
        }
    }
}

/// `value` in units of 2^-`point`, rounded down. `value` is 0 or above, and below 2^128 of these units.
pub(super) fn fixed(value: f64, point: i32) -> u128 {
    let mantissa = value.to_bits() << 12 >> 12 | 1 << 52;
    let shift = exponent(value) - 52 + point;
    if shift >= 0 {
        u128::from(mantissa) << shift
    } else {
        u128::from(mantissa.checked_shr(-shift as u32).unwrap_or(0))
    }
}

/// The same for a `value` below 2^64 units and a `point` of 0 or more.
pub(super) fn short_fixed(value: f64, point: u8) -> u64 {
    let mantissa = value.to_bits() << 12 >> 12 | 1 << 52;
    let shift = exponent(value) - 52 + i32::from(point);
    if shift >= 0 { mantissa << shift } else { mantissa.checked_shr(shift.unsigned_abs()).unwrap_or(0) }
}

/// The largest whole e with 2^e <= `x` for a normal number; -1023 for 0.
pub(super) fn exponent(x: f64) -> i32 {
    (x.to_bits() >> 52 & 0x7ff) as i32 - 1_023
}

#[cfg(test)]
mod tests {
    use isostep_trials::cases;
    use proptest::prelude::*;

    use super::{Linear, U96, fixed, left, right, right_signed, short_fixed};

    fn value(wide: U96) -> u128 {
        u128::from(wide.upper()) << 32 | u128::from(wide.bottom)
    }

    /// Numbers of every length.
    fn any_length() -> impl Strategy<Value = u128> {
        (any::<u128>(), 32..128u32).prop_map(|(bits, zeros)| bits >> zeros)
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: cases(1_000, 10_000), failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn lines_are_exact(start in any_length(), slope in any_length(), x: u32) {
            let line = Linear { start: U96::new(start), slope: U96::new(slope) };
            let exact = start.wrapping_add(slope.wrapping_mul(u128::from(x))) & ((1 << 96) - 1);
            prop_assert_eq!(value(line.at(x)), exact);
        }

        #[test]
        fn normalised_numbers_start_in_their_first_two_bits(bits in any_length()) {
            let (zeros, mantissa) = U96::new(bits).normalised();
            prop_assert_eq!(zeros, ((bits << 32).leading_zeros() & !1).min(94));
            prop_assert_eq!(mantissa, (bits << zeros >> 32) as u64);
        }

        #[test]
        fn fixed_numbers_are_exact(
            value in prop_oneof![Just(0.0), 1e-9..1e-6, 0.0..1.0, 1.0..1e15], point in -32..=64,
        ) {
            prop_assert_eq!(fixed(value, point), (value * 2f64.powi(point)) as u128);
            if let Ok(point) = u8::try_from(point) && value * 2f64.powi(point.into()) < 2f64.powi(64) {
                prop_assert_eq!(u128::from(short_fixed(value, point)), fixed(value, point.into()));
            }
        }

        #[test]
        fn shifts_are_exact(value: u64, bits in 0..32u32) {
            prop_assert_eq!(left(value, bits), value << bits);
            prop_assert_eq!(right(value, bits), value >> bits);
            prop_assert_eq!(right_signed(value as i64, bits), value as i64 >> bits);
        }
    }
}
