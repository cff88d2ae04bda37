//! A phase of a move as one axis sees it: when its steps are due, and how many of them make a segment.

use super::gentle::Gentle;
use super::ramp::Ramp;
use super::wide::{Line, Wide, exponent, fixed};
use crate::segment::{SPAN_MAX_TICKS, Segment};
use crate::trapezoid::{EndRamp, Trapezoid};

/// The number of an axis's last step is below this; steps count from 0.
const STEPS_END: u32 = 1 << 31;
/// The growth of a segment's intervals is rounded to 2^-32 tick: 2^-7 tick over so many steps, log2.
const CURVED_LOG2_MAX: u8 = 14;
/// A segment's interval is rounded to 2^-32 tick: 2^-10 tick over so many steps, log2.
const EVEN_LOG2_MAX: u8 = 22;
/// From this lead on, a ramp is [`Gentle`], ticks: 26 days at 125 MHz.
const GENTLE_LEAD_TICKS: f64 = 281_474_976_710_656.0;

/// What an axis makes of the plan.
#[derive(Clone, Copy)]
pub(super) struct View {
    /// Steps of the master per step of the axis; at least 1.
    pub(super) stride: f64,
    pub(super) tick_hz: f64,
}

/// A step as the law of its phase knows it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Knot {
    /// When it is due, units of 2^-point tick from the start of the move.
    pub(super) instant: u64,
    /// How fast the axis is there: see [`Ramp`].
    pub(super) level: i32,
}

/// Consecutive steps of an axis that share a law.
#[derive(Clone, Copy, Debug)]
pub(super) struct Phase {
    law: Law,
    /// What the law's times are added to, or, backwards, subtracted from.
    origin: u64,
    /// The step after its last.
    pub(super) end: u32,
    /// The law goes on smoothly to this step, which may be beyond the phase.
    reach: u32,
    /// Decelerating: the law's times count back from the end of the move, its steps from `reach`.
    backwards: bool,
    /// Instants are in units of 2^-point tick; 32 at most, less for a move too long for that.
    point: u8,
    /// A segment holds 2^length_log2 steps, or those left.
    length_log2: u8,
    length_log2_max: u8,
}

/// How long an odd number of half steps takes.
#[derive(Clone, Copy, Debug)]
enum Law {
    Even(Line),
    Ramp(Ramp),
    Gentle(Gentle),
}

impl Phase {
    /// No steps.
    pub(super) fn empty() -> Self {
        let nowhere = Line { start: Wide::default(), slope: Wide::default() };
        Self::curved(Law::Even(nowhere), 0, 32, 0, 0)
    }

    /// Accelerates from the first step to the one before `end`.
    pub(super) fn accelerating(plan: &Trapezoid, view: View, end: u32) -> Self {
        let ramp = plan.accel_ramp();
        let lead_ticks = view.lead_ticks(ramp);
        let reach = beyond(end, CURVED_LOG2_MAX);
        if lead_ticks >= GENTLE_LEAD_TICKS {
            let point = point_for(view.tick_hz * plan.t_accel_s());
            return Self::curved(Law::Gentle(Gentle::new(ramp, view, point)), 0, point, end, reach);
        }
        let slope = view.slope(ramp);
        let farthest_squared = lead_ticks * lead_ticks + slope * (2.0 * f64::from(reach) + 1.0);
        let point = point_of(exponent(farthest_squared) / 2);
        let lead = fixed(lead_ticks, point.into()) as u64;
        let radicand = Line { start: Wide::new(squared(lead)), slope: Wide::new(fixed(slope, radicand_point(point))) };
        let law = Law::Ramp(Ramp::new(radicand, point, view.tick_hz));
        Self::curved(law, lead.wrapping_neg(), point, end, reach)
    }

    /// Keeps its speed up to the step before `end`.
    pub(super) fn cruising(plan: &Trapezoid, view: View, end: u32) -> Self {
        let speed = plan.cruise_speed_steps_s();
        let start_ticks = view.tick_hz * (plan.t_accel_s() - plan.accel_end_steps() / speed);
        let period_ticks = view.tick_hz * view.stride / speed;
        let point = point_for(view.tick_hz * (plan.t_accel_s() + plan.t_cruise_s()));
        let line = Line {
            start: Wide::new(fixed(start_ticks, i32::from(point) + 32)),
            slope: Wide::new(fixed(period_ticks / 2.0, i32::from(point) + 32)),
        };
        let held_log2 = exponent(f64::from(SPAN_MAX_TICKS) / period_ticks).clamp(0, i32::from(EVEN_LOG2_MAX)) as u8;
        Self {
            law: Law::Even(line),
            origin: 0,
            end,
            reach: beyond(end, held_log2),
            backwards: false,
            point,
            length_log2: held_log2,
            length_log2_max: held_log2,
        }
    }

