//! The formulae of the logarithmic speed profile.
//!
//! Fonseca-Campos 2023 takes the logarithm of the step's number i, which is 1 to p_N. On a ramp of p_N steps, ln i is
//! ln(1 + K u) with K = p_N - 1. Here K is always that of the paper's Table 1, so that ramps of any length have the
//! same shape.

use core::f64::consts::E;

use libm::{exp, log1p};

use crate::fixed::{TWO_TO_64, polynomial};

/// p_N - 1, with p_N = 24: a fifth of the 120 steps of Table 1.
pub(super) const K: f64 = 23.0;
/// ln(1 + K).
pub(super) const LN_END: f64 = 3.178_053_830_347_945_8;

/// K/((1 + K u) ln(1 + K)).
pub(super) fn slope(u: f64) -> f64 {
    K / ((1.0 + K * u) * LN_END)
}

/// q = `slow` ln(1 + K) and exp(-q), from which the length and the time of a whole ramp follow.
#[derive(Clone, Copy)]
pub(super) struct Pole {
    q: f64,
    residue: f64,
}

impl Pole {
    pub(super) fn new(slow: f64) -> Self {
        let q = slow * LN_END;
        Self { q, residue: exp(-q) }
    }
}

/// The length of a ramp, as `OverDisplacement::length` defines it, and its derivative.
///
/// With q of slow/rise and s = ln(1 + K u), (slow + rise v) rise v' is rise² (q + s) exp(-s) K/ln²(1 + K).
pub(super) fn length(Pole { q, residue }: Pole, slow: f64, rise: f64) -> (f64, f64) {
    let (peak, slope) = if q < 1.0 {
        let peak = 1.0 / (E * residue);
        (peak, peak)
    } else {
        (q, 1.0)
    };
    let scale = K / LN_END;
    let peak = rise * peak * (scale / LN_END);
    (rise * peak, 2.0 * peak - slow * slope * scale)
}

/// ∫ du/(slow + ln(1 + K u)/ln(1 + K)) from 0 to `u`.
///
/// With s = ln(1 + K u) and q = slow ln(1 + K) it is ln(1 + K)/K times ∫ exp(σ)/(q + σ) dσ from 0 to s. It is computed
/// by the series of the exponential integral if q is small, and by quadrature if the pole at -q is far.
pub(super) fn time(slow: f64, u: f64) -> f64 {
    let (q, s) = (slow * LN_END, log1p(K * u));
    LN_END / K * if q < SERIES_END { by_series(q, s) } else { by_quadrature(q, s) }
}

/// The time to the end of the ramp, where s = ln(1 + K).
///
/// The term of the pole, exp(-q)/(q + σ), has a logarithm as integral. Without it the function is smooth, however near
/// the pole is.
#[cold]
pub(super) fn whole_time(Pole { q, residue }: Pole) -> f64 {
    let smooth = |(sigma, weight, exp): &(f64, f64, f64)| weight * (exp - residue) / (q + sigma);
    LN_END / K * (residue * log1p(LN_END / q) + WHOLE_NODES.iter().map(smooth).sum::<f64>())
}

/// `slow` times the derivative of the whole time by `slow`. `time` is the whole time at `slow`.
///
/// The derivative of the integral is -∫ exp(σ)/(q + σ)² dσ from 0 to ln(1 + K). Integration by parts gives it from the
/// integral itself.
pub(super) fn whole_time_growth(slow: f64, time: f64) -> f64 {
    let ends = 1.0 - (1.0 + K) * slow / (slow + 1.0);
    -(LN_END / K * ends + slow * LN_END * time)
}

/// The series is used for a q below this, quadrature above.
const SERIES_END: f64 = 4.0;
/// Number of terms of the series. The next one is less than 2^-56 of the sum at q + s = 7.2.
const TERMS: usize = 37;

/// exp(-q) (ln(1 + s/q) + S(q + s) - S(q)) with S(w) = Σ w^k/(k k!).
fn by_series(q: f64, s: f64) -> f64 {
    exp(-q) * (log1p(s / q) + series(q + s) - series(q))
}

/// S(w), for w below 8.
fn series(w: f64) -> f64 {
    polynomial(&COEFFICIENTS, (w * (TWO_TO_64 / W_END)) as u64) as f64 / UNITS
}

/// The number of units of the coefficients that make 1. S(8) is 436, so the sum fits.
const UNITS: f64 = 18_014_398_509_481_984.0;
const W_END: f64 = 8.0;

/// 8^k/(k k!), the coefficients of (w/8)^k. There is none for k = 0.
const COEFFICIENTS: [i64; TERMS] = coefficients();

const fn coefficients() -> [i64; TERMS] {
    let mut coefficients = [0; TERMS];
    let (mut k, mut power) = (1, UNITS);
    while k < TERMS {
        power *= W_END / k as f64;
        coefficients[k] = (power / k as f64) as i64;
        k += 1;
    }
    coefficients
}

/// Gauss-Legendre nodes, those to the right of the middle, and their weights.
const NODES: [(f64, f64); 5] = [
    (0.148_874_338_981_631_22, 0.295_524_224_714_752_87),
    (0.433_395_394_129_247_2, 0.269_266_719_309_996_35),
    (0.679_409_568_299_024_4, 0.219_086_362_515_982_04),
    (0.865_063_366_688_984_5, 0.149_451_349_150_580_6),
    (0.973_906_528_517_171_7, 0.066_671_344_308_688_14),
];

/// Gauss-Legendre quadrature from 0 to ln(1 + K): the nodes σ, their weights, and exp(σ).
const WHOLE_NODES: [(f64, f64, f64); 8] = [
    (0.063_100_486_830_835_79, 0.160_854_868_749_073_15, 1.065_133_865_780_424_1),
    (0.323_102_440_146_882_05, 0.353_369_449_170_642_6, 1.381_406_855_178_795_2),
    (0.753_941_771_020_684_8, 0.498_488_303_768_913_1, 2.125_361_214_065_810_2),
    (1.297_544_331_073_069_9, 0.576_314_293_485_343_9, 3.660_297_144_256_315_7),
    (1.880_509_499_274_875_7, 0.576_314_293_485_343_9, 6.556_844_718_921_371),
    (2.424_112_059_327_261, 0.498_488_303_768_913_1, 11.292_198_164_324_295),
    (2.854_951_390_201_063_7, 0.353_369_449_170_642_6, 17.373_592_660_283_766),
    (3.114_953_343_517_109_7, 0.160_854_868_749_073_15, 22.532_379_047_412_21),
];

fn by_quadrature(q: f64, s: f64) -> f64 {
    let half = s / 2.0;
    let at = |sigma: f64| exp(sigma) / (q + sigma);
    half * NODES.iter().map(|(x, weight)| weight * (at(half * (1.0 - x)) + at(half * (1.0 + x)))).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::{Pole, time, whole_time};

    #[test]
    fn the_whole_is_the_time_to_the_end() {
        for i in -40..40 {
            let slow = f64::from(i).mul_add(0.25, 0.1).exp2();
            let (whole, to_end) = (whole_time(Pole::new(slow)), time(slow, 1.0));
            assert!((whole - to_end).abs() <= 1e-14 * to_end, "{slow}: {whole} and {to_end}");
        }
    }
}
