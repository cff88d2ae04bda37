//! Speed, acceleration and jerk of a law by differences of its steps.

use isostep_sim::analysis::{gradient, mean_derivative};

use super::Curve;
use crate::pictures::profile as picture;

/// Speed, acceleration and jerk, each by differences of the quantity before it (Fonseca-Campos 2023, section VI.A).
pub fn differences(curve: &Curve) -> picture::Curve {
    let (t_s, position): (Vec<f64>, Vec<f64>) = curve.samples.iter().copied().unzip();
    by_differences(&curve.name, &t_s, position)
}

/// The same of the positions at these instants, s.
pub fn by_differences(name: &str, t_s: &[f64], position: Vec<f64>) -> picture::Curve {
    let speed = gradient(t_s, &position);
    let accel = gradient(t_s, &speed);
    let jerk = gradient(t_s, &accel);
    let [position, speed, accel, jerk] =
        [position, speed, accel, jerk].map(|values| t_s.iter().copied().zip(values).collect());
    picture::Curve { name: name.to_owned(), position, speed, accel, jerk }
}

/// The largest magnitude.
pub fn peak(points: &[(f64, f64)]) -> f64 {
    points.iter().map(|point| point.1.abs()).fold(0.0, f64::max)
}

/// The largest magnitude of a mean derivative. The derivative has order `N` - 1, and the mean is over `N` consecutive
/// steps.
///
/// Near standstill, steps are far apart. Repeated differences may then be half as large again as the law's own
/// derivative. A mean over steps never exceeds the law's peak.
pub fn peak_mean<const N: usize>(curve: &Curve) -> f64 {
    let means = curve.samples.windows(N).map(|samples| {
        let sample = |index: usize| samples[index];
        mean_derivative(std::array::from_fn::<_, N, _>(|k| sample(k).0), std::array::from_fn(|k| sample(k).1))
    });
    means.map(f64::abs).fold(0.0, f64::max)
}
