//! A plan in ticks, and the steps of an axis in it.

use super::fixed_ramp::log2_of;
use super::shared_spans::SharedSpans;
use super::u96::exponent;
use super::{NO_RAMP_S, PhaseBoundaries, StepRange};
use crate::profile::Profile;
use crate::ramp::Ramp;

/// A plan in ticks from the start of the run: what its axes have in common when they are compiled, computed once. The axis that
/// needs a span of a curved ramp first computes it and leaves it here for the others.
#[derive(Clone, Debug)]
pub struct TimedPlan {
    pub(super) profile: Profile,
    /// True if it is the plan of a whole move.
    pub(crate) is_whole: bool,
    pub(super) boundaries: PhaseBoundaries,
    pub(super) clock: Clock,
    /// Its ramps, if they are at constant acceleration.
    pub(super) accel: Option<ConstantAccelRamp>,
    pub(super) decel: Option<ConstantAccelRamp>,
    /// Its cruise, if that lasts any time.
    pub(super) cruise: Option<Cruise>,
    /// For curved ramps: how far the profile is at the first step of any axis, and how far it goes on after the last
    /// step of any axis.
    pub(super) begin_steps: f64,
    pub(super) end_steps: f64,
    pub(super) spans: SharedSpans,
}

/// The ticks of a plan, or of a part of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clock {
    pub(super) tick_hz: f64,
    /// log2 of `tick_hz`, in units of 2^-16.
    pub(super) hz_log2: i32,
    /// The instants at which it begins and ends.
    pub(super) begin_ticks: f64,
    pub(super) end_ticks: f64,
}

/// The steps of an axis, and when the plan makes them. They count from 0, their instants from the start of the run.
#[derive(Clone, Copy, Debug)]
pub(super) struct TimedStepRange<'a> {
    pub(super) clock: &'a Clock,
    pub(super) step_range: &'a StepRange,
}

/// A ramp at constant acceleration, in ticks and steps of the longest axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct ConstantAccelRamp {
    pub(super) slow_steps_s: f64,
    pub(super) accel_steps_s2: f64,
    /// f/a.
    ticks_per_speed: f64,
    /// The time from standstill to the ramp's slow end at the ramp's acceleration: C = f v/a.
    pub(super) lead_ticks: f64,
    /// The amount that half a step adds to the square of the time from standstill: B/2 = f²/a.
    pub(super) slope_ticks2: f64,
}

/// Constant speed, in ticks and steps of the longest axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cruise {
    pub(super) ticks_per_step: f64,
    /// The instant at which the profile would have begun if all of it were at that speed.
    pub(super) start_ticks: f64,
}

impl TimedPlan {
    /// An empty timed plan.
    #[must_use]
    pub const fn empty() -> Self {
        Self {
            profile: Profile::NONE,
            is_whole: false,
            boundaries: PhaseBoundaries::NONE,
            clock: Clock { tick_hz: 0.0, hz_log2: 0, begin_ticks: 0.0, end_ticks: 0.0 },
            accel: None,
            decel: None,
            cruise: None,
            begin_steps: 0.0,
            end_steps: 0.0,
            spans: SharedSpans::NONE,
        }
    }

    /// Changes in its place, because it is large, to a profile that begins at `begin_s` from the start of the run, in ticks of
    /// 1/`tick_hz` s.
    pub(crate) fn set(&mut self, plan: &Profile, is_whole: bool, begin_s: f64, tick_hz: u32) {
        (self.profile, self.is_whole, self.boundaries) = (*plan, is_whole, PhaseBoundaries::of(plan));
        self.clock = Clock::new([begin_s, begin_s + plan.duration_s()], tick_hz);
        self.accel = ConstantAccelRamp::of(&plan.accel, self.clock.tick_hz, None);
        self.decel = ConstantAccelRamp::of(&plan.decel, self.clock.tick_hz, self.accel.as_ref());
        self.cruise = (plan.t_cruise_s() > 0.0).then(|| Cruise::of(plan, &self.clock));
        (self.begin_steps, self.end_steps) = (0.0, 0.0);
        self.spans.clear();
    }

    /// Makes its spans include the steps of all these step ranges.
    pub(crate) fn set_reach(&mut self, step_ranges: impl Iterator<Item = StepRange>) {
        let (mut begin, mut end) = (f64::INFINITY, f64::INFINITY);
        for step_range in step_ranges {
            (begin, end) = (begin.min(step_range.begin_steps()), end.min(step_range.end_steps()));
        }
        (self.begin_steps, self.end_steps) = (begin, end);
    }

    /// True if the acceleration changes within a ramp.
    pub(crate) fn is_curved(&self) -> bool {
        self.profile.is_curved()
    }
}

impl Clock {
    pub(super) fn new([begin_s, end_s]: [f64; 2], tick_hz: u32) -> Self {
        let hz = f64::from(tick_hz);
        Self { tick_hz: hz, hz_log2: log2_of(hz), begin_ticks: begin_s * hz, end_ticks: end_s * hz }
    }
}

impl ConstantAccelRamp {
    /// A ramp of one axis.
    pub(super) fn new(slow_steps_s: f64, accel_steps_s2: f64, tick_hz: f64) -> Self {
        let ticks_per_speed = tick_hz / accel_steps_s2;
        let (lead_ticks, slope_ticks2) = (ticks_per_speed * slow_steps_s, ticks_per_speed * tick_hz);
        Self { slow_steps_s, accel_steps_s2, ticks_per_speed, lead_ticks, slope_ticks2 }
    }

    /// `None` if its acceleration changes, or if it is no ramp. `other` saves a division if it has the same
    /// acceleration.
    fn of(ramp: &Ramp, tick_hz: f64, other: Option<&Self>) -> Option<Self> {
        let (slow_steps_s, accel_steps_s2) = (ramp.slow_steps_s(), ramp.constant_accel_steps_s2()?);
        if ramp.duration_s() <= NO_RAMP_S {
            return None;
        }
        let (ticks_per_speed, slope_ticks2) = match other {
            Some(other) if other.accel_steps_s2 == accel_steps_s2 => (other.ticks_per_speed, other.slope_ticks2),
            _ => {
                let ticks_per_speed = tick_hz / accel_steps_s2;
                (ticks_per_speed, ticks_per_speed * tick_hz)
            }
        };
        let lead_ticks = ticks_per_speed * slow_steps_s;
        Some(Self { slow_steps_s, accel_steps_s2, ticks_per_speed, lead_ticks, slope_ticks2 })
    }
}

impl Cruise {
    pub(super) fn of(plan: &Profile, clock: &Clock) -> Self {
        let Clock { tick_hz, begin_ticks, .. } = *clock;
        let ticks_per_step = tick_hz / plan.cruise_speed_steps_s();
        let start_ticks = begin_ticks + tick_hz * plan.t_accel_s() - ticks_per_step * plan.accel_end_steps();
        Self { ticks_per_step, start_ticks }
    }
}

impl TimedStepRange<'_> {
    /// The point for instants of the run.
    pub(super) fn point(&self) -> u8 {
        point_for(exponent(self.clock.end_ticks))
    }
}

/// The point of the finest units in which 63 bits hold ticks below 2^(`exponent` + 1).
pub(super) fn point_for(exponent: i32) -> u8 {
    (62 - exponent).clamp(1, 32) as u8
}
