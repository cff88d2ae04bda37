//! Products and polynomials of fixed-point numbers. On a Cortex-M0+ they cost a third of what software floats cost.

/// The value 1 in units of 2^-64.
pub(crate) const TWO_TO_64: f64 = 18_446_744_073_709_551_616.0;

/// True if a float is 0. This is shorter than the call that compares two floats.
#[inline(always)]
pub(crate) fn is_zero(x: f64) -> bool {
    x.to_bits() << 1 == 0
}

/// True if a float has the sign of negative numbers.
#[inline(always)]
pub(crate) fn is_negative(x: f64) -> bool {
    (x.to_bits() as i64) < 0
}

/// The product of two 32-bit numbers, from their 16-bit halves. A Cortex-M0+ multiplies 32 by 32 bits to 32 bits, and
/// the compiler would call a routine that multiplies 64 by 64 bits.
#[inline(always)]
pub(crate) fn product(a: u32, b: u32) -> u64 {
    let (a_low, a_high, b_low, b_high) = (a & 0xffff, a >> 16, b & 0xffff, b >> 16);
    let outer = u64::from(a_high * b_high) << 32 | u64::from(a_low * b_low);
    let inner = (u64::from(a_high * b_low) << 16).wrapping_add(u64::from(a_low * b_high) << 16);
    outer.wrapping_add(inner)
}

/// `value` times `times`, modulo 2^64. The compiler's own routine takes three times as long.
#[inline]
pub(crate) fn times(value: u64, times: u32) -> u64 {
    let upper = ((value >> 32) as u32).wrapping_mul(times);
    product(value as u32, times).wrapping_add(u64::from(upper) << 32)
}

/// `value` times `y`, rounded down. `y` is in units of 2^-64.
#[inline(always)]
fn fraction_of(value: i64, y: u64) -> i64 {
    // As an unsigned number, a negative value is too large by 2^64.
    (upper(value as u64, y) as i64).wrapping_sub(if value < 0 { y as i64 } else { 0 })
}

/// The upper 64 bits of a product.
#[inline(always)]
fn upper(a: u64, b: u64) -> u64 {
    let (a_low, a_high, b_low, b_high) = (a as u32, (a >> 32) as u32, b as u32, (b >> 32) as u32);
    let middle = product(a_low, b_high).wrapping_add(product(a_low, b_low) >> 32);
    let other = product(a_high, b_low).wrapping_add(u64::from(middle as u32));
    product(a_high, b_high).wrapping_add(middle >> 32).wrapping_add(other >> 32)
}

/// Σ c_i y^i with i from 0, in the units of the coefficients. `y` is in units of 2^-64. No partial sum may overflow.
pub(crate) fn polynomial(coefficients: &[i64], y: u64) -> i64 {
    coefficients.iter().rev().fold(0, |sum, &coefficient| fraction_of(sum, y).wrapping_add(coefficient))
}

#[cfg(test)]
mod tests {
    use isostep_trials::cases;
    use proptest::prelude::*;

    use super::{fraction_of, polynomial, product, times};

    proptest! {
        #![proptest_config(ProptestConfig { cases: cases(1_000, 10_000), failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn products_are_exact(a: u32, b: u32) {
            prop_assert_eq!(product(a, b), u64::from(a) * u64::from(b));
        }

        #[test]
        fn times_are_exact_modulo_2_to_64(value: u64, count: u32) {
            prop_assert_eq!(times(value, count), value.wrapping_mul(u64::from(count)));
        }

        #[test]
        fn ratios_are_rounded_down(value: i64, y: u64) {
            prop_assert_eq!(fraction_of(value, y), ((i128::from(value) * i128::from(y)) >> 64) as i64);
        }
    }

    #[test]
    fn a_polynomial_by_hand() {
        // 3 - 2/2 + 8/4
        assert_eq!(polynomial(&[3, -2, 8], 1 << 63), 4);
    }
}
