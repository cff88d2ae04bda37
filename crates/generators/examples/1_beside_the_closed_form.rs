//! A generator of the literature beside the closed form: how far it drifts over one ramp.
//!
//! Run it with `cargo run -p isostep-generators --example 1_beside_the_closed_form`.

use isostep_generators::{Avr446, GeneratorError};
use isostep_profile::{IntervalSplit, Limits, SpeedProfile, SyncMove};

const TICK_HZ: u32 = 1_000_000;
const STEPS: u32 = 4_000;
const LIMITS: Limits = Limits {
    start_speed_steps_s: 0.0,
    top_speed_steps_s: 5_000.0,
    accel_steps_s2: 10_000.0,
    decel_steps_s2: 10_000.0,
    jerk_steps_s3: f64::INFINITY,
};

/// Prints the duration of the same move by both.
pub fn main() -> Result<(), GeneratorError> {
    let intervals = Avr446::plan(STEPS, &LIMITS, TICK_HZ)?;
    let theirs_s = intervals.map(f64::from).sum::<f64>() / f64::from(TICK_HZ);
    let plan = SyncMove::plan([STEPS as i32], &[LIMITS], IntervalSplit::Fastest, SpeedProfile::Trapezoid, None)
        .expect("these limits can be planned");
    let ours_s = plan.step_time_s(0, STEPS) - plan.step_time_s(0, 1);
    let apart_percent = (theirs_s / ours_s - 1.0) * 100.0;
    println!(
        "from the first step to the last: AVR446 {theirs_s:.6} s, closed form {ours_s:.6} s, {apart_percent:+.3} %"
    );
    assert!((0.1..0.2).contains(&apart_percent));
    Ok(())
}
