//! The tool's outputs as seen by the simulated world.

pub(crate) mod port;
pub mod trace;

use std::fmt;

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
