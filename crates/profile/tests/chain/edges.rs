//! Rare cases: the largest and smallest limits and moves, refusals, and single holds.

use isostep_profile::chain::{Chain, ChainConfig, ChunkKind, Effort, Request};
use isostep_profile::{IntervalSplit, Limits, PlanError, ProfileError, SpeedProfile};
use isostep_trials::cases;
use proptest::prelude::*;

use super::case::{AXES, Case, line};
use super::drive::{drive, overrides};

fn limits(start: f64, top: f64, accel: f64) -> Limits {
    Limits {
        start_speed_steps_s: start,
        top_speed_steps_s: top,
        accel_steps_s2: accel,
        decel_steps_s2: accel,
        jerk_steps_s3: f64::INFINITY,
    }
}

fn request(steps: [i32; AXES], tag: u64) -> Request<AXES> {
    Request { tag, ..Request::new(steps) }
}

/// A chain of moves in one direction, at 10 mm/s, 100 mm/s² and 100 steps/mm.
fn straight(moves: i32, steps: i32) -> Chain<AXES, 4> {
    let config = ChainConfig::new(
        [limits(0.0, 1e3, 1e4); AXES],
        [0.01; AXES],
        0.01,
        IntervalSplit::Fastest,
        SpeedProfile::Trapezoid,
    );
    let mut chain = Chain::new(config);
    for tag in 0..moves {
        chain.push(request([steps, 0, 0], tag as u64)).unwrap();
    }
    chain
}

#[test]
fn a_full_chain_refuses_and_changes_nothing() {
    let mut chain = straight(4, 100);
    assert_eq!(chain.push(request([1, 0, 0], 4)), Err(PlanError::NoRoom));
    assert!(chain.is_full() && chain.len() == 4);
    let mut ends = Vec::new();
    while let Some(chunk) = chain.advance(f64::INFINITY) {
        ends.push((chunk.tag, chunk.until_s));
    }
    assert_eq!(ends.iter().map(|end| end.0).collect::<Vec<_>>(), [0, 1, 2, 3]);
    // 400 steps at 1,000 steps/s, and 0.1 s for the ramps.
    assert!((ends[3].1 - 0.5).abs() < 1e-9);
}

/// Whatever a move's length is, a move that only accelerates has no cruise, not even for a rounding.
#[test]
fn a_move_that_only_accelerates_has_no_cruise() {
    for steps in 1..200 {
        let mut chain = straight(4, steps);
        let first = line(&chain.advance(f64::INFINITY).unwrap()).profile;
        let is_fast = first.exit_speed_steps_s() == 1e3;
        assert!(is_fast || first.t_cruise_s() + first.t_decel_s() == 0.0, "{steps} steps: {first:?}");
        assert!(is_fast || first.accel_end_steps() == first.distance_steps(), "{steps} steps: {first:?}");
    }
}

#[test]
fn what_cannot_be_planned_is_refused() {
    let slow = |speed_profile, start| {
        let config = ChainConfig::new(
            [limits(start, 1e3, 1e4); AXES],
            [0.01; AXES],
            0.01,
            IntervalSplit::Fastest,
            speed_profile,
        );
        Chain::<AXES, 4>::new(config)
    };
    assert_eq!(slow(SpeedProfile::Trapezoid, 0.0).push(request([0; AXES], 0)), Err(PlanError::NoSteps));
    let standstill = slow(SpeedProfile::Linear, 0.0).push(request([1, 0, 0], 0));
    assert!(matches!(standstill, Err(PlanError::Profile(ProfileError::Standstill { .. }))));
    let crawling = Request { feed_mm_s: Some(1e-6), ..request([1, 0, 0], 0) };
    assert!(matches!(slow(SpeedProfile::Trapezoid, 0.0).push(crawling), Err(PlanError::PathSpeed { .. })));
    // No feed is too fast, because a feed is an upper bound.
    for feed_mm_s in [1e5, 1e300, f64::INFINITY] {
        let mut fast = slow(SpeedProfile::Trapezoid, 0.0);
        fast.push(Request { feed_mm_s: Some(feed_mm_s), ..request([1_000, 0, 0], 0) }).unwrap();
        let chunk = fast.advance(f64::INFINITY).unwrap();
        assert!((chunk.until_s - 1.1).abs() < 1e-9, "{feed_mm_s} mm/s: {} s", chunk.until_s);
    }
    let nothing = Request { feed_mm_s: Some(f64::NAN), ..request([1, 0, 0], 0) };
    assert!(matches!(slow(SpeedProfile::Trapezoid, 0.0).push(nothing), Err(PlanError::PathSpeed { .. })));
    let long = Request { feed_mm_s: Some(1e-3), ..request([1_000_000, 0, 0], 0) };
    let too_long = slow(SpeedProfile::Trapezoid, 0.0).push(long);
    assert!(matches!(too_long, Err(PlanError::Profile(ProfileError::TooLong { .. }))));
    // The ramps alone last too long.
    let config = ChainConfig::new(
        [limits(0.0, 1e3, 1e-9); AXES],
        [0.01; AXES],
        0.01,
        IntervalSplit::Fastest,
        SpeedProfile::Trapezoid,
    );
    let too_long = Chain::<AXES, 4>::new(config).push(request([1_000_000, 0, 0], 0));
    assert!(matches!(too_long, Err(PlanError::Profile(ProfileError::TooLong { .. }))));
}

