//! A plan in ticks: what its axes have in common when they are compiled.

use super::StepRange;
use super::shared_spans::SharedSpans;
use super::timed_plan::{Clock, TimedPlan};
use crate::profile::Profile;

/// What the axes of a plan have in common when they are compiled, computed once: the plan in ticks, and the spans of
/// its curved ramps. The axis that needs a span first computes it and leaves it here for the others.
#[derive(Clone, Debug)]
pub struct Course {
    pub(super) plan: TimedPlan,
    pub(super) spans: SharedSpans,
}

impl Course {
    /// A course of no plan.
    #[must_use]
    pub const fn empty() -> Self {
        Self { plan: TimedPlan::EMPTY, spans: SharedSpans::NONE }
    }

    /// Changes to a profile that begins at `begin_s` from the start of the run, in ticks of 1/`tick_hz` s.
    pub(crate) fn set(&mut self, plan: &Profile, is_whole: bool, begin_s: f64, tick_hz: u32) {
        self.plan.set(plan, is_whole, begin_s, tick_hz);
        self.spans.clear();
    }

    /// Changes to a blend that begins at `begin_s` from the start of the run.
    pub(crate) fn set_clock(&mut self, ends_s: [f64; 2], tick_hz: u32) {
        self.plan.clock = Clock::new(ends_s, tick_hz);
    }

    /// Makes its spans include the steps of all these step ranges.
    pub(crate) fn set_reach(&mut self, step_ranges: impl Iterator<Item = StepRange>) {
        let (mut begin, mut end) = (f64::INFINITY, f64::INFINITY);
        for step_range in step_ranges {
            (begin, end) = (begin.min(step_range.begin_steps()), end.min(step_range.end_steps()));
        }
        (self.plan.begin_steps, self.plan.end_steps) = (begin, end);
    }

    pub(crate) fn is_whole(&self) -> bool {
        self.plan.is_whole
    }

    /// Whether the acceleration changes within a ramp.
    pub(crate) fn is_curved(&self) -> bool {
        self.plan.profile.is_curved()
    }
}
