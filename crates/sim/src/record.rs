//! What is seen during a run, as it is kept.

use std::fmt;

use isostep_motion::{Axis, Event};

use crate::driver::Violation;
use crate::moves::Moves;
use crate::tool::ToolChange;

/// A wire between the controller and its world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Wire {
    /// STEP of an axis: a rising edge is a step.
    Step(Axis),
    /// DIR of an axis: high is positive.
    Dir(Axis),
    /// ENABLE of all drivers: active low.
    Enable,
    /// The limit switch of an axis: low while it is closed.
    Limit(Axis),
    /// The emergency stop: low while it is pressed.
    EmergencyStop,
    /// The probe: low while it touches.
    Probe,
    /// The button of the feed hold, or the safety door's switch: low while it is pressed, or open.
    Hold,
    /// The button of the cycle start: low while it is pressed.
    Start,
}

/// One change of a wire's level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wave {
    /// When, since power-up.
    pub t_ns: u64,
    /// Which wire.
    pub wire: Wire,
    /// Its new level.
    pub high: bool,
}

/// One step: a rising edge of STEP.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Edge {
    /// When, since power-up.
    pub t_ns: u64,
    /// Index of the axis.
    pub axis: usize,
    /// 1 or -1, as DIR says.
    pub direction: i32,
    /// Steps counted after this one, from power-up or since the axis was homed.
    pub position_steps: i32,
}

/// Why steps were lost.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LossCause {
    /// The driver was not enabled.
    Disabled,
    /// The carriage stood against its end stop.
    EndStop,
    /// Something held the motor, as was asked for.
    Stalled,
    /// The motor was asked for more than its pull-out curve allows.
    PullOut {
        /// The rate asked for.
        asked_steps_s: f64,
        /// The acceleration asked for.
        asked_steps_s2: f64,
    },
    /// The edges ceased above the pull-in rate, and the rotor ran on.
    Overshoot {
        /// The rate at which they ceased.
        from_steps_s: f64,
    },
}

/// Steps lost in a row, for one reason.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Loss {
    /// When the first was lost, since power-up.
    pub t_ns: u64,
    /// Index of the axis.
    pub axis: usize,
    /// Why.
    pub cause: LossCause,
    /// How many.
    pub steps: u32,
}

impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let axis = Axis::ALL[self.axis];
        write!(f, "{:.6} s: {axis}: {} steps lost: ", self.t_ns as f64 * 1e-9, self.steps)?;
        match self.cause {
            LossCause::Disabled => write!(f, "the driver is not enabled"),
            LossCause::EndStop => write!(f, "the carriage stands against its end stop"),
            LossCause::Stalled => write!(f, "something held the motor"),
            LossCause::PullOut { asked_steps_s, asked_steps_s2 } => {
                write!(f, "the motor pulled out at {asked_steps_s:.0} steps/s and {asked_steps_s2:.0} steps/s²")
            }
            LossCause::Overshoot { from_steps_s } => write!(f, "stopped at once from {from_steps_s:.0} steps/s"),
        }
    }
}

/// What was seen during a run.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Every step.
    pub edges: Vec<Edge>,
    /// Every change of every wire.
    pub waves: Vec<Wave>,
    /// Every change of the tool's outputs.
    pub tool: Vec<ToolChange>,
    /// Every event but those that tell of moves and runs, with its instant in ns since power-up.
    pub events: Vec<(u64, Event)>,
    /// What those tell.
    pub moves: Moves,
    /// Every edge that a driver may misread.
    pub violations: Vec<Violation>,
    /// Every step that no carriage made.
    pub losses: Vec<Loss>,
}
