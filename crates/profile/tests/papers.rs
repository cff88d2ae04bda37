//! The papers' own examples, compared with numbers worked out by hand.

use core::f64::consts::TAU;

use isostep_profile::{IntervalSplit, Limits, Profile, SpeedProfile, StepCounts, SyncMove};

fn close(got: f64, wanted: f64, tolerance: f64) {
    assert!((got - wanted).abs() <= tolerance, "{got} is not {wanted} within {tolerance}");
}

/// Stoychitch's motor, in the units of its footnote: 1 step/s = 2 pi / K rad/s.
fn stoychitch_2018_limits(steps_per_rad: f64) -> Limits {
    Limits {
        start_speed_steps_s: 0.5 * steps_per_rad,
        top_speed_steps_s: 2.0 * steps_per_rad,
        accel_steps_s2: 2.0 * steps_per_rad,
        decel_steps_s2: 1.0 * steps_per_rad, // m = a/d = 2
        jerk_steps_s3: f64::INFINITY,
    }
}

/// Stoychitch 2018, appendix: K = 4096 steps/rev, one revolution, v_s = 0.5 rad/s, v_M = 2 rad/s, a_M = 2 rad/s², m =
/// 2.
///
/// By hand, eq 4: T = -0.75 + sqrt(0.5625 + 6 pi) = 3.656 s, t_a = 1.219 s, v = 2.937 rad/s > v_M: a trapezoid.
/// t_a = 1.5/2 = 0.75 s, t_d = m t_a = 1.5 s; eq 6: s_ad = 0.5 * 2.25 + 2 * 2.25²/6 = 2.8125 rad;
/// eq 7: t_v = (2 pi - 2.8125)/2 = 1.735343 s, T = 3.985343 s;
/// eq 8: N_ad = 2.8125 * 4096/(2 pi) = 1833.46, N_a = 1833.46/3 = 611.15, N_v = 4096 - 1833.46 = 2262.54.
#[test]
fn stoychitch_2018_revolution_is_a_trapezoid() {
    let limits = stoychitch_2018_limits(4096.0 / TAU);
    let start = limits.start_speed_steps_s;
    let plan = Profile::plan(4096.0, start, start, &limits, IntervalSplit::Fastest, SpeedProfile::Trapezoid).unwrap();
    close(plan.t_accel_s(), 0.75, 1e-12);
    close(plan.t_cruise_s(), 1.735_342_653_6, 1e-9);
    close(plan.t_decel_s(), 1.5, 1e-12);
    close(plan.duration_s(), 3.985_342_653_6, 1e-9);
    close(plan.accel_end_steps(), 611.154, 1e-3);
    close(plan.cruise_end_steps(), 2873.691, 1e-3);
    assert_eq!(plan.step_counts(), StepCounts { accel: 611, cruise: 2263, decel: 1222 });
}

/// The same motor over half a radian (326 steps): a triangle.
///
/// By hand, eq 4 with s = 326 * 2 pi/4096 = 0.500078 rad: T = -0.75 + sqrt(0.5625 + 3 s) = 0.686222 s;
/// t_a = T/3 = 0.228741 s, t_d = 0.457481 s, v = 0.5 + 2 t_a = 0.957481 rad/s; eq 5: N_a = 326/3 = 108.67 -> 109.
#[test]
fn stoychitch_2018_half_a_radian_is_a_triangle() {
    let steps_per_rad = 4096.0 / TAU;
    let limits = stoychitch_2018_limits(steps_per_rad);
    let start = limits.start_speed_steps_s;
    let plan = Profile::plan(326.0, start, start, &limits, IntervalSplit::Fastest, SpeedProfile::Trapezoid).unwrap();
    close(plan.duration_s(), 0.686_222, 1e-6);
    close(plan.t_accel_s(), 0.228_741, 1e-6);
    close(plan.t_decel_s(), 0.457_481, 1e-6);
    assert_eq!(plan.t_cruise_s(), 0.0);
    close(plan.cruise_speed_steps_s() / steps_per_rad, 0.957_481, 1e-6);
    assert_eq!(plan.step_counts(), StepCounts { accel: 109, cruise: 0, decel: 217 });
}

/// Forero 2023, eqs 1-7: 20,000 steps, t1 = 4.5 s, so V_c = 20000/9 = 2,222.2 steps/s, below f_max = 2,400 steps/s, and
/// a = V_c/t1 = 493.827 steps/s². The paper's staircase measured 4.5 / 4.725 / 6.8 s (its Table 1).
#[test]
fn forero_2023_has_three_equal_intervals_and_loses_no_step() {
    let limit = |top, accel| Limits {
        start_speed_steps_s: 0.0,
        top_speed_steps_s: top,
        accel_steps_s2: accel,
        decel_steps_s2: accel,
        jerk_steps_s3: f64::INFINITY,
    };
    let x = limit(2_400.0, 20_000.0 / (2.0 * 4.5 * 4.5));
    let plan =
        SyncMove::plan([20_000, 7_500, 0], &[x; 3], IntervalSplit::Thirds, SpeedProfile::Trapezoid, None).unwrap();
    close(plan.profile.t_accel_s(), 4.5, 1e-9);
    close(plan.profile.t_cruise_s(), 4.5, 1e-9);
    close(plan.profile.t_decel_s(), 4.5, 1e-9);
    close(plan.profile.cruise_speed_steps_s(), 20_000.0 / 9.0, 1e-6);
    assert_eq!(plan.profile.step_counts(), StepCounts { accel: 5_000, cruise: 10_000, decel: 5_000 });
    for (axis, steps) in [(0, 20_000), (1, 7_500), (2, 0)] {
        let ticks = plan.segments(axis, 1_000_000).flat_map(|segment| segment.ticks());
        assert_eq!(ticks.count(), steps);
    }
}

/// Forero 2023, eq 5: at f_max itself the shortest t1 is 20000/(2 * 2400) = 4.1667 s, if the acceleration is high
/// enough.
#[test]
fn forero_2023_shortest_interval_is_bound_by_the_top_speed() {
    let limits = Limits {
        start_speed_steps_s: 0.0,
        top_speed_steps_s: 2_400.0,
        accel_steps_s2: 1e4,
        decel_steps_s2: 1e4,
        jerk_steps_s3: f64::INFINITY,
    };
    let plan = Profile::plan(20_000.0, 0.0, 0.0, &limits, IntervalSplit::Thirds, SpeedProfile::Trapezoid).unwrap();
    close(plan.t_accel_s(), 25.0 / 6.0, 1e-9);
    close(plan.duration_s(), 12.5, 1e-9);
}
