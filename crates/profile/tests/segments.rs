//! Segments, compared with the closed form at the tick rates of both ports: 10,000 random moves and 2,000 extreme ones.
//! Every run tries the same moves; `PROPTEST_RNG_SEED=n cargo test -p isostep-profile segments::` tries others.

use isostep_profile::{
    BRIEF_S, FIT_ERROR_MAX_TICKS, IntervalSplit, Limits, Segment, Segments, SpeedProfile, SyncMove, TimedPlan,
    fit_error_max_ticks,
};
use isostep_trials::cases;
use proptest::prelude::*;

const RATES_HZ: [u32; 2] = [1_000_000, 125_000_000];
/// The error of fixed point, ticks.
const FIXED_POINT_ERROR_TICKS: f64 = 0.02;

fn log(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from.ln()..to.ln()).prop_map(f64::exp)
}

fn interval_split() -> impl Strategy<Value = IntervalSplit> {
    prop::sample::select(&IntervalSplit::ALL[..])
}

fn speed_profile() -> impl Strategy<Value = SpeedProfile> {
    prop::sample::select(&SpeedProfile::ALL[..])
}

/// The same limits, with a start speed from which the speed profile can start.
fn moving(speed_profile: SpeedProfile, limits: Limits) -> Limits {
    let least = if speed_profile.is_over_displacement() { 1e-3 * limits.top_speed_steps_s } else { 0.0 };
    Limits { start_speed_steps_s: limits.start_speed_steps_s.max(least), ..limits }
}

/// The start speed as a fraction of the top speed: none, any, almost all, all.
fn start_ratio() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), 0.0..1.0, log(1e-17, 1e-3).prop_map(|less| 1.0 - less), Just(1.0)]
}

prop_compose! {
    fn limits(top: (f64, f64), accel: (f64, f64))(
        top_speed_steps_s in log(top.0, top.1),
        accel_steps_s2 in log(accel.0, accel.1),
        decel_steps_s2 in log(accel.0, accel.1),
        jerk_ratio in log(0.01, 1e3),
        ratio in start_ratio(),
    ) -> Limits {
        Limits {
            start_speed_steps_s: top_speed_steps_s * ratio,
            top_speed_steps_s,
            accel_steps_s2,
            decel_steps_s2,
            jerk_steps_s3: jerk_ratio * accel_steps_s2 * decel_steps_s2 / top_speed_steps_s,
        }
    }
}

/// An axis of a move, whose segments are compared with the closed form.
struct Axis<'a, const N: usize> {
    plan: &'a SyncMove<N>,
    axis: usize,
    tick_hz: u32,
}

impl<const N: usize> Axis<'_, N> {
    fn segments(&self) -> Segments {
        self.plan.segments(self.axis, self.tick_hz)
    }

    /// The error of step `k`, counted from 1, at `tick`, ticks, if that is more than allowed with this error of the
    /// fit.
    fn excess(&self, k: u32, tick: u64, fit_error: f64) -> Option<f64> {
        let exact_s = self.plan.step_time_s(self.axis, k);
        let hz = f64::from(self.tick_hz);
        let error = tick as f64 - exact_s * hz;
        let bound = fit_error + 0.5 + FIXED_POINT_ERROR_TICKS;
        // Most steps need no allowance for floats, which takes as long to compute as the instant itself.
        let is_within = error.abs() <= bound || error.abs() <= bound + self.float_error_s(exact_s) * hz;
        (!is_within).then_some(error)
    }

    /// The digits that 64-bit floats lose. They round the closed form's instant a few times, and the displacement that it is
    /// computed from.
    fn float_error_s(&self, exact_s: f64) -> f64 {
        let profile = &self.plan.profile;
        let displaced_s = profile.distance_steps() / profile.speed_at(exact_s);
        (24.0 * profile.duration_s() + 2.0 * displaced_s) * f64::EPSILON
    }

    /// Checks the first `most` steps of the segment that begins at step `k`, and its last step.
    fn check_segment(&self, k: u32, segment: Segment, most: usize) -> Result<(), TestCaseError> {
        // A brief segment may hold twice as many steps, and then lasts twice as long.
        let lasts_s = (segment.last_ticks() - segment.first_ticks()) as f64 / f64::from(self.tick_hz);
        let is_brief = lasts_s < 2.5 * BRIEF_S;
        let fit_error = if is_brief { fit_error_max_ticks(self.tick_hz) } else { FIT_ERROR_MAX_TICKS };
        // The last step, unless it is among the first ones.
        let last = (segment.steps() as usize > most).then(|| (k + (segment.steps() - 1), segment.last_ticks()));
        for (k, tick) in (k..).zip(segment.ticks().take(most)).chain(last) {
            if let Some(error) = self.excess(k, tick, fit_error) {
                prop_assert!(false, "axis {} step {k}: tick {tick} is off by {error}", self.axis);
            }
        }
        Ok(())
    }

    /// Checks that all segments are in order and complete, with their steps where they belong. Of long moves it checks
    /// a sample.
    fn check(&self) -> Result<(), TestCaseError> {
        let mut done = 0;
        let mut last = None;
        for (index, segment) in self.segments().enumerate() {
            let most = match index {
                0..100 => 100,
                _ if index % 64 == 0 => 10,
                _ => 1,
            };
            self.check_segment(done + 1, segment, most)?;
            prop_assert!(last <= Some(segment.first_ticks()), "axis {}, after step {done}", self.axis);
            last = Some(segment.last_ticks());
            done += segment.steps();
        }
        prop_assert_eq!(done, self.plan.steps[self.axis].unsigned_abs());
        Ok(())
    }
}

