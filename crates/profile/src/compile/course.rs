//! A plan in ticks: what its axes have in common when they are compiled.

use super::fixed_ramp::log2_of;
use super::setup::{ConstantAccelRamp, Cruise};
use super::spans::SharedSpans;
use super::{PhaseBounds, Stretch};
use crate::profile::Profile;

/// What the axes of a plan have in common when they are compiled, computed once: the plan in ticks, and the spans of
/// its curved ramps. The axis that needs a span first computes it and leaves it here for the others.
#[derive(Clone, Debug)]
pub struct Course {
    pub(super) frame: Frame,
    pub(super) spans: SharedSpans,
}

/// A plan in ticks from the start of the run.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    pub(super) plan: Profile,
    /// Whether it is the plan of a whole move.
    pub(super) is_whole: bool,
    pub(super) bounds: PhaseBounds,
    pub(super) tick_hz: f64,
    /// log2 of `tick_hz`, in units of 2^-16.
    pub(super) hz_log2: i32,
    /// When the profile begins and ends.
    pub(super) begin_ticks: f64,
    pub(super) end_ticks: f64,
    /// Its ramps, if they are at constant acceleration.
    pub(super) accel: Option<ConstantAccelRamp>,
    pub(super) decel: Option<ConstantAccelRamp>,
    /// Its cruise, if that lasts any time.
    pub(super) cruise: Option<Cruise>,
    /// For curved ramps: how far the profile is at the first step of any axis, and how far it goes on after the last
    /// step of any axis.
    pub(super) begin_steps: f64,
    pub(super) end_steps: f64,
}

impl Course {
    /// A course of no plan.
    #[must_use]
    pub const fn empty() -> Self {
        Self { frame: Frame::EMPTY, spans: SharedSpans::NONE }
    }

    /// Changes to a profile that begins at `begin_s` from the start of the run, in ticks of 1/`tick_hz` s.
    pub(crate) fn set(&mut self, plan: &Profile, is_whole: bool, begin_s: f64, tick_hz: u32) {
        self.frame = Frame::new(plan, is_whole, begin_s, tick_hz);
        self.spans.clear();
    }

    /// Makes its spans include the steps of all these stretches.
    pub(crate) fn set_reach(&mut self, stretches: impl Iterator<Item = Stretch>) {
        let (mut begin, mut end) = (f64::INFINITY, f64::INFINITY);
        for stretch in stretches {
            (begin, end) = (begin.min(stretch.begin_steps()), end.min(stretch.end_steps()));
        }
        (self.frame.begin_steps, self.frame.end_steps) = (begin, end);
    }

    pub(crate) fn is_whole(&self) -> bool {
        self.frame.is_whole
    }

    /// Whether the acceleration changes within a ramp.
    pub(crate) fn is_curved(&self) -> bool {
        self.frame.plan.is_curved()
    }
}

impl Frame {
    const EMPTY: Self = Self {
        plan: Profile::NONE,
        is_whole: false,
        bounds: PhaseBounds::NONE,
        tick_hz: 0.0,
        hz_log2: 0,
        begin_ticks: 0.0,
        end_ticks: 0.0,
        accel: None,
        decel: None,
        cruise: None,
        begin_steps: 0.0,
        end_steps: 0.0,
    };

    fn new(plan: &Profile, is_whole: bool, begin_s: f64, tick_hz: u32) -> Self {
        let hz = f64::from(tick_hz);
        let begin_ticks = begin_s * hz;
        let accel = ConstantAccelRamp::of(&plan.accel, hz, None);
        Self {
            plan: *plan,
            is_whole,
            bounds: PhaseBounds::of(plan),
            tick_hz: hz,
            hz_log2: log2_of(hz),
            begin_ticks,
            end_ticks: (begin_s + plan.duration_s()) * hz,
            decel: ConstantAccelRamp::of(&plan.decel, hz, accel.as_ref()),
            accel,
            cruise: (plan.t_cruise_s() > 0.0).then(|| Cruise::of(plan, begin_ticks, hz)),
            begin_steps: 0.0,
            end_steps: 0.0,
        }
    }
}
