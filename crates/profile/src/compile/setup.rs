//! Takes from the plan's floats what a phase of an axis needs, once a phase.

use super::fixed_phase::{FixedPhase, Formula};
use super::fixed_ramp::{FixedRamp, LENGTH_MAX, log2_of};
use super::small_accel::SmallAccel;
use super::timed_plan::{ConstantAccelRamp, Cruise, TimedPlan, TimedStepRange, point_for};
use super::u96::{Linear, U96, exponent, fixed, short_fixed};
use super::{NEAREST_STEPS, StepRange};
use crate::fixed::{is_zero, product};

/// Steps have numbers below this.
const STEPS_END: u32 = 1 << 31;
/// log2 of the steps of the longest segment of a cruise. Its interval is rounded to 2^-32 tick, which makes 2^-10 tick
/// over this many steps.
const CRUISE_LENGTH_MAX: u32 = 22;
/// log2 of the lead, ticks, from which on a ramp is a [`SmallAccel`]: 13 days at 125 MHz.
const SMALL_ACCEL_LEAD_LOG2: i32 = 47;

/// A ramp in ticks and in the steps of one axis.
struct AxisRamp {
    /// C.
    lead_ticks: f64,
    /// B/2.
    slope_ticks2: f64,
}

impl FixedPhase {
    /// A phase of no steps.
    pub(super) fn empty() -> Self {
        let line = Linear { start: U96::default(), slope: U96::default() };
        Self {
            formula: Formula::ConstantSpeed(line),
            origin: 0,
            end: 0,
            reach: 0,
            backwards: false,
            point: 0,
            length: 0,
        }
    }

    /// Makes it accelerate from the first step to the one before `end`.
    pub(super) fn accelerate(&mut self, ramp: &ConstantAccelRamp, timed: TimedStepRange, end: u32) {
        let (clock, more) = (timed.clock, doubled(-timed.step_range.ahead));
        let axis_ramp = timed.axis_ramp(ramp);
        if axis_ramp.has_small_accel() {
            let (formula, point, length) = small_accel(ramp, timed, more);
            let reach = beyond(end, length);
            let origin = fixed(clock.begin_ticks, point.into()) as u64;
            *self = Self { formula, origin, end, reach, backwards: false, point, length: length as u8 };
            return;
        }
        let reach = beyond(end, LENGTH_MAX);
        let mut exponent_max = axis_ramp.exponent_at(reach);
        if clock.begin_ticks > 0.0 {
            exponent_max = exponent_max.max(exponent(clock.begin_ticks)) + 1;
        }
        let point = point_for(exponent_max);
        let (lead, slope) = (axis_ramp.lead(point), axis_ramp.slope(point));
        let square = squared(lead);
        let start = square.wrapping_add(axis_ramp.first(point, (square, slope), more));
        let formula = Formula::Ramp(axis_ramp.ramp(
            Linear { start: U96::new(start), slope: U96::new(slope) },
            point,
            clock.hz_log2,
        ));
        let origin = short_fixed(clock.begin_ticks, point).wrapping_sub(lead);
        *self = Self { formula, origin, end, reach, backwards: false, point, length: 0 };
    }

    /// Makes it keep its speed up to the step before `end`.
    pub(super) fn cruise(&mut self, plan: &TimedPlan, step_range: &StepRange, end: u32) {
        let timed = TimedStepRange { clock: &plan.clock, step_range };
        let cruise = plan.cruise.unwrap_or_else(|| Cruise::of(&plan.profile, &plan.clock));
        let period_ticks = cruise.ticks_per_step * step_range.stride;
        let start_ticks = cruise.start_ticks - period_ticks * step_range.ahead;
        self.cruise_on(start_ticks, period_ticks, timed, end);
    }

