//! Three axes with different limits make one straight move: all of them accelerate, cruise and decelerate over the same
//! intervals, and none exceeds its own limits.
//!
//! Run it with `cargo run -p isostep-profile --example 2_synchronised_axes`.

use isostep_profile::{IntervalSplit, Limits, PlanError, SpeedProfile, SyncMove};

/// An axis of that top speed, steps/s, and acceleration, steps/s².
const fn limits(top_speed_steps_s: f64, accel_steps_s2: f64) -> Limits {
    Limits {
        start_speed_steps_s: 0.0,
        top_speed_steps_s,
        accel_steps_s2,
        decel_steps_s2: accel_steps_s2,
        jerk_steps_s3: 50_000.0,
    }
}

/// Plans the move and prints when each axis makes its first step, its middle one and its last.
pub fn main() -> Result<(), PlanError> {
    // Z is slow, so it decides how fast the others may be.
    let limits = [limits(2_400.0, 2_500.0), limits(2_400.0, 2_500.0), limits(400.0, 500.0)];
    let steps = [8_000, -4_000, 1_000];
    let plan = SyncMove::plan(steps, &limits, IntervalSplit::Fastest, SpeedProfile::SCurve, None)?;
    println!("the longest axis cruises at {:.0} steps/s", plan.profile.cruise_speed_steps_s());
    for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
        let count = steps[axis].unsigned_abs();
        let [first_s, middle_s, last_s] = [1, count / 2, count].map(|step| plan.step_time_s(axis, step));
        println!("{name}: {count:>5} steps, at {first_s:.4}, {middle_s:.4} and {last_s:.4} s");
    }
    // Halfway along the path all axes are halfway, to half a step of the coarsest, which makes 300 steps/s.
    let [x_s, z_s] = [plan.step_time_s(0, 4_000), plan.step_time_s(2, 500)];
    assert!((x_s - z_s).abs() < 0.5 / 300.0, "{x_s} and {z_s}");
    Ok(())
}
