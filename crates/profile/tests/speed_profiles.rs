//! Every speed profile, compared with numbers worked out by hand, with quadrature, and with its own derivatives.

use core::f64::consts::{FRAC_PI_2, PI};

use isostep_profile::{IntervalSplit, Limits, Profile, SpeedProfile, SyncMove};

const START: f64 = 100.0;
const TOP: f64 = 500.0;
const ACCEL: f64 = 2_000.0;
/// Half of the acceleration, so that the decelerating ramp of most speed profiles takes twice as long.
const DECEL: f64 = 1_000.0;
const JERK: f64 = 20_000.0;
/// K of the logarithmic speed profile: ln(1 + 23 u)/ln 24.
const LOGARITHMIC: f64 = 23.0;

const LIMITS: Limits = Limits {
    start_speed_steps_s: START,
    top_speed_steps_s: TOP,
    accel_steps_s2: ACCEL,
    decel_steps_s2: DECEL,
    jerk_steps_s3: JERK,
};

const OVER_DISPLACEMENT: [SpeedProfile; 4] =
    [SpeedProfile::Linear, SpeedProfile::Quadratic, SpeedProfile::Sinusoidal, SpeedProfile::Logarithmic];

fn plan(distance_steps: f64, entry: f64, exit: f64, limits: &Limits, speed_profile: SpeedProfile) -> Profile {
    Profile::plan(distance_steps, entry, exit, limits, IntervalSplit::Fastest, speed_profile).unwrap()
}

/// A move that is long enough to cruise.
fn long(speed_profile: SpeedProfile) -> Profile {
    plan(10_000.0, START, START, &LIMITS, speed_profile)
}

fn close(name: &str, got: f64, wanted: f64, tolerance: f64) {
    assert!((got - wanted).abs() <= tolerance, "{name}: {got} is not {wanted} within {tolerance}");
}

/// By hand, from 100 to 500 steps/s at 2,000 steps/s² at most; L is the ramp's length, v its speed.
///
/// - Trapezoid: t = 400/2000 = 0.2 s; L = 300 * 0.2 = 60.
/// - S-curve: t = 400/2000 + 2000/20000 = 0.3 s; L = 300 * 0.3 = 90.
/// - Sine: t = pi/2 * 400/2000 = 0.3141593 s; L = 300 t = 94.24778.
/// - Linear: a = v 400/L is most at the end: L = 500 * 400/2000 = 100; t = 100/400 ln 5 = 0.4023595 s.
/// - Quadratic: a = v 800 u/L, most at the end: L = 200; t = 200/sqrt(100 * 400) atan 2 = 1.1071487 s.
/// - Sinusoidal: a = (300 - 200 c) sqrt(1 - c²) 200 pi/L with c = cos pi u is most where 400 c² - 300 c - 200 = 0:
///   c = -0.4253905, 385.07811 * 0.9050099 = 348.49949, L = 348.49949 * 200 pi/2000 = 109.484345;
///   t = L/sqrt(300² - 200²) = 0.4896289 s.
/// - Logarithmic: with s = ln(1 + 23 u) and q = ln(24)/4 = 0.7945135, a = 400²/L 23/ln² 24 (q + s) exp(-s) is most
///   where s = 1 - q: L = 80 * 23/10.100026 * exp(-0.2054865) = 148.338422; its time is left to the quadrature.
#[test]
fn ramps_by_hand() {
    let by_hand = [
        (SpeedProfile::Trapezoid, 60.0, Some(0.2)),
        (SpeedProfile::SCurve, 90.0, Some(0.3)),
        (SpeedProfile::Sine, 94.247_779_6, Some(0.314_159_265_4)),
        (SpeedProfile::Linear, 100.0, Some(0.402_359_478_1)),
        (SpeedProfile::Quadratic, 200.0, Some(1.107_148_717_8)),
        (SpeedProfile::Sinusoidal, 109.484_344_9, Some(0.489_628_875_1)),
        (SpeedProfile::Logarithmic, 148.338_421_5, None),
    ];
    assert_eq!(by_hand.map(|(speed_profile, ..)| speed_profile), SpeedProfile::ALL);
    for (speed_profile, steps, duration_s) in by_hand {
        let profile = long(speed_profile);
        assert_eq!(profile.cruise_speed_steps_s(), TOP, "{speed_profile}");
        close(speed_profile.name(), profile.accel_end_steps(), steps, 1e-6);
        if let Some(duration_s) = duration_s {
            close(speed_profile.name(), profile.t_accel_s(), duration_s, 1e-9);
        }
    }
}

