//! The ticks of the machine's clock, whose rate the board chooses, beside the seconds of plans and the ticks of ports.

use embassy_time::{Duration, Instant};

/// Tick rate of the time driver, Hz.
pub(crate) const TICK_HZ: u32 = embassy_time::TICK_HZ as u32;
/// One tick, s: the resolution of instants.
pub(crate) const TICK_S: f64 = 1.0 / TICK_HZ as f64;

/// A time in seconds.
pub(crate) const fn seconds(time: Duration) -> f64 {
    time.as_ticks() as f64 * TICK_S
}

/// The instant `t_s` after `start`, rounded up to a whole tick.
pub(crate) fn instant_after(start: Instant, t_s: f64) -> Instant {
    start + Duration::from_ticks(libm::ceil(t_s * f64::from(TICK_HZ)) as u64)
}

/// The instant `t_s` after `start`, rounded to the nearest tick.
pub(crate) fn instant_near(start: Instant, t_s: f64) -> Instant {
    start + Duration::from_ticks((t_s * f64::from(TICK_HZ) + 0.5) as u64)
}

/// The ticks of a port.
#[derive(Clone, Copy)]
pub(crate) struct PortTicks {
    pub hz: u32,
    /// The number of them in a tick of the clock, if that is a whole number, and 0 otherwise.
    per_tick: u32,
}

impl PortTicks {
    pub fn new(hz: u32) -> Self {
        Self { hz, per_tick: if hz.is_multiple_of(TICK_HZ) { hz / TICK_HZ } else { 0 } }
    }

    /// The number of them in `time`, rounded down.
    pub fn of(self, time: Duration) -> u64 {
        let ticks = time.as_ticks();
        if self.per_tick != 0 {
            // Far below 2^64, and looking for an overflow takes another product.
            return ticks.wrapping_mul(self.per_tick.into());
        }
        // Whole seconds apart, so that the products of a run of any length fit.
        let (clock_hz, hz) = (u64::from(TICK_HZ), u64::from(self.hz));
        ticks / clock_hz * hz + ticks % clock_hz * hz / clock_hz
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_of_any_port_are_exact_after_a_week() {
        let week = Duration::from_secs(7 * 24 * 3600);
        for hz in [32_768, 64_000, 1_000_000, 12_500_000, 64_000_001, 125_000_000] {
            let ticks = PortTicks::new(hz);
            assert_eq!(ticks.of(week), 7 * 24 * 3600 * u64::from(hz), "{hz}");
            let part = Duration::from_ticks(u64::from(TICK_HZ) * 3 / 4);
            assert_eq!(ticks.of(week + part) - ticks.of(week), u64::from(hz) * 3 / 4, "{hz}");
        }
    }
}
