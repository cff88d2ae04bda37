//! Step instants as short runs that are replayed by additions.

use core::sync::atomic::{AtomicU32, Ordering};

/// What a segment spans is less than this, so any interval of it has 31 bits.
pub(crate) const SPAN_MAX_TICKS: u32 = (1 << 31) - 64;
/// In units of 2^-32 tick.
const HALF_TICK: u64 = 1 << 31;

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

    /// One step. `first` is in units of 2^-`point` tick; `point` is 32 at most.
    pub(crate) fn single(first: u64, point: u8) -> Self {
        Self::fit(1, 0, first, 0, 0, point)
    }

    /// `steps` along the quadratic t(j) with t(0) = `first`, t(n) - t(0) = `rise` and t(n) - 2 t(n/2) + t(0) = `bend`,
    /// n being 2^`length_log2`, all in units of 2^-`point` tick.
    pub(crate) fn fit(steps: u32, length_log2: u32, first: u64, rise: u64, bend: i64, point: u8) -> Self {
        let to_q32 = 32 - u32::from(point);
        let first_rounded = first.wrapping_add(HALF_TICK >> to_q32);
        let growth = (bend << to_q32) >> (2 * length_log2).saturating_sub(2);
        // The growths up to n make n (n - 1)/2.
        let grown = (growth << length_log2).wrapping_sub(growth) >> 1;
        let interval = ((rise << to_q32) >> length_log2).wrapping_sub(grown as u64);
        Self {
            steps,
            fraction: (first_rounded << to_q32) as u32,
            first_ticks: first_rounded >> point,
            interval,
            growth: growth as u64,
        }
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
