//! The logarithmic law's own numbers.
//!
//! Paper 000 takes the logarithm of the step's number i, 1 to p_N: on a ramp of p_N steps, ln i is ln(1 + K u) with
//! K = p_N - 1. So that a ramp of any length is of one shape, K is that of the paper's Table 1.

use libm::{exp, log1p};

/// p_N - 1, with p_N = 24: a fifth of the 120 steps of Table 1.
pub(super) const K: f64 = 23.0;
/// ln(1 + K).
pub(super) const LN_END: f64 = 3.178_053_830_347_945_8;

/// K/((1 + K u) ln(1 + K)).
pub(super) fn slope(u: f64) -> f64 {
    K / ((1.0 + K * u) * LN_END)
}

/// ∫ du/(slow + ln(1 + K u)/ln(1 + K)) from 0 to `u`.
///
/// With s = ln(1 + K u) and q = slow ln(1 + K) it is ln(1 + K)/K times ∫ exp(σ)/(q + σ) dσ from 0 to s: by the series of
/// the exponential integral where q is small, by quadrature where the pole at -q is far.
pub(super) fn time(slow: f64, u: f64) -> f64 {
    let (q, s) = (slow * LN_END, log1p(K * u));
    LN_END / K * if q < SERIES_END { by_series(q, s) } else { by_quadrature(q, s) }
}

/// Above it, quadrature.
const SERIES_END: f64 = 4.0;
/// Of the series: the next is less than 2^-56 of the sum at q + s = 7.2.
const TERMS: usize = 36;

/// exp(-q) (ln(1 + s/q) + S(q + s) - S(q)) with S(w) = Σ w^k/(k k!).
fn by_series(q: f64, s: f64) -> f64 {
    exp(-q) * (log1p(s / q) + series(q + s) - series(q))
}

fn series(w: f64) -> f64 {
    w * COEFFICIENTS.iter().rev().fold(0.0, |sum, coefficient| sum * w + coefficient)
}

/// 1/(k k!), from k = 1 on.
static COEFFICIENTS: [f64; TERMS] = coefficients();

const fn coefficients() -> [f64; TERMS] {
    let mut coefficients = [0.0; TERMS];
    let (mut k, mut factorial) = (1, 1.0);
    while k <= TERMS {
        factorial *= k as f64;
        coefficients[k - 1] = 1.0 / (k as f64 * factorial);
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

fn by_quadrature(q: f64, s: f64) -> f64 {
    let half = s / 2.0;
    let at = |sigma: f64| exp(sigma) / (q + sigma);
    half * NODES.iter().map(|(x, weight)| weight * (at(half * (1.0 - x)) + at(half * (1.0 + x)))).sum::<f64>()
}