/// Whether a move is refused does not depend on the overrides, which may change until it is made.
#[test]
fn a_long_move_is_accepted_under_any_override() {
    // 2,000 mm take 800,000 s.
    let long = Request { feed_mm_s: Some(2.5e-3), ..request([200_000, 0, 0], 0) };
    for (feed_ratio, wanted_s) in [(1.0, 8e5), (0.1, 8e6)] {
        let limits = [limits(0.0, 1e3, 1e4); AXES];
        let config = ChainConfig::new(limits, [0.01; AXES], 0.01, IntervalSplit::Fastest, SpeedProfile::Trapezoid);
        let mut chain = Chain::<AXES, 4>::new(config);
        chain.override_speed(feed_ratio, 1.0);
        chain.push(long).unwrap();
        let until_s = chain.advance(f64::INFINITY).unwrap().until_s;
        assert!((until_s - wanted_s).abs() < 1.0, "{until_s} s at {feed_ratio}");
    }
}

/// The delta v² of a step is less than one unit.
#[test]
fn one_step_of_the_slowest_ramp_on_the_fastest_axis_has_its_time() {
    let config = ChainConfig::new(
        [limits(0.0, 1e7, 1e-5); AXES],
        [0.01; AXES],
        0.01,
        IntervalSplit::Fastest,
        SpeedProfile::Trapezoid,
    );
    let mut chain = Chain::<AXES, 4>::new(config);
    chain.push(request([1, 0, 0], 0)).unwrap();
    // Half a step up and half a step down, x = a t²/2.
    let expected_s = 2.0 * (1.0f64 / 1e-5).sqrt();
    let chunk = chain.advance(f64::INFINITY).unwrap();
    assert!((chunk.until_s - expected_s).abs() < 1e-6, "{}", chunk.until_s);
}

/// The first move is at a speed that needs no ramp, and has no room left to brake to a lower override. So it does not
/// stop at its end, where a stop was planned. The corner would allow its speed, but the other axis of the next move
/// would not.
#[test]
fn a_move_that_is_not_to_stop_any_more_flows_into_none_that_is_slower() {
    for speed_profile in SpeedProfile::ALL {
        let axes = [limits(300.0, 1e3, 1e4), limits(9.0, 40.0, 1e3), limits(9.0, 40.0, 1e3)];
        let mut chain =
            Chain::<AXES, 4>::new(ChainConfig::new(axes, [0.04; AXES], 0.1, IntervalSplit::Fastest, speed_profile));
        // 200 steps/s; the second move allows 120 at most.
        let feed = |steps, tag| Request { feed_mm_s: Some(8.0), ..request(steps, tag) };
        chain.push(feed([20, 0, 0], 0)).unwrap();
        chain.push(feed([30, 10, 0], 1)).unwrap();
        chain.advance(0.0995).unwrap();
        chain.override_speed(0.3, 1.0);
        while let Some(chunk) = chain.advance(f64::INFINITY) {
            let fastest = line(&chunk).profile.entry_speed_steps_s().max(line(&chunk).profile.cruise_speed_steps_s());
            assert!(chunk.tag == 0 || fastest <= 120.0 + 1e-6, "{speed_profile}: {fastest} steps/s");
        }
    }
}

