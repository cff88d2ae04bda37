//! Power spectral density by Welch's method.

use std::f64::consts::TAU;

use realfft::RealFftPlanner;

/// The longest segment, samples: SciPy's default.
const SEGMENT_MAX: usize = 256;

/// The power of a signal over frequency.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Spectrum {
    /// Frequencies, Hz: from 0 to half the sampling rate, with equal spacing.
    pub frequencies_hz: Vec<f64>,
    /// Power density at each frequency, the signal's unit squared per Hz, for positive and negative frequency together.
    pub densities: Vec<f64>,
}

#[cfg(test)]
impl Spectrum {
    /// The total power, the signal's unit squared: the integral of the density over frequency.
    pub fn power(&self) -> f64 {
        self.densities.iter().sum::<f64>() * self.spacing_hz()
    }

    /// The frequency with the highest density, Hz; 0 for an empty spectrum.
    pub fn peak_hz(&self) -> f64 {
        let highest = self.densities.iter().copied().fold(0.0, f64::max);
        let at = self.densities.iter().position(|density| *density == highest);
        at.map_or(0.0, |at| self.frequencies_hz[at])
    }

    fn spacing_hz(&self) -> f64 {
        self.frequencies_hz.get(1).copied().unwrap_or(0.0)
    }
}

/// The power spectral density of `samples` taken at `sample_hz`, by Welch's method (1967) with the defaults of
/// `scipy.signal.welch`, which Fonseca-Campos 2023, section VI.F, used. Segments have [`SEGMENT_MAX`] samples, or one
/// segment has all if there are fewer, and overlap by half. The mean of each segment is subtracted, a Hann window is
/// applied, and the squared magnitudes of all segments are averaged. Samples after the last whole segment are left out.
///
/// With no samples or a single one, the spectrum is empty.
pub fn welch(samples: &[f64], sample_hz: f64) -> Spectrum {
    let length = samples.len().min(SEGMENT_MAX);
    if length < 2 {
        return Spectrum { frequencies_hz: Vec::new(), densities: Vec::new() };
    }
    let window = hann(length);
    let segments = samples.windows(length).step_by(length - length / 2);
    let mut densities = vec![0.0; length / 2 + 1];
    let count = segments.len() as f64;
    for segment in segments {
        for (sum, power) in densities.iter_mut().zip(powers(segment, &window)) {
            *sum += power / count;
        }
    }
    let scale = 1.0 / (sample_hz * window.iter().map(|weight| weight * weight).sum::<f64>());
    for (k, density) in densities.iter_mut().enumerate() {
        // 0 Hz and, for an even length, half the sampling rate have no separate negative frequency.
        *density *= if k == 0 || 2 * k == length { scale } else { 2.0 * scale };
    }
    let frequencies_hz = (0..densities.len()).map(|k| k as f64 * sample_hz / length as f64).collect();
    Spectrum { frequencies_hz, densities }
}

/// Hann's window for spectra: one period of a raised cosine. The final zero belongs to the next period.
fn hann(length: usize) -> Vec<f64> {
    (0..length).map(|n| 0.5 - 0.5 * (TAU * n as f64 / length as f64).cos()).collect()
}

