//! The outputs of an axis.

use core::convert::Infallible;

use embedded_hal::digital::OutputPin;

use crate::port::Motors;

/// STEP and DIR of the motors of one axis.
pub trait MotorPins {
    /// Gets ready for a run of `motors`: whether there is a second one, which way it turns, and which ganged motor is held. STEP
    /// is low, and stays so. DIR of the second motor may change.
    fn begin(&mut self, motors: &Motors);

    /// Sets STEP of all motors that move, at one instant.
    fn set_step(&mut self, high: bool);

    /// Sets DIR of all motors.
    fn set_dir(&mut self, high: bool);
}

/// STEP and DIR of the only motor of an axis.
impl<S, D> MotorPins for (S, D)
where
    S: OutputPin<Error = Infallible>,
    D: OutputPin<Error = Infallible>,
{
    fn begin(&mut self, _motors: &Motors) {}

    #[inline(always)]
    fn set_step(&mut self, high: bool) {
        let Ok(()) = if high { self.0.set_high() } else { self.0.set_low() };
    }

    #[inline(always)]
    fn set_dir(&mut self, high: bool) {
        let Ok(()) = if high { self.1.set_high() } else { self.1.set_low() };
    }
}
