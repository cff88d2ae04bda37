//! One axis moves 2,000 steps from rest to rest: the plan, and the instants of its steps.
//!
//! Run it with `cargo run -p isostep-profile --example 1_one_axis`.

use isostep_profile::{IntervalSplit, Limits, PlanError, SpeedProfile, SyncMove};

/// The limits of the axis.
const LIMITS: Limits = Limits {
    start_speed_steps_s: 0.0,
    top_speed_steps_s: 2_400.0,
    accel_steps_s2: 2_500.0,
    decel_steps_s2: 2_500.0,
    // A trapezoid does not limit the jerk.
    jerk_steps_s3: f64::INFINITY,
};

/// Segments tell instants in ticks of this clock, Hz.
const TICK_HZ: u32 = 1_000_000;

/// Plans the move and prints it.
pub fn main() -> Result<(), PlanError> {
    let plan = SyncMove::plan([2_000], &[LIMITS], IntervalSplit::Fastest, SpeedProfile::Trapezoid, None)?;
    let profile = &plan.profile;
    println!("accelerates for {:.3} s", profile.t_accel_s());
    println!("cruises for     {:.3} s at {:.0} steps/s", profile.t_cruise_s(), profile.cruise_speed_steps_s());
    println!("decelerates for {:.3} s", profile.t_decel_s());

    // The closed form answers for any step. It needs floats and roots.
    println!("step 1000 leaves at {:.6} s", plan.step_time_s(0, 1_000));

    // Segments give the same instants by additions alone, in order. A segment holds many steps.
    let segments: Vec<_> = plan.segments(0, TICK_HZ).collect();
    let instants: Vec<u64> = segments.iter().flat_map(|segment| segment.ticks()).collect();
    println!("{} steps in {} segments; step 1000 leaves at {} us", instants.len(), segments.len(), instants[999]);
    assert_eq!(instants.len(), 2_000);
    assert!((instants[999] as f64 * 1e-6 - plan.step_time_s(0, 1_000)).abs() < 1e-6);
    Ok(())
}
