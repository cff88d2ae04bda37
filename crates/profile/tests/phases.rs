//! Phases: every edge is at its instant, within the bound that all segments have. Most are those of a box, whose acceleration
//! changes.

use isostep_profile::{AxisCompiler, AxisPhase, CountedPhase, fit_error_max_ticks};
use isostep_trials::cases;
use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;

/// The clocks of boards, ticks/s: the slower one is, the longer segments may be.
const CLOCKS_HZ: [u32; 2] = [125_000_000, 1_000_000];
/// The error of rounding in an instant in fixed point, ticks, and in a place, steps.
const ROUNDING_TICKS: f64 = 0.01;
const ROUNDING_STEPS: f64 = 1e-8;
/// A phase of a box of 10 ms lasts no longer, s.
const LASTS_MAX_S: f64 = 0.01;
const TOP_STEPS_S: f64 = 1e6;

/// Speed, acceleration and jerk where an axis begins.
#[derive(Clone, Copy, Debug)]
struct Start {
    speed_steps_s: f64,
    accel_steps_s2: f64,
    jerk_steps_s3: f64,
    place_steps: f64,
}

impl Start {
    fn speed_steps_s(&self, t_s: f64) -> f64 {
        self.speed_steps_s + (self.accel_steps_s2 + 0.5 * self.jerk_steps_s3 * t_s) * t_s
    }

    fn place_steps(&self, t_s: f64) -> f64 {
        let gained = 0.5 * self.accel_steps_s2 + self.jerk_steps_s3 * t_s / 6.0;
        self.place_steps + (self.speed_steps_s + gained * t_s) * t_s
    }

    /// The phase for as long as the axis is neither too fast nor too slow, 10 ms at most; `None` if that is hardly any time.
    fn phase(&self) -> Option<CountedPhase> {
        let speeds = 0.1 * self.speed_steps_s..TOP_STEPS_S;
        let parts = (1..=1_000).map(|part| LASTS_MAX_S * f64::from(part) / 1_000.0);
        let end_s = parts.take_while(|&t_s| speeds.contains(&self.speed_steps_s(t_s))).last()?;
        let end = (self.place_steps(end_s) + 0.5).floor() as i32;
        let Self { speed_steps_s, accel_steps_s2, jerk_steps_s3, place_steps } = *self;
        Some(CountedPhase {
            phase: AxisPhase { begin_s: 0.0, place_steps, speed_steps_s, accel_steps_s2 },
            end_s,
            end_place_steps: self.place_steps(end_s),
            end_speed_steps_s: self.speed_steps_s(end_s),
            jerk_steps_s3,
            counts: [0, end, end],
        })
    }
}

/// Log-uniform numbers.
fn log_range(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low.ln()..high.ln()).prop_map(f64::exp)
}

/// Among them many whose instants have nearly no third derivative over the steps: j v = 3 a². There a quadratic is not farthest
/// from them where it is from a cubic.
fn starts() -> impl Strategy<Value = Start> {
    let share = prop_oneof![3 => log_range(0.5, 2.0), 1 => log_range(1e-3, 1e3).prop_map(|share| -share)];
    (log_range(1e3, 3e5), log_range(1e5, 3e7), share, any::<bool>(), -0.49..0.49).prop_map(
        |(speed_steps_s, accel_steps_s2, share, slows, place_steps)| Start {
            speed_steps_s,
            accel_steps_s2: if slows { -accel_steps_s2 } else { accel_steps_s2 },
            jerk_steps_s3: share * 3.0 * accel_steps_s2 * accel_steps_s2 / speed_steps_s,
            place_steps,
        },
    )
}

fn assert_at_their_instants(start: &Start) -> TestCaseResult {
    start.phase().map_or(Ok(()), |phase| assert_phase_at_its_instants(start, &phase))
}

fn assert_phase_at_its_instants(start: &Start, phase: &CountedPhase) -> TestCaseResult {
    CLOCKS_HZ.into_iter().try_for_each(|tick_hz| assert_at_clock(start, phase, tick_hz))
}

fn assert_at_clock(start: &Start, phase: &CountedPhase, tick_hz: u32) -> TestCaseResult {
    let mut compiler = AxisCompiler::empty();
    compiler.begin_phase(phase, tick_hz);
    let bound_s = (fit_error_max_ticks(tick_hz) + 0.5 + ROUNDING_TICKS) / f64::from(tick_hz);
    let mut count = 0;
    while let Some(segment) = compiler.next_of_phase() {
        for tick in segment.ticks() {
            let (t_s, edge) = (tick as f64 / f64::from(tick_hz), f64::from(count) + 0.5);
            let around = [t_s - bound_s, t_s + bound_s].map(|t_s| start.place_steps(t_s) - edge);
            prop_assert!(
                around[0] <= ROUNDING_STEPS && around[1] >= -ROUNDING_STEPS,
                "edge {count} at {t_s}: {around:?}, {start:?}"
            );
            count += 1;
        }
    }
    prop_assert_eq!(count, phase.counts[2]);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(2_000, 50_000), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_edge_of_a_phase_of_constant_jerk_is_at_its_instant(start in starts()) {
        assert_at_their_instants(&start)?;
    }
}

/// One of its edges was 25.2 ns from its instant, where 24 are allowed.
#[test]
fn where_the_third_derivative_vanishes_every_edge_is_at_its_instant() {
    let start = Start {
        speed_steps_s: 100_076.53,
        accel_steps_s2: -22_360_609.5,
        jerk_steps_s3: 17_988_919_779.0,
        place_steps: 0.0,
    };
    assert_at_their_instants(&start).unwrap();
}

/// An edge at the slow end of a ramp was moved away by a millionth of a step, which takes 32 ns at 32 steps/s, where 24 are allowed.
/// Only where the axis stands must it be kept away.
#[test]
fn an_edge_at_the_slow_end_of_a_ramp_is_at_its_instant() {
    for beside_steps in [-1e-12, 0.0, 1e-12, 1e-7] {
        // The place after the last edge where it begins, or before the next one where it has slowed down.
        let begins =
            Start { speed_steps_s: 31.6, accel_steps_s2: 1_000.0, jerk_steps_s3: 0.0, place_steps: 0.5 + beside_steps };
        let slows_s = (100.0 - 31.6) / 1_000.0;
        let way_steps = 100.0 * slows_s - 500.0 * slows_s * slows_s;
        let ends = Start {
            speed_steps_s: 100.0,
            accel_steps_s2: -1_000.0,
            place_steps: 4.5 + beside_steps - way_steps,
            ..begins
        };
        for (start, end_s, counts) in [(begins, LASTS_MAX_S, [0, 1, 1]), (ends, slows_s, [0, 5, 5])] {
            let (end_place_steps, end_speed_steps_s) = (start.place_steps(end_s), start.speed_steps_s(end_s));
            let phase =
                CountedPhase { counts, end_s, end_place_steps, end_speed_steps_s, ..start.phase().expect("a phase") };
            assert_phase_at_its_instants(&start, &phase).unwrap();
        }
    }
}