/// As before, but nothing can brake: the jerk is too low. The second move may stop from 180 steps/s, and the first one
/// arrives at 200, from which it may stop too.
#[test]
fn a_move_that_can_stop_does_not_flow_into_one_that_could_not() {
    let slow = |start| Limits { jerk_steps_s3: 1.0, ..limits(start, 1e3, 1e4) };
    let axes = [slow(300.0), slow(60.0), slow(60.0)];
    let config = ChainConfig::new(axes, [0.04; AXES], 0.1, IntervalSplit::Fastest, SpeedProfile::SCurve);
    for override_ratio in [1.0, 0.3] {
        let mut chain = Chain::<AXES, 4>::new(config.clone());
        let feed = |steps, tag| Request { feed_mm_s: Some(8.0), ..request(steps, tag) };
        chain.push(feed([20, 0, 0], 0)).unwrap();
        chain.push(feed([30, 10, 0], 1)).unwrap();
        chain.advance(0.05).unwrap();
        chain.override_speed(override_ratio, 1.0);
        let first = chain.advance(f64::INFINITY).unwrap();
        assert!(first.tag == 0 && line(&first).profile.exit_speed_steps_s() > 190.0);
        let last = chain.advance(f64::INFINITY).unwrap();
        let wanted_steps_s = if override_ratio == 1.0 { 180.0 } else { 60.0 };
        let exit_steps_s = line(&last).profile.exit_speed_steps_s();
        assert!((exit_steps_s / wanted_steps_s - 1.0).abs() < 0.06, "{exit_steps_s} steps/s");
        assert_eq!(chain.advance(f64::INFINITY), None);
    }
}

/// An override makes another plan for what is left of a move, unless less than a millionth of a step is left.
#[test]
fn what_is_nothing_is_not_planned_again() {
    for (left_steps, wanted) in [(1e-3, ChunkKind::Replan), (5e-7, ChunkKind::Continuation)] {
        let mut chain = straight(2, 1_000);
        // A ramp of 0.1 s and 50 steps, then 1,000 steps/s.
        let first = chain.advance(1.05 - left_steps / 1e3).unwrap();
        assert!((1_000.0 - first.until_steps - left_steps).abs() < 1e-9, "{}", first.until_steps);
        chain.override_speed(0.5, 0.5);
        assert_eq!(chain.advance(f64::INFINITY).unwrap().kind, wanted, "{left_steps} steps left");
    }
}

/// A plan is as fast as it can be until it slows down. A move that comes meanwhile counts from there.
#[test]
fn a_move_that_comes_later_counts_from_where_the_plan_slows_down() {
    for speed_profile in SpeedProfile::ALL {
        let config =
            ChainConfig::new([limits(10.0, 1e3, 1e4); AXES], [0.01; AXES], 0.01, IntervalSplit::Fastest, speed_profile);
        let mut chain = Chain::<AXES, 4>::new(config);
        chain.push(request([2_000, 0, 0], 0)).unwrap();
        let begun = chain.advance(0.5).unwrap();
        chain.push(request([2_000, 0, 0], 1)).unwrap();
        let fast = chain.advance(f64::INFINITY).unwrap();
        assert_eq!((fast.kind, fast.plan), (ChunkKind::Continuation, begun.plan), "{speed_profile}");
        let rest = chain.advance(f64::INFINITY).unwrap();
        assert_eq!(rest.kind, ChunkKind::Replan, "{speed_profile}");
        assert!((line(&rest).profile.exit_speed_steps_s() - 1e3).abs() < 1e-3, "{speed_profile}");
    }
}

#[test]
fn a_hold_brakes_and_a_start_goes_on() {
    let mut chain = straight(2, 1_000);
    chain.advance(0.5).unwrap();
    chain.hold();
    chain.hold();
    let braking = chain.advance(f64::INFINITY).unwrap();
    // v²/2a = 50 steps, 0.1 s.
    assert_eq!(braking.kind, ChunkKind::Replan);
    assert!((braking.until_s - 0.6).abs() < 1e-9 && (braking.until_steps - 500.0).abs() < 1e-6, "{braking:?}");
    assert_eq!(chain.advance(f64::INFINITY), None);
    assert_eq!(chain.advance(f64::INFINITY), None);
    assert!(chain.is_at_rest());
    chain.start();
    let rest = chain.advance(f64::INFINITY).unwrap();
    assert_eq!((rest.kind, line(&rest).begin_s(), rest.tag), (ChunkKind::Move, 0.0, 0));
    assert_eq!(line(&rest).begin_steps(), braking.until_steps);
    assert_eq!(chain.advance(f64::INFINITY).unwrap().tag, 1);
    assert_eq!(chain.advance(f64::INFINITY), None);
}

