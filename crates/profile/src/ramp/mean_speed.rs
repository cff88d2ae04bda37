//! Mean speeds of ramps, and what else the search for a profile in three equal intervals needs to know of them.

use super::{Ramp, RampLimits, Shape};
use crate::speed_profile::SpeedProfile;

impl RampLimits {
    /// The ramp with this rise, this duration and this mean speed.
    #[cold]
    pub(crate) fn lasting(&self, duration_s: f64, slow_steps_s: f64, rise_steps_s: f64, mean_steps_s: f64) -> Ramp {
        let shape = match self.shape(rise_steps_s).0 {
            // On a short ramp, rounding must not lift the acceleration above its limit. Without a rise the ramp is a
            // cruise.
            Shape::ConstantAccel { accel_steps_s2 } => {
                Shape::ConstantAccel { accel_steps_s2: accel_steps_s2.min(rise_steps_s / duration_s) }
            }
            other => other,
        };
        Ramp { shape, slow_steps_s, rise_steps_s, steps: mean_steps_s * duration_s, duration_s }
    }

    /// A rough rise over `slow` in thirds by this speed profile, if that of a trapezoid in thirds is `trapezoid`. A search begins
    /// with it.
    pub(crate) fn speed_rise_near(&self, slow: f64, trapezoid: f64) -> f64 {
        trapezoid
            * match self.speed_profile {
                SpeedProfile::Trapezoid => 1.0,
                SpeedProfile::SCurve | SpeedProfile::Sine => 0.78,
                SpeedProfile::Linear | SpeedProfile::Sinusoidal => 0.6,
                SpeedProfile::Quadratic => 0.38,
                // The faster the ramp begins, the longer it is because of its steep beginning.
                SpeedProfile::Logarithmic => {
                    0.14 + 0.64 * trapezoid * trapezoid / (trapezoid * trapezoid + 3.0 * slow * (trapezoid + slow))
                }
            }
    }

    /// The mean speed of a ramp with this rise, which does not depend on its length.
    pub(crate) fn mean_steps_s(&self, slow: f64, rise: f64) -> f64 {
        match self.shape_of_speed_profile() {
            Shape::OverDisplacement(speed_profile) if rise > 0.0 => rise / speed_profile.whole_time(slow / rise),
            _ => slow + rise / 2.0,
        }
    }

    /// The length of the shortest ramp and the mean speed of any ramp, each with how much more it is for each step/s
    /// more.
    #[cold]
    pub(crate) fn length_and_mean(&self, slow: f64, rise: f64) -> ((f64, f64), (f64, f64)) {
        match self.shape_of_speed_profile() {
            Shape::OverDisplacement(speed_profile) if rise > 0.0 => {
                let ((length, length_growth), (time, time_growth)) = speed_profile.whole(slow, rise);
                let per_time = 1.0 / time;
                let mean_growth = (1.0 + time_growth * per_time) * per_time;
                ((length * self.per_accel, length_growth * self.per_accel), (rise * per_time, mean_growth))
            }
            _ => (self.length(slow, rise), (slow + rise / 2.0, 0.5)),
        }
    }
}
