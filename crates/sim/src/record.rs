//! The record of a run.

use std::fmt;
use std::mem::take;

use isostep_motion::{Axis, Event, Motor};

use crate::driver::Violation;
use crate::moves::Moves;
use crate::outcome::{first_edge, sort_edges};
use crate::tool::ToolChange;

/// A wire between the controller and its world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Wire {
    /// STEP of a motor: a rising edge is a step.
    Step(Motor),
    /// DIR of a motor: high is positive, unless inverted.
    Dir(Motor),
    /// ENABLE of all drivers: active low.
    Enable,
    /// The limit switch of a motor: low while it is closed.
    Limit(Motor),
    /// The emergency stop: low while it is pressed.
    EmergencyStop,
    /// The probe: low while it touches.
    Probe,
    /// The button of the feed hold, or the safety door's switch: low while it is pressed, or open.
    Hold,
    /// The button of the cycle start: low while it is pressed.
    Start,
    /// The alarm of an axis's drive, or X's of all of them: low in an alarm, unless its contact opens.
    DriveAlarm(Axis),
}

/// One change of a wire's level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wave {
    /// Time since power-up.
    pub t_ns: u64,
    /// The wire.
    pub wire: Wire,
    /// The new level.
    pub high: bool,
}

/// One step of an axis: a rising edge of STEP. Edges of two motors at one instant are one step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Edge {
    /// Time since power-up.
    pub t_ns: u64,
    /// Index of the axis.
    pub axis: usize,
    /// 1 or -1, according to DIR.
    pub direction: i32,
    /// Position after this step, counted from power-up or since the axis was homed.
    pub position_steps: i32,
}

/// The reason why steps were lost.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LossCause {
    /// The driver was not enabled.
    Disabled,
    /// The driver had no supply, or had switched the motor off because of a fault.
    DriverOff,
    /// The carriage stood against its end stop.
    EndStop,
    /// Something blocked the motor, as requested.
    Stalled,
    /// The gantry was skewed so far that it bound.
    Bound,
    /// More was asked for than the motor's torque gives.
    PullOut {
        /// The rate asked for.
        asked_steps_s: f64,
    },
    /// The edges ceased at once, and the rotor went on turning.
    Overshoot {
        /// The rate at which the edges ceased.
        from_steps_s: f64,
    },
}

/// Consecutive steps lost for one reason.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct Loss {
    /// When the first step was lost, since power-up.
    pub t_ns: u64,
    /// Index of the axis.
    pub axis: usize,
    /// The reason.
    pub cause: LossCause,
    /// Number of steps.
    pub steps: u32,
}

impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let axis = Axis::ALL[self.axis];
        write!(f, "{:.6} s: {axis}: {} steps lost: ", self.t_ns as f64 * 1e-9, self.steps)?;
        match self.cause {
            LossCause::Disabled => write!(f, "the driver is not enabled"),
            LossCause::EndStop => write!(f, "the carriage stands against its end stop"),
            LossCause::DriverOff => write!(f, "the driver was without supply, or had switched the motor off"),
            LossCause::Stalled => write!(f, "something held the motor"),
            LossCause::Bound => write!(f, "the gantry was so skewed that it bound"),
            LossCause::PullOut { asked_steps_s } => write!(f, "the motor pulled out at {asked_steps_s:.0} steps/s"),
            LossCause::Overshoot { from_steps_s } => {
                write!(f, "the rotor went on when the edges ceased at {from_steps_s:.0} steps/s")
            }
        }
    }
}

/// A frame on the wire to a VFD.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VfdFrame {
    /// When its last character ended, ns since power-up.
    pub t_ns: u64,
    /// The VFD has sent it, or what disturbs its wire.
    pub is_reply: bool,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

/// The record of a run.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Every step.
    pub edges: Vec<Edge>,
    /// Every change of every wire.
    pub waves: Vec<Wave>,
    /// Every change of the tool's outputs.
    pub tool: Vec<ToolChange>,
    /// Every frame on the wire to a VFD.
    pub vfd: Vec<VfdFrame>,
    /// Every event except those about moves and runs, with its instant in ns since power-up.
    pub events: Vec<(u64, Event)>,
    /// The moves, assembled from the events about moves and runs.
    pub moves: Moves,
    /// Every edge that a driver may misread.
    pub violations: Vec<Violation>,
    /// Every step that a carriage did not make.
    pub losses: Vec<Loss>,
    /// True if what came before was taken out already, so that all edges are of the moves here.
    pub continues: bool,
}

impl Record {
    /// Takes the moves that nothing can change any more, with their edges, and all else that was recorded so far. The last
    /// edge was at `edge_ns`.
    pub(crate) fn take_settled(&mut self, edge_ns: u64, tolerance_ns: f64) -> Self {
        let continues = self.continues;
        let (waves, tool, events) = (take(&mut self.waves), take(&mut self.tool), take(&mut self.events));
        let (violations, losses) = (take(&mut self.violations), take(&mut self.losses));
        let taken = Self { waves, tool, events, violations, losses, continues, ..Self::default() };
        let Some(count) = self.moves.settled(edge_ns) else { return Self { moves: self.moves.none(), ..taken } };
        sort_edges(&mut self.edges);
        let first = first_edge(self.moves.records(), count, &mut self.edges, tolerance_ns);
        let later = self.edges.split_off(first);
        let edges = std::mem::replace(&mut self.edges, later);
        self.continues = true;
        Self { edges, moves: self.moves.take_first(count), ..taken }
    }
}