/// The hold ends between two steps, at a place that is not a whole number in any unit. The steps that are left must be
/// where they would be without the hold.
#[test]
fn a_resume_begins_where_the_hold_ended_to_the_last_digit() {
    let accel = 1e4;
    for held_at in 0..200 {
        let mut chain = straight(1, 1_000);
        // A time on the ramp, which lasts 0.1 s.
        let reported_s = 0.01 + 1.2e-4 * std::f64::consts::PI * f64::from(held_at);
        chain.advance(reported_s).unwrap();
        chain.hold();
        let braking = chain.advance(f64::INFINITY).unwrap();
        // Braking to rest takes as far as speeding up from rest did.
        let place = accel * reported_s * reported_s;
        assert!((braking.until_steps / place - 1.0).abs() < 1e-13, "{} not {place}", braking.until_steps);
        chain.start();
        let rest = *line(&chain.advance(f64::INFINITY).unwrap());
        assert_eq!(rest.begin_steps(), braking.until_steps);
        let first = rest.step_numbers(0).start;
        assert_eq!(first, (place + 0.5).floor() as u32 + 1, "held at {place}");
        for k in first..first + 3 {
            let left_steps = f64::from(k) - 0.5 - place;
            let wanted_s = (2.0 * left_steps / accel).sqrt();
            // Even a place that is rounded to a millionth of a step would be too inexact.
            let off_s = (rest.step_time_s(0, k) - wanted_s).abs();
            assert!(off_s * accel * wanted_s < 1e-9, "step {k} from {place}: {off_s} s off");
        }
    }
}

#[test]
fn a_hold_taken_back_goes_on_by_the_same_clock() {
    let mut chain = straight(1, 1_000);
    chain.advance(0.5).unwrap();
    chain.hold();
    chain.start();
    let chunk = chain.advance(f64::INFINITY).unwrap();
    assert_eq!((chunk.kind, line(&chunk).begin_s()), (ChunkKind::Replan, 0.5));
    assert!((chunk.until_s - 1.1).abs() < 1e-9);
}

#[test]
fn at_rest_a_hold_holds() {
    let mut chain = straight(0, 1);
    chain.hold();
    chain.push(request([100, 0, 0], 0)).unwrap();
    assert_eq!(chain.advance(1.0), None);
    chain.start();
    assert!(chain.advance(1.0).is_some());
    // A start with nothing left does nothing.
    chain.start();
    assert_eq!(chain.advance(1.0), None);
    assert_eq!(chain.at_s(), 0.0);
}

#[test]
fn a_rest_without_a_step_is_forgotten() {
    let mut chain = straight(1, 1_000);
    // It comes to rest 0.3 steps before the end.
    let brakes_s = 1.0 + (2.0 * 0.3 / 1e4f64).sqrt();
    chain.advance(1.1 - brakes_s.fract() - 1e-3).unwrap();
    chain.hold();
    while chain.advance(1e-4).is_some() {}
    chain.start();
    assert!(chain.advance(1.0).is_none() && chain.is_empty());
}

#[test]
fn a_chain_cleared_is_a_new_one() {
    let mut chain = straight(2, 1_000);
    chain.advance(0.5).unwrap();
    chain.hold();
    chain.advance(1.0).unwrap();
    chain.clear();
    assert!(chain.is_empty() && chain.is_at_rest());
    chain.push(request([100, 0, 0], 7)).unwrap();
    let chunk = chain.advance(f64::INFINITY).unwrap();
    assert_eq!(
        (chunk.tag, chunk.kind, line(&chunk).begin_s(), line(&chunk).begin_steps()),
        (7, ChunkKind::Move, 0.0, 0.0)
    );
    assert!((chunk.until_s - 0.2).abs() < 1e-9);
}

