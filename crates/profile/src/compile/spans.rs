//! One axis on the spans of a ramp whose acceleration changes (`shared_spans`).
//!
//! Segments are computed from the polynomial in fixed point ([`Curve`]). Each axis has its own curve.

use super::curve::{Curve, SpanSteps};
use super::hermite::Hermite;
use super::shared_spans::{Reached, Span};
use super::timed_plan::{TimedPlan, TimedStepRange};
use super::{NEAREST_STEPS, StepRange};
use crate::segment::Segment;

/// One axis on the spans of a ramp.
#[derive(Clone, Debug)]
pub(super) struct Spans {
    is_backwards: bool,
    /// The number of spans that it has come to.
    count: u32,
    /// The end of the last of them. Before the first one, it is where that begins.
    reached: Reached,
    curve: Curve,
    /// The step after the span's last.
    curve_end: u32,
    /// The step after the ramp's last.
    end: u32,
}

impl Spans {
    /// The spans over the steps from `begin` to the one before `end`: those of the accelerating ramp, or, if
    /// `is_backwards`, of the decelerating one.
    #[cold]
    pub(super) fn new(timed_plan: &mut TimedPlan, is_backwards: bool, (begin, end): (u32, u32)) -> Self {
        // Span 0 has no polynomial. It is kept so that other axes find where the first span begins.
        let reached = match timed_plan.spans.find(is_backwards, 0) {
            Some(none) => none.end,
            None => {
                let end = timed_plan.path(is_backwards).begin(timed_plan);
                timed_plan.spans.keep(Span { end, is_backwards, ..Span::NONE });
                end
            }
        };
        Self { is_backwards, count: 0, reached, curve: Curve::empty(), curve_end: begin, end }
    }

    /// The segment that begins at the step with the number `step`.
    pub(super) fn segment(&mut self, step: u32, step_range: &StepRange, timed_plan: &mut TimedPlan) -> Segment {
        while self.curve_end <= step {
            self.next_span(step, step_range, timed_plan);
        }
        self.curve.segment(step, self.curve_end.wrapping_sub(step))
    }

    /// Goes on to the next span. Its first step, if it has any, is `step`.
    #[cold]
    fn next_span(&mut self, step: u32, step_range: &StepRange, timed_plan: &mut TimedPlan) {
        self.count += 1;
        let hermite = match timed_plan.spans.find(self.is_backwards, self.count) {
            Some(span) => {
                self.reached = span.end;
                span.hermite
            }
            None => {
                let hermite = timed_plan.path(self.is_backwards).next(&mut self.reached);
                let (end, number, is_backwards) = (self.reached, self.count, self.is_backwards);
                timed_plan.spans.keep(Span { hermite, end, number, is_backwards });
                hermite
            }
        };
        let is_last = self.reached.parameter >= self.reached.last;
        self.curve_end = if is_last { self.end } else { self.steps_before(self.reached.state.steps, step_range) };
        self.curve_end = self.curve_end.clamp(step, self.end);
        if self.curve_end == step {
            return;
        }
        let steps_after_begin = self.steps_after(&hermite, step, step_range);
        let range = SpanSteps { step, count: self.curve_end.wrapping_sub(step), steps_after_begin };
        self.curve =
            Curve::new(&hermite, TimedStepRange { clock: &timed_plan.clock, step_range }, self.is_backwards, range);
    }

    /// The number of steps that are due before the ramp is at `ramp_steps`.
    fn steps_before(&self, ramp_steps: f64, step_range: &StepRange) -> u32 {
        let axis_steps = ramp_steps / step_range.stride + 0.5;
        if self.is_backwards {
            self.end - ((axis_steps - step_range.beyond) as u32).min(self.end)
        } else {
            (axis_steps + step_range.ahead) as u32
        }
    }

    /// The number of steps after the span's beginning at which `step` is due. If rounding puts it a little before, that is 0.
    fn steps_after(&self, hermite: &Hermite, step: u32, step_range: &StepRange) -> f64 {
        let begin = hermite.begin_steps / step_range.stride;
        let after = if self.is_backwards {
            begin - (f64::from(self.end - step) - 0.5 + step_range.beyond).max(NEAREST_STEPS)
        } else {
            (f64::from(step) + 0.5 - step_range.ahead).max(NEAREST_STEPS) - begin
        };
        after.max(0.0)
    }
}
