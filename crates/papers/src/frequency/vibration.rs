//! The ringing that the profiles cause (Fonseca-Campos 2023, section VI.F, Tables 5 to 7, figure 13). A model.

use crate::welch::{Spectrum, welch};
use anyhow::Result;
use isostep_generators::{FrequencyProfile, FrequencyRamp};
use isostep_sim::analysis::{Oscillator, mean};

use super::parameters::TABLE_6;

/// Natural frequencies of the carriage, Hz. The paper prints none, and saw the most power between 40 and 50 Hz. So each
/// of these is tried, and the mean square is taken.
pub const NATURAL_HZ: [f64; 11] = [40.0, 41.0, 42.0, 43.0, 44.0, 45.0, 46.0, 47.0, 48.0, 49.0, 50.0];
/// Damping as a fraction of critical damping, for a lightly damped metal structure.
pub const DAMPING_RATIO: f64 = 0.02;
/// Samples of a waveform (Fonseca-Campos 2023, section VI.F).
pub const SAMPLES: usize = 180;
/// Waveforms of a profile (Fonseca-Campos 2023, section VI.F). Here each begins a tenth of a sample later than the previous
/// one.
pub const WAVEFORMS: usize = 10;
/// Sample rate, the inverse of t_s (Fonseca-Campos 2023, Table 5).
pub const SAMPLE_HZ: f64 = 100.0;

/// Speed over time as corner points (s, steps/s), with straight lines between them.
pub type Drive = Vec<(f64, f64)>;

/// The excitation of a carriage by `frequency_ramp` with the parameters of Table 6. The speed is f\[i\] in the middle of period i
/// and changes linearly between. It jumps from standstill to f\[1\] and from f\[N\] to standstill.
pub fn drive(frequency_ramp: FrequencyRamp) -> Result<Drive> {
    let profile = TABLE_6.exact(frequency_ramp)?;
    Ok(corners(&profile))
}

fn corners(profile: &FrequencyProfile) -> Drive {
    let last = profile.steps();
    let middles =
        profile.edges_s().zip(1..).map(|(edge_s, i)| (edge_s + profile.period_s(i) / 2.0, profile.frequency_hz(i)));
    let start = (0.0, profile.frequency_hz(1));
    [start].into_iter().chain(middles).chain([(profile.duration_s(), profile.frequency_hz(last))]).collect()
}

/// The excitation without its jumps, as if the carriage moved at the start speed before and after the move.
pub fn without_jumps(drive: &Drive) -> Drive {
    let start = drive.first().map_or(0.0, |corner| corner.1);
    drive.iter().map(|&(t_s, speed)| (t_s, speed - start)).collect()
}

/// The measurements of a sensor on the carriage in the ten waveforms, steps/s².
pub fn waveforms(drive: &Drive, oscillator: &Oscillator) -> Vec<Vec<f64>> {
    let instants = |waveform: usize| -> Vec<f64> {
        let late_s = waveform as f64 / WAVEFORMS as f64 / SAMPLE_HZ;
        (0..SAMPLES).map(|n| late_s + n as f64 / SAMPLE_HZ).collect()
    };
    (0..WAVEFORMS).map(|waveform| oscillator.ring(drive, &instants(waveform))).collect()
}

/// Instants of one waveform, s.
pub fn instants_s() -> impl Iterator<Item = f64> {
    (0..SAMPLES).map(|n| n as f64 / SAMPLE_HZ)
}

/// The standard deviation of all samples of all waveforms of all natural frequencies, steps/s².
pub fn deviation(drive: &Drive) -> Result<f64> {
    let mut variances = Vec::new();
    for natural_hz in NATURAL_HZ {
        let all = waveforms(drive, &Oscillator::new(natural_hz, DAMPING_RATIO)?).concat();
        variances.push(isostep_sim::analysis::deviation(&all).powi(2));
    }
    Ok(mean(&variances).sqrt())
}

/// The power spectral density, (steps/s²)²/Hz: the mean over waveforms and natural frequencies.
pub fn spectrum(drive: &Drive) -> Result<Spectrum> {
    let mut spectra = Vec::new();
    for natural_hz in NATURAL_HZ {
        let all = waveforms(drive, &Oscillator::new(natural_hz, DAMPING_RATIO)?);
        spectra.extend(all.iter().map(|waveform| welch(waveform, SAMPLE_HZ)));
    }
    let frequencies_hz = spectra[0].frequencies_hz.clone();
    let densities = (0..frequencies_hz.len()).map(|k| spectra.iter().map(|one| one.densities[k]).sum::<f64>());
    let densities = densities.map(|sum| sum / spectra.len() as f64).collect();
    Ok(Spectrum { frequencies_hz, densities })
}

/// The standard deviation for one natural frequency, sampled every millisecond over the same time. At the paper's
/// hundred samples per second, a frequency above 50 Hz would be aliased to a lower one.
pub fn fine_deviation(drive: &Drive, natural_hz: f64) -> Result<f64> {
    let instants: Vec<f64> = (0..SAMPLES * 10).map(|n| n as f64 * 1e-3).collect();
    let readings = Oscillator::new(natural_hz, DAMPING_RATIO)?.ring(drive, &instants);
    Ok(isostep_sim::analysis::deviation(&readings))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn deviations(drive: impl Fn(FrequencyRamp) -> Drive) -> [f64; 4] {
        FrequencyRamp::ALL.map(|frequency_ramp| deviation(&drive(frequency_ramp)).unwrap())
    }

    #[test]
    fn sinusoidal_rings_least_and_logarithmic_most() {
        let [linear, quadratic, sinusoidal, logarithmic] = deviations(|frequency_ramp| drive(frequency_ramp).unwrap());
        assert!(sinusoidal < linear && linear < quadratic && quadratic < logarithmic);
    }

    #[test]
    fn the_ramps_alone_are_in_the_same_order_and_far_apart() {
        let [linear, quadratic, sinusoidal, logarithmic] =
            deviations(|frequency_ramp| without_jumps(&drive(frequency_ramp).unwrap()));
        assert!(sinusoidal * 3.0 < linear && linear * 1.5 < quadratic && quadratic * 2.0 < logarithmic);
    }

    #[test]
    fn the_spectrum_has_the_power_of_the_waveforms_where_the_carriage_rings() {
        let drive = drive(FrequencyRamp::Logarithmic).unwrap();
        let peak_hz = spectrum(&drive).unwrap().peak_hz();
        assert!((38.0..=50.0).contains(&peak_hz), "{peak_hz}");
    }

    /// The drive covers the distance: its area is the number of steps, except for the outer halves of the first and
    /// last periods.
    #[test]
    fn the_drive_covers_the_way() {
        for frequency_ramp in FrequencyRamp::ALL {
            let drive = drive(frequency_ramp).unwrap();
            let area: f64 = drive.windows(2).map(|pair| (pair[1].0 - pair[0].0) * (pair[0].1 + pair[1].1) / 2.0).sum();
            assert!((area - 2_000.0).abs() < 2.0, "{frequency_ramp}: {area}");
        }
    }
}
