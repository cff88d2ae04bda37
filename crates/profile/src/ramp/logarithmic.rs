//! The logarithmic law's own numbers.
//!
//! Paper 000 takes the logarithm of the step's number i, 1 to p_N: on a ramp of p_N steps, ln i is ln(1 + K u) with
//! K = p_N - 1. So that a ramp of any length is of one shape, K is that of the paper's Table 1.

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

/// With q = slow/rise ln(1 + K) and s = ln(1 + K u), (slow + rise v) rise v' is rise² (q + s) exp(-s) K/ln²(1 + K).
pub(super) fn length(slow: f64, rise: f64) -> (f64, f64) {
    let q = slow / rise * LN_END;
    let (peak, slope) = if q < 1.0 {
        let peak = exp(q - 1.0);
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
/// With s = ln(1 + K u) and q = slow ln(1 + K) it is ln(1 + K)/K times ∫ exp(σ)/(q + σ) dσ from 0 to s: by the series of
/// the exponential integral where q is small, by quadrature where the pole at -q is far.
pub(super) fn time(slow: f64, u: f64) -> f64 {
    let (q, s) = (slow * LN_END, log1p(K * u));
    LN_END / K * if q < SERIES_END { by_series(q, s) } else { by_quadrature(q, s) }
}

/// The same to the end, where s = ln(1 + K).
pub(super) fn whole_time(slow: f64) -> f64 {
    let q = slow * LN_END;
    let integral = if q < SERIES_END {
        by_series(q, LN_END)
    } else {
        let part = |(sigma, weight): &(f64, f64)| weight / (q + sigma);
        WHOLE_NODES.iter().map(part).sum()
    };
    LN_END / K * integral
}

/// `slow` times the slope of that, which is `time` there, over `slow`.
///
/// The slope of the integral is -∫ exp(σ)/(q + σ)² dσ from 0 to ln(1 + K): by parts, with the integral itself.
pub(super) fn whole_time_growth(slow: f64, time: f64) -> f64 {
    let ends = 1.0 - (1.0 + K) * slow / (slow + 1.0);
    -(LN_END / K * ends + slow * LN_END * time)
}

/// Above it, quadrature.
const SERIES_END: f64 = 4.0;
/// Of the series: the next is less than 2^-56 of the sum at q + s = 7.2.
const TERMS: usize = 37;

/// exp(-q) (ln(1 + s/q) + S(q + s) - S(q)) with S(w) = Σ w^k/(k k!).
fn by_series(q: f64, s: f64) -> f64 {
    exp(-q) * (log1p(s / q) + series(q + s) - series(q))
}

/// S(w), for w below 8.
fn series(w: f64) -> f64 {
    polynomial(&COEFFICIENTS, (w * (TWO_TO_64 / W_END)) as u64) as f64 / UNITS
}

/// Of the coefficients in 1: S(8) is 436.
const UNITS: f64 = 18_014_398_509_481_984.0;
const W_END: f64 = 8.0;

/// 8^k/(k k!): of the powers of w/8, the first of which has none.
static COEFFICIENTS: [i64; TERMS] = coefficients();

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

/// Gauss and Legendre's nodes, as they stand right of the middle, and their weights.
const NODES: [(f64, f64); 5] = [
    (0.148_874_338_981_631_22, 0.295_524_224_714_752_87),
    (0.433_395_394_129_247_2, 0.269_266_719_309_996_35),
    (0.679_409_568_299_024_4, 0.219_086_362_515_982_04),
    (0.865_063_366_688_984_5, 0.149_451_349_150_580_6),
    (0.973_906_528_517_171_7, 0.066_671_344_308_688_14),
];

/// Of s = ln(1 + K): the nodes σ themselves, and their weights, times s/2, times exp(σ).
const WHOLE_NODES: [(f64, f64); 10] = [
    (0.041_463_228_496_538_68, 0.110_427_621_179_327_21),
    (0.214_417_942_174_164_5, 0.294_273_816_972_510_54),
    (0.509_426_824_720_093_5, 0.579_412_495_881_137_3),
    (0.900_349_968_990_167_1, 1.052_763_830_870_025_6),
    (1.352_461_583_553_427, 1.815_895_878_003_357),
    (1.825_592_246_794_518_7, 2.914_533_013_811_871_7),
    (2.277_703_861_357_778_7, 4.173_574_313_506_265),
    (2.668_627_005_627_852_3, 5.020_148_695_897_063),
    (2.963_635_888_173_781, 4.599_618_435_109_015),
    (3.136_590_601_851_407, 2.439_351_898_769_427_6),
];

fn by_quadrature(q: f64, s: f64) -> f64 {
    let half = s / 2.0;
    let at = |sigma: f64| exp(sigma) / (q + sigma);
    half * NODES.iter().map(|(x, weight)| weight * (at(half * (1.0 - x)) + at(half * (1.0 + x)))).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::{time, whole_time};

    #[test]
    fn the_whole_is_the_time_to_the_end() {
        for i in -40..40 {
            let slow = f64::from(i).mul_add(0.25, 0.1).exp2();
            let (whole, to_end) = (whole_time(slow), time(slow, 1.0));
            assert!((whole - to_end).abs() <= 1e-14 * to_end, "{slow}: {whole} and {to_end}");
        }
    }
}
