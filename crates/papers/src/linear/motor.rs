//! Stoychitch's motor, with the default values of the paper's appendix.

use std::f64::consts::TAU;

use isostep_profile::Limits;

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
