//! Sine and cosine of a quarter turn.
//!
//! libm's functions take any angle, which would cost a tenth of all the flash that the firmware has.

use core::f64::consts::PI;

use crate::fixed::{TWO_TO_64, polynomial};

/// Sine and cosine of π/2 `t`, for `t` from 0 to 1.
#[cold]
pub(super) fn sin_cos(t: f64) -> (f64, f64) {
    if t > 0.5 {
        let (sine, cosine) = eighth(1.0 - t);
        return (cosine, sine);
    }
    eighth(t)
}

/// Sine and cosine by their series up to x^19. x = π/2 `t` is at most π/4, so the terms left out are less than 2^-63.
fn eighth(t: f64) -> (f64, f64) {
    let x = PI / 2.0 * t;
    let square = (x * x * TWO_TO_64) as u64;
    let series = |coefficients| polynomial(coefficients, square) as f64 / UNITS;
    (x * series(&SINE), series(&COSINE))
}

/// The number of units of the coefficients that make 1.
const UNITS: f64 = 4_611_686_018_427_387_904.0;
/// 1, -1/3!, 1/5! and so on: the coefficients of the powers of x².
const SINE: [i64; 10] = inverse_factorials(1);
/// 1, -1/2!, 1/4! and so on.
const COSINE: [i64; 10] = inverse_factorials(0);

const fn inverse_factorials(first: usize) -> [i64; 10] {
    let mut inverses = [0; 10];
    let (mut units, mut n, mut index) = (UNITS, 0, 0);
    while index < inverses.len() {
        while n < first + 2 * index {
            n += 1;
            units /= n as f64;
        }
        inverses[index] = units as i64;
        units = -units;
        index += 1;
    }
    inverses
}

#[cfg(test)]
mod tests {
    use super::sin_cos;

    #[test]
    fn they_are_libms() {
        for i in 0..=100_000 {
            let t = f64::from(i) / 1e5;
            let (sine, cosine) = sin_cos(t);
            let angle = core::f64::consts::FRAC_PI_2 * t;
            assert!((sine - libm::sin(angle)).abs() <= 2.3e-16 && (cosine - libm::cos(angle)).abs() <= 2.3e-16, "{t}");
        }
    }

    #[test]
    fn a_small_sine_keeps_its_digits() {
        for t in [1e-12, 1e-6, 1e-3] {
            let exact = libm::sin(core::f64::consts::FRAC_PI_2 * t);
            assert!((sin_cos(t).0 - exact).abs() <= 2.3e-16 * exact);
        }
    }
}
