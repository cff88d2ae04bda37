//! When the vibration is greatest, and which law has the most power (Fonseca-Campos 2023, section VI.F, figure 13). A
//! model.

use anyhow::Result;
use isostep_generators::FrequencyLaw;
use isostep_sim::analysis::Oscillator;

use super::parameters::TABLE_6;
use super::vibration::{DAMPING_RATIO, drive, spectrum};
use crate::row::{Paper, Row};

/// The middle of the band in which the paper saw the most power, Hz.
const NATURAL_HZ: f64 = 45.0;

/// The paper's statements about its figure 13.
pub fn rows() -> Result<Vec<Row>> {
    Ok(vec![second_peak()?, greatest_power()?])
}

/// When a law's deceleration begins and its move ends, with the parameters of Table 6, s.
struct Phases {
    decel_s: f64,
    end_s: f64,
}

fn phases(law: FrequencyLaw) -> Result<Phases> {
    let profile = TABLE_6.exact(law)?;
    let first_decelerating = (profile.steps() - profile.ramp_steps()) as usize - 1;
    let decel_s = profile.edges_s().nth(first_decelerating).unwrap_or(0.0);
    Ok(Phases { decel_s, end_s: profile.duration_s() })
}

/// When the vibration is greatest in the second half of the move and after it, s.
fn peak_s(law: FrequencyLaw) -> Result<f64> {
    let end_s = phases(law)?.end_s;
    let instants: Vec<f64> =
        (0..).map(|n| end_s / 2.0 + f64::from(n) * 1e-4).take_while(|t_s| *t_s < end_s + 0.3).collect();
    let readings = Oscillator::new(NATURAL_HZ, DAMPING_RATIO)?.ring(&drive(law)?, &instants);
    let greatest = readings.iter().zip(&instants).max_by(|one, other| one.0.abs().total_cmp(&other.0.abs()));
    Ok(greatest.map_or(0.0, |(_, t_s)| *t_s))
}

fn second_peak() -> Result<Row> {
    let law = FrequencyLaw::Logarithmic;
    let (peak_s, Phases { decel_s, end_s }) = (peak_s(law)?, phases(law)?);
    let agrees = (peak_s - decel_s).abs() < (peak_s - end_s).abs();
    let found = format!("at {peak_s:.2} s, when the move ends; it decelerates from {decel_s:.2} s on");
    let ask = Paper::Frequency.asks("VI.F, figure 13", "second peak of the logarithmic law's vibration (a model)");
    Ok(ask.says("when the deceleration begins", found, agrees))
}

fn greatest_power() -> Result<Row> {
    let mut peaks = Vec::new();
    for law in FrequencyLaw::ALL {
        peaks.push((law, spectrum(&drive(law)?)?.densities.into_iter().fold(0.0, f64::max)));
    }
    let greatest = peaks.iter().max_by(|one, other| one.1.total_cmp(&other.1)).copied();
    let least = peaks.iter().map(|peak| peak.1).fold(f64::MAX, f64::min);
    let (law, peak) = greatest.unwrap_or((FrequencyLaw::Linear, 0.0));
    let found = format!("{law}: {:.1} times the lowest law's", peak / least);
    let ask = Paper::Frequency.asks("VI.F, figure 13", "highest power spectral density (a model)");
    Ok(ask.says("logarithmic", found, law == FrequencyLaw::Logarithmic))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every law stops abruptly from its start speed, which excites more vibration than any law's deceleration.
    #[test]
    fn every_law_rings_most_when_it_stops() {
        for law in FrequencyLaw::ALL {
            let (peak_s, Phases { decel_s, end_s }) = (peak_s(law).unwrap(), phases(law).unwrap());
            assert!(decel_s < end_s - 0.05 && (peak_s - end_s).abs() < 0.03, "{law}: {peak_s} of {end_s}");
        }
    }

    #[test]
    fn most_power_is_the_logarithmic_laws() {
        assert_eq!(greatest_power().unwrap().difference_text(), "none");
    }
}
