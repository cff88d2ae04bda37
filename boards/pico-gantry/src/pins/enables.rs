//! ENABLE of the motors: one pin for all, or one for each, which are switched together.

use core::convert::Infallible;

use embassy_rp::gpio::{Level, Output};
use embedded_hal::digital::{ErrorType, OutputPin};

use super::ENABLE;

/// Low energises the motors.
pub struct Enables(pub [Output<'static>; ENABLE.len()]);

impl Enables {
    /// Sets the level of all.
    pub fn set_level(&mut self, level: Level) {
        self.0.iter_mut().for_each(|enable| enable.set_level(level));
    }
}

impl ErrorType for Enables {
    type Error = Infallible;
}

impl OutputPin for Enables {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.set_level(Level::Low);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.set_level(Level::High);
        Ok(())
    }
}
