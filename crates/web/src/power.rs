//! The power that the tool is given.

use isostep_sim::Outcome;
use isostep_sim::tool::ToolOutput;

/// The changes of the tool's PWM, of spindle or laser.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Power {
    /// s since power-up, in order.
    pub times_s: Vec<f64>,
    /// From then on, from 0 to 1.
    pub shares: Vec<f32>,
}

impl Power {
    /// Adds the changes of a piece of a run.
    pub(crate) fn add(&mut self, piece: &Outcome) {
        for change in piece.tool.iter().filter(|change| change.output == ToolOutput::Pwm) {
            self.times_s.push(change.t_ns as f64 * 1e-9);
            self.shares.push(change.duty_ratio() as f32);
        }
    }
}
