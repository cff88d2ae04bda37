//! A segment from the quadratic through three steps, by shifts alone.

use super::u96::{joined, left, right, right_signed};
use crate::segment::{SPAN_MAX_TICKS, Segment};

/// Instants t(j) on a quadratic, in units of 2^-point tick.
pub(super) struct Quadratic {
    /// 1 to 32.
    pub(super) point: u32,
    /// log2 n; at most 31.
    pub(super) length: u32,
    /// t(0)
    pub(super) first: u64,
    /// t(n) - t(0); less than 2^31 ticks.
    pub(super) rise: u64,
    /// t(n) - 2 t(n/2) + t(0); 0 if n is 1.
    pub(super) curvature: i64,
}

impl Quadratic {
    /// True if it lasts longer than a segment may, to a precision of 2^32 units.
    pub(super) fn is_too_long(&self) -> bool {
        (self.rise >> 32) as u32 >= SPAN_MAX_TICKS.wrapping_shr(32 - self.point)
    }

    /// Makes it one whose middle is so long after its beginning.
    pub(super) fn bend(&mut self, half_rise: u64) {
        self.curvature = self.rise.wrapping_sub(half_rise).wrapping_sub(half_rise) as i64;
    }

    /// The segment of its first `steps` steps.
    pub(super) fn segment(&self, steps: u32) -> Segment {
        // The shift that converts to units of 2^-32 tick.
        let shift = 32 - self.point;
        let half_tick = (1u32 << 31).wrapping_shr(shift);
        let first = self.first.wrapping_add(half_tick.into());
        let (upper, lower) = ((first >> 32) as u32, first as u32);
        let first_ticks = u64::from(joined(0, upper, shift)) << 32 | u64::from(joined(upper, lower, shift));
        let fraction = lower.wrapping_shl(shift);
        // t(j + 1) - t(j) grows by 4 curvature/n² a step, which adds growth n (n - 1)/2 over n steps.
        let growth = right_signed(left(self.curvature as u64, shift) as i64, (2 * self.length).saturating_sub(2));
        let grown = (left(growth as u64, self.length) as i64).wrapping_sub(growth) >> 1;
        let interval = right(left(self.rise, shift), self.length).wrapping_sub(grown as u64);
        Segment::new(steps, (first_ticks, fraction), interval, growth as u64)
    }
}
