//! The tool's port in the simulator.

use embassy_time::Duration;
use isostep_motion::{Inhibit, Switches, ToolPort};

use super::ToolOutput;
use crate::world::Shared;

/// The outputs of a world. Changes happen at once. A stop needs no inhibit, because the tool's task runs at the
/// same instant.
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
