//! Runs of step instants that are replayed by additions.
//!
//! Over a few steps the instant is a quadratic in the step number, to a bounded error ([`compile`](crate::compile) says
//! how the bound is kept). What is left per step is two additions of 64 bits, the same for every shape of profile: the
//! interval grows by a constant, and its fraction is carried over, so that no rounding accumulates.

use core::sync::atomic::{AtomicU32, Ordering};

use crate::fixed::times;

/// What a segment spans is less than this, so any interval of it has 30 bits: a port's word has two more to say.
pub(crate) const SPAN_MAX_TICKS: u32 = (1 << 30) - 64;

/// A run of steps of one axis. Made by [`Segments`](crate::Segments); replayed as instants by
/// [`ticks`](Segment::ticks), as intervals by [`intervals`](Segment::intervals).
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
        self.first_ticks + (self.sum(self.steps - 1) >> 32)
    }

    /// Its first `steps` steps, fewer than it holds and at least 1, and the others, each at the same instants.
    #[must_use]
    pub fn split(&self, steps: u32) -> (Self, Self) {
        let sum = self.sum(steps);
        let others = Self {
            steps: self.steps - steps,
            fraction: sum as u32,
            first_ticks: self.first_ticks + (sum >> 32),
            interval: self.interval.wrapping_add(times(self.growth, steps)),
            growth: self.growth,
        };
        (Self { steps, ..*self }, others)
    }

    /// Its first `n` intervals and what the first instant leaves over, 2^-32 tick.
    fn sum(&self, n: u32) -> u64 {
        // n (n - 1)/2 growths, the half of the even one of both.
        let (half, other) = if n.is_multiple_of(2) { (n / 2, n.wrapping_sub(1)) } else { (n, n / 2) };
        let grown = times(times(self.growth, half), other);
        times(self.interval, n).wrapping_add(grown).wrapping_add(u64::from(self.fraction))
    }

    /// The same steps, `ticks` later.
    #[must_use]
    pub fn delayed(&self, ticks: u64) -> Self {
        Self { first_ticks: self.first_ticks + ticks, ..*self }
    }

    /// The shortest of its intervals, ticks, rounded down; `None` for a single step. Intervals grow or shrink evenly, so it
    /// is the first or the last.
    #[must_use]
    pub fn interval_min_ticks(&self) -> Option<u32> {
        let last = self.interval.wrapping_add(times(self.growth, self.steps.checked_sub(2)?));
        Some((self.interval.min(last) >> 32) as u32)
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

    /// `first`: the first instant, in ticks and 2^-32 tick, plus half a tick.
    pub(crate) fn new(steps: u32, first: (u64, u32), interval: u64, growth: u64) -> Self {
        Self { steps, fraction: first.1, first_ticks: first.0, interval, growth }
    }
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
    /// many: 8 cycles a word on a Cortex-M0+ in RAM. Not inlined, as it needs all registers for itself.
    #[inline(never)]
    pub fn fill(&mut self, words: &[AtomicU32], bias: u32) -> usize {
        let count = words.len().min(self.left as usize);
        let mut series = Series::new(self, bias);
        let (blocks, rest) = words[..count].as_chunks::<8>();
        let mut put = |word: &AtomicU32| word.store(series.advance(), Ordering::Relaxed);
        // Unrolled by hand: a caller that is optimised for size would keep the loop.
        for [a, b, c, d, e, f, g, h] in blocks {
            put(a);
            put(b);
            put(c);
            put(d);
            put(e);
            put(f);
            put(g);
            put(h);
        }
        rest.iter().for_each(put);
        self.left -= count as u32;
        (self.interval, self.fraction) = (series.interval(), series.fraction);
        count
    }
}

/// Intervals plus a bias, held so that a Cortex-M0+ has registers enough.
struct Series {
    fraction: u32,
    /// The interval, its upper half with the bias and less the growth's upper half. So that half can be added with each
    /// carry, where a register with 0 would be request else.
    held: u64,
    growth: u64,
    bias: u32,
}

impl Series {
    #[inline(always)]
    fn new(intervals: &Intervals, bias: u32) -> Self {
        let Intervals { fraction, interval, growth, .. } = *intervals;
        let bias = bias.wrapping_sub((growth >> 32) as u32);
        Self { fraction, held: interval.wrapping_add(u64::from(bias) << 32), growth, bias }
    }

    #[inline(always)]
    fn interval(&self) -> u64 {
        self.held.wrapping_sub(u64::from(self.bias) << 32)
    }

    #[inline(always)]
    fn advance(&mut self) -> u32 {
        let (fraction, carry) = self.fraction.overflowing_add(self.held as u32);
        let growth_upper = (self.growth >> 32) as u32;
        let word = ((self.held >> 32) as u32).wrapping_add(growth_upper).wrapping_add(u32::from(carry));
        self.fraction = fraction;
        self.held = self.held.wrapping_add(self.growth);
        word
    }
}

impl Iterator for Intervals {
    type Item = u32;

    #[inline]
    fn next(&mut self) -> Option<u32> {
        self.left = self.left.checked_sub(1)?;
        let sum = self.interval.wrapping_add(u64::from(self.fraction));
        self.fraction = sum as u32;
        self.interval = self.interval.wrapping_add(self.growth);
        Some((sum >> 32) as u32)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.left as usize, Some(self.left as usize))
    }
}

impl ExactSizeIterator for Intervals {}
