//! Stoychitch's motor, with the default values of the paper's appendix (2018), the generators of its section 3, and the linear
//! profile that they are compared with.

use std::f64::consts::TAU;

use anyhow::Result;
use isostep_generators::{Correction, StepsPerTime, TimePerStep};
use isostep_profile::{IntervalSplit, Limits, Profile, SpeedProfile, SyncMove};

/// K, steps per revolution.
pub const STEPS_PER_REV: u32 = 4_096;
/// v_s, the start speed, rad/s.
pub const START_RAD_S: f64 = 0.5;
/// A start nearly from rest, rad/s. It is just above the speed gained in one step, sqrt(2 a alpha) = 0.0783 rad/s;
/// below that, eq 11 diverges.
pub const SLOW_START_RAD_S: f64 = 0.08;
/// v_M, the top speed, rad/s.
pub const TOP_RAD_S: f64 = 2.0;
/// a_M, the acceleration, rad/s².
pub const ACCEL_RAD_S2: f64 = 2.0;
/// m = a/d, acceleration over deceleration.
pub const RATIO: f64 = 2.0;

/// Steps per radian: 1/alpha.
pub fn steps_per_rad() -> f64 {
    f64::from(STEPS_PER_REV) / TAU
}

/// The motor's limits, with a start speed of `start_rad_s`.
pub fn limits(start_rad_s: f64) -> Limits {
    let steps = steps_per_rad();
    Limits {
        start_speed_steps_s: start_rad_s * steps,
        top_speed_steps_s: TOP_RAD_S * steps,
        accel_steps_s2: ACCEL_RAD_S2 * steps,
        decel_steps_s2: ACCEL_RAD_S2 / RATIO * steps,
        jerk_steps_s3: f64::INFINITY,
    }
}

/// The timer of "time per step" and of our segments, Hz. The paper does not print a value.
pub const TICK_HZ: u32 = 1_000_000;
/// The interrupts of "steps per time", Hz (Stoychitch 2018, appendix).
pub const SERVICE_HZ: u32 = 10_000;

/// The names of the generators, in the order of [`generators`].
pub const NAMES: [&str; 4] =
    ["Isostep, exact segments", "time per step, eqs 11-13", "time per step with eq 14", "steps per time, eq 17"];

/// One revolution made by one generator.
pub struct Generator {
    /// The generator's name in this report.
    pub name: &'static str,
    /// The intervals between its steps, s.
    pub intervals_s: Vec<f64>,
    truth: Truth,
}

/// The reference for an interval.
#[derive(Clone, Copy)]
enum Truth {
    /// The speed that the profile has at step i, counted from 0 (Stoychitch 2018, eqs 9 and 10).
    SpeedAtStep,
    /// The time that the profile takes from one step's displacement to the next one's. The value is the displacement of the
    /// first step.
    TimeFrom(f64),
}

/// All generators, with a start speed of `start_rad_s`.
pub fn generators(start_rad_s: f64) -> Result<Vec<Generator>> {
    let limits = limits(start_rad_s);
    let made = [
        (exact(&limits)?, Truth::TimeFrom(0.5)),
        (time_per_step(&limits, Correction::Without)?, Truth::SpeedAtStep),
        (time_per_step(&limits, Correction::With)?, Truth::SpeedAtStep),
        (steps_per_time(&limits)?, Truth::TimeFrom(1.0)),
    ];
    let named = NAMES.into_iter().zip(made);
    Ok(named.map(|(name, (intervals_s, truth))| Generator { name, intervals_s, truth }).collect())
}

fn exact(limits: &Limits) -> Result<Vec<f64>> {
    let plan =
        SyncMove::plan([STEPS_PER_REV as i32], &[*limits], IntervalSplit::Fastest, SpeedProfile::Trapezoid, None)?;
    let ticks: Vec<u64> = plan.segments(0, TICK_HZ).flat_map(|segment| segment.ticks()).collect();
    Ok(ticks.windows(2).map(|pair| (pair[1] - pair[0]) as f64 / f64::from(TICK_HZ)).collect())
}

fn time_per_step(limits: &Limits, correction: Correction) -> Result<Vec<f64>> {
    let intervals = TimePerStep::<f64>::plan(STEPS_PER_REV, limits, correction, TICK_HZ)?;
    Ok(intervals.map(|ticks| f64::from(ticks) / f64::from(TICK_HZ)).collect())
}

fn steps_per_time(limits: &Limits) -> Result<Vec<f64>> {
    let services = StepsPerTime::plan(STEPS_PER_REV, limits, 1, SERVICE_HZ)?;
    Ok(services.map(|count| f64::from(count) / f64::from(SERVICE_HZ)).collect())
}

/// The linear profile itself, over so many steps.
pub fn linear_profile(start_rad_s: f64, steps: u32) -> Result<Profile> {
    crate::plan(f64::from(steps), &limits(start_rad_s), SpeedProfile::Trapezoid)
}

impl Generator {
    /// The displacement of the profile at which the first step is due, steps.
    fn first_steps(&self) -> f64 {
        match self.truth {
            Truth::SpeedAtStep => 0.0,
            Truth::TimeFrom(first) => first,
        }
    }

    /// The instants of the first `count` steps, s from the beginning of the profile.
    pub fn edges_s(&self, linear_profile: &Profile, count: usize) -> Vec<f64> {
        let mut edges = vec![linear_profile.time_at(self.first_steps())];
        for interval_s in self.intervals_s.iter().take(count - 1) {
            edges.push(edges[edges.len() - 1] + interval_s);
        }
        edges
    }

    /// The speed error of each interval relative to the profile, %.
    pub fn errors_percent(&self, linear_profile: &Profile) -> Vec<f64> {
        let exact_steps_s = |i: usize| {
            let at = self.first_steps() + i as f64;
            match self.truth {
                Truth::SpeedAtStep => linear_profile.speed_at(linear_profile.time_at(at)),
                Truth::TimeFrom(_) => 1.0 / (linear_profile.time_at(at + 1.0) - linear_profile.time_at(at)),
            }
        };
        let intervals = self.intervals_s.iter().enumerate();
        intervals.map(|(i, interval_s)| 100.0 * (1.0 / interval_s / exact_steps_s(i) - 1.0)).collect()
    }

    /// The time that the generator takes longer from its first step to its last than the profile, s.
    pub fn late_s(&self, linear_profile: &Profile) -> f64 {
        let first = self.first_steps();
        let last = first + self.intervals_s.len() as f64;
        self.intervals_s.iter().sum::<f64>() - (linear_profile.time_at(last) - linear_profile.time_at(first))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand, at 0.08 rad/s = 52.15 steps/s and a = 1303.8 steps/s²: eq 10 gives v_1 = v_0 + a/v_0 = 77.15. The profile
    /// has sqrt(v_0² + 2 a) = 72.99 steps/s, which is 5.70 % less.
    #[test]
    fn the_recurrence_runs_ahead_by_hand() {
        let errors = generators(SLOW_START_RAD_S).unwrap()[1]
            .errors_percent(&linear_profile(SLOW_START_RAD_S, STEPS_PER_REV).unwrap());
        assert!((errors[1] - 5.70).abs() < 0.01, "{}", errors[1]);
    }

    #[test]
    fn each_makes_every_step_of_the_revolution() {
        for generator in generators(SLOW_START_RAD_S).unwrap() {
            assert_eq!(generator.intervals_s.len(), 4_095, "{}", generator.name);
        }
    }
}