/// At half of the acceleration a ramp takes twice as long; that of the S-curve takes 400/1000 + 1000/20000 = 0.45 s.
#[test]
fn the_decelerating_ramp_has_its_own_limit() {
    for speed_profile in SpeedProfile::ALL {
        let profile = long(speed_profile);
        let wanted_s = if speed_profile == SpeedProfile::SCurve { 0.45 } else { 2.0 * profile.t_accel_s() };
        close(speed_profile.name(), profile.t_decel_s(), wanted_s, 1e-12);
        let steps = profile.distance_steps() - profile.cruise_end_steps();
        close(speed_profile.name(), steps / profile.accel_end_steps(), wanted_s / profile.t_accel_s(), 1e-12);
    }
}

/// By hand: 300 steps/s where the speed profile is symmetrical; 100 + 400/4 = 200; 100 + 400 ln(12.5)/ln(24) = 417.8962697.
#[test]
fn speeds_midway_by_hand() {
    for speed_profile in [SpeedProfile::Trapezoid, SpeedProfile::SCurve, SpeedProfile::Sine] {
        let profile = long(speed_profile);
        close(speed_profile.name(), profile.speed_at(profile.t_accel_s() / 2.0), 300.0, 1e-9);
    }
    let midway = [300.0, 200.0, 300.0, 417.896_269_7];
    for (speed_profile, wanted) in OVER_DISPLACEMENT.into_iter().zip(midway) {
        let profile = long(speed_profile);
        let t_s = profile.time_at(profile.accel_end_steps() / 2.0);
        close(speed_profile.name(), profile.speed_at(t_s), wanted, 1e-7);
    }
}

/// By hand, both ramps at 2,000 steps/s² from 100 to 300 steps/s and back: linear 2 * 300 * 200/2000 = 60 steps,
/// quadratic twice that, sine 2 * 200 * pi/2 * 200/2000 = 20 pi; S-curve 2 * 200 (200/2000 + 2000/20000) = 80.
#[test]
fn short_moves_peak_where_the_ramps_meet() {
    let limits = Limits { decel_steps_s2: ACCEL, ..LIMITS };
    let by_hand = [
        (SpeedProfile::Trapezoid, 40.0),
        (SpeedProfile::SCurve, 80.0),
        (SpeedProfile::Sine, 20.0 * PI),
        (SpeedProfile::Linear, 60.0),
        (SpeedProfile::Quadratic, 120.0),
    ];
    for (speed_profile, steps) in by_hand {
        let profile = plan(steps, START, START, &limits, speed_profile);
        close(speed_profile.name(), profile.cruise_speed_steps_s(), 300.0, 1e-8);
        close(speed_profile.name(), profile.accel_end_steps(), steps / 2.0, 1e-8);
    }
}

/// By hand: the acceleration would be reached at a rise of 2000²/5000 = 800 steps/s, but the rise is 400. So the
/// duration is 2 sqrt(400/5000) = 0.5656854 s, and the acceleration is sqrt(5000 * 400) = 1414.2136 steps/s² at most.
#[test]
fn an_s_curve_that_does_not_reach_its_acceleration() {
    let limits = Limits { jerk_steps_s3: 5_000.0, ..LIMITS };
    let profile = plan(10_000.0, START, START, &limits, SpeedProfile::SCurve);
    close("duration", profile.t_accel_s(), 0.565_685_424_9, 1e-9);
    close("acceleration", profile.accel_at(profile.t_accel_s() / 2.0), 1_414.213_562_4, 1e-6);
}

#[test]
fn times_over_displacement_are_the_quadrature_of_its_speed() {
    for speed_profile in OVER_DISPLACEMENT {
        // From almost standstill to almost no rise.
        for start in [0.5, 10.0, START, 300.0, 499.9] {
            let limits = Limits { start_speed_steps_s: start, ..LIMITS };
            let profile = plan(10_000.0, start, start, &limits, speed_profile);
            let length = profile.accel_end_steps();
            for ratio in [0.01, 0.3, 1.0] {
                let slowness = |u: f64| length / (start + (TOP - start) * speed(speed_profile, u));
                let wanted_s = integral(slowness, ratio);
                let got_s = profile.time_at(length * ratio);
                assert!(
                    (got_s / wanted_s - 1.0).abs() < 1e-9,
                    "{speed_profile} from {start} to {ratio}: {got_s} for {wanted_s} s"
                );
            }
        }
    }
}

