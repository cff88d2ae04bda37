//! ENABLE of a board that proves: the motors stay off, whatever the machine asks for.

use core::convert::Infallible;

use embassy_rp::gpio::Level;
use embedded_hal::digital::{ErrorType, OutputPin};
use isostep_motion::Machine;

use crate::pins::Enables;

/// ENABLE at the level that frees the motors, by setting `$4`.
pub struct MotorsOff {
    enable: Enables,
    machine: &'static Machine,
}

impl MotorsOff {
    pub fn new(enable: Enables, machine: &'static Machine) -> Self {
        Self { enable, machine }
    }

    fn switch_off(&mut self) {
        self.enable.set_level(Level::from(!self.machine.config().enable_inverted));
    }
}

impl ErrorType for MotorsOff {
    type Error = Infallible;
}

impl OutputPin for MotorsOff {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.switch_off();
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.switch_off();
        Ok(())
    }
}
