//! Forero's staircase and timers, compared with the paper's numbers and with numbers worked out by hand.

use isostep_generators::{PreloadTimer, Staircase, StaircaseError, TimedStaircase, TimerError};
use isostep_trials::cases;
use proptest::prelude::*;

/// The longest move of the paper, 20,000 steps at t_1 = 4.5 s (its eqs 4-7). The paper does not print the steps of
/// figure 9.
fn paper() -> Staircase {
    Staircase::plan(20_000, 4.5).unwrap()
}

fn on_timers(steps: u32, reload_ticks: u32) -> TimedStaircase {
    TimedStaircase::plan(Staircase::plan(steps, 4.5).unwrap(), reload_ticks).unwrap()
}

/// By hand, eq 7: V_c = 20000/9 = 2222.2 steps/s; eq 11: A_i = 25 i; eq 10: 2 * 25 * 190 = 9500 steps on the ramps, so
/// the cruise has 10,500 and lasts 10,500/2222.2 = 4.725 s.
#[test]
fn the_ideal_staircase_makes_every_step() {
    let plan = paper();
    assert_eq!(plan.t_cruise_s(), 4.725);
    assert_eq!(plan.duration_s(), 13.725);
    let treads: Vec<_> = plan.treads().collect();
    assert_eq!(treads.len(), 41);
    let steps: Vec<f64> = treads.iter().map(|tread| tread.ideal_steps).collect();
    let ramp = (0..20).map(|i| 25.0 * f64::from(i));
    let wanted: Vec<f64> = ramp.clone().chain([10_500.0]).chain(ramp.rev()).collect();
    assert_eq!(steps, wanted);
    assert_eq!(steps.iter().sum::<f64>(), 20_000.0);
    for tread in &treads {
        assert!((tread.speed_steps_s * tread.duration_s - tread.ideal_steps).abs() < 1e-9);
    }
}

#[test]
fn speed_and_position_are_the_treads() {
    let plan = paper();
    assert_eq!([-0.1, 0.1, 13.6, 13.8].map(|t_s| plan.speed_at(t_s)), [0.0; 4]);
    assert!((plan.speed_at(0.3) - 2_000.0 / 18.0).abs() < 1e-9);
    assert!((plan.speed_at(6.0) - 20_000.0 / 9.0).abs() < 1e-9);
    // 25 * (1 + ... + 19) = 4750 at the end of the ramp; half of the cruise is 5250.
    let at = [(-1.0, 0.0), (0.225, 0.0), (0.45, 25.0), (4.5, 4_750.0), (6.8625, 10_000.0), (13.5, 20_000.0)];
    for (t_s, steps) in at.into_iter().chain([(99.0, 20_000.0)]) {
        assert!((plan.position_at(t_s) - steps).abs() < 1e-6, "{} at {t_s} s", plan.position_at(t_s));
    }
}

/// The paper: "preloads of 9 286" for 0.225 s on TMR0. By hand, TMR1 at V_c/20 = 111.1 steps/s: half a period is 4.5
/// ms, 2250 counts of 2 us, 65536 - 2250 = 63286; at V_c, 112.5 counts: 65423.5, cut down to 65423, 113 counts.
#[test]
fn preloads_by_hand() {
    assert_eq!(PreloadTimer::TMR0.exact_preload(0.225), 9_286.0);
    assert_eq!(PreloadTimer::TMR0.preload(0.225), Ok(9_286));
    let treads: Vec<_> = on_timers(20_000, 0).treads().collect();
    assert_eq!(treads[0].preload, None);
    let slow = treads[1].preload.unwrap();
    assert_eq!(slow.truncated, 63_286);
    assert!((slow.exact - 63_286.0).abs() < 1e-9);
    let top = treads[20].preload.unwrap();
    assert_eq!(top.truncated, 65_423);
    assert!((top.exact - 65_423.5).abs() < 1e-9);
    assert_eq!(PreloadTimer::TMR1.ticks(top.truncated), 113);
}

