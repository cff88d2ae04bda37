//! Moves that go on otherwise: held, resumed and at another speed, at random instants under every law; the same in every
//! run; `PROPTEST_RNG_SEED=n cargo test -p isostep-profile --test replan` tries others.

use isostep_profile::{
    FIT_ERROR_MAX_TICKS, IntervalLaw, Limits, SpeedLaw, SyncMove, fit_error_max_ticks, replan::Parts,
};
use proptest::prelude::*;

const TICK_HZ: u32 = 125_000_000;
/// What fixed point and 64-bit floats lose, ticks.
const ROUNDING_TICKS: f64 = 0.1;
/// Speeds are looked at so often on each part.
const LOOKS: u32 = 200;

prop_compose! {
    fn limits()(
        top_log in 2.0..5.5f64, accel_log in 0.3..2.0f64, decel_share in 0.5..2.0f64, start_share in 0.0..0.3f64,
        jerk_log in -0.5..2.0f64,
    ) -> Limits {
        let top = 10f64.powf(top_log);
        let accel = top * 10f64.powf(accel_log);
        Limits {
            start_speed_steps_s: top * start_share,
            top_speed_steps_s: top,
            accel_steps_s2: accel,
            decel_steps_s2: accel * decel_share,
            jerk_steps_s3: 10f64.powf(jerk_log) * accel * accel / top,
        }
    }
}

fn moving(law: SpeedLaw, limits: Limits) -> Limits {
    let least = if law.is_over_displacement() { 1e-2 * limits.top_speed_steps_s } else { 0.0 };
    Limits { start_speed_steps_s: limits.start_speed_steps_s.max(least), ..limits }
}

fn law() -> impl Strategy<Value = SpeedLaw> {
    prop::sample::select(&SpeedLaw::ALL[..])
}

fn interval_law() -> impl Strategy<Value = IntervalLaw> {
    prop_oneof![Just(IntervalLaw::Fastest), Just(IntervalLaw::Thirds)]
}

/// A chain of parts on one clock: a move up to `at_s`, then others.
struct Chain {
    first: SyncMove<2>,
    at_s: f64,
    others: Vec<SyncMove<2>>,
}

impl Chain {
    fn new(first: SyncMove<2>, at_s: f64, others: Parts<2>) -> Self {
        Self { first, at_s, others: others.into_iter().flatten().collect() }
    }

    /// Every part begins where and when the one before it ends, at its speed.
    fn check_joints(&self) -> Result<(), TestCaseError> {
        let mut end = (self.at_s, self.first.place_at(self.at_s), self.first.speed_at(self.at_s));
        for part in &self.others {
            // An easing part is the second half of its profile.
            let begin_s = end.0;
            prop_assert!(
                (part.place_at(begin_s) - end.1).abs() <= 1e-9 * (end.1 + 1.0),
                "{} {}",
                part.place_at(begin_s),
                end.1
            );
            let speed = part.speed_at(begin_s + 1e-12);
            prop_assert!((speed - end.2).abs() <= 1e-6 * (end.2 + 1.0), "{speed} after {}", end.2);
            end = (part.end_s(), part.end_steps(), part.profile.exit_speed_steps_s());
        }
        Ok(())
    }

    /// No part exceeds `limits` of the longest axis.
    fn check_limits(&self, limits: &Limits, law: SpeedLaw) -> Result<(), TestCaseError> {
        let mut begin_s = self.at_s;
        for part in &self.others {
            for look in 0..=LOOKS {
                let t_s = begin_s + (part.end_s() - begin_s) * f64::from(look) / f64::from(LOOKS);
                let profile_s = t_s - (part.end_s() - part.profile.duration_s());
                let (speed, accel) = (part.speed_at(t_s), part.profile.accel_at(profile_s));
                prop_assert!(speed <= limits.top_speed_steps_s * (1.0 + 1e-9), "{speed} steps/s");
                prop_assert!(accel <= limits.accel_steps_s2 * (1.0 + 1e-9), "{accel} steps/s2");
                prop_assert!(-accel <= limits.decel_steps_s2 * (1.0 + 1e-9), "{accel} steps/s2");
                let jerk = part.profile.jerk_at(profile_s).abs();
                prop_assert!(law != SpeedLaw::SCurve || jerk <= limits.jerk_steps_s3 * (1.0 + 1e-9), "{jerk} steps/s3");
            }
            begin_s = part.end_s();
        }
        Ok(())
    }