    /// Decelerates to the last of the axis's `steps`.
    pub(super) fn decelerating(plan: &Trapezoid, view: View, steps: u32) -> Self {
        let ramp = plan.decel_ramp();
        let lead_ticks = view.lead_ticks(ramp);
        let duration_ticks = view.tick_hz * plan.duration_s();
        let backwards = |law, origin, point, reach| Self {
            backwards: true,
            length_log2: CURVED_LOG2_MAX,
            ..Self::curved(law, origin, point, steps, reach)
        };
        if lead_ticks >= GENTLE_LEAD_TICKS {
            let point = point_for(duration_ticks);
            let origin = fixed(duration_ticks, point.into()) as u64;
            return backwards(Law::Gentle(Gentle::new(ramp, view, point)), origin, point, steps - 1);
        }
        let slope_ticks2 = view.slope(ramp);
        let point = point_for(lead_ticks + duration_ticks);
        let lead = fixed(lead_ticks, point.into()) as u64;
        let slope = fixed(slope_ticks2, radicand_point(point));
        // The ramp would go on to standstill.
        let beyond = (lead_ticks * lead_ticks / (2.0 * slope_ticks2)).min(f64::from(1 << CURVED_LOG2_MAX)) as u32;
        let start = squared(lead).saturating_sub(slope * u128::from(2 * beyond));
        let radicand = Line { start: Wide::new(start), slope: Wide::new(slope) };
        let origin = (fixed(duration_ticks, point.into()) as u64).wrapping_add(lead);
        backwards(Law::Ramp(Ramp::new(radicand, point, view.tick_hz)), origin, point, steps - 1 + beyond)
    }

    fn curved(law: Law, origin: u64, point: u8, end: u32, reach: u32) -> Self {
        let (length_log2, length_log2_max) = match law {
            Law::Ramp(_) => (0, CURVED_LOG2_MAX),
            // Straight to within what can be told over any segment.
            Law::Gentle(_) | Law::Even(_) => (CURVED_LOG2_MAX, CURVED_LOG2_MAX),
        };
        Self { law, origin, end, reach, backwards: false, point, length_log2, length_log2_max }
    }

    /// The step with the number `step`, up to `reach`.
    pub(super) fn knot(&self, step: u32) -> Knot {
        let from_origin = if self.backwards { self.reach.wrapping_sub(step) } else { step };
        let half_steps = from_origin.wrapping_mul(2) | 1;
        let Knot { instant, level } = match &self.law {
            Law::Even(line) => Knot { instant: line.at(half_steps).upper(), level: 0 },
            Law::Ramp(ramp) => ramp.knot(half_steps),
            Law::Gentle(gentle) => Knot { instant: gentle.units(half_steps), level: 0 },
        };
        let instant =
            if self.backwards { self.origin.wrapping_sub(instant) } else { self.origin.wrapping_add(instant) };
        Knot { instant, level }
    }

    /// The segment that begins at the step with the number `step`, and the step after it, which means nothing after the
    /// phase's end.
    pub(super) fn segment(&mut self, step: u32, first: Knot) -> (Segment, Knot) {
        let left = self.end - step;
        if left == 1 {
            return (Segment::single(first.instant, self.point), first);
        }
        let mut log2 = self.choose_length_log2(step, first.level);
        let mut far = self.knot(step.wrapping_add(1 << log2));
        while far.instant.wrapping_sub(first.instant) >= u64::from(SPAN_MAX_TICKS) << self.point {
            if log2 == 0 {
                return (Segment::single(first.instant, self.point), far);
            }
            log2 -= 1;
            far = self.knot(step.wrapping_add(1 << log2));
        }
        // The step at the far end is on the quadratic too.
        let steps = if left - 1 <= 1 << log2 { left } else { 1 << log2 };
        let rise = far.instant.wrapping_sub(first.instant);
        let bend = match self.law {
            Law::Even(_) => 0,
            _ if log2 == 0 => 0,
            _ => {
                let middle = self.knot(step.wrapping_add(1 << (log2 - 1)));
                let half_rise = middle.instant.wrapping_sub(first.instant);
                rise.wrapping_sub(half_rise).wrapping_sub(half_rise) as i64
            }
        };
        (Segment::fit(steps, log2.into(), first.instant, rise, bend, self.point), far)
    }

    fn choose_length_log2(&mut self, step: u32, level: i32) -> u8 {
        if let Law::Ramp(ramp) = &self.law {
            let fits = |log2: u8| ramp.fits(log2.into(), level, self.backwards);
            while self.length_log2 < self.length_log2_max && fits(self.length_log2 + 1) {
                self.length_log2 += 1;
            }
            while self.length_log2 > 0 && !fits(self.length_log2) {
                self.length_log2 -= 1;
            }
        }
        let mut log2 = self.length_log2;
        while 1 << log2 > self.reach - step {
            log2 -= 1;
        }
        log2
    }
}

impl View {
    /// From standstill to the ramp's slow end at the ramp's acceleration: f v/a.
    fn lead_ticks(&self, ramp: EndRamp) -> f64 {
        self.tick_hz * ramp.slow_steps_s / ramp.accel_steps_s2
    }

    /// What half a step adds to the radicand: f²/a, in ticks².
    fn slope(&self, ramp: EndRamp) -> f64 {
        self.tick_hz * self.tick_hz * self.stride / ramp.accel_steps_s2
    }
}

/// The last step of a segment that begins at the last one before `end`.
fn beyond(end: u32, length_log2: u8) -> u32 {
    (end - 1).saturating_add(1 << length_log2).min(STEPS_END - 1)
}

/// The finest unit that `ticks` fit into 63 bits of.
fn point_for(ticks: f64) -> u8 {
    point_of(exponent(ticks))
}

fn point_of(exponent: i32) -> u8 {
    (62 - exponent).clamp(0, 32) as u8
}

/// A root has 32 bits more than half its radicand's.
fn radicand_point(point: u8) -> i32 {
    2 * i32::from(point) - 32
}

/// The radicand whose root is `time`.
fn squared(time: u64) -> u128 {
    (u128::from(time) * u128::from(time)) >> 32
}
