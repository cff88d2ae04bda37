//! The generators of the literature: their equations worked out by hand, and how far they deviate from the closed form.

use core::f64::consts::TAU;

use isostep_generators::{Avr446, Correction, Float, GeneratorError, StepsPerTime, TimePerStep};
use isostep_profile::{IntervalSplit, LimitError, Limits, Profile, ProfileError, SpeedProfile};
use isostep_trials::cases;
use proptest::prelude::*;

const TICK_HZ: u32 = 1_000_000;

/// Stoychitch's motor: 4096 steps/rev, v_s = 0.5 rad/s, v_M = 2 rad/s, a = 2 rad/s², d = 1 rad/s².
fn stoychitch_2018() -> Limits {
    let steps_per_rad = 4096.0 / TAU;
    Limits {
        start_speed_steps_s: 0.5 * steps_per_rad,
        top_speed_steps_s: 2.0 * steps_per_rad,
        accel_steps_s2: 2.0 * steps_per_rad,
        decel_steps_s2: 1.0 * steps_per_rad,
        jerk_steps_s3: f64::INFINITY,
    }
}

fn from_rest(top_speed_steps_s: f64, accel_steps_s2: f64, decel_steps_s2: f64) -> Limits {
    Limits { start_speed_steps_s: 0.0, top_speed_steps_s, accel_steps_s2, decel_steps_s2, jerk_steps_s3: f64::INFINITY }
}

fn closed_form(steps: u32, limits: &Limits) -> Profile {
    let start = limits.start_speed_steps_s;
    Profile::plan(f64::from(steps), start, start, limits, IntervalSplit::Fastest, SpeedProfile::Trapezoid).unwrap()
}

/// The speed of each interval divided by the closed form's at step i, less 1: a counter of a time per step stands for
/// that speed.
fn errors_at_steps(intervals: &[u32], profile: &Profile) -> Vec<f64> {
    let speed_at = |steps: f64| profile.speed_at(profile.time_at(steps));
    let with_index = intervals.iter().zip(0..);
    with_index.map(|(&c, i)| f64::from(TICK_HZ) / f64::from(c) / speed_at(f64::from(i)) - 1.0).collect()
}

/// The speed of each interval divided by the closed form's mean speed from one step to the next, less 1. The first step
/// is at `first`.
fn errors_between_steps(intervals: &[u32], profile: &Profile, first: f64) -> Vec<f64> {
    let between = |x: f64| (profile.time_at(x + 1.0) - profile.time_at(x)) * f64::from(TICK_HZ);
    let with_index = intervals.iter().zip(0..);
    with_index.map(|(&c, i)| between(first + f64::from(i)) / f64::from(c) - 1.0).collect()
}

fn worst(errors: &[f64]) -> f64 {
    errors.iter().fold(0.0, |worst, error| f64::max(worst, error.abs()))
}

fn total_s(intervals: &[u32]) -> f64 {
    intervals.iter().map(|&ticks| u64::from(ticks)).sum::<u64>() as f64 / f64::from(TICK_HZ)
}

fn time_per_step<F: Float>(steps: u32, limits: &Limits, correction: Correction) -> Vec<u32> {
    TimePerStep::<F>::plan(steps, limits, correction, TICK_HZ).unwrap().collect()
}

fn steps_per_time(steps: u32, limits: &Limits, service_ticks: u32) -> Vec<u32> {
    StepsPerTime::plan(steps, limits, service_ticks, TICK_HZ).unwrap().collect()
}

fn avr446(steps: u32, limits: &Limits) -> Vec<u32> {
    Avr446::plan(steps, limits, TICK_HZ).unwrap().collect()
}

/// By hand, eq 13: c_0 = 1e6 / 325.949 = 3067.96, c_m = 1e6 / 1303.797 = 766.99. Eq 11, R_a = 1303.797e-12:
/// c_1 = 3067.96 / (1 + 0.0122718) = 3030.77, c_2 = 3030.77 / 1.0119761 = 2994.90. Step 612 (N_a = 611, N_v = 2263:
/// eq 8) cruises. Step 2875 is the first that eq 12 slows down, by R_d = -651.899e-12: its interval is 766.99 /
/// (1 - 3.83495e-4) = 767.28. Step 2881 is the seventh: about 766.99 / (1 - 7 * 3.835e-4) = 769.06.
#[test]
fn stoychitch_2018_recurrence_by_hand() {
    let intervals = time_per_step::<f64>(4096, &stoychitch_2018(), Correction::Without);
    assert_eq!(intervals.len(), 4095);
    assert_eq!(intervals[..3], [3068, 3031, 2995]);
    assert_eq!([intervals[612], intervals[2874], intervals[2875], intervals[2881]], [767, 767, 767, 769]);
}

