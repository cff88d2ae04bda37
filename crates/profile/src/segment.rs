//! Step instants as short runs that are replayed by additions.
//!
//! # Design
//! Over a few steps the instant is a quadratic in the step number, to a bounded error. All roots and divisions
//! happen here, once a segment, ahead of time; what is left per step is three 64-bit additions and a shift, the
//! same for every shape of profile ([`Ticks`]).
//!
//! A segment never crosses a phase boundary. Its quadratic passes through the closed form at its first, middle and
//! last step; between them a cubic term c j³ strays by at most t''' h³ / (9 √3), h being half the segment's
//! steps and t''' the third derivative at its slow end, where it is largest. The length is chosen so that this
//! stays within [`FIT_ERROR_MAX_TICKS`]. Each segment starts from the absolute profile: nothing accumulates from
//! one to the next.

use core::sync::atomic::{AtomicU32, Ordering};

use libm::{cbrtf, floor};

use crate::trapezoid::Trapezoid;

/// How far a segment's quadratic may stray from the closed form, ticks. Rounding to a whole tick adds up to half.
pub const FIT_ERROR_MAX_TICKS: f64 = 0.125;

/// Instants inside a segment are Q32.32 ticks from its first step: one segment spans less than this.
const SPAN_MAX_TICKS: f64 = 2_147_483_648.0;
/// The interval is rounded to 2^-33 tick, so that over this many steps it strays by at most 2^-11 tick.
const STEPS_MAX: u32 = 1 << 22;
/// A quadratic through three steps is exact, whatever the profile.
const STEPS_EXACT: u32 = 3;
const ONE_TICK: f64 = 4_294_967_296.0;
const HALF_TICK: u64 = 1 << 31;
/// 9 √3: see the module's error bound.
const CUBIC_BOUND: f64 = 15.588_457_268_119_896;

/// A run of steps of one axis. Made by [`Segments`]; replayed as instants by [`ticks`](Segment::ticks), as intervals by
/// [`intervals`](Segment::intervals).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    steps: u32,
    /// What the rounded first instant leaves over, 2^-32 tick.
    fraction: u32,
    first_ticks: u64,
    /// From the first step to the second, Q32.32 ticks.
    interval: u64,
    /// From one interval to the next, Q32.32 ticks in two's complement.
    growth: u64,
}

impl Segment {
    /// How many steps it holds; at least 1.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// When its first step is due, ticks from the start of the move, rounded to the nearest.
    #[must_use]
    pub fn first_ticks(&self) -> u64 {
        self.first_ticks
    }

    /// When its last step is due, ticks from the start of the move, rounded to the nearest. No loop: a closed sum.
    #[must_use]
    pub fn last_ticks(&self) -> u64 {
        let n = u64::from(self.steps - 1);
        let growths = n * n.saturating_sub(1) / 2;
        let sum = self.interval.wrapping_mul(n).wrapping_add(self.growth.wrapping_mul(growths));
        self.first_ticks + (sum.wrapping_add(u64::from(self.fraction)) >> 32)
    }

    /// The instants of its steps in ticks from the start of the move, rounded to the nearest.
    #[must_use]
    pub fn ticks(&self) -> Ticks {
        Ticks { next: Some(self.first_ticks), intervals: self.intervals() }
    }

    /// The ticks from each of its steps to the next: one fewer than it has steps. They add up to its last instant less
    /// its first, exactly.
    #[inline]
    #[must_use]
    pub fn intervals(&self) -> Intervals {
        Intervals { left: self.steps - 1, fraction: self.fraction, interval: self.interval, growth: self.growth }
    }

    /// `instants_ticks`: the closed form at the first, middle and last of `steps` steps.
    fn fit(steps: u32, instants_ticks: [f64; 3]) -> Self {
        let [first, middle, last] = instants_ticks;
        let base = floor(first);
        let (interval, growth) = if steps == 1 {
            (0.0, 0.0)
        } else {
            // t(j) = first + b j + c j² through j = 0, h and 2h.
            let h = f64::from(steps - 1) / 2.0;
            let c = (last - 2.0 * middle + first) / (2.0 * h * h);
            let b = (last - first) / (2.0 * h) - 2.0 * c * h;
            (b + c, 2.0 * c)
        };
        let offset = fixed(first - base).wrapping_add(HALF_TICK);
        Self {
            steps,
            fraction: offset as u32,
            first_ticks: base as u64 + (offset >> 32),
            interval: fixed(interval),
            growth: fixed(growth),
        }
    }
}

/// Q32.32, two's complement: a negative growth wraps when it is added, as intended.
fn fixed(ticks: f64) -> u64 {
    libm::round(ticks * ONE_TICK) as i64 as u64
}

/// The instants of a segment's steps, ticks from the start of the move. Each costs additions only.
#[derive(Clone, Copy, Debug)]
pub struct Ticks {
    next: Option<u64>,
    intervals: Intervals,
}

impl Iterator for Ticks {
    type Item = u64;