fn check_all<const N: usize>(plan: &SyncMove<N>) -> Result<(), TestCaseError> {
    for tick_hz in RATES_HZ {
        for axis in 0..N {
            Axis { plan, axis, tick_hz }.check()?;
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(1_000, 10_000), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn steps_are_where_they_belong(
        limits in limits((1e2, 2e6), (1e2, 1e8)), steps in 1..3_000i32, other in -3_000..3_000i32, interval_split in interval_split(),
        speed_profile in speed_profile(),
    ) {
        let limits = moving(speed_profile, limits);
        check_all(&SyncMove::plan([steps, other], &[limits; 2], interval_split, speed_profile, None).unwrap())?;
    }
}

proptest! {
    // There are fewer cases, because moves of millions of segments take long.
    #![proptest_config(ProptestConfig { cases: cases(100, 2_000), failure_persistence: None, ..ProptestConfig::default() })]

    /// Speeds from one step in 33 minutes to ten steps a microsecond, ramps that last a day, ramps that are almost
    /// none, two billion steps.
    #[test]
    fn so_are_those_of_extreme_moves(
        limits in limits((5e-4, 1e7), (1e-9, 1e9)), steps in log(1.0, 2e9), ratio in log(1e-9, 1.0), interval_split in interval_split(),
        speed_profile in speed_profile(),
    ) {
        let limits = moving(speed_profile, limits);
        let steps = [steps as i32, -(steps * ratio) as i32];
        let Ok(plan) = SyncMove::plan(steps, &[limits; 2], interval_split, speed_profile, None) else { return Ok(()) };
        check_all(&plan)?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(100, 500), failure_persistence: None, ..ProptestConfig::default() })]

    /// Axes that share a timed plan have the same segments as each has alone, whichever axis is ahead, and by however much.
    #[test]
    fn a_timed_plan_has_the_same_segments_for_every_axis(
        limits in limits((1e2, 2e6), (1e2, 1e8)), steps in prop::array::uniform3(-3_000..3_000i32), interval_split in interval_split(),
        speed_profile in speed_profile(), turns in prop::collection::vec((0..3_usize, 1..40_usize), 1..50), tick_hz in
        prop::sample::select(&RATES_HZ[..]),
    ) {
        prop_assume!(steps != [0; 3]);
        let plan = SyncMove::plan(steps, &[moving(speed_profile, limits); 3], interval_split, speed_profile, None).unwrap();
        // What the timed plan held before must make no difference.
        let mut timed_plan = TimedPlan::empty();
        fastest([900, 1, -7], limits_of(1e4, 1e6)).convert_to_ticks(&mut timed_plan, tick_hz);
        plan.convert_to_ticks(&mut timed_plan, tick_hz);
        let mut compilers = [0, 1, 2].map(|axis| plan.compiler(axis, &timed_plan));
        let mut shared = [const { Vec::new() }; 3];
        // In each turn one of the axis compilers goes on a little. In the end all of them go on to their ends.
        for (axis, count) in turns.into_iter().chain([0, 1, 2].map(|axis| (axis, usize::MAX))) {
            let compiler = &mut compilers[axis];
            shared[axis].extend(std::iter::from_fn(|| compiler.next(&mut timed_plan)).take(count));
        }
        for (axis, shared) in shared.into_iter().enumerate() {
            prop_assert_eq!(shared, plan.segments(axis, tick_hz).collect::<Vec<_>>(), "axis {}", axis);
        }
    }
}

fn limits_of(top_speed_steps_s: f64, accel_steps_s2: f64) -> Limits {
    Limits {
        start_speed_steps_s: 0.0,
        top_speed_steps_s,
        accel_steps_s2,
        decel_steps_s2: accel_steps_s2,
        jerk_steps_s3: f64::INFINITY,
    }
}

fn fastest<const N: usize>(steps: [i32; N], limits: Limits) -> SyncMove<N> {
    SyncMove::plan(steps, &[limits; N], IntervalSplit::Fastest, SpeedProfile::Trapezoid, None).unwrap()
}

#[test]
fn the_longest_move_of_all() {
    for start_speed_steps_s in [0.0, 9e6] {
        let limits = Limits { start_speed_steps_s, ..limits_of(1e7, 1e9) };
        check_all(&fastest([i32::MIN, i32::MAX], limits)).unwrap();
    }
}

