//! The steps of one axis on a span's polynomial, in fixed point.

use super::fit::Quadratic;
use super::fixed_ramp::LENGTH_MAX;
use super::hermite::{ERROR_MAX_TICKS, Hermite, TERMS};
use super::timed_plan::TimedStepRange;
use super::u96::exponent;
use super::{BRIEF_S, FIT_ERROR_MAX_TICKS, fit_error_max_ticks};
use crate::fixed::{TWO_TO_64, polynomial};
use crate::segment::Segment;

/// Instants are in units of 2^-24 tick, or in coarser ones if the move is too long for that.
const POINT_MAX: u8 = 24;
/// y is 1 at this multiple of the span's length, because the last segment may reach beyond the span.
const UNIT_RATIO: f64 = 1.5;
/// A span has at least this many segments, so that the last one does not reach far beyond it.
const SEGMENTS_MIN: u32 = 4;
/// A quadratic over n steps deviates by t''' n³/(72 √3), where t''' is the third derivative. This is 72 √3.
const ERROR_DIVISOR: f64 = 124.707_658_144_959_16;

/// The steps of a span.
pub(super) struct SpanSteps {
    /// The first step.
    pub(super) step: u32,
    /// The number of steps from the beginning of the span to the first step.
    pub(super) steps_after_begin: f64,
    /// The number of steps.
    pub(super) count: u32,
}

/// The instants of steps, t = Σ c_i y^i. Steps count from `first`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Curve {
    /// In units of 2^-`point` tick.
    coefficients: [i64; TERMS],
    point: u8,
    /// log2 of the steps that a segment holds.
    length: u8,
    first: u32,
    /// y of the first step, in units of 2^-64.
    begin: u64,
    /// The difference of y from one step to the next, in units of 2^-64.
    per_step: u64,
}

impl Curve {
    /// A curve of no steps.
    pub(super) fn empty() -> Self {
        Self { coefficients: [0; TERMS], point: 0, length: 0, first: 0, begin: 0, per_step: 0 }
    }

    /// The instants of the steps of `range`. If `is_backwards`, times are counted back from the end of the move.
    pub(super) fn new(hermite: &Hermite, timed: TimedStepRange, is_backwards: bool, range: SpanSteps) -> Self {
        let point = timed.point().min(POINT_MAX);
        let unit_hz = f64::from(1u32 << point);
        let TimedStepRange { clock, step_range } = timed;
        let mut factor = if is_backwards { -clock.tick_hz * unit_hz } else { clock.tick_hz * unit_hz };
        let mut coefficients = hermite.coefficients.map(|coefficient| {
            // The direction of rounding does not matter, because a unit is far less than the deviation of a polynomial.
            let fixed = (coefficient * factor) as i64;
            factor *= UNIT_RATIO;
            fixed
        });
        let origin_ticks = if is_backwards { clock.end_ticks } else { clock.begin_ticks };
        coefficients[0] = coefficients[0].wrapping_add((origin_ticks * unit_hz) as i64);
        let per_step = step_range.stride / (hermite.steps.abs() * UNIT_RATIO);
        Self {
            coefficients,
            point,
            length: length(hermite, timed, range.count),
            first: range.step,
            begin: (range.steps_after_begin * per_step * TWO_TO_64) as u64,
            per_step: (per_step * TWO_TO_64) as u64,
        }
    }

    /// The segment that begins at `step`, which is the first of `left` steps that are left.
    pub(super) fn segment(&self, step: u32, left: u32) -> Segment {
        let first = self.instant(step);
        let mut fit = Quadratic { point: self.point.into(), length: self.length.into(), first, rise: 0, curvature: 0 };
        if left == 1 {
            fit.length = 0;
            return fit.segment(1);
        }
        let n = 1u32.wrapping_shl(fit.length);
        fit.rise = self.instant(step.wrapping_add(n)).wrapping_sub(first);
        if n > 1 {
            let half_rise = self.instant(step.wrapping_add(n / 2)).wrapping_sub(first);
            fit.curvature = fit.rise.wrapping_sub(half_rise).wrapping_sub(half_rise) as i64;
        }
        // The step at the far end lies on the quadratic, too.
        fit.segment(if left.wrapping_sub(1) <= n { left } else { n })
    }

    fn instant(&self, step: u32) -> u64 {
        let y = u64::from(step.wrapping_sub(self.first)).wrapping_mul(self.per_step).wrapping_add(self.begin);
        polynomial(&self.coefficients, y) as u64
    }
}

/// log2 of the steps that a quadratic may hold anywhere on the span.
fn length(hermite: &Hermite, timed: TimedStepRange, count: u32) -> u8 {
    let tick_hz = timed.clock.tick_hz;
    let steps = hermite.steps.abs() / timed.step_range.stride;
    let per_step = tick_hz / steps;
    let curvature = hermite.third_derivative_max() * per_step / (steps * steps * ERROR_DIVISOR);
    // log2 n for the largest n, a power of two, with n³ curvature <= E.
    let held = |error_ticks: f64| (exponent(error_ticks / curvature)).div_euclid(3);
    let strict = held(FIT_ERROR_MAX_TICKS - ERROR_MAX_TICKS);
    let loose = held(fit_error_max_ticks(tick_hz as u32) - ERROR_MAX_TICKS);
    // A brief segment may become up to twice as long.
    let brief = exponent(BRIEF_S * tick_hz / (hermite.slope_max() * per_step)) + 1;
    // There is always a quadratic through three steps.
    let most = exponent(f64::from(count / SEGMENTS_MIN)).min(LENGTH_MAX as i32);
    strict.max(loose.min(brief)).max(1).min(most).max(0) as u8
}
