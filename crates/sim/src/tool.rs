//! The tool's outputs as seen by the simulated world, and its port.

use std::fmt;

use embassy_time::Duration;
use isostep_motion::{Inhibit, Switches, ToolPort};

use crate::world::Shared;

/// An output of the tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ToolOutput {
    /// Pulse-width modulation of spindle or laser.
    Pwm,
    /// Enables the spindle or the laser.
    Enable,
    /// The spindle's direction: on for counter-clockwise.
    Direction,
    /// Flood coolant.
    Flood,
    /// Mist coolant.
    Mist,
}

impl ToolOutput {
    /// All outputs.
    pub const ALL: [Self; 5] = [Self::Pwm, Self::Enable, Self::Direction, Self::Flood, Self::Mist];
}

impl fmt::Display for ToolOutput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Pwm => "pwm",
            Self::Enable => "enable",
            Self::Direction => "direction",
            Self::Flood => "flood",
            Self::Mist => "mist",
        })
    }
}

/// One change of one output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ToolChange {
    /// Time since power-up.
    pub t_ns: u64,
    /// The output.
    pub output: ToolOutput,
    /// Duty of 65,535. The outputs other than PWM have 65,535 for on and 0 for off.
    pub duty: u16,
}

impl ToolChange {
    /// The duty as a fraction from 0 to 1.
    pub fn duty_ratio(self) -> f64 {
        f64::from(self.duty) / f64::from(u16::MAX)
    }
}

/// The outputs of a world. Changes happen at once. A stop needs no inhibit, because the tool's task runs at the
/// same instant.
pub(crate) struct SimTool {
    world: Shared,
}

impl SimTool {
    /// The outputs of `world`, all off.
    pub fn new(world: &Shared) -> Self {
        Self { world: world.clone() }
    }

    fn set(&mut self, output: ToolOutput, duty: u16) {
        self.world.borrow_mut().drive_tool(output, duty);
    }
}

impl ToolPort for SimTool {
    fn inhibit(&self) -> Inhibit {
        |_engaged| {}
    }

    fn switch(&mut self, switches: Switches) {
        let Switches { enable, counter_clockwise, flood, mist } = switches;
        let outputs = [ToolOutput::Enable, ToolOutput::Direction, ToolOutput::Flood, ToolOutput::Mist];
        for (output, is_on) in outputs.into_iter().zip([enable, counter_clockwise, flood, mist]) {
            self.set(output, if is_on { u16::MAX } else { 0 });
        }
    }

    fn set_frequency(&mut self, _hz: u32) {}

    fn lead(&self) -> Duration {
        Duration::MIN
    }

    fn set_duty(&mut self, duty: u16, _anew: bool) {
        self.set(ToolOutput::Pwm, duty);
    }
}
