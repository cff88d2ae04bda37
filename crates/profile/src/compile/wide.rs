//! Unsigned numbers of 96 bits, as wide as the instants of a move need, and lines over them.

/// The product of two 32-bit numbers. By halves, since a Cortex-M0+ multiplies 32 bits to 32 and the compiler would call
/// a routine that multiplies 64 by 64.
#[inline(always)]
pub(super) fn product(a: u32, b: u32) -> u64 {
    let (a_low, a_high, b_low, b_high) = (a & 0xffff, a >> 16, b & 0xffff, b >> 16);
    let outer = u64::from(a_high * b_high) << 32 | u64::from(a_low * b_low);
    let inner = (u64::from(a_high * b_low) << 16).wrapping_add(u64::from(a_low * b_high) << 16);
    outer.wrapping_add(inner)
}

/// A 96-bit number, by its 32-bit digits. Sums and products are modulo 2^96.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Wide {
    pub(super) top: u32,
    pub(super) middle: u32,
    pub(super) bottom: u32,
}

impl Wide {
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

    /// How many of its first bits are 0.
    #[inline(always)]
    pub(super) fn leading_zeros(self) -> u32 {
        match self {
            Self { top: 0, middle: 0, bottom } => 64 + bottom.leading_zeros(),
            Self { top: 0, middle, .. } => 32 + middle.leading_zeros(),
            Self { top, .. } => top.leading_zeros(),
        }
    }

    /// Its first 64 bits after leaving out `zeros` of them; 95 at most.
    #[inline(always)]
    pub(super) fn mantissa(self, zeros: u32) -> u64 {
        let Self { top, middle, bottom } = self;
        let (first, second, third) = match zeros >> 5 {
            0 => (top, middle, bottom),
            1 => (middle, bottom, 0),
            _ => (bottom, 0, 0),
        };
        u64::from(joined(first, second, zeros & 31)) << 32 | u64::from(joined(second, third, zeros & 31))
    }
}

/// The first 32 bits of two digits after leaving out `bits` of them; 31 at most.
#[inline(always)]
fn joined(first: u32, second: u32, bits: u32) -> u32 {
    first.wrapping_shl(bits) | (second >> 1).wrapping_shr(31 ^ bits)
}

/// start + slope x, for whole x.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) start: Wide,
    pub(super) slope: Wide,
}

impl Line {
    #[inline(always)]
    pub(super) fn at(&self, x: u32) -> Wide {
        let Self { start, slope } = self;
        let bottom = product(slope.bottom, x);
        let middle = product(slope.middle, x);
        let (sum, carry) = start.lower().overflowing_add(bottom);
        let (sum, carry_too) = sum.overflowing_add(middle << 32);
        let top = start.top.wrapping_add(slope.top.wrapping_mul(x)).wrapping_add((middle >> 32) as u32);
        Wide {
            top: top.wrapping_add(u32::from(carry)).wrapping_add(u32::from(carry_too)),
            middle: (sum >> 32) as u32,
            bottom: sum as u32,
        }
    }
}

/// `value` in units of 2^-`point`, rounded down; 0 to 2^128.
pub(super) fn fixed(value: f64, point: i32) -> u128 {
    (value * power_of_two(point)) as u128
}

/// Of a number from 2^-1022 up, the largest whole e with 2^e <= x. Of 0, -1023.
pub(super) fn exponent(x: f64) -> i32 {
    (x.to_bits() >> 52 & 0x7ff) as i32 - 1_023
}

pub(super) fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((1_023 + exponent) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{Line, Wide, product};

    fn value(wide: Wide) -> u128 {
        u128::from(wide.upper()) << 32 | u128::from(wide.bottom)
    }

    /// Numbers of every length.
    fn any_length() -> impl Strategy<Value = u128> {
        (any::<u128>(), 32..128u32).prop_map(|(bits, zeros)| bits >> zeros)
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 10_000, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn products_are_exact(a: u32, b: u32) {
            prop_assert_eq!(product(a, b), u64::from(a) * u64::from(b));
        }

        #[test]
        fn lines_are_exact(start in any_length(), slope in any_length(), x: u32) {
            let line = Line { start: Wide::new(start), slope: Wide::new(slope) };
            let exact = start.wrapping_add(slope.wrapping_mul(u128::from(x))) & ((1 << 96) - 1);
            prop_assert_eq!(value(line.at(x)), exact);
        }

        #[test]
        fn a_mantissa_is_the_first_64_bits(bits in any_length(), share in 0..=96u32) {
            let wide = Wide::new(bits);
            let zeros = (bits << 32).leading_zeros().min(96);
            prop_assert_eq!(wide.leading_zeros(), zeros);
            let left_out = zeros.min(share).min(95);
            prop_assert_eq!(wide.mantissa(left_out), (bits << left_out >> 32) as u64);
        }
    }
}