/// The speed profiles in a unit square (Fonseca-Campos 2023, eqs 5-8).
fn speed(speed_profile: SpeedProfile, u: f64) -> f64 {
    match speed_profile {
        SpeedProfile::Linear => u,
        SpeedProfile::Quadratic => u * u,
        SpeedProfile::Sinusoidal => (1.0 - (PI * u).cos()) / 2.0,
        SpeedProfile::Logarithmic => (1.0 + LOGARITHMIC * u).ln() / (1.0 + LOGARITHMIC).ln(),
        _ => unreachable!("{speed_profile} is over time"),
    }
}

/// The integral from 0 to `end`, by Simpson's rule over the fourth root, because the function is steep where the ramp
/// is slow.
fn integral(function: impl Fn(f64) -> f64, end: f64) -> f64 {
    const INTERVALS: u32 = 200_000;
    let width = end.sqrt().sqrt() / f64::from(INTERVALS);
    let over_root = |root: f64| 4.0 * root.powi(3) * function(root.powi(4));
    let weight = |i: u32| match i {
        0 | INTERVALS => 1.0,
        _ if i % 2 == 1 => 4.0,
        _ => 2.0,
    };
    width / 3.0 * (0..=INTERVALS).map(|i| weight(i) * over_root(f64::from(i) * width)).sum::<f64>()
}

#[test]
fn the_peak_acceleration_is_the_limit() {
    for speed_profile in SpeedProfile::ALL {
        for start in [0.5, START, 300.0] {
            let profile = plan(10_000.0, start, start, &LIMITS, speed_profile);
            let [up, down] = peaks(&profile);
            assert!((up / ACCEL - 1.0).abs() < 1e-9, "{speed_profile} from {start}: {up}");
            assert!((down / DECEL - 1.0).abs() < 1e-9, "{speed_profile} to {start}: {down}");
        }
    }
}

/// The largest acceleration and deceleration, found by a search over the displacement.
fn peaks(profile: &Profile) -> [f64; 2] {
    let accel_at = |steps: f64| profile.accel_at(profile.time_at(steps));
    let decel_steps = profile.distance_steps() - profile.cruise_end_steps();
    let up = highest(|ratio| accel_at(profile.accel_end_steps() * ratio));
    let down = highest(|ratio| -accel_at(profile.distance_steps() - decel_steps * ratio));
    [up, down]
}

/// The maximum, between 0 and almost 1, of a function that rises and then falls: by ternary search.
fn highest(function: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0 - 1e-12);
    for _ in 0..60 {
        let third = (high - low) / 3.0;
        if function(low + third) < function(high - third) { low += third } else { high -= third }
    }
    function(low)
}

/// The instants are away from corners. The S-curve has corners at a third of its accelerating ramp (0.1 of 0.3 s) and
/// at a ninth of its decelerating ramp (0.05 of 0.45 s).
#[test]
fn each_derivative_is_the_difference_of_what_it_derives_from() {
    let ratios = [0.02, 0.2, 0.4, 0.5, 0.62, 0.8, 0.97];
    for speed_profile in SpeedProfile::ALL {
        let profile = long(speed_profile);
        let decel_start_s = profile.duration_s() - profile.t_decel_s();
        let accelerating = ratios.map(|ratio| ratio * profile.t_accel_s());
        let decelerating = ratios.map(|ratio| decel_start_s + ratio * profile.t_decel_s());
        for t_s in accelerating.into_iter().chain(decelerating) {
            let derivative = |function: fn(&Profile, f64) -> f64| five_points(|t_s| function(&profile, t_s), t_s);
            close(speed_profile.name(), derivative(Profile::position_at), profile.speed_at(t_s), 1e-6);
            close(speed_profile.name(), derivative(Profile::speed_at), profile.accel_at(t_s), 1e-5);
            close(speed_profile.name(), derivative(Profile::accel_at), profile.jerk_at(t_s), 1e-2);
        }
    }
}

/// The derivative of a function, with an error of the fifth derivative times h⁴/30.
fn five_points(function: impl Fn(f64) -> f64, t: f64) -> f64 {
    const H: f64 = 1e-4;
    let odd = |h: f64| function(t + h) - function(t - h);
    (8.0 * odd(H) - odd(2.0 * H)) / (12.0 * H)
}

