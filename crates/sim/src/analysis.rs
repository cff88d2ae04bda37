//! The effect of a profile on the machine: derivatives of sampled curves, and the oscillation of a carriage.
//!
//! | item | what | after |
//! |---|---|---|
//! | [`gradient`] | derivative of samples at unequal spacing | `numpy.gradient`, as Fonseca-Campos 2023, section VI.A used it |
//! | [`Oscillator`] | **model** of a carriage on a spring, driven by a profile's acceleration | Fonseca-Campos 2023, section VI.F |
//! | [`mean`], [`deviation`] | average and standard deviation | Fonseca-Campos 2023, Table 7 |

mod oscillator;

pub use self::oscillator::{Oscillator, OscillatorError, Ringing};

/// The slope dy/dt at each of the samples (`t`, `y`), in their order.
///
/// Inside, it is the slope at the sample of the parabola through it and its neighbours: exact to second order for any
/// spacing. At each end it is the slope to the only neighbour, exact to first order. This is `numpy.gradient(y, t)`
/// with its default, `edge_order=1`. Fonseca-Campos 2023, section VI.A, uses it to take speed from position,
/// acceleration from speed and jerk from acceleration. So the first and the last value of each derivative are less
/// accurate than the others.
///
/// `t` must rise from sample to sample. A single sample has no slope: its derivative is given as 0.
///
/// ```
/// use isostep_sim::analysis::gradient;
///
/// // y = t²: exact inside, 1 s off its place at the ends.
/// assert_eq!(gradient(&[0.0, 1.0, 3.0], &[0.0, 1.0, 9.0]), [1.0, 2.0, 4.0]);
/// ```
///
/// # Panics
/// If `t` and `y` differ in length.
pub fn gradient(t: &[f64], y: &[f64]) -> Vec<f64> {
    assert_eq!(t.len(), y.len(), "a derivative needs as many instants as values");
    let last = t.len().saturating_sub(1);
    let slope = |from: usize, to: usize| (y[to] - y[from]) / (t[to] - t[from]);
    let at = |k: usize| match k {
        _ if last == 0 => 0.0,
        0 => slope(0, 1),
        k if k == last => slope(k - 1, k),
        // The parabola's slope: the slope of each side, weighted by the length of the other side.
        k => {
            let (before, after) = (t[k] - t[k - 1], t[k + 1] - t[k]);
            (after * slope(k - 1, k) + before * slope(k, k + 1)) / (before + after)
        }
    };
    (0..t.len()).map(at).collect()
}

/// The mean of the derivative of order `N` - 1 over `N` samples: (N - 1)! times their divided difference.
///
/// It is a weighted mean of the derivative between the first and the last of them, so it is never above the highest
/// value that the derivative has there. Differences of differences ([`gradient`]) promise no such thing where samples
/// are far apart.
///
/// ```
/// use isostep_sim::analysis::mean_derivative;
///
/// // y = t²
/// assert_eq!(mean_derivative([0.0, 1.0, 3.0], [0.0, 1.0, 9.0]), 2.0);
/// ```
#[must_use]
pub fn mean_derivative<const N: usize>(t: [f64; N], mut y: [f64; N]) -> f64 {
    for order in 1..N {
        for k in 0..N - order {
            y[k] = order as f64 * (y[k + 1] - y[k]) / (t[k + order] - t[k]);
        }
    }
    y[0]
}

/// The average; 0 for no values.
pub fn mean(values: &[f64]) -> f64 {
    if values.is_empty() { 0.0 } else { values.iter().sum::<f64>() / values.len() as f64 }
}

/// The standard deviation of a whole population, not of a sample (`numpy.std`); 0 for no values.
pub fn deviation(values: &[f64]) -> f64 {
    let middle = mean(values);
    let squares: Vec<f64> = values.iter().map(|value| (value - middle) * (value - middle)).collect();
    mean(&squares).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(got: &[f64], wanted: &[f64]) {
        assert_eq!(got.len(), wanted.len());
        for (got, wanted) in got.iter().zip(wanted) {
            assert!((got - wanted).abs() <= 1e-12 * wanted.abs().max(1.0), "{got} is not {wanted}");
        }
    }

    #[test]
    fn quadratics_are_exact_inside_whatever_the_spacing() {
        let t = [-1.0, -0.7, 0.0, 0.1, 2.5, 2.6, 4.0];
        let y = t.map(|t| 3.0 * t * t - 2.0 * t + 5.0);
        let slopes = gradient(&t, &y);
        close(&slopes[1..6], &[-0.7, 0.0, 0.1, 2.5, 2.6].map(|t| 6.0 * t - 2.0));
    }

    /// Computed by hand, and what `numpy.gradient([1, 2, 4, 7, 11, 16], [0, 1, 1.5, 3.5, 4, 6])` prints (NumPy's
    /// manual).
    #[test]
    fn values_of_numpys_manual() {
        let slopes = gradient(&[0.0, 1.0, 1.5, 3.5, 4.0, 6.0], &[1.0, 2.0, 4.0, 7.0, 11.0, 16.0]);
        close(&slopes, &[1.0, 3.0, 3.5, 6.7, 6.9, 2.5]);
    }

    #[test]
    fn few_samples() {
        assert!(gradient(&[], &[]).is_empty());
        assert_eq!(gradient(&[1.0], &[5.0]), [0.0]);
        assert_eq!(gradient(&[1.0, 3.0], &[5.0, 9.0]), [2.0, 2.0]);
    }

    #[test]
    #[should_panic(expected = "as many instants as values")]
    fn lengths_must_agree() {
        gradient(&[0.0, 1.0], &[0.0]);
    }

    #[test]
    fn deviation_of_a_textbook_case() {
        // Squared distances from 5: 9, 1, 1, 1, 0, 0, 4, 16; their mean is 4.
        let values = [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0];
        assert_eq!((mean(&values), deviation(&values)), (5.0, 2.0));
        assert_eq!((mean(&[]), deviation(&[])), (0.0, 0.0));
    }
}
