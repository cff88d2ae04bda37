//! One move by each of the machine's laws, within the same limits.

use anyhow::Result;
use isostep_profile::{IntervalLaw, Limits, Profile, SpeedLaw};
use isostep_sim::analysis::{Oscillator, deviation, mean};

use crate::frequency::vibration::{DAMPING_RATIO, Drive, NATURAL_HZ, without_jumps};

/// The gantry's default limits at 50 steps/mm, with the start speed that the laws over displacement need.
pub const LIMITS: Limits = Limits {
    start_speed_steps_s: 480.0,
    top_speed_steps_s: 2_400.0,
    accel_steps_s2: 2_500.0,
    decel_steps_s2: 2_500.0,
    jerk_steps_s3: 25_000.0,
};
/// 200 mm on the gantry.
pub const STEPS: f64 = 10_000.0;

/// Number of sampled intervals per ramp.
const PIECES: u32 = 4_000;
/// How long the ringing is observed after the end of the longest move, s.
const AFTER_S: f64 = 0.5;
/// Samples of the carriage's acceleration per second.
const READINGS_HZ: f64 = 1_000.0;

/// The move by `law`.
pub fn plan(law: SpeedLaw) -> Result<Profile> {
    let start = LIMITS.start_speed_steps_s;
    Ok(Profile::plan(STEPS, start, start, &LIMITS, IntervalLaw::Fastest, law)?)
}

/// Sampled instants from start to end, s: many on each ramp, and the two ends of the cruise.
pub fn instants_s(plan: &Profile) -> Vec<f64> {
    let (accel_s, total_s) = (plan.t_accel_s(), plan.duration_s());
    let ramp =
        |from_s: f64, to_s: f64| (0..=PIECES).map(move |k| from_s + (to_s - from_s) * f64::from(k) / f64::from(PIECES));
    let cruise_end_s = total_s - plan.t_decel_s();
    // This includes an instant just before the deceleration, because the acceleration may jump there.
    let before_s = cruise_end_s * (1.0 - 1e-9);
    ramp(0.0, accel_s).chain([before_s]).chain(ramp(cruise_end_s, total_s)).collect()
}

/// The highest acceleration, steps/s².
pub fn peak_accel(plan: &Profile) -> f64 {
    instants_s(plan).into_iter().map(|t_s| plan.accel_at(t_s).abs()).fold(0.0, f64::max)
}

/// The largest jump of the acceleration, steps/s²: at the start, between the intervals, or at the end.
pub fn accel_jump(plan: &Profile) -> f64 {
    let total_s = plan.duration_s();
    let near_s = 1e-9 * total_s;
    let corners = [0.0, plan.t_accel_s(), total_s - plan.t_decel_s(), total_s];
    let jumps = corners.map(|t_s| (plan.accel_at(t_s + near_s) - plan.accel_at(t_s - near_s)).abs());
    jumps.into_iter().fold(0.0, f64::max)
}

/// The highest jerk apart from the jumps of the acceleration, steps/s³.
pub fn peak_jerk(plan: &Profile) -> f64 {
    instants_s(plan).into_iter().map(|t_s| plan.jerk_at(t_s).abs()).fold(0.0, f64::max)
}

/// The excitation of a carriage by the move, without the jump to the start speed, which is the same for all laws.
pub fn drive(plan: &Profile) -> Drive {
    let corners = instants_s(plan).into_iter().map(|t_s| (t_s, plan.speed_at(t_s)));
    without_jumps(&corners.collect())
}

/// The standard deviation of the acceleration of a carriage with natural frequency `natural_hz`, over `window_s`;
/// steps/s².
pub fn ringing(drive: &Drive, natural_hz: f64, window_s: f64) -> Result<f64> {
    let count = (window_s * READINGS_HZ) as usize;
    let instants: Vec<f64> = (0..count).map(|n| n as f64 / READINGS_HZ).collect();
    Ok(deviation(&Oscillator::new(natural_hz, DAMPING_RATIO)?.ring(drive, &instants)))
}

/// The root of the mean square of [`ringing`] over carriages of 40 to 50 Hz.
pub fn mean_ringing(drive: &Drive, window_s: f64) -> Result<f64> {
    let all = NATURAL_HZ.into_iter().map(|hz| ringing(drive, hz, window_s)).collect::<Result<Vec<_>>>()?;
    let squares: Vec<f64> = all.iter().map(|deviation| deviation * deviation).collect();
    Ok(mean(&squares).sqrt())
}

/// The window in which all moves end and ring out, s.
pub fn window_s(plans: &[Profile]) -> f64 {
    plans.iter().map(Profile::duration_s).fold(0.0, f64::max) + AFTER_S
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_law_keeps_the_limits() {
        for law in SpeedLaw::ALL {
            let plan = plan(law).unwrap();
            assert!(peak_accel(&plan) <= LIMITS.accel_steps_s2 * (1.0 + 1e-9), "{law}: {}", peak_accel(&plan));
            assert!(plan.cruise_speed_steps_s() <= LIMITS.top_speed_steps_s * (1.0 + 1e-9), "{law}");
        }
    }

    #[test]
    fn the_trapezoid_is_the_fastest_and_the_s_curve_next() {
        let duration_s = |law| plan(law).unwrap().duration_s();
        let (trapezoid, s_curve) = (duration_s(SpeedLaw::Trapezoid), duration_s(SpeedLaw::SCurve));
        for law in SpeedLaw::ALL {
            assert!(duration_s(law) >= trapezoid, "{law}");
            assert!(law == SpeedLaw::Trapezoid || duration_s(law) >= s_curve, "{law}");
        }
    }

    /// By hand: 1,920 steps/s at 2,500 steps/s² take 0.768 s. At 25,000 steps/s³ the acceleration is reached after 0.1
    /// s, which makes each ramp 0.1 s longer.
    #[test]
    fn ramps_by_hand() {
        assert!((plan(SpeedLaw::Trapezoid).unwrap().t_accel_s() - 0.768).abs() < 1e-9);
        assert!((plan(SpeedLaw::SCurve).unwrap().t_accel_s() - 0.868).abs() < 1e-9);
        assert!((peak_jerk(&plan(SpeedLaw::SCurve).unwrap()) - 25_000.0).abs() < 1e-6);
        assert!((accel_jump(&plan(SpeedLaw::Trapezoid).unwrap()) - 2_500.0).abs() < 1e-6);
    }

    #[test]
    fn laws_that_are_smooth_over_time_hardly_ring() {
        let plans: Vec<Profile> = SpeedLaw::ALL.into_iter().map(|law| plan(law).unwrap()).collect();
        let ringing = |index: usize| mean_ringing(&drive(&plans[index]), window_s(&plans)).unwrap();
        let trapezoid = ringing(0);
        assert!(ringing(1) < trapezoid / 10.0 && ringing(2) < trapezoid / 50.0);
    }
}