#[test]
fn thirds_go_from_rest_to_rest() {
    let config = ChainConfig::new(
        [limits(0.0, 1e3, 1e4); AXES],
        [0.01; AXES],
        0.01,
        IntervalSplit::Thirds,
        SpeedProfile::Trapezoid,
    );
    let mut chain = Chain::<AXES, 4>::new(config);
    chain.push(request([1_000, 0, 0], 0)).unwrap();
    chain.push(request([1_000, 0, 0], 1)).unwrap();
    while let Some(chunk) = chain.advance(f64::INFINITY) {
        let profile = line(&chunk).profile;
        assert_eq!((profile.entry_speed_steps_s(), profile.exit_speed_steps_s()), (0.0, 0.0));
        assert!((profile.t_accel_s() - profile.t_cruise_s()).abs() < 1e-9);
    }
}

prop_compose! {
    /// Speeds from one step in 2,000 s to 10 million steps/s, and moves of up to a billion steps.
    fn extreme()(
        speed_profile in prop::sample::select(&SpeedProfile::ALL[..]), top_log in -3.3..7.0f64, accel_log in 0.0..1.0f64,
        ratios in [0.5..1.0f64, 0.5..1.0f64, 0.5..1.0f64], jerk_log in -1.0..3.0f64, start in 0.01..1.0f64,
        steps in prop::collection::vec([0.0..1.0f64, 0.0..1.0f64, 0.0..1.0f64], 1..8), log in 0.0..9.0f64,
        has_jerk in any::<bool>(),
    ) -> Case {
        let top = 10f64.powf(top_log);
        // No move may last longer than can be planned.
        let log = log.min(top_log + 5.0).max(0.0);
        let accel = 10f64.powf((top_log - 3.0).max(-6.0) * (1.0 - accel_log) + 9.0 * accel_log);
        // At a corner, the slowest speed of one axis is even slower for another.
        let start = if speed_profile.is_over_displacement() { (start * top).max(0.5) } else { 0.0 };
        let top = top.max(start);
        let limits = ratios.map(|ratio| Limits {
            start_speed_steps_s: start,
            top_speed_steps_s: top,
            accel_steps_s2: accel * ratio,
            decel_steps_s2: accel,
            jerk_steps_s3: if has_jerk { 10f64.powf(jerk_log) * accel * accel / top } else { f64::INFINITY },
        });
        let moves = steps.iter().enumerate().map(|(tag, ratios)| {
            let steps = ratios.map(|ratio| (10f64.powf(log) * ratio) as i32);
            let steps = if steps == [0; AXES] { [1, 0, 0] } else { steps };
            request(steps, tag as u64)
        });
        Case {
            limits, mm_per_step: [0.01, 0.001, 0.02], deviation_mm: 0.01, interval_split: IntervalSplit::Fastest, speed_profile, effort: Effort::NONE,
            moves: moves.collect(),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(200, 2_000), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn extremes_keep_their_limits(case in extreme(), events in overrides()) {
        drive::<8>(&case, &events)?;
    }
}

/// A step that is due exactly where one plan follows another is due when the plan of the whole move has it. The axis is
/// moving there, so the step must not be shifted as at standstill.
#[test]
fn a_step_between_two_parts_is_in_time() {
    let limits = Limits { jerk_steps_s3: 5e5, ..limits(50.0, 2_400.0, 5e4) };
    let config = ChainConfig::new([limits; AXES], [0.02; AXES], 0.01, IntervalSplit::Fastest, SpeedProfile::SCurve);
    let mut chain = Chain::<AXES, 4>::new(config);
    chain.push(request([41, 1, 2], 0)).unwrap();
    let whole = chain.advance(0.06).unwrap();
    // The half of the distance that speeds up is jerk alone. The second half of that ramp becomes another plan, which
    // ends at the same place.
    chain.hold();
    chain.start();
    let mut parts = Vec::new();
    while let Some(chunk) = chain.advance(f64::INFINITY) {
        parts.push(*line(&chunk));
    }
    assert_eq!(parts.len(), 2);
    assert!((parts[0].end_steps() - 20.5).abs() < 1e-9, "{parts:?}");
    let part = parts.iter().find(|part| part.step_numbers(1).contains(&1)).unwrap();
    let [is_s, wanted_s] = [part, line(&whole)].map(|part| part.step_time_s(1, 1));
    assert!((is_s - wanted_s).abs() < 1e-9, "{is_s} for {wanted_s}");
    let ticks: Vec<_> = part.segments(1, 125_000_000).flat_map(|segment| segment.ticks()).collect();
    assert!((ticks[0] as f64 - wanted_s * 125e6).abs() < 1.0, "{ticks:?} for {wanted_s}");
}
