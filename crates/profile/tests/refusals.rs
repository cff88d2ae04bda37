//! Moves that cannot be planned are refused, and the error names the bound that it crosses.

use isostep_profile::{
    ACCEL_MAX_STEPS_S2, IntervalSplit, LimitError, Limits, PlanError, Profile, ProfileError, SPEED_MAX_STEPS_S,
    SPEED_MIN_STEPS_S, SpeedProfile, SyncMove,
};

const GOOD: Limits = Limits {
    start_speed_steps_s: 10.0,
    top_speed_steps_s: 100.0,
    accel_steps_s2: 50.0,
    decel_steps_s2: 50.0,
    jerk_steps_s3: f64::INFINITY,
};

fn refusal(limits: Limits) -> LimitError {
    limits.check().unwrap_err()
}

#[test]
fn limits_out_of_range() {
    let accel = |asked| LimitError::Accel { asked, max: ACCEL_MAX_STEPS_S2 };
    assert_eq!(refusal(Limits { accel_steps_s2: 0.0, ..GOOD }), accel(0.0));
    assert_eq!(refusal(Limits { accel_steps_s2: -1.0, ..GOOD }), accel(-1.0));
    assert_eq!(refusal(Limits { accel_steps_s2: f64::INFINITY, ..GOOD }), accel(f64::INFINITY));
    let decel = LimitError::Decel { asked: 2e9, max: ACCEL_MAX_STEPS_S2 };
    assert_eq!(refusal(Limits { decel_steps_s2: 2e9, ..GOOD }), decel);
    let start = LimitError::StartSpeed { asked: 101.0, max: 100.0 };
    assert_eq!(refusal(Limits { start_speed_steps_s: 101.0, ..GOOD }), start);
    let top = LimitError::TopSpeed { asked: 2e7, min: SPEED_MIN_STEPS_S, max: SPEED_MAX_STEPS_S };
    assert_eq!(refusal(Limits { top_speed_steps_s: 2e7, ..GOOD }), top);
    assert!(matches!(refusal(Limits { top_speed_steps_s: f64::NAN, ..GOOD }), LimitError::TopSpeed { .. }));
    assert!(matches!(refusal(Limits { start_speed_steps_s: f64::NAN, ..GOOD }), LimitError::StartSpeed { .. }));
}

#[test]
fn end_speeds_that_the_distance_does_not_allow() {
    let plan = |entry, exit| {
        Profile::plan(9.0, entry, exit, &GOOD, IntervalSplit::Fastest, SpeedProfile::Trapezoid).unwrap_err()
    };
    // Over 9 steps at 50 steps/s², a change between 0 and sqrt(2 * 50 * 9) = 30 steps/s is possible.
    assert_eq!(plan(31.0, 0.0), ProfileError::EntrySpeed { asked: 31.0, max: 30.0 });
    assert_eq!(plan(0.0, 31.0), ProfileError::ExitSpeed { asked: 31.0, max: 30.0 });
    assert!(matches!(plan(f64::NAN, 0.0), ProfileError::EntrySpeed { .. }));
    assert!(matches!(plan(-1.0, 0.0), ProfileError::EntrySpeed { .. }));
    // The entry speed is below the top speed, but three equal intervals would have to be shorter than the ramp.
    let thirds = Profile::plan(9.0, 29.0, 0.0, &GOOD, IntervalSplit::Thirds, SpeedProfile::Trapezoid).unwrap_err();
    assert!(matches!(thirds, ProfileError::EntrySpeed { asked: 29.0, max } if max < 29.0), "{thirds}");
}

#[test]
fn distances_that_are_no_distance() {
    for asked in [0.0, -1.0, f64::INFINITY] {
        let error = Profile::plan(asked, 0.0, 0.0, &GOOD, IntervalSplit::Fastest, SpeedProfile::Trapezoid).unwrap_err();
        assert_eq!(error, ProfileError::Distance { asked });
    }
}

#[test]
fn moves_that_are_no_move() {
    let plan = |steps, limits: &[Limits; 2], feed| {
        SyncMove::plan(steps, limits, IntervalSplit::Fastest, SpeedProfile::Trapezoid, feed)
    };
    assert_eq!(plan([0, 0], &[GOOD; 2], None), Err(PlanError::NoSteps));
    let bad = Limits { accel_steps_s2: 0.0, ..GOOD };
    let error = LimitError::Accel { asked: 0.0, max: ACCEL_MAX_STEPS_S2 };
    assert_eq!(plan([5, 1], &[GOOD, bad], None), Err(PlanError::Limits { axis: 1, error }));
    assert!(plan([5, 0], &[GOOD, bad], None).is_ok(), "an axis that does not move is not asked");
    assert!(matches!(plan([5, 1], &[GOOD; 2], Some(0.0)), Err(PlanError::PathSpeed { .. })));
    assert_eq!(plan([5, 1], &[GOOD; 2], Some(1e300)), plan([5, 1], &[GOOD; 2], None), "the most that is wanted");
    let slow = plan([i32::MIN, 0], &[GOOD; 2], Some(0.001));
    assert!(matches!(slow, Err(PlanError::Profile(ProfileError::TooLong { .. }))), "{slow:?}");
}
