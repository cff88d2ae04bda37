//! Random moves and limits: 10,000 cases for each property. Every run tries the same cases. A failure prints the
//! smallest case, and the same command fails again;
//! `PROPTEST_RNG_SEED=n cargo test -p isostep-profile properties::` tries others.

use std::sync::atomic::{AtomicU32, Ordering};

use isostep_profile::{FIT_ERROR_MAX_TICKS, IntervalSplit, Intervals, Limits, Profile, SpeedProfile, SyncMove};
use isostep_trials::cases;
use proptest::prelude::*;

const TICK_HZ: u32 = 1_000_000;

/// The error of an instant: rounding to the nearest tick, the error of the fit, and what 64-bit floats lose.
const EDGE_ERROR_MAX_TICKS: f64 = 0.5 + FIT_ERROR_MAX_TICKS + 0.01;

fn limits() -> impl Strategy<Value = Limits> {
    // Speeds are up to 200,000 steps/s, five ticks a step. The start speed is a fraction of the top speed. The ramp to
    // the top speed is jerk alone, or hardly any of it is, or there is no limit of the jerk.
    let log = |from: f64, to: f64| (from.ln()..to.ln()).prop_map(f64::exp);
    let jerk = prop_oneof![4 => log(0.01, 1e3), 1 => Just(f64::INFINITY)];
    let start = prop_oneof![Just(0.0), 0.0..1.0];
    (log(50.0, 200_000.0), log(10.0, 5e6), log(10.0, 5e6), start, jerk).prop_map(|(top, accel, decel, start, jerk)| {
        Limits {
            start_speed_steps_s: top * start,
            top_speed_steps_s: top,
            accel_steps_s2: accel,
            decel_steps_s2: decel,
            jerk_steps_s3: jerk * accel * decel / top,
        }
    })
}

fn interval_split() -> impl Strategy<Value = IntervalSplit> {
    prop_oneof![Just(IntervalSplit::Fastest), Just(IntervalSplit::Thirds)]
}

fn speed_profile() -> impl Strategy<Value = SpeedProfile> {
    prop::sample::select(&SpeedProfile::ALL[..])
}

/// The same limits, with a start speed from which the speed profile can start.
fn moving(speed_profile: SpeedProfile, limits: Limits) -> Limits {
    let least = if speed_profile.is_over_displacement() { 1e-3 * limits.top_speed_steps_s } else { 0.0 };
    Limits { start_speed_steps_s: limits.start_speed_steps_s.max(least), ..limits }
}

fn count() -> impl Strategy<Value = i32> {
    prop_oneof![1 => Just(0), 1 => Just(1), 2 => -3..=3i32, 6 => -3_000..=3_000i32]
}

prop_compose! {
    fn moves()(
        steps in [count(), count(), count()], limits in [limits(), limits(), limits()],
        interval_split in interval_split(), speed_profile in speed_profile(),
    ) -> ([i32; 3], [Limits; 3], IntervalSplit, SpeedProfile) {
        (steps, limits.map(|own| moving(speed_profile, own)), interval_split, speed_profile)
    }
}