    /// Every step once, in order, at the instant of the closed form; returns how many each axis makes.
    fn check_steps(&self) -> Result<[u32; 2], TestCaseError> {
        let mut done = [0; 2];
        for (axis, done) in done.iter_mut().enumerate() {
            let cut = self.first.steps_before(axis, self.first.place_at(self.at_s));
            let mut next = self.first.step_numbers(axis).start;
            let mut last_ticks = 0;
            let parts = std::iter::once((&self.first, cut)).chain(self.others.iter().map(|part| (part, u32::MAX)));
            for (part, most) in parts {
                prop_assert_eq!(part.step_numbers(axis).start, next, "axis {}", axis);
                let ticks = part.segments(axis, TICK_HZ).flat_map(|segment| segment.ticks());
                for (k, tick) in (next..).zip(ticks) {
                    if k > most {
                        break;
                    }
                    let error = tick as f64 - part.step_time_s(axis, k) * f64::from(TICK_HZ);
                    let bound = fit_error_max_ticks(TICK_HZ).max(FIT_ERROR_MAX_TICKS) + 0.5 + ROUNDING_TICKS;
                    prop_assert!(error.abs() <= bound, "axis {axis} step {k}: off by {error} ticks");
                    prop_assert!(tick >= last_ticks, "axis {axis} step {k}: {tick} after {last_ticks}");
                    (last_ticks, next) = (tick, k + 1);
                }
            }
            *done = next - 1;
        }
        Ok(done)
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, failure_persistence: None, ..ProptestConfig::default() })]

    /// A hold at any instant, and the resume: every step of the move is made once, by limits kept throughout.
    #[test]
    fn a_held_move_ends_where_it_should(
        limits in limits(), steps in 2..4_000i32, share in 0.0..1.0f64, law in law(), interval_law in interval_law(),
        at in 0.0..1.0f64,
    ) {
        let limits = [moving(law, limits); 2];
        let steps = [steps, -((f64::from(steps) * share) as i32)];
        let plan = SyncMove::plan(steps, &limits, interval_law, law, None).unwrap();
        let at_s = at * plan.profile.duration_s();
        let Some(parts) = plan.held(at_s, &limits, law).unwrap() else {
            prop_assert!(at_s >= plan.profile.duration_s() - plan.profile.t_decel_s());
            return Ok(());
        };
        let chain = Chain::new(plan, at_s, parts);
        chain.check_joints()?;
        chain.check_limits(&limits[0], law)?;
        let done = chain.check_steps()?;
        let stop = chain.others.last().map_or(plan.place_at(at_s), SyncMove::end_steps);
        prop_assert!(stop <= plan.way_steps() * (1.0 + 1e-9));
        let exit = chain.others.last().map_or(plan.speed_at(at_s), |part| part.profile.exit_speed_steps_s());
        prop_assert!(exit <= limits[0].start_speed_steps_s);

        let Some(rest) = plan.resumed(stop, &limits, interval_law, law, None).unwrap() else {
            prop_assert_eq!(done, steps.map(i32::unsigned_abs));
            return Ok(());
        };
        let chain = Chain { first: rest, at_s: rest.end_s(), others: Vec::new() };
        prop_assert_eq!(rest.step_numbers(0).start, done[0] + 1);
        prop_assert_eq!(rest.step_numbers(1).start, done[1] + 1);
        prop_assert_eq!(chain.check_steps()?, steps.map(i32::unsigned_abs));
    }

    /// Another speed at any instant, higher or lower.
    #[test]
    fn a_move_at_another_speed_ends_where_it_should(
        limits in limits(), steps in 2..4_000i32, share in 0.0..1.0f64, law in law(), interval_law in interval_law(),
        at in 0.0..1.0f64, speeds in (0.1..1.0f64, 0.1..1.0f64),
    ) {
        let limits = [moving(law, limits); 2];
        let steps = [steps, -((f64::from(steps) * share) as i32)];
        let [first, then] = [speeds.0, speeds.1].map(|share| Some(share * limits[0].top_speed_steps_s));
        let plan = SyncMove::plan(steps, &limits, interval_law, law, first).unwrap();
        let at_s = at * plan.profile.duration_s();
        let Some(parts) = plan.respeeded(at_s, &limits, law, then).unwrap() else { return Ok(()) };
        let chain = Chain::new(plan, at_s, parts);
        chain.check_joints()?;
        chain.check_limits(&limits[0], law)?;
        prop_assert_eq!(chain.check_steps()?, steps.map(i32::unsigned_abs));
        let last = chain.others.last().unwrap();
        prop_assert!(last.profile.cruise_speed_steps_s() <= then.unwrap() * (1.0 + 1e-9));
    }
}
