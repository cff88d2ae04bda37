//! The pins: STEP, DIR and ENABLE on ports B and C. A trace of them goes to UART1.
//!
//! # Trace
//! QEMU can tell each change of a pin, but not when in the machine's time it came. So each rise of STEP is written to
//! UART1 as eight bytes: the ticks of the clock (seven, little-endian), then the axis, with bit 7 for DIR. A chip with
//! drivers needs none of that.

use core::convert::Infallible;

use embassy_time::Instant;
use embedded_hal::digital::{ErrorType, OutputPin};
use isostep_motion::{MotorPins, Motors};

use crate::chip::Register;
use crate::gantry;

const PORT_B: u32 = 0x4000_5000;
const PORT_C: u32 = 0x4000_6000;
const UART1: u32 = 0x4000_D000;
const TRACE: Register = Register::at(UART1, 0x00);
const TRACE_CONTROL: Register = Register::at(UART1, 0x30);
const DIRECTION: u32 = 0x400;
const DIGITAL: u32 = 0x51C;
const ENABLE: u32 = 1 << 4;
/// DIR of each axis is so many pins above STEP.
const DIR_SHIFT: u32 = 4;

/// Makes the pins outputs, low.
pub fn init() {
    for port in [PORT_B, PORT_C] {
        Register::at(port, DIRECTION).write(0xFF);
        Register::at(port, DIGITAL).write(0xFF);
        Register::at(port, 0xFF << 2).write(0);
    }
    TRACE_CONTROL.write(1 | 1 << 8);
}

/// The pins of a port that `mask` names: a write changes these alone.
const fn of(port: u32, mask: u32) -> Register {
    Register::at(port, mask << 2)
}

/// STEP and DIR of an axis.
pub struct AxisPins {
    axis: u32,
    dir_high: bool,
}

impl AxisPins {
    pub fn new(axis: usize) -> Self {
        Self { axis: axis as u32, dir_high: false }
    }
}

impl MotorPins for AxisPins {
    fn begin(&mut self, _motors: &Motors) {}

    #[inline(always)]
    fn set_step(&mut self, high: bool) {
        of(PORT_B, 1 << self.axis).write(u32::from(high) << self.axis);
        if high {
            let ticks = Instant::now().as_ticks() << 8 | u64::from(self.axis) | u64::from(self.dir_high) << 7;
            // The axis and DIR are in the lowest byte, so it is the first that is written.
            for byte in ticks.to_le_bytes() {
                TRACE.write(byte.into());
            }
            gantry::step(self.axis as usize, self.dir_high);
        }
    }

    fn set_dir(&mut self, high: bool) {
        self.dir_high = high;
        let pin = self.axis + DIR_SHIFT;
        of(PORT_B, 1 << pin).write(u32::from(high) << pin);
    }
}

/// ENABLE of all drivers.
pub struct Enable;

impl ErrorType for Enable {
    type Error = Infallible;
}

impl OutputPin for Enable {
    fn set_low(&mut self) -> Result<(), Infallible> {
        of(PORT_C, ENABLE).write(0);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        of(PORT_C, ENABLE).write(ENABLE);
        Ok(())
    }
}
