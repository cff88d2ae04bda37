//! `TimerPort` on this board: STEP and DIR by the processor, each step a wake-up.

use embassy_rp::gpio::{Level, Output};
use embedded_hal::delay::DelayNs;
use isostep_motion::{AXES, DriverTiming, TimerPort};

use crate::pins::StepPins;

pub type Port = TimerPort<Output<'static>, Output<'static>, CoreDelay>;

/// The ports of all axes, at rest, STEP and DIR low.
pub fn open(pins: StepPins, timing: DriverTiming) -> [Port; AXES] {
    let [x, y, z] = pins.dir;
    [
        TimerPort::new(Output::new(pins.x, Level::Low), x, CoreDelay, timing),
        TimerPort::new(Output::new(pins.y, Level::Low), y, CoreDelay, timing),
        TimerPort::new(Output::new(pins.z, Level::Low), z, CoreDelay, timing),
    ]
}

/// Any: a late start of the first step is a fault only after it has come.
pub const fn serves(_timing: &DriverTiming) {}

/// Blocks for the width of a pulse.
#[derive(Debug)]
pub struct CoreDelay;

impl DelayNs for CoreDelay {
    fn delay_ns(&mut self, ns: u32) {
        // `delay(n)` goes n + 1 times round a loop of 3 cycles, 24 ns at 125 MHz. 3/64 asks for a turn each 21.3 ns: an
        // eighth too long, never too short, and no division, of which this core has none.
        cortex_m::asm::delay(ns * 3 / 64);
    }
}
