//! The closed form of a speed profile, for speed profiles that have one.

use isostep_profile::Profile;

use super::Derivatives;

/// Number of instants per phase for drawing and for finding peaks.
const INSTANTS: usize = 4_000;
/// Distance from a phase boundary at which values on either side are taken, as a fraction of the duration.
const ASIDE: f64 = 1e-9;
/// An acceleration that changes by more than this fraction of its peak across a phase boundary counts as a jump. No
/// finite jerk changes it as much within `ASIDE`.
const JUMP: f64 = 1e-4;

/// Position, speed, acceleration and jerk at any instant.
pub struct Exact(pub Profile);

impl Exact {
    /// Highest acceleration or deceleration, steps/s².
    pub fn peak_accel(&self) -> f64 {
        self.peak(|plan, t_s| plan.accel_at(t_s))
    }

    /// Highest jerk of either sign, steps/s³; infinite where the acceleration jumps.
    pub fn peak_jerk(&self) -> f64 {
        if self.accel_jump() > JUMP * self.peak_accel() { f64::INFINITY } else { self.jerk_beside_jumps() }
    }

    /// The largest jump of the acceleration, steps/s²: at the start, between the phases, or at the end.
    pub fn accel_jump(&self) -> f64 {
        let aside_s = self.0.duration_s() * ASIDE;
        let jump = |t_s: f64| (self.0.accel_at(t_s + aside_s) - self.0.accel_at(t_s - aside_s)).abs();
        self.corners_s().into_iter().map(jump).fold(0.0, f64::max)
    }

    /// Highest jerk of either sign but that of the jumps, steps/s³.
    pub fn jerk_beside_jumps(&self) -> f64 {
        self.peak(|plan, t_s| plan.jerk_at(t_s))
    }

    /// Position, speed, acceleration and jerk as curves over time.
    pub fn curve(&self, name: &str) -> Derivatives {
        self.curve_of(name, INSTANTS)
    }

    /// The same by so many instants in each phase, and its end.
    pub fn curve_of(&self, name: &str, instants: usize) -> Derivatives {
        let over_time = |value: fn(&Profile, f64) -> f64| {
            self.instants_s(instants).into_iter().map(|t_s| (t_s, value(&self.0, t_s))).collect()
        };
        Derivatives {
            name: name.to_owned(),
            position: over_time(Profile::position_at),
            speed: over_time(Profile::speed_at),
            accel: over_time(Profile::accel_at),
            jerk: over_time(Profile::jerk_at),
        }
    }

    fn peak(&self, value: impl Fn(&Profile, f64) -> f64) -> f64 {
        self.instants_s(INSTANTS).into_iter().map(|t_s| value(&self.0, t_s).abs()).fold(0.0, f64::max)
    }

    /// The instants of the phase boundaries, with the start and the end.
    fn corners_s(&self) -> [f64; 4] {
        let plan = &self.0;
        [0.0, plan.t_accel_s(), plan.t_accel_s() + plan.t_cruise_s(), plan.duration_s()]
    }

    /// Instants in each phase, from just after its beginning to just before its end.
    fn instants_s(&self, instants: usize) -> Vec<f64> {
        let aside_s = self.0.duration_s() * ASIDE;
        let corners_s = self.corners_s();
        let phases = corners_s.windows(2).map(|pair| (pair[0] + aside_s, pair[1] - aside_s));
        let through = |(from_s, to_s): (f64, f64)| {
            (0..=instants).map(move |k| from_s + (to_s - from_s) * k as f64 / instants as f64)
        };
        phases.filter(|(from_s, to_s)| from_s < to_s).flat_map(through).collect()
    }
}