/// Eq 14 by hand: c_1 = 3030.77 * 1.08 = 3273.23, c_5 = 2894.98 * 1.016 = 2941.30, and c_6 is not corrected. The
/// paper's own motor starts at a speed that needs no correction, so its errors are largest where it is corrected.
#[test]
fn stoychitch_2018_correction_by_hand() {
    let without = time_per_step::<f64>(4096, &stoychitch_2018(), Correction::Without);
    let with = time_per_step::<f64>(4096, &stoychitch_2018(), Correction::With);
    assert_eq!([with[0], with[1], with[5], with[6]], [3068, 3273, 2941, without[6]]);
    let corrected = |i: usize| (1..=5).contains(&i) || (1..=5).contains(&(4096 - i));
    for i in 0..with.len() {
        assert!(corrected(i) || with[i] == without[i], "step {i}");
    }
    let profile = closed_form(4096, &stoychitch_2018());
    assert!(worst(&errors_at_steps(&without, &profile)) < 0.007);
    assert!((0.07..0.08).contains(&worst(&errors_at_steps(&with, &profile))));
}

/// From sqrt(2 a), the speed that one step from rest reaches, v_1 is 1.5 times v_0, where the closed form has
/// sqrt(2): 6.1 % too fast, and 1.8 % too slow with eq 14. So near standstill the correction is useful, at both ends.
#[test]
fn stoychitch_2018_correction_helps_a_slow_start() {
    let limits = Limits { start_speed_steps_s: 2_000_f64.sqrt(), ..from_rest(2_000.0, 1_000.0, 1_000.0) };
    let profile = closed_form(6_000, &limits);
    let errors = |correction| errors_at_steps(&time_per_step::<f64>(6_000, &limits, correction), &profile);
    let (without, with) = (errors(Correction::Without), errors(Correction::With));
    assert!((without[1] - (1.5 / 2_f64.sqrt() - 1.0)).abs() < 1e-4);
    assert!((with[1] - (1.5 / 1.08 / 2_f64.sqrt() - 1.0)).abs() < 1e-4);
    // The deceleration begins ahead of the closed form and gets further ahead.
    assert!((0.22..0.23).contains(&worst(&without)) && (0.17..0.18).contains(&worst(&with)));
}

/// By hand, F = 10 kHz as in the paper's program: V_s = 0.0325949 and A = 1.303797e-5 steps/T_s². After k services the
/// position is V_s k + A k (k + 1)/2: 1 after 30.5 -> 31, 2 after 60.7 -> 61, 3 after 90.2 -> 91, 4 after 119.5 -> 120.
#[test]
fn stoychitch_2018_sums_by_hand() {
    let intervals = steps_per_time(4096, &stoychitch_2018(), 100);
    assert_eq!(intervals.len(), 4095);
    assert_eq!(intervals[..3], [3_000, 3_000, 2_900]);
    // In the cruise, 7.67 services a step.
    assert!(intervals[700..2_800].iter().all(|interval| [700, 800].contains(interval)));
    let profile = closed_form(4096, &stoychitch_2018());
    let exact_s = profile.time_at(4096.0) - profile.time_at(1.0);
    assert!((total_s(&intervals) - exact_s).abs() < 2e-4, "no drift: within two services");
}

/// By hand, f = 1 MHz, a = 200 steps/s²: c_0 = 0.676e6 * sqrt(0.01) = 67600; 135200/5 = 27040 rest 0: c_1 = 40560;
/// 81120/9 = 9013 rest 3: 31547; 63097/13 = 4853 rest 8: 26694; 53396/17 = 3140 rest 16: 23554.
/// The exact first interval is 1e6 * sqrt(2/200) = 100000: 48 % too fast; c_4 = 1e5 * (sqrt 5 - 2) = 23607: 0.2 %.
#[test]
fn avr446_by_hand() {
    let limits = from_rest(2_000.0, 200.0, 400.0);
    let intervals = avr446(20_000, &limits);
    assert_eq!(intervals.len(), 19_999);
    assert_eq!(intervals[..5], [67_600, 40_560, 31_547, 26_694, 23_554]);
    assert_eq!(intervals[10_100..14_900], [500; 4_800]);
    let errors = errors_between_steps(&intervals, &closed_form(20_000, &limits), 0.0);
    assert!((0.479..0.480).contains(&errors[0]) && (0.0022..0.0023).contains(&errors[4]));
    // One tick of 500 is 0.2 %, and a truncated interval passes its error on to the next.
    assert!(worst(&errors[5..19_900]) < 0.004);
}

#[test]
fn a_single_step_has_no_interval() {
    assert_eq!(time_per_step::<f32>(1, &stoychitch_2018(), Correction::With), []);
    assert_eq!(steps_per_time(1, &stoychitch_2018(), 100), []);
    assert_eq!(avr446(1, &from_rest(2_000.0, 200.0, 400.0)), []);
}