    /// The same for steps of this period, if the axis had begun at that instant half a step before its first one.
    pub(super) fn cruise_on(&mut self, start_ticks: f64, period_ticks: f64, timed: TimedStepRange, end: u32) {
        let point = timed.point();
        // The first 64 of the 96 bits are the instant; a half step takes half a period. If the profile begins less than
        // half a step before the first step, the line may begin a little before the run. That is negative, and taken
        // modulo 2^96, as all lines are.
        let before = fixed((-start_ticks).max(0.0), i32::from(point) + 32);
        let start = U96::new(fixed(start_ticks.max(0.0), i32::from(point) + 32).wrapping_sub(before));
        let slope = U96::new(fixed(period_ticks, i32::from(point) + 31));
        let length = length_held(period_ticks, CRUISE_LENGTH_MAX);
        let formula = Formula::ConstantSpeed(Linear { start, slope });
        *self =
            Self { formula, origin: 0, end, reach: beyond(end, length), backwards: false, point, length: length as u8 };
    }

    /// Makes it decelerate to the last of the axis's steps, the one before `end`.
    pub(super) fn decelerate(&mut self, ramp: &ConstantAccelRamp, timed: TimedStepRange, end: u32) {
        let (clock, more) = (timed.clock, doubled(timed.step_range.beyond));
        let axis_ramp = timed.axis_ramp(ramp);
        if axis_ramp.has_small_accel() {
            let (formula, point, length) = small_accel(ramp, timed, more);
            let origin = fixed(clock.end_ticks, point.into()) as u64;
            *self = Self { formula, origin, end, reach: end - 1, backwards: true, point, length: length as u8 };
            return;
        }
        let point = point_for(exponent(axis_ramp.lead_ticks).max(exponent(clock.end_ticks)) + 1);
        let (lead, slope) = (axis_ramp.lead(point), axis_ramp.slope(point));
        let spare_log2 = axis_ramp.spare_steps_log2();
        let spare = spare_log2.map_or(0, |log2| (1 << log2).min(STEPS_END - end));
        let spared = match spare_log2 {
            Some(log2) if spare == 1 << log2 => slope << (log2 + 1),
            _ => slope * u128::from(2 * spare),
        };
        let square = squared(lead);
        let start = square.saturating_sub(spared).wrapping_add(axis_ramp.first(point, (square, slope), more));
        let formula = Formula::Ramp(axis_ramp.ramp(
            Linear { start: U96::new(start), slope: U96::new(slope) },
            point,
            clock.hz_log2,
        ));
        let origin = short_fixed(clock.end_ticks, point).wrapping_add(lead);
        *self = Self { formula, origin, end, reach: end - 1 + spare, backwards: true, point, length: LENGTH_MAX as u8 };
    }
}

impl TimedStepRange<'_> {
    fn axis_ramp(&self, ramp: &ConstantAccelRamp) -> AxisRamp {
        let StepRange { stride, .. } = *self.step_range;
        let slope_ticks2 =
            if self.step_range.is_longest() { ramp.slope_ticks2 } else { multiplied(ramp.slope_ticks2, stride) };
        AxisRamp { lead_ticks: ramp.lead_ticks, slope_ticks2 }
    }
}

/// A product. Inlined, the compiler would multiply by 1 instead of branching.
#[inline(never)]
fn multiplied(a: f64, b: f64) -> f64 {
    a * b
}

/// Twice a number, which is mostly 0.
fn doubled(steps: f64) -> f64 {
    if is_zero(steps) { 0.0 } else { 2.0 * steps }
}

impl AxisRamp {
    fn has_small_accel(&self) -> bool {
        exponent(self.lead_ticks) >= SMALL_ACCEL_LEAD_LOG2
    }

    /// The lead, in units of 2^-`point` tick.
    fn lead(&self, point: u8) -> u64 {
        short_fixed(self.lead_ticks, point)
    }

    /// The slope, in units of a radicand whose root is in units of 2^-`point` tick. The root is that of 2^32 times the
    /// radicand, so the radicand has 2 `point` - 32 digits after its point.
    fn slope(&self, point: u8) -> u128 {
        fixed(self.slope_ticks2, 2 * i32::from(point) - 32)
    }