/// The words that `fill` writes, `piece` words at a time, less the bias.
fn filled(mut intervals: Intervals, piece: usize, bias: u32) -> Vec<u32> {
    let words: Vec<AtomicU32> = (0..piece).map(|_| AtomicU32::new(0)).collect();
    let mut all = Vec::new();
    loop {
        let count = intervals.fill(&words, bias);
        all.extend(words[..count].iter().map(|word| word.load(Ordering::Relaxed).wrapping_sub(bias)));
        if count < piece {
            return all;
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(1_000, 10_000), failure_persistence: None, ..ProptestConfig::default() })]

    /// Every axis makes exactly its steps, at rising instants. Each instant is within the stated error of the closed
    /// form, and none is outside the move.
    #[test]
    fn every_edge_is_the_closed_forms((steps, limits, interval_split, speed_profile) in moves()) {
        prop_assume!(steps != [0; 3]);
        let plan = SyncMove::plan(steps, &limits, interval_split, speed_profile, None).unwrap();
        let end_ticks = plan.profile.duration_s() * f64::from(TICK_HZ);
        for (axis, n) in steps.iter().enumerate() {
            let mut last = None;
            let mut k = 0;
            for tick in plan.segments(axis, TICK_HZ).flat_map(|segment| segment.ticks()) {
                k += 1;
                let exact = plan.step_time_s(axis, k) * f64::from(TICK_HZ);
                let error = tick as f64 - exact;
                prop_assert!(error.abs() <= EDGE_ERROR_MAX_TICKS, "axis {axis} step {k}: {tick} for {exact}");
                prop_assert!(last < Some(tick), "axis {axis} step {k}: {tick} after {last:?}");
                prop_assert!(tick as f64 <= end_ticks + EDGE_ERROR_MAX_TICKS);
                last = Some(tick);
            }
            prop_assert_eq!(k, n.unsigned_abs());
        }
    }

    /// A segment's instants, its intervals, a buffer filled with them in pieces, and its closed sum all agree.
    #[test]
    fn intervals_are_the_instants_differences(
        (steps, limits, interval_split, speed_profile) in moves(), piece in 1..20usize, bias in any::<u32>(),
    ) {
        prop_assume!(steps != [0; 3]);
        let plan = SyncMove::plan(steps, &limits, interval_split, speed_profile, None).unwrap();
        for segment in (0..3).flat_map(|axis| plan.segments(axis, TICK_HZ)) {
            let ticks: Vec<u64> = segment.ticks().collect();
            prop_assert_eq!(ticks.len(), segment.steps() as usize);
            prop_assert_eq!(ticks.first(), Some(&segment.first_ticks()));
            prop_assert_eq!(ticks.last(), Some(&segment.last_ticks()));
            let differences: Vec<u32> = ticks.windows(2).map(|pair| (pair[1] - pair[0]) as u32).collect();
            prop_assert_eq!(segment.intervals().len(), differences.len());
            prop_assert_eq!(&segment.intervals().collect::<Vec<_>>(), &differences);
            // Rounding makes an interval a tick longer at most.
            let shortest = differences.iter().min();
            prop_assert_eq!(segment.interval_min_ticks().is_some(), shortest.is_some());
            prop_assert!(shortest.is_none_or(|&min| (min - 1..=min).contains(&segment.interval_min_ticks().unwrap())));
            prop_assert_eq!(filled(segment.intervals(), piece, bias), differences);
        }
    }

    /// No axis exceeds its own top speed over any step, nor its acceleration and deceleration.
    #[test]
    fn no_axis_exceeds_its_limits((steps, limits, interval_split, speed_profile) in moves()) {
        prop_assume!(steps != [0; 3]);
        let plan = SyncMove::plan(steps, &limits, interval_split, speed_profile, None).unwrap();
        let profile = &plan.profile;
        for axis in (0..3).filter(|&axis| steps[axis] != 0) {
            let ratio = f64::from(steps[axis].unsigned_abs()) / profile.distance_steps();
            let own = &limits[axis];
            let slack = 1.0 + 1e-9;
            prop_assert!(profile.cruise_speed_steps_s() * ratio <= own.top_speed_steps_s * slack);
            prop_assert!(profile.entry_speed_steps_s() * ratio <= own.start_speed_steps_s * slack);
            for i in 0..=64 {
                let accel = profile.accel_at(profile.duration_s() * f64::from(i) / 64.0) * ratio;
                prop_assert!(accel <= own.accel_steps_s2 * slack);
                prop_assert!(-accel <= own.decel_steps_s2 * slack);
            }
            if speed_profile == SpeedProfile::SCurve {
                for i in 0..=64 {
                    let jerk = profile.jerk_at(profile.duration_s() * f64::from(i) / 64.0) * ratio;
                    prop_assert!(jerk.abs() <= own.jerk_steps_s3 * slack);
                }
            }
            for k in 1..steps[axis].unsigned_abs() {
                let period_s = plan.step_time_s(axis, k + 1) - plan.step_time_s(axis, k);
                prop_assert!(1.0 / period_s <= own.top_speed_steps_s * (1.0 + 1e-6), "step {k}: {period_s} s");
            }
        }
    }

    /// An axis planned alone, with the limits the shared profile gave it, has the intervals of all the others.
    #[test]
    fn every_axis_alone_has_the_same_intervals((steps, limits, interval_split, _) in moves()) {
        prop_assume!(steps != [0; 3]);
        let shared = SyncMove::plan(steps, &limits, interval_split, SpeedProfile::Trapezoid, None).unwrap().profile;
        for &n in steps.iter().filter(|&&n| n != 0) {
            let ratio = f64::from(n.unsigned_abs()) / shared.distance_steps();
            let ramp = |accel: f64, t_s: f64| if t_s > 0.0 { accel * ratio } else { 1.0 };
            let own = Limits {
                start_speed_steps_s: shared.entry_speed_steps_s() * ratio,
                top_speed_steps_s: shared.cruise_speed_steps_s() * ratio,
                accel_steps_s2: ramp(shared.accel_at(0.0), shared.t_accel_s()),
                decel_steps_s2: ramp(-shared.accel_at(shared.duration_s()), shared.t_decel_s()),
                jerk_steps_s3: f64::INFINITY,
            };
            prop_assume!(own.top_speed_steps_s >= isostep_profile::SPEED_MIN_STEPS_S);
            let alone = SyncMove::plan([n], &[own], IntervalSplit::Fastest, SpeedProfile::Trapezoid, None).unwrap().profile;
            // Rounding the top speed by one part in 1e15 moves the end of a ramp by this time, and makes a cruise of
            // this time at the peak of a triangle.
            let ramps_s = own.top_speed_steps_s / own.accel_steps_s2 + own.top_speed_steps_s / own.decel_steps_s2;
            let tolerance_s = 1e-9 * shared.duration_s() + 1e-15 * ramps_s;
            prop_assert!((alone.t_accel_s() - shared.t_accel_s()).abs() <= tolerance_s);
            prop_assert!((alone.t_cruise_s() - shared.t_cruise_s()).abs() <= tolerance_s);
            prop_assert!((alone.t_decel_s() - shared.t_decel_s()).abs() <= tolerance_s);
        }
    }

    /// Three equal intervals by the paper's speed profile, whatever the limits.
    #[test]
    fn thirds_are_thirds((steps, limits, _, speed_profile) in moves()) {
        prop_assume!(steps != [0; 3]);
        let profile = SyncMove::plan(steps, &limits, IntervalSplit::Thirds, speed_profile, None).unwrap().profile;
        prop_assert_eq!(profile.t_accel_s(), profile.t_cruise_s());
        prop_assert_eq!(profile.t_cruise_s(), profile.t_decel_s());
        let half_way = profile.position_at(profile.duration_s() / 2.0);
        prop_assert!((half_way - profile.distance_steps() / 2.0).abs() <= 1e-9 * profile.distance_steps());
    }

    /// If a = d, a move made backwards is the same move.
    #[test]
    fn equal_ramps_are_time_symmetric(
        n in 1..3_000i32, own in limits(), interval_split in interval_split(), speed_profile in speed_profile(),
    ) {
        let own = moving(speed_profile, Limits { decel_steps_s2: own.accel_steps_s2, ..own });
        let plan = SyncMove::plan([n], &[own], interval_split, speed_profile, None).unwrap();
        let last = n.unsigned_abs() + 1;
        for k in 1..last {
            let mirrored = plan.profile.duration_s() - plan.step_time_s(0, last - k);
            prop_assert!((plan.step_time_s(0, k) - mirrored).abs() <= 1e-9 * plan.profile.duration_s());
        }
    }

    /// Halving a limit never makes a move faster. For the speed profiles over displacement this holds for acceleration only: a
    /// ramp to a lower top speed, or from a higher start speed, spends less time at low speeds.
    #[test]
    fn a_tighter_limit_is_never_faster((steps, limits, interval_split, speed_profile) in moves(), axis in 0..3usize, which in 0..5) {
        prop_assume!(steps != [0; 3]);
        let mut tighter = limits;
        let own = &mut tighter[axis];
        match if speed_profile.is_over_displacement() { which % 2 } else { which } {
            0 => own.accel_steps_s2 /= 2.0,
            1 => own.decel_steps_s2 /= 2.0,
            2 => own.start_speed_steps_s /= 2.0,
            3 => own.jerk_steps_s3 /= 2.0,
            _ => {
                own.top_speed_steps_s /= 2.0;
                own.start_speed_steps_s = own.start_speed_steps_s.min(own.top_speed_steps_s);
            }
        }
        let duration_s = |limits| SyncMove::plan(steps, limits, interval_split, speed_profile, None).unwrap().profile.duration_s();
        // Thirds of a speed profile over displacement are found to 1e-5.
        let slack = if speed_profile.is_over_displacement() && interval_split == IntervalSplit::Thirds { 1e-4 } else { 1e-9 };
        prop_assert!(duration_s(&tighter) >= duration_s(&limits) * (1.0 - slack));
    }

    /// With the fastest intervals, no speed profile is faster than the trapezoid. In thirds, a speed profile with a higher mean
    /// speed can be.
    #[test]
    fn the_trapezoid_is_the_fastest((steps, limits, _, speed_profile) in moves()) {
        prop_assume!(steps != [0; 3]);
        let duration_s = |speed_profile| {
            SyncMove::plan(steps, &limits, IntervalSplit::Fastest, speed_profile, None).unwrap().profile.duration_s()
        };
        prop_assert!(duration_s(speed_profile) >= duration_s(SpeedProfile::Trapezoid) * (1.0 - 1e-9));
    }

    /// Position and time are each other's inverse, with any entry and exit speed that can be planned.
    #[test]
    fn position_and_time_are_inverse(
        distance in 1.0..1e5, entry in 0.0..1.0, exit in 0.0..1.0, own in limits(), interval_split in interval_split(),
        speed_profile in speed_profile(), at in 0.0..=1.0,
    ) {
        let (entry, exit) = (entry * own.top_speed_steps_s, exit * own.top_speed_steps_s);
        let Ok(plan) = Profile::plan(distance, entry, exit, &own, interval_split, speed_profile) else { return Ok(()) };
        let steps = at * distance;
        let back = plan.position_at(plan.time_at(steps));
        prop_assert!((back - steps).abs() <= 1e-7 * distance, "{back} for {steps}");
        prop_assert!((plan.position_at(plan.duration_s()) - distance).abs() <= 1e-9 * distance);
        let t_s = at * plan.duration_s();
        prop_assert!(plan.speed_at(t_s) <= own.top_speed_steps_s * (1.0 + 1e-9));
        prop_assert!(plan.accel_at(t_s) <= own.accel_steps_s2 * (1.0 + 1e-9));
        prop_assert!(-plan.accel_at(t_s) <= own.decel_steps_s2 * (1.0 + 1e-9));
    }
}