    #[inline]
    fn next(&mut self) -> Option<u64> {
        let instant = self.next?;
        self.next = self.intervals.next().map(|interval| instant + u64::from(interval));
        Some(instant)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = self.next.map_or(0, |_| self.intervals.len() + 1);
        (left, Some(left))
    }
}

impl ExactSizeIterator for Ticks {}

/// The ticks between neighbouring steps of a segment. Each costs additions only.
#[derive(Clone, Copy, Debug)]
pub struct Intervals {
    left: u32,
    fraction: u32,
    interval: u64,
    growth: u64,
}

impl Intervals {
    /// Writes as many intervals as there are left and `words` holds, each plus `bias` (modulo 2^32), and returns how
    /// many. Inlined, so that its caller decides which memory it runs from.
    #[inline(always)]
    pub fn fill(&mut self, words: &[AtomicU32], bias: u32) -> usize {
        let count = words.len().min(self.left as usize);
        for word in &words[..count] {
            word.store(self.advance().wrapping_add(bias), Ordering::Relaxed);
        }
        self.left -= count as u32;
        count
    }

    #[inline(always)]
    fn advance(&mut self) -> u32 {
        let sum = self.interval.wrapping_add(u64::from(self.fraction));
        self.fraction = sum as u32;
        self.interval = self.interval.wrapping_add(self.growth);
        (sum >> 32) as u32
    }
}

impl Iterator for Intervals {
    type Item = u32;

    #[inline]
    fn next(&mut self) -> Option<u32> {
        self.left = self.left.checked_sub(1)?;
        Some(self.advance())
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.left as usize, Some(self.left as usize))
    }
}

impl ExactSizeIterator for Intervals {}

/// Compiles one axis of a move into segments, one per call of `next`, each a handful of square roots.
///
/// Step k of the axis (k = 1 to `steps`) is due when the master has covered (k - 1/2)/`steps` of the way.
#[derive(Clone, Copy, Debug)]
pub struct Segments {
    profile: Trapezoid,
    tick_hz: f64,
    /// Master steps per step of this axis; at least 1.
    stride: f64,
    /// Steps already compiled.
    done: u32,
    accel_end: u32,
    cruise_end: u32,
    steps: u32,
}

impl Segments {
    pub(crate) fn new(profile: Trapezoid, steps: u32, tick_hz: u32) -> Self {
        let stride = if steps == 0 { 1.0 } else { profile.distance_steps() / f64::from(steps) };
        let steps_before = |boundary: f64| (floor(boundary / stride + 0.5) as u32).min(steps);
        let accel_end = steps_before(profile.accel_end_steps());
        Self {
            tick_hz: f64::from(tick_hz),
            stride,
            done: 0,
            accel_end,
            cruise_end: steps_before(profile.cruise_end_steps()).max(accel_end),
            steps,
            profile,
        }
    }

    /// Displacement of the master at which the step after `done` (a real number) is due.
    fn displacement_after(&self, done: f64) -> f64 {
        (done + 0.5) * self.stride
    }

    fn ticks_after(&self, done: f64) -> f64 {
        self.profile.time_at(self.displacement_after(done)) * self.tick_hz
    }

    /// How many steps a quadratic holds when the third derivative is that of the step after `done`.
    fn steps_held(&self, done: f64) -> u32 {
        let cubed = self.stride * self.stride * self.stride * self.tick_hz;
        let third = self.profile.third_derivative_at(self.displacement_after(done)) * cubed;
        // Seven digits are plenty for a length.
        let span = 2.0 * cbrtf((CUBIC_BOUND * FIT_ERROR_MAX_TICKS / third) as f32);
        // A float-to-integer cast saturates; third = 0 (a ramp that does not accelerate) holds any length.
        (span as u32).saturating_add(1).clamp(STEPS_EXACT, STEPS_MAX)
    }

    /// Length of the next segment by the error bound alone.
    fn length(&self) -> u32 {
        let first = f64::from(self.done);
        if self.done < self.accel_end {
            self.steps_held(first).min(self.accel_end - self.done)
        } else if self.done < self.cruise_end {
            STEPS_MAX.min(self.cruise_end - self.done)
        } else {
            // The slow end is the far one. The bound at the end of a guess is safe for anything shorter.
            let left = self.steps - self.done;
            let guess = self.steps_held(first).min(left);
            self.steps_held(first + f64::from(guess - 1)).min(guess)
        }
    }
}

impl Iterator for Segments {
    type Item = Segment;

    fn next(&mut self) -> Option<Segment> {
        if self.done == self.steps {
            return None;
        }
        let first = self.ticks_after(f64::from(self.done));
        let mut length = self.length();
        loop {
            let reach = f64::from(length - 1);
            let last = self.ticks_after(f64::from(self.done) + reach);
            if length > 1 && last - first >= SPAN_MAX_TICKS {
                length = length.div_ceil(2);
                continue;
            }
            let middle = self.ticks_after(f64::from(self.done) + reach / 2.0);
            self.done += length;
            return Some(Segment::fit(length, [first, middle, last]));
        }
    }
}
