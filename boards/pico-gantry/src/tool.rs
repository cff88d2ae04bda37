//! The tool's outputs: a PWM slice, four pins, and an inhibit that does not depend on them.
//!
//! # Design
//! A pad can be forced low whatever drives it. That is the inhibit: five registers, written in any context. Until it is
//! released, nothing that the slice or a task does reaches the tool. If the core hangs, the output watchdog forces the
//! pads low within 20 ms (`output_watchdog`).
//!
//! The hardware buffers the duty until the period ends, which takes up to 200 us at 5 kHz. That is too late for a level
//! that belongs to a step. So a change of the duty ends the period at once, by setting the counter to its end.

use embassy_rp::gpio::Output;
use embassy_rp::pac;
use embassy_rp::pac::io::vals::Outover;
use embassy_rp::pwm::{Config, Pwm};
use embassy_time::Duration;
use isostep_motion::{Inhibit, Switches, ToolPort};

use crate::chip::CLOCK_HZ;
use crate::output_watchdog;
use crate::pins::{self, ToolPins};

const SLICE: usize = pins::TOOL_PWM / 2 % 8;
/// The second output of each slice is on the odd pins.
const IS_SECOND: bool = pins::TOOL_PWM % 2 == 1;
/// The longest period: the counter has 16 bits and is compared with a value that may be one more than its end.
const PERIOD_MAX: u32 = 65_535;

/// The least time from the alarm to the change of the duty: it takes 8 to 15 us in the emulator.
const LEAD: Duration = Duration::from_micros(8);

/// Function numbers of a pin: it is driven by SIO or by the PWM slice.
const SIO_FUNCTION: u8 = 5;
const PWM_FUNCTION: u8 = 4;

/// The outputs of the tool.
pub struct Tool {
    _slice: Pwm<'static>,
    _pwm: Output<'static>,
    enable: Output<'static>,
    direction: Output<'static>,
    flood: Output<'static>,
    mist: Output<'static>,
    /// Period of the counter, ticks.
    period: u32,
    duty: u16,
}

impl Tool {
    /// Takes the pins, with all outputs off.
    pub fn new(pins: ToolPins) -> Self {
        let ToolPins { slice, pwm, enable, direction, flood, mist } = pins;
        let config = Config::default();
        let period = u32::from(config.top) + 1;
        // The pad is the slice's when the inhibit is released first.
        let slice = Pwm::new_free(slice, config);
        Self { _slice: slice, _pwm: pwm, enable, direction, flood, mist, period, duty: 0 }
    }

    fn compare(&self) {
        // Full duty is one more than the counter's end: always high.
        let ticks = (self.period * u32::from(self.duty)).div_ceil(u32::from(u16::MAX));
        pac::PWM
            .ch(SLICE)
            .cc()
            .write(|compare| if IS_SECOND { compare.set_b(ticks as u16) } else { compare.set_a(ticks as u16) });
    }
}

impl ToolPort for Tool {
    fn inhibit(&self) -> Inhibit {
        inhibit
    }

    fn switch(&mut self, switches: Switches) {
        let Switches { enable, counter_clockwise, flood, mist } = switches;
        // Set the direction before the spindle turns.
        self.direction.set_level(counter_clockwise.into());
        self.enable.set_level(enable.into());
        self.flood.set_level(flood.into());
        self.mist.set_level(mist.into());
    }

    fn set_frequency(&mut self, hz: u32) {
        let ticks = CLOCK_HZ / hz.max(1);
        let divider = ticks.div_ceil(PERIOD_MAX).clamp(1, 255);
        self.period = (ticks / divider).clamp(1, PERIOD_MAX);
        let slice = pac::PWM.ch(SLICE);
        slice.div().write(|div| div.set_int(divider as u8));
        slice.top().write(|top| top.set_top((self.period - 1) as u16));
        self.compare();
    }

    fn lead(&self) -> Duration {
        LEAD
    }

    fn set_duty(&mut self, duty: u16, anew: bool) {
        self.duty = duty;
        self.compare();
        if anew {
            pac::PWM.ch(SLICE).ctr().write(|counter| counter.set_ctr((self.period - 1) as u16));
        }
    }
}

/// Forces all outputs of the tool low, or releases them, unless the output watchdog has run out. It is called where nothing
/// interrupts it: in critical sections, and in the handler of the guard. So calls never overlap.
pub fn inhibit(engaged: bool) {
    let mut low = engaged;
    loop {
        low = low || output_watchdog::has_run_out();
        override_pads(low);
        // If it has run out since that look, they are released only for this round. If it does after this one, it forces
        // them low after they were released.
        if low || !output_watchdog::has_run_out() {
            return;
        }
    }
}

#[inline(always)]
fn override_pads(low: bool) {
    let over = if low { Outover::LOW } else { Outover::NORMAL };
    let drive = |pin: usize, function| {
        pac::IO_BANK0.gpio(pin).ctrl().write(|ctrl| {
            ctrl.set_funcsel(function);
            ctrl.set_outover(over);
        });
    };
    // One by one: a loop would read the table of the pins for each of them.
    let [enable, direction, flood, mist] = pins::TOOL_SWITCHES;
    drive(pins::TOOL_PWM, PWM_FUNCTION);
    drive(enable, SIO_FUNCTION);
    drive(direction, SIO_FUNCTION);
    drive(flood, SIO_FUNCTION);
    drive(mist, SIO_FUNCTION);
}

/// Enables or disables the pull-up of the probe's input.
pub fn pull_probe_up(up: bool) {
    pac::PADS_BANK0.gpio(pins::PROBE).modify(|pad| pad.set_pue(up));
}