#[test]
fn what_cannot_be_generated_is_refused_with_its_limit() {
    let rest = from_rest(2_000.0, 200.0, 400.0);
    let moving = Limits { start_speed_steps_s: 100.0, ..rest };
    let plan = |steps, limits: &Limits, hz| TimePerStep::<f64>::plan(steps, limits, Correction::Without, hz).err();
    let no_steps = GeneratorError::Profile(ProfileError::Distance { asked: 0.0 });
    assert_eq!(plan(0, &moving, TICK_HZ), Some(no_steps));
    assert_eq!(StepsPerTime::plan(0, &moving, 100, TICK_HZ).err(), Some(no_steps));
    assert_eq!(Avr446::plan(0, &rest, TICK_HZ).err(), Some(no_steps));

    let no_accel = LimitError::Accel { asked: f64::INFINITY, max: isostep_profile::ACCEL_MAX_STEPS_S2 };
    let limits = Limits { accel_steps_s2: f64::INFINITY, ..moving };
    assert_eq!(plan(9, &limits, TICK_HZ), Some(GeneratorError::Profile(ProfileError::Limits(no_accel))));

    // sqrt(2 * 400) = 28.28.
    let too_slow = |error| matches!(error, Some(GeneratorError::StartSpeed { asked: 0.0, min, .. }) if min > 0.0);
    assert!(too_slow(plan(9, &rest, TICK_HZ)));
    assert!(plan(9, &Limits { start_speed_steps_s: 28.29, ..rest }, TICK_HZ).is_none());
    assert!(plan(9, &Limits { start_speed_steps_s: 28.28, ..rest }, TICK_HZ).is_some());
    assert!(too_slow(StepsPerTime::plan(9, &rest, 100, TICK_HZ).err()));
    let not_from_rest = GeneratorError::StartSpeed { asked: 100.0, min: 0.0, max: 0.0 };
    assert_eq!(Avr446::plan(9, &moving, TICK_HZ).err(), Some(not_from_rest));

    let too_fast = |max| Some(GeneratorError::TopSpeed { asked: 2_000.0, max });
    assert_eq!(plan(9, &moving, 1_999), too_fast(1_999.0));
    assert_eq!(Avr446::plan(9, &rest, 0).err(), too_fast(0.0));
    assert_eq!(StepsPerTime::plan(9, &moving, 1_000, TICK_HZ).err(), too_fast(1_000.0));
    assert_eq!(StepsPerTime::plan(9, &moving, 0, TICK_HZ).err(), too_fast(0.0));

    let too_many = GeneratorError::Steps { asked: 1 << 29, max: 1 << 28 };
    assert_eq!(Avr446::plan(1 << 29, &rest, TICK_HZ).err(), Some(too_many));
    let slow = from_rest(2_000.0, 200.0, 1e-6);
    assert!(
        matches!(Avr446::plan(9, &slow, TICK_HZ).err(), Some(GeneratorError::Accel { asked: 1e-6, min }) if min > 3e-6)
    );
}

prop_compose! {
    fn moves()(
        steps in 1..3_000_u32,
        top in 50.0..200_000.0,
        accel in 10.0..5e6,
        decel in 10.0..5e6,
    ) -> (u32, Limits) {
        (steps, from_rest(top, accel, decel))
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(200, 2_000), failure_persistence: None, ..ProptestConfig::default() })]

    /// For every move, a generator ends with the steps it was asked for, and no interval is zero or too long.
    #[test]
    fn every_generator_gives_every_interval((steps, rest) in moves(), start in 0.0..1.0, service_ticks in 1..5_u32) {
        let slowest = (2.0 * rest.accel_steps_s2.max(rest.decel_steps_s2)).sqrt();
        let start = slowest + start * (rest.top_speed_steps_s - slowest).max(0.0);
        let moving = Limits { start_speed_steps_s: start, ..rest };
        let all = |intervals: Vec<u32>, most: f64| {
            prop_assert_eq!(intervals.len(), steps as usize - 1);
            let within = |&interval: &u32| interval > 0 && f64::from(interval) <= most;
            prop_assert!(intervals.iter().all(within), "{:?} outside 1 to {}", intervals, most);
            Ok(())
        };
        let exact = f64::from(TICK_HZ) * (2.0 / rest.accel_steps_s2.min(rest.decel_steps_s2)).sqrt();
        // The note counts a whole step where the top speed takes less than one, and may then slow down over all others:
        // n steps from the top speed end at an interval of sqrt(n) of its own.
        let is_at_once = rest.top_speed_steps_s.powi(2) < 4.0 * rest.accel_steps_s2;
        let slowing = if is_at_once { f64::from(steps).sqrt() } else { 1.0 };
        all(avr446(steps, &rest), 2.0 * exact.max(slowing * f64::from(TICK_HZ) / rest.top_speed_steps_s) + 2.0)?;
        prop_assume!(start <= rest.top_speed_steps_s);
        let first = f64::from(TICK_HZ) / start;
        let longest = 2.0 * first + 1.0;
        for correction in [Correction::Without, Correction::With] {
            all(time_per_step::<f64>(steps, &moving, correction), longest)?;
            all(time_per_step::<f32>(steps, &moving, correction), longest)?;
        }
        all(steps_per_time(steps, &moving, service_ticks), first + 2.0 * f64::from(service_ticks))?;
    }
}
