//! A ramp that hardly accelerates.

use super::phase::View;
use super::wide::power_of_two;
use crate::trapezoid::{EndRamp, ramp_time_s};

/// Where the acceleration is so small beside the speed that √(C² + B x) - C would lose its digits, or there is none: in
/// floats, by a formula in which nothing cancels. It is slow, and its segments are long.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gentle {
    ramp: EndRamp,
    half_step: f64,
    units_hz: f64,
}

impl Gentle {
    pub(super) fn new(ramp: EndRamp, view: View, point: u8) -> Self {
        let units_hz = view.tick_hz * power_of_two(point.into());
        Self { ramp, half_step: view.stride / 2.0, units_hz }
    }

    /// How long `half_steps` take from the slow end, in units of 2^-point tick.
    pub(super) fn units(&self, half_steps: u32) -> u64 {
        let steps = f64::from(half_steps) * self.half_step;
        (ramp_time_s(steps, self.ramp.slow_steps_s, self.ramp.accel_steps_s2) * self.units_hz) as u64
    }
}