/// The squared magnitudes of the Fourier transform of `segment`, with its mean subtracted and `window` applied.
fn powers(segment: &[f64], window: &[f64]) -> Vec<f64> {
    let mean = isostep_sim::analysis::mean(segment);
    let mut weighted: Vec<f64> = segment.iter().zip(window).map(|(sample, weight)| (sample - mean) * weight).collect();
    let transform = RealFftPlanner::new().plan_fft_forward(segment.len());
    let mut spectrum = transform.make_output_vec();
    transform.process(&mut weighted, &mut spectrum).expect("the plan's own lengths fit");
    spectrum.iter().map(|line| line.norm_sqr()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(count: usize, amplitude: f64, hz: f64, sample_hz: f64) -> Vec<f64> {
        (0..count).map(|n| amplitude * (TAU * hz * n as f64 / sample_hz).sin()).collect()
    }

    /// Uniformly distributed numbers from -0.5 to 0.5: their variance is 1/12.
    fn noise(count: usize) -> Vec<f64> {
        let mut random = oorandom::Rand64::new(1);
        (0..count).map(|_| random.rand_float() - 0.5).collect()
    }

    #[test]
    fn a_sine_has_half_its_amplitude_squared() {
        let spectrum = welch(&sine(4096, 3.0, 25.0, 200.0), 200.0);
        assert!((spectrum.power() - 4.5).abs() < 1e-9, "{}", spectrum.power());
        assert_eq!(spectrum.peak_hz(), 25.0);
        // A Hann window spreads a line over three bins: 1/4, 1, 1/4 of its amplitude, so 1/6, 4/6, 1/6 of its power.
        let bin = 200.0 / 256.0;
        for (k, share) in [(31, 1.0 / 6.0), (32, 4.0 / 6.0), (33, 1.0 / 6.0), (35, 0.0)] {
            assert!((spectrum.densities[k] * bin - 4.5 * share).abs() < 1e-9, "bin {k}");
        }
    }

    #[test]
    fn white_noise_is_level_and_keeps_its_variance() {
        let spectrum = welch(&noise(256 * 400), 100.0);
        assert!((spectrum.power() * 12.0 - 1.0).abs() < 0.01, "{}", spectrum.power());
        // The density is the variance over the band of 50 Hz, in each quarter of it. The lowest bins lack the
        // subtracted mean.
        for quarter in spectrum.densities[3..127].chunks(31) {
            assert!((isostep_sim::analysis::mean(quarter) * 12.0 * 50.0 - 1.0).abs() < 0.02);
        }
    }

    /// Parseval: the power over all frequencies is that of the windowed samples over all instants.
    #[test]
    fn one_segment_has_the_power_of_its_windowed_samples() {
        for count in [180, 181] {
            let samples = noise(count);
            let (middle, window) = (isostep_sim::analysis::mean(&samples), hann(count));
            let weighted = samples.iter().zip(&window).map(|(sample, weight)| ((sample - middle) * weight).powi(2));
            let power = weighted.sum::<f64>() / window.iter().map(|weight| weight * weight).sum::<f64>();
            let spectrum = welch(&samples, 100.0);
            assert!((spectrum.power() / power - 1.0).abs() < 1e-12);
            assert_eq!(spectrum.densities.len(), count / 2 + 1);
        }
    }

    /// The result of `scipy.signal.welch(numpy.array([1., 2., 4., 7., 11., 16., 3., 5.]), fs=10)` (SciPy 1.17).
    #[test]
    fn values_of_scipy() {
        let spectrum = welch(&[1.0, 2.0, 4.0, 7.0, 11.0, 16.0, 3.0, 5.0], 10.0);
        assert_eq!(spectrum.frequencies_hz, [0.0, 1.25, 2.5, 3.75, 5.0]);
        let wanted =
            [3.7856180831641253, 11.283897299526219, 7.247056274847711, 2.9081722001353647, 1.2635618083164126];
        for (got, wanted) in spectrum.densities.iter().zip(wanted) {
            assert!((got - wanted).abs() < 1e-9, "{got} is not {wanted}");
        }
    }

    #[test]
    fn segments_overlap_by_half_and_a_short_rest_is_left_out() {
        let samples = noise(600);
        let parts = [welch(&samples[..256], 1.0), welch(&samples[128..384], 1.0), welch(&samples[256..512], 1.0)];
        let whole = welch(&samples, 1.0);
        for (k, density) in whole.densities.iter().enumerate() {
            let average = parts.iter().map(|part| part.densities[k]).sum::<f64>() / 3.0;
            assert!((density - average).abs() <= 1e-12 * average);
        }
    }

    #[test]
    fn nothing_has_no_spectrum() {
        assert_eq!(welch(&[], 1.0).power(), 0.0);
        assert_eq!(welch(&[1.0], 1.0).peak_hz(), 0.0);
    }
}
