//! Fonseca-Campos's tables of parameters, and the curves of his profiles by them.

use anyhow::Result;
use isostep_generators::{FrequencyProfile, FrequencyRamp, TruncatedProfile};
use isostep_report::pictures::profile::Curve;
use isostep_report::speed_profiles::by_differences;

/// The parameters that one table prints.
#[derive(Clone, Copy, Debug)]
pub struct Parameters {
    /// The name of the table.
    pub name: &'static str,
    /// theta_f, the angle of the move, degrees.
    pub angle_deg: f64,
    /// spr, steps per revolution.
    pub steps_per_rev: f64,
    /// tau_max, the longest period, us.
    pub max_period_us: f64,
    /// tau_min, the shortest period, us.
    pub min_period_us: f64,
    /// p_N, the steps of a ramp, as a fraction of N.
    pub ramp_share: f64,
}

/// Parameters of figures 7 and 10.
pub const TABLE_1: Parameters = Parameters {
    name: "Table 1",
    angle_deg: 27.0,
    steps_per_rev: 1_600.0,
    max_period_us: 4_000.0,
    min_period_us: 1_500.0,
    ramp_share: 0.2,
};
/// Parameters of figure 11.
pub const TABLE_2: Parameters = Parameters {
    name: "Table 2",
    angle_deg: 30.0,
    steps_per_rev: 20_000.0,
    max_period_us: 4_000.0,
    min_period_us: 400.0,
    ramp_share: 0.1,
};
/// Parameters of figure 12.
pub const TABLE_4: Parameters = Parameters {
    name: "Table 4",
    angle_deg: 4.5,
    steps_per_rev: 160_000.0,
    max_period_us: 5_000.0,
    min_period_us: 300.0,
    ramp_share: 0.15,
};
/// Parameters of figure 13.
pub const TABLE_6: Parameters = Parameters {
    name: "Table 6",
    angle_deg: 4.5,
    steps_per_rev: 160_000.0,
    max_period_us: 3_000.0,
    min_period_us: 300.0,
    ramp_share: 0.2,
};

/// All tables that profiles are made from.
pub const TABLES: [Parameters; 4] = [TABLE_1, TABLE_2, TABLE_4, TABLE_6];

/// Added before truncation, so that a fraction that gives whole steps is not truncated to one step less.
const ROUNDING: f64 = 1e-9;

impl Parameters {
    /// N = int(spr/360 theta_f).
    pub fn steps(&self) -> u32 {
        (self.steps_per_rev * self.angle_deg / 360.0 + ROUNDING) as u32
    }

    /// p_N = int(fraction N).
    pub fn ramp_steps(&self) -> u32 {
        (self.ramp_share * f64::from(self.steps()) + ROUNDING) as u32
    }

    /// theta_s, degrees.
    pub fn step_deg(&self) -> f64 {
        360.0 / self.steps_per_rev
    }

    /// The profile without truncation.
    pub fn exact(&self, frequency_ramp: FrequencyRamp) -> Result<FrequencyProfile> {
        let (steps, ramp) = (self.steps(), self.ramp_steps());
        Ok(FrequencyProfile::plan(frequency_ramp, steps, ramp, self.max_period_us, self.min_period_us)?)
    }

    /// The profile truncated as in the paper's program.
    pub fn truncated(&self, frequency_ramp: FrequencyRamp) -> Result<TruncatedProfile> {
        let (steps, ramp) = (self.steps(), self.ramp_steps());
        Ok(TruncatedProfile::plan(frequency_ramp, steps, ramp, self.max_period_us, self.min_period_us)?)
    }

    /// Position, speed, acceleration and jerk of a profile over time, degrees, as the paper computes them (sections II.B and
    /// VI.A): at the end of each step, eq 9's theta\[i\] = i theta_s over the sum of the first i periods.
    pub fn exact_curve(&self, frequency_ramp: FrequencyRamp) -> Result<Curve> {
        let profile = self.exact(frequency_ramp)?;
        Ok(self.curve(profile.edges_s().skip(1).chain([profile.duration_s()]).collect()))
    }

    /// The same of the profile truncated to whole microseconds.
    pub fn truncated_curve(&self, frequency_ramp: FrequencyRamp) -> Result<Curve> {
        let profile = self.truncated(frequency_ramp)?;
        let ends_us = profile.edges_us().skip(1).chain([profile.duration_us()]);
        Ok(self.curve(ends_us.map(|us| us as f64 * 1e-6).collect()))
    }

    fn curve(&self, ends_s: Vec<f64>) -> Curve {
        let position = (1..=ends_s.len()).map(|i| i as f64 * self.step_deg()).collect();
        by_differences("", &ends_s, position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_and_ramps_of_the_tables() {
        let counts = TABLES.map(|table| (table.steps(), table.ramp_steps()));
        assert_eq!(counts, [(120, 24), (1_666, 166), (2_000, 300), (2_000, 400)]);
    }

    /// By hand: in the cruise, 0.225 degrees every 1.5 ms are 150 degrees/s, without acceleration or jerk.
    #[test]
    fn the_cruise_is_a_straight_line() {
        let curve = TABLE_1.exact_curve(FrequencyRamp::Linear).unwrap();
        assert_eq!(curve.position.len(), 120);
        assert!((curve.speed[60].1 - 150.0).abs() < 1e-9);
        assert!(curve.accel[60].1.abs() < 1e-6 && curve.jerk[60].1.abs() < 1e-2);
        let (end_s, end_deg) = curve.position[119];
        assert!((end_deg - 27.0).abs() < 1e-12);
        assert!((end_s - TABLE_1.exact(FrequencyRamp::Linear).unwrap().duration_s()).abs() < 1e-12);
    }
}