/// By hand, an interval is 112,500 counts. Level 4: 562.5 counts become 563, so 199 toggles fit, with 100 rising edges.
/// Level 7: 321.4 become 322, with 349 toggles; the level before ended high, so there are 174 rising edges. Level
/// 19: 118.4 become 119, with 945 toggles and 473 or 472 rising edges. The cruise: 2,362,500/113 = 20,907 toggles,
/// 10,453 of 10,500 steps.
#[test]
fn every_interval_loses_steps_to_truncation() {
    let plan = on_timers(20_000, 0);
    let steps: Vec<u32> = plan.treads().map(|tread| tread.steps).collect();
    let up = [0, 25, 50, 75, 100, 125, 150, 174, 199, 225, 250, 274, 299, 323, 349, 375, 399, 422, 450, 473];
    assert_eq!(steps[..20], up);
    assert_eq!(steps[20], 10_453);
    assert_eq!(plan.lost_steps(), 73);
    assert_eq!(steps.iter().sum::<u32>(), 20_000, "the last interval makes up for them");
    assert_eq!(steps[40], 73);
}

/// The paper's Table 1 measured 4.5, 4.725 and 6.8 s. In the model, truncation alone makes the deceleration 4.94 s; a
/// timer that loses one or two counts at each toggle makes it 6.28 or 7.57 s.
#[test]
fn the_last_interval_is_long() {
    let plan = on_timers(20_000, 0);
    assert!((plan.t_accel_s() - 4.5).abs() < 1e-9 && (plan.t_cruise_s() - 4.725).abs() < 1e-9);
    // 19 intervals, and 147 half periods of 4.5 ms: 73 steps have 146, and the level before ended high, which adds one.
    assert!((plan.t_decel_s() - (19.0 * 0.225 + 147.0 * 0.0045)).abs() < 1e-9, "{}", plan.t_decel_s());
    assert_eq!([1, 2].map(|reload| on_timers(20_000, reload).lost_steps()), [222, 365]);
    assert!((on_timers(20_000, 1).t_decel_s() - 6.278_39).abs() < 1e-5);
    assert!((on_timers(20_000, 2).t_decel_s() - 7.567_424).abs() < 1e-5);
}

#[test]
fn what_the_timers_cannot_make_is_refused_with_the_bound() {
    assert_eq!(Staircase::plan(0, 4.5), Err(StaircaseError::NoSteps));
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(Staircase::plan(9, bad), Err(StaircaseError::RampTime { .. })), "{bad}");
    }
    let plan = |steps, t1_s| TimedStaircase::plan(Staircase::plan(steps, t1_s).unwrap(), 0);
    // 2250 * 20000 / 65536 = 686.6 steps.
    assert!(plan(687, 4.5).is_ok());
    let too_slow = |error| matches!(error, Err(StaircaseError::Timer(TimerError { max, .. })) if max == 0.131_072);
    assert!(too_slow(plan(686, 4.5)));
    // 65536 counts of 4 us, 20 times: 5.24288 s.
    assert!(plan(20_000, 5.242).is_ok());
    let too_long = |error| matches!(error, Err(StaircaseError::Timer(TimerError { max, .. })) if max == 0.262_144);
    assert!(too_long(plan(20_000, 5.243)));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(100, 300), failure_persistence: None, ..ProptestConfig::default() })]

    /// For every move, all its steps are made in the end, in order, and none before the ideal staircase has come within
    /// one step of it.
    #[test]
    fn every_step_is_made_in_the_end(steps in 3_000..100_000_u32, t1_s in 1.0..5.2, reload_ticks in 0..4_u32) {
        let ideal = Staircase::plan(steps, t1_s).unwrap();
        let plan = TimedStaircase::plan(ideal, reload_ticks).unwrap();
        let edges: Vec<f64> = plan.edges_s().collect();
        prop_assert_eq!(edges.len(), steps as usize);
        prop_assert_eq!(plan.treads().map(|tread| tread.steps).sum::<u32>(), steps);
        prop_assert!(edges.windows(2).all(|pair| pair[0] < pair[1]));
        let ends_s = plan.t_accel_s() + plan.t_cruise_s() + plan.t_decel_s();
        prop_assert!(edges[edges.len() - 1] <= ends_s);
        for (made, edge_s) in (0_u32..).zip(&edges) {
            prop_assert!(f64::from(made) <= ideal.position_at(*edge_s) + 2.0, "{} at {} s", made, edge_s);
        }
    }
}
