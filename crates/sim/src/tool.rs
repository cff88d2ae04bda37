//! The tool's outputs as the world sees them, and the plate that the probe touches.

use std::fmt;

use embassy_time::Duration;
use isostep_motion::{Axis, Brake, Switches, ToolPort};

use crate::world::Shared;

/// An output of the tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ToolOutput {
    /// Pulse-width modulation of spindle or laser.
    Pwm,
    /// The spindle is to turn, or the laser may shine.
    Enable,
    /// The spindle's direction: on for counter-clockwise.
    Direction,
    /// Flood coolant.
    Flood,
    /// Mist coolant.
    Mist,
}

impl ToolOutput {
    /// All of them.
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
    /// When, since power-up.
    pub t_ns: u64,
    /// Which.
    pub output: ToolOutput,
    /// Duty of the PWM output, of 65,535; of the others 65,535 for on, 0 for off.
    pub duty: u16,
}

impl ToolChange {
    /// The same, from 0 to 1.
    pub fn share(self) -> f64 {
        f64::from(self.duty) / f64::from(u16::MAX)
    }
}

/// The tool's port in the simulator: changes happen at once, and a stop needs no brake, as the task that has to do with it is
/// there at the same instant.
pub struct SimTool {
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
    fn brake(&self) -> Brake {
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

/// A conducting plate across an axis: the probe touches it from a place on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plate {
    /// Which axis goes there.
    pub axis: Axis,
    /// Where it is, mm above the limit switch.
    pub place_mm: f64,
    /// It is touched at that place and nearer to the switch, rather than farther from it.
    pub is_below: bool,
}

impl Plate {
    /// Whether the probe touches it where the axis is.
    pub fn is_touched(&self, place_steps: i32, steps_per_mm: f64) -> bool {
        let plate_steps = (self.place_mm * steps_per_mm).round() as i32;
        if self.is_below { place_steps <= plate_steps } else { place_steps >= plate_steps }
    }
}

impl fmt::Display for Plate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { axis, place_mm, is_below } = self;
        write!(f, "{axis},{place_mm},{}", if *is_below { "below" } else { "above" })
    }
}
