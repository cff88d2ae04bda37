//! Segments against the closed form, at both ports' tick rates and at the ends of every range.

use isostep_profile::{IntervalLaw, Limits, Segment, SyncMove, fit_error_max_ticks};
use proptest::prelude::*;

const RATES_HZ: [u32; 2] = [1_000_000, 125_000_000];

/// Rounding to the nearest tick, the fit, and what fixed point loses.
fn error_max_ticks(tick_hz: u32) -> f64 {
    0.5 + fit_error_max_ticks(tick_hz) + 0.02
}

/// What 64-bit floats lose on the way to the closed form's instant: a few roundings of it, and one of the displacement.
fn float_error_ticks(plan: &SyncMove<2>, tick_hz: u32, exact_s: f64) -> f64 {
    let displacement_s = plan.profile.distance_steps() / plan.profile.speed_at(exact_s);
    (8.0 * plan.profile.duration_s() + 2.0 * displacement_s) * f64::EPSILON * f64::from(tick_hz)
}

fn log(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from.ln()..to.ln()).prop_map(f64::exp)
}

fn law() -> impl Strategy<Value = IntervalLaw> {
    prop_oneof![Just(IntervalLaw::Fastest), Just(IntervalLaw::Thirds)]
}

/// A share of the top speed that is 0, anything, almost 1 or 1.
fn start_share() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), 0.0..1.0, log(1e-17, 1e-3).prop_map(|less| 1.0 - less), Just(1.0)]
}

prop_compose! {
    fn limits(top: (f64, f64), accel: (f64, f64))
        (top in log(top.0, top.1), accel in log(accel.0, accel.1), decel in log(accel.0, accel.1), share in start_share())
        -> Limits {
        Limits { start_speed_steps_s: top * share, top_speed_steps_s: top, accel_steps_s2: accel, decel_steps_s2: decel }
    }
}

fn check_step(plan: &SyncMove<2>, axis: usize, tick_hz: u32, k: u32, tick: u64) -> Result<(), TestCaseError> {
    let exact_s = plan.step_time_s(axis, k);
    let exact = exact_s * f64::from(tick_hz);
    let error = tick as f64 - exact;
    let bound = error_max_ticks(tick_hz) + float_error_ticks(plan, tick_hz, exact_s);
    prop_assert!(error.abs() <= bound, "axis {axis} step {k} at {tick_hz} Hz: {tick} for {exact}, off by {error}");
    Ok(())
}

/// The first steps of a segment, `most` at most, and its last.
fn check_segment(
    plan: &SyncMove<2>,
    axis: usize,
    tick_hz: u32,
    first: u32,
    segment: Segment,
    most: usize,
) -> Result<(), TestCaseError> {
    for (k, tick) in (first..).zip(segment.ticks().take(most)) {
        check_step(plan, axis, tick_hz, k, tick)?;
    }
    check_step(plan, axis, tick_hz, first + (segment.steps() - 1), segment.last_ticks())
}

/// All segments of an axis: in order, complete, each step where it belongs.
fn check_axis(plan: &SyncMove<2>, axis: usize, tick_hz: u32) -> Result<(), TestCaseError> {
    let mut done = 0;
    let mut last = None;
    for (index, segment) in plan.segments(axis, tick_hz).enumerate() {
        // Of long moves, a sample.
        let most = if index < 200 || index % 64 == 0 { 500 } else { 2 };
        check_segment(plan, axis, tick_hz, done + 1, segment, most)?;
        prop_assert!(last <= Some(segment.first_ticks()), "axis {axis} after {done} at {tick_hz} Hz: {last:?}");
        last = Some(segment.last_ticks());
        done += segment.steps();
    }
    prop_assert_eq!(done, plan.steps[axis].unsigned_abs());
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 10_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_moves(
        limits in limits((1e2, 2e6), (1e2, 1e8)), steps in 1..4_000i32, other in -4_000..4_000i32, law in law(),
    ) {
        let plan = SyncMove::plan([steps, other], &[limits; 2], law, None).unwrap();
        for tick_hz in RATES_HZ {
            check_axis(&plan, 0, tick_hz)?;
            check_axis(&plan, 1, tick_hz)?;
        }
    }

    #[test]
    fn extreme_moves(
        limits in limits((1e-3, 1e7), (1e-9, 1e9)), steps in log(1.0, 2e9), share in log(1e-9, 1.0), law in law(),
    ) {
        let steps = [steps as i32, -(steps * share) as i32];
        let Ok(plan) = SyncMove::plan(steps, &[limits; 2], law, None) else { return Ok(()) };
        for tick_hz in RATES_HZ {
            check_axis(&plan, 0, tick_hz)?;
            check_axis(&plan, 1, tick_hz)?;
        }
    }
}
