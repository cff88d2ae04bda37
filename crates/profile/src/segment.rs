//! Short sequences of step instants, which are replayed by additions.
//!
//! Over a few steps the instants are a quadratic in the step number, within a bounded error
//! ([`compile`](crate::compile) explains the bound). A step then costs two additions of 64 bits, for every shape of
//! profile: the interval grows by a constant, and its fraction is carried into the next one, so that no rounding error
//! accumulates.

use core::sync::atomic::{AtomicU32, Ordering};

use crate::fixed::times;

/// A segment lasts less than this, ticks. So each of its intervals fits into 30 bits, and a port's word has two bits
/// left for other uses.
pub(crate) const SPAN_MAX_TICKS: u32 = (1 << 30) - 64;

/// A few consecutive steps of one axis, made by [`Segments`](crate::Segments). [`ticks`](Segment::ticks) replays it as
/// instants, [`intervals`](Segment::intervals) as intervals.
// Packed, because queues hold many of them, and what stands beside one there would end with a gap of seven bytes.
#[repr(C, packed(4))]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    steps: u32,
    /// The fraction of the first instant plus half a tick, in units of 2^-32 tick.
    fraction: u32,
    first_ticks: u64,
    /// From the first step to the second, Q32.32 ticks.
    interval: u64,
    /// From one interval to the next, Q32.32 ticks in two's complement.
    growth: u64,
}

impl Segment {
    /// The number of steps that it holds; at least 1.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// The instant at which its first step is due, ticks from the start of the move, rounded to the nearest.
    #[must_use]
    pub fn first_ticks(&self) -> u64 {
        self.first_ticks
    }

    /// The instant at which its last step is due, ticks from the start of the move, rounded to the nearest. It is computed as a
    /// closed sum, without a loop.
    #[must_use]
    pub fn last_ticks(&self) -> u64 {
        self.first_ticks + (self.sum(self.steps - 1) >> 32)
    }

    /// Splits it into its first `steps` steps and the others; all instants stay the same. `steps` is at least 1 and
    /// less than the number of steps it holds.
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

    /// The sum of its first `n` intervals and of `fraction`, in units of 2^-32 tick.
    fn sum(&self, n: u32) -> u64 {
        // The growth counts n (n - 1)/2 times.
        let grown = if n < 1 << 16 {
            times(self.growth, n.wrapping_mul(n.wrapping_sub(1)) / 2)
        } else {
            // The even one of n and n - 1 is halved.
            let (half, other) = if n.is_multiple_of(2) { (n / 2, n.wrapping_sub(1)) } else { (n, n / 2) };
            times(times(self.growth, half), other)
        };
        times(self.interval, n).wrapping_add(grown).wrapping_add(u64::from(self.fraction))
    }

    /// The same steps, `ticks` later.
    #[must_use]
    pub fn delayed(&self, ticks: u64) -> Self {
        Self { first_ticks: self.first_ticks + ticks, ..*self }
    }

    /// The shortest of its intervals, ticks, rounded down; `None` for a single step. Intervals grow or shrink by a
    /// constant, so the first or the last is the shortest.
    #[must_use]
    pub fn interval_min_ticks(&self) -> Option<u32> {
        let more = self.steps.checked_sub(2)?;
        let shrinks = self.growth >> 63 != 0;
        let shortest = if shrinks { self.interval.wrapping_add(times(self.growth, more)) } else { self.interval };
        Some((shortest >> 32) as u32)
    }

    /// The instants of its steps in ticks from the start of the move, rounded to the nearest.
    #[must_use]
    pub fn ticks(&self) -> Ticks {
        Ticks { next: Some(self.first_ticks), intervals: self.intervals() }
    }

    /// The ticks from each of its steps to the next: one interval fewer than it has steps. Their sum is exactly its
    /// last instant less its first.
    #[inline]
    #[must_use]
    pub fn intervals(&self) -> Intervals {
        Intervals { left: self.steps - 1, fraction: self.fraction, interval: self.interval, growth: self.growth }
    }

    /// `first` is the first instant plus half a tick, in ticks and in units of 2^-32 tick.
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
    /// Writes intervals into `words`, each plus `bias` (modulo 2^32), until `words` is full or no interval is left.
    /// Returns how many it has written. On a Cortex-M0+, in RAM, this takes 8 cycles a word. It is not inlined, because
    /// it needs all registers for itself.
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

/// Intervals plus a bias, in a form for which a Cortex-M0+ has enough registers.
struct Series {
    fraction: u32,
    /// The interval, whose upper half also has the bias added and the upper half of the growth subtracted. So the upper
    /// half of the growth can be added together with each carry; otherwise adding the carry would need a register that
    /// holds 0.
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
