//! Position, speed, acceleration and jerk over time, computed as in Fonseca-Campos 2023 (sections II.B and VI.A).

use isostep_generators::{FrequencyProfile, TruncatedProfile};
use isostep_sim::analysis::gradient;

/// Samples at the end of each step: eq 9's theta\[i\] = i theta_s over the sum of the first i periods.
#[derive(Clone, Debug)]
pub struct Kinematics {
    /// Instants, s.
    pub t_s: Vec<f64>,
    /// Position, degrees.
    pub position: Vec<f64>,
    /// Speed, degrees/s, by differences of the position.
    pub speed: Vec<f64>,
    /// Acceleration, degrees/s², by differences of the speed.
    pub accel: Vec<f64>,
    /// Jerk, degrees/s³, by differences of the acceleration.
    pub jerk: Vec<f64>,
}

impl Kinematics {
    /// From a law without truncation.
    pub fn exact(profile: &FrequencyProfile, step_deg: f64) -> Self {
        Self::new(profile.edges_s().skip(1).chain([profile.duration_s()]).collect(), step_deg)
    }

    /// From a law truncated to whole microseconds.
    pub fn truncated(profile: &TruncatedProfile, step_deg: f64) -> Self {
        let ends_us = profile.edges_us().skip(1).chain([profile.duration_us()]);
        Self::new(ends_us.map(|us| us as f64 * 1e-6).collect(), step_deg)
    }

    fn new(t_s: Vec<f64>, step_deg: f64) -> Self {
        let position: Vec<f64> = (1..=t_s.len()).map(|i| i as f64 * step_deg).collect();
        let speed = gradient(&t_s, &position);
        let accel = gradient(&t_s, &speed);
        let jerk = gradient(&t_s, &accel);
        Self { t_s, position, speed, accel, jerk }
    }

    /// Pairs of instant and value.
    pub fn over_time(&self, values: &[f64]) -> Vec<(f64, f64)> {
        self.t_s.iter().copied().zip(values.iter().copied()).collect()
    }
}

/// The largest magnitude.
pub fn peak(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |peak: f64, value| peak.max(value.abs()))
}

/// `values` divided by the largest magnitude, as the paper draws figures 11 and 12.
pub fn normalised(values: &[f64]) -> Vec<f64> {
    let peak = peak(values).max(f64::MIN_POSITIVE);
    values.iter().map(|value| value / peak).collect()
}

#[cfg(test)]
mod tests {
    use isostep_generators::FrequencyLaw;

    use super::super::parameters::TABLE_1;
    use super::*;

    /// By hand: in the cruise, 0.225 degrees every 1.5 ms are 150 degrees/s, without acceleration or jerk.
    #[test]
    fn the_cruise_is_a_straight_line() {
        let profile = TABLE_1.exact(FrequencyLaw::Linear).unwrap();
        let kinematics = Kinematics::exact(&profile, TABLE_1.step_deg());
        assert_eq!(kinematics.t_s.len(), 120);
        assert!((kinematics.speed[60] - 150.0).abs() < 1e-9);
        assert!(kinematics.accel[60].abs() < 1e-6 && kinematics.jerk[60].abs() < 1e-2);
        assert!((kinematics.position[119] - 27.0).abs() < 1e-12);
        assert!((kinematics.t_s[119] - profile.duration_s()).abs() < 1e-12);
    }

    #[test]
    fn shares_of_the_largest_magnitude() {
        assert_eq!(normalised(&[1.0, -4.0, 2.0]), [0.25, -1.0, 0.5]);
        assert_eq!(normalised(&[0.0]), [0.0]);
    }
}
