//! A ramp that hardly accelerates.

use super::u96::fixed;
use crate::ramp::constant_accel_time_s;

/// A ramp whose acceleration is zero, or so small beside the speed that √(C² + B x) - C would lose its digits. Its
/// times are computed in floats, by a formula in which nothing cancels. That is slow, but its segments are long.
#[derive(Clone, Copy, Debug)]
pub(super) struct SmallAccel {
    pub(super) slow_steps_s: f64,
    pub(super) accel_steps_s2: f64,
    /// Half a step of the axis, in steps of the longest axis.
    pub(super) half_step: f64,
    /// By how many half steps the first half step is longer.
    pub(super) more: f64,
    /// Ticks per second.
    pub(super) tick_hz: f64,
    /// Times are in units of 2^-`point` tick.
    pub(super) point: u8,
}

impl SmallAccel {
    /// The time that `half_steps` take from the slow end, in units of 2^-`point` tick.
    pub(super) fn time(&self, half_steps: u32) -> u64 {
        let steps = (f64::from(half_steps) + self.more).max(0.0) * self.half_step;
        let time_s = constant_accel_time_s(steps, self.slow_steps_s, self.accel_steps_s2);
        fixed(time_s * self.tick_hz, self.point.into()) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::SmallAccel;

    /// A cruise of 100 steps/s, whose first half step is longer or shorter, as behind a replan.
    #[test]
    fn a_time_counts_from_the_place_where_the_ramp_begins() {
        for more in [-0.5, 0.0, 0.3] {
            let cruise =
                SmallAccel { slow_steps_s: 100.0, accel_steps_s2: 0.0, half_step: 0.5, more, tick_hz: 1e6, point: 0 };
            assert_eq!([1, 3].map(|half_steps| cruise.time(half_steps)), [1.0, 3.0].map(|n| ((n + more) * 5e3) as u64));
        }
    }
}