/// By hand, for a rise of 400 steps/s at 2,000 steps/s². S-curve: ±20,000, and 0 in its middle third. Sine: 400/2
/// (pi/t)² at the start with t = pi/10 s: 20,000 steps/s³. Linear: a = 4 v, so j = 16 v: 1,600 at the start.
#[test]
fn jerks_by_hand() {
    let s_curve = long(SpeedProfile::SCurve);
    let middles = [0.05, 0.15, 0.25].map(|t_s| s_curve.jerk_at(t_s));
    for (got, wanted) in middles.into_iter().zip([JERK, 0.0, -JERK]) {
        close("s-curve", got, wanted, 1e-6);
    }
    close("sine", long(SpeedProfile::Sine).jerk_at(0.0), 20_000.0, 1e-6);
    close("sine midway", long(SpeedProfile::Sine).jerk_at(PI / 20.0), 0.0, 1e-6);
    close("linear", long(SpeedProfile::Linear).jerk_at(0.0), 1_600.0, 1e-6);
    assert_eq!(long(SpeedProfile::Trapezoid).jerk_at(0.1), 0.0);
}

/// From rest, the trapezoid takes t = 500/2000 s. The sine takes pi/2 times as long, the S-curve 2000/20000 s longer.
#[test]
fn speed_profiles_over_time_start_from_rest() {
    let by_hand =
        [(SpeedProfile::Trapezoid, 0.25), (SpeedProfile::SCurve, 0.35), (SpeedProfile::Sine, FRAC_PI_2 * 0.25)];
    for (speed_profile, duration_s) in by_hand {
        close(speed_profile.name(), plan(10_000.0, 0.0, 0.0, &LIMITS, speed_profile).t_accel_s(), duration_s, 1e-12);
    }
}

#[test]
fn speed_profiles_over_displacement_never_leave_standstill() {
    for speed_profile in OVER_DISPLACEMENT {
        for (entry, exit) in [(0.0, 0.0), (0.0, START), (START, 0.0)] {
            let plan = Profile::plan(10_000.0, entry, exit, &LIMITS, IntervalSplit::Fastest, speed_profile);
            let wanted = format!(
                "the {speed_profile} speed profile cannot start or end at 0 steps/s, it never leaves standstill: set a start speed of at least \
                 0.0005 steps/s, or take another speed profile"
            );
            assert_eq!(plan.unwrap_err().to_string(), wanted);
        }
        let slowest = plan(10_000.0, 5e-4, 5e-4, &LIMITS, speed_profile);
        assert!(slowest.t_accel_s() > 0.0 && slowest.t_accel_s().is_finite());
    }
}

/// A move that enters and leaves at the top speed has no ramp, and no acceleration even at its ends.
#[test]
fn without_ramps_there_is_no_acceleration() {
    let limits = Limits {
        start_speed_steps_s: 100.0,
        top_speed_steps_s: 100.0,
        accel_steps_s2: 50.0,
        decel_steps_s2: 50.0,
        jerk_steps_s3: 10.0,
    };
    for speed_profile in SpeedProfile::ALL {
        let profile = Profile::plan(1_000.0, 100.0, 100.0, &limits, IntervalSplit::Fastest, speed_profile).unwrap();
        assert_eq!(profile.duration_s(), 10.0, "{speed_profile}");
        for t_s in [0.0, 5.0, 10.0] {
            assert_eq!(
                (profile.speed_at(t_s), profile.accel_at(t_s), profile.jerk_at(t_s)),
                (100.0, 0.0, 0.0),
                "{speed_profile}"
            );
        }
    }
}

/// Thirds must not use a top speed that is just above what their accelerations allow.
#[test]
fn thirds_keep_to_their_accelerations_whatever_the_top_speed() {
    let limits = Limits {
        start_speed_steps_s: 50.0,
        top_speed_steps_s: 2_400.0,
        accel_steps_s2: 8_000.0,
        decel_steps_s2: 1_750.0,
        jerk_steps_s3: 100_000.0,
    };
    for speed_profile in SpeedProfile::ALL {
        for top in (100..1_200).step_by(3) {
            let limits = Limits { top_speed_steps_s: f64::from(top), ..limits };
            let plan = SyncMove::plan([179], &[limits], IntervalSplit::Thirds, speed_profile, None).unwrap();
            let (profile, instants) = (plan.profile, 1_000);
            let accels = (0..instants)
                .map(|k| profile.accel_at(profile.duration_s() * (f64::from(k) + 0.5) / f64::from(instants)));
            let (least, most) = accels.fold((0.0, 0.0), |(least, most): (f64, f64), a| (least.min(a), most.max(a)));
            assert!(least >= -1_750.0 * (1.0 + 1e-9), "{speed_profile}, {top} steps/s: {least} steps/s²");
            assert!(most <= 8_000.0 * (1.0 + 1e-9), "{speed_profile}, {top} steps/s: {most} steps/s²");
        }
    }
}