    /// By how much the first half step makes a radicand of this slope larger, if it is `more` half steps longer; modulo
    /// 2^96, as lines are. Where the ramp is slowest, the radicand is `square`.
    fn first(&self, point: u8, (square, slope): (u128, u128), more: f64) -> u128 {
        if is_zero(more) {
            return 0;
        }
        let radicand = |half_steps: f64| fixed(self.slope_ticks2 * half_steps, 2 * i32::from(point) - 32);
        let half_steps = 1.0 + more;
        // Rounding may take a step beyond the slow end of its ramp.
        let first = if half_steps < 2.0 * NEAREST_STEPS {
            radicand(half_steps.max(0.0)).max(radicand(2.0 * NEAREST_STEPS).saturating_sub(square))
        } else {
            radicand(half_steps)
        };
        first.wrapping_sub(slope)
    }

    fn ramp(&self, radicand: Linear, point: u8, hz_log2: i32) -> FixedRamp {
        // The slope in the radicand's units.
        let slope_log2 = log2_of(self.slope_ticks2) + ((2 * i32::from(point) - 32) << 16);
        FixedRamp::new(radicand, slope_log2, point, hz_log2)
    }

    /// log2 of the time from standstill to the step `reach`, ticks, rounded down. It may be too large, but not too
    /// small.
    fn exponent_at(&self, reach: u32) -> i32 {
        // 2 reach + 1 half steps are less than 2^(reach_log2 + 1).
        let reach_log2 = 32 - reach.leading_zeros() as i32;
        let squares = [2 * exponent(self.lead_ticks) + 2, exponent(self.slope_ticks2) + reach_log2 + 2];
        // The sum of numbers below 2^a and 2^b is less than twice the larger.
        squares[0].max(squares[1]).div_euclid(2)
    }

    /// log2 of how many steps, or fewer, the ramp would still have before standstill; `None` if there are none.
    fn spare_steps_log2(&self) -> Option<u32> {
        // At most C²/B, computed from the exponents of both.
        let log2 = 2 * exponent(self.lead_ticks) - exponent(self.slope_ticks2) - 2;
        if log2 < 0 { None } else { Some(log2.min(LENGTH_MAX as i32) as u32) }
    }
}

/// The formula of a ramp that hardly accelerates, its point, and log2 of the steps of its segments, over which a quadratic
/// deviates by 2^-6 tick at most. Its first half step is `more` half steps longer.
fn small_accel(ramp: &ConstantAccelRamp, timed: TimedStepRange, more: f64) -> (Formula, u8, u32) {
    let point = timed.point();
    let (tick_hz, stride) = (timed.clock.tick_hz, timed.step_range.stride);
    let ConstantAccelRamp { slow_steps_s, accel_steps_s2, .. } = *ramp;
    let slowest_ticks = tick_hz / slow_steps_s * stride;
    let ramp = SmallAccel { slow_steps_s, accel_steps_s2, half_step: stride / 2.0, more, tick_hz, point };
    (Formula::SmallAccel(ramp), point, length_held(slowest_ticks, LENGTH_MAX))
}

/// log2 of a number of periods that last less than 2^31 ticks together, `max` at most. It is 0 even if one period lasts
/// longer.
fn length_held(period_ticks: f64, max: u32) -> u32 {
    (30 - exponent(period_ticks)).clamp(0, max as i32) as u32
}

/// The last step that a segment of 2^`length` steps can reach if it begins before `end`.
fn beyond(end: u32, length: u32) -> u32 {
    (end - 1).saturating_add(1 << length).min(STEPS_END - 1)
}

/// The radicand whose root is `time`.
fn squared(time: u64) -> u128 {
    let (upper, lower) = ((time >> 32) as u32, time as u32);
    let sides = u128::from(product(upper, lower)) << 1;
    (u128::from(product(upper, upper)) << 32) + sides + u128::from(product(lower, lower) >> 32)
}