#[test]
fn an_axis_of_one_step_in_an_hour() {
    let plan = fastest([10_800_000, 1, -2], limits_of(3_000.0, 1_000.0));
    check_all(&plan).unwrap();
    for tick_hz in RATES_HZ {
        let alone: Vec<Segment> = plan.segments(1, tick_hz).collect();
        let [only] = alone[..] else { panic!("{alone:?}") };
        // The step is in the middle of the move, which is symmetrical.
        let middle_ticks = plan.profile.duration_s() / 2.0 * f64::from(tick_hz);
        assert_eq!((only.steps(), only.first_ticks()), (1, middle_ticks.round() as u64));
        // Half an hour is more than an interval can hold, even at 1 MHz, so these are two segments of one step.
        let steps: Vec<u32> = plan.segments(2, tick_hz).map(|segment| segment.steps()).collect();
        assert_eq!(steps, [1, 1]);
    }
}

/// Every interval inside a segment fits into 30 bits, with room for a port's own cycles.
#[test]
fn intervals_have_30_bits() {
    for speed_steps_s in [0.04, 0.055, 0.06, 0.07, 0.1, 1.0] {
        let plan = fastest([20], limits_of(speed_steps_s, 0.01));
        for segment in plan.segments(0, 125_000_000) {
            assert!(segment.intervals().all(|interval| interval < (1 << 30) - 64), "{segment:?}");
        }
        check_all(&plan).unwrap();
    }
}

/// After ten seconds and after an hour, the error of the last step is no larger than that of the first.
#[test]
fn nothing_drifts() {
    for (steps, limits) in [(9_900_000, limits_of(1e6, 1e7)), (360_000_000, limits_of(1e5, 1e6))] {
        let plan = fastest([steps, steps / 3, 12_345], limits);
        check_all(&plan).unwrap();
        for (axis, n) in plan.steps.iter().enumerate() {
            let axis = Axis { plan: &plan, axis, tick_hz: 125_000_000 };
            let last = axis.segments().last().unwrap();
            let excess = axis.excess(n.unsigned_abs(), last.last_ticks(), 0.0);
            assert_eq!(excess, None, "ticks after {} s", plan.profile.duration_s());
        }
    }
}

/// Axes of one move cruise over the same interval: the cruise of each begins and ends within one of its step periods of
/// that interval.
#[test]
fn axes_share_their_intervals() {
    let plan = fastest([120_000, -70_001, 33_333], limits_of(1e6, 1e7));
    let (from_s, to_s) = (plan.profile.t_accel_s(), plan.profile.t_accel_s() + plan.profile.t_cruise_s());
    for (axis, n) in plan.steps.iter().enumerate() {
        let period_s = plan.profile.distance_steps() / (f64::from(n.unsigned_abs()) * 1e6);
        let cruise: Vec<Segment> = plan
            .segments(axis, 125_000_000)
            .filter(|segment| {
                segment.steps() > 1_000 && segment.intervals().max() <= segment.intervals().min().map(|min| min + 1)
            })
            .collect();
        let [cruise] = cruise[..] else { panic!("{cruise:?}") };
        let begins_s = cruise.first_ticks() as f64 / 125e6;
        let ends_s = cruise.last_ticks() as f64 / 125e6;
        assert!((begins_s - from_s).abs() <= period_s && (ends_s - to_s).abs() <= period_s, "axis {axis}");
    }
}

/// The numbers of segments of the fastest move and of the parking gantry's move.
#[test]
fn segments_are_few() {
    let count = |steps, limits, tick_hz| fastest([steps], limits).segments(0, tick_hz).count();
    assert_eq!(count(120_000, limits_of(1e6, 1e7), 125_000_000), 357);
    assert_eq!(count(120_000, limits_of(1e6, 1e7), 1_000_000), 205);
    assert_eq!(count(8_750, limits_of(2_400.0, 2_500.0), 125_000_000), 841);
    assert_eq!(count(8_750, limits_of(2_400.0, 2_500.0), 1_000_000), 264);
}

/// The same by each speed profile that is built in, at both tick rates.
#[test]
fn segments_of_curves_are_few() {
    let limits = Limits { start_speed_steps_s: 1e3, jerk_steps_s3: 1e6, ..limits_of(5e4, 1e5) };
    let counts = SpeedProfile::ALL.map(|interval_split| {
        let plan = SyncMove::plan([40_000], &[limits], IntervalSplit::Fastest, interval_split, None).unwrap();
        RATES_HZ.map(|tick_hz| plan.segments(0, tick_hz).count())
    });
    let wanted = [[303, 803], [444, 961], [484, 1202], [574, 2484], [553, 2814], [619, 2485], [445, 1114]];
    assert_eq!(counts[..], wanted[..counts.len()], "{:?}", SpeedProfile::ALL);
}
