//! The events of a machine, as values that logs, traces and tests share.

use core::fmt;

use embassy_time::Instant;
use isostep_profile::{Blend, PlanError, ProfileError, SyncMove};

use crate::axes::{AXES, Axis};
use crate::machine::Move;
use crate::motor::Motor;
use crate::port::PortFault;
use crate::shaping::Shaping;

/// The state of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum State {
    /// Standing still, ready.
    Idle,
    /// Moving, dwelling, or with moves waiting.
    Run,
    /// Moving by hand.
    Jog,
    /// Held: braking, or standing `still`, until it is resumed.
    Hold {
        /// Nothing moves any more.
        still: bool,
    },
    /// Homing.
    Home,
    /// Locked: nothing moves until it is unlocked or homed.
    Alarm(Alarm),
}

/// The name that a status report gives it.
impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Idle => f.write_str("Idle"),
            Self::Run => f.write_str("Run"),
            Self::Jog => f.write_str("Jog"),
            Self::Hold { still: true } => f.write_str("Hold:0"),
            Self::Hold { still: false } => f.write_str("Hold:1"),
            Self::Home => f.write_str("Home"),
            Self::Alarm(_) => f.write_str("Alarm"),
        }
    }
}

/// Why the machine locked itself. What a person reads of it, and the remedy, is in the words of the console's settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Alarm {
    /// A limit switch closed outside homing, and the stop was abrupt; or it had closed already, and a move would have
    /// gone further onto it. The position is no longer trusted.
    HardLimit {
        /// Whose switch.
        motor: Motor,
    },
    /// A move would have left the travel; nothing moved.
    SoftLimit {
        /// The axis that would have left it.
        axis: Axis,
    },
    /// A second reset stopped a move abruptly before the first had braked: the position is no longer trusted.
    ResetInMotion,
    /// A reset stopped homing.
    HomingReset,
    /// The switch was still closed after backing off.
    SwitchStuck {
        /// Whose switch.
        motor: Motor,
    },
    /// The switch did not close within the search distance.
    SwitchNotFound {
        /// Whose switch.
        axis: Axis,
    },
    /// One motor of a squared axis stood at its switch, and the other did not reach its own within the skew limit.
    Skewed {
        /// The motor that did not reach its switch.
        motor: Motor,
    },
    /// The two stalls by which an axis homes were farther apart than the pull-off: one of them was none.
    StallsApart {
        /// The axis.
        axis: Axis,
    },
    /// The emergency stop was pressed.
    EmergencyStop,
    /// A step was too late to be emitted: the processor was held up, or the driver could not take it so soon after the
    /// one before.
    LateStep {
        /// Whose step.
        axis: Axis,
    },
    /// A step port ran out of steps in the middle of a move: the processor was held up.
    Underrun {
        /// Whose port.
        axis: Axis,
    },
    /// The board switched the tool off by itself, because the processor was held up. The position is trusted only if
    /// nothing moved.
    ToolCutOff,
    /// The driver of this motor has failed, or does not answer, so nothing says where the axis stands.
    DriverFailed {
        /// Whose driver.
        motor: Motor,
    },
    /// The spindle does not turn as it is to, or nobody knows whether it does. The position is trusted only if nothing moved.
    SpindleFailed {
        /// What is wrong with it.
        fault: SpindleFault,
    },
    /// The probe touched already before the move, or did not touch before a move that was to end the contact; nothing
    /// moved.
    ProbeInitial,
    /// The probe found nothing up to the end of its move.
    ProbeContact,
    /// The safety door was opened while homing.
    HomingDoor,
    /// A move could not be planned with the present configuration; nothing moved.
    Unplannable {
        /// Why not.
        reason: Unplannable,
    },
}

impl Alarm {
    /// True if the homed axes stay homed after a motion that ended with this alarm: every step was made as planned.
    pub(crate) fn leaves_position(self) -> bool {
        matches!(self, Self::Unplannable { .. } | Self::ProbeInitial | Self::ProbeContact)
    }
}

/// What is wrong with a spindle that reports its speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SpindleFault {
    /// It has not reached its speed in time, or has left it.
    Speed,
    /// What turns it has failed, or does not answer.
    Drive,
}

/// Why a move could not be planned: what the planner's error means for the move that was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Unplannable {
    /// It has no steps.
    NoSteps,
    /// The limits of this axis do not work.
    Limits {
        /// The axis.
        axis: Axis,
    },
    /// The feed is slower than a step in 2,000 s.
    Feed,
    /// It would last longer than can be planned.
    TooLong,
    /// The speed profile never leaves standstill, and there is no start speed.
    Standstill,
    /// Its speeds at the ends do not fit its length.
    Ends,
}

impl From<PlanError> for Unplannable {
    fn from(error: PlanError) -> Self {
        match error {
            PlanError::NoSteps => Self::NoSteps,
            PlanError::Limits { axis, .. } => Self::Limits { axis: Axis::ALL[axis] },
            PlanError::PathSpeed { .. } => Self::Feed,
            PlanError::Profile(ProfileError::TooLong { .. }) => Self::TooLong,
            PlanError::Profile(ProfileError::Standstill { .. }) => Self::Standstill,
            // The other errors of a profile are about its ends: the limits of each axis have been checked, and the
            // shared limits lie between them. The chain has room, because a move waits for it.
            PlanError::Profile(_) | PlanError::NoRoom => Self::Ends,
        }
    }
}

/// The end of a run, for one axis or for all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Finish {
    /// Every step was made.
    Done,
    /// It was stopped before its end; the position says where.
    Stopped,
    /// It braked on its path, before its end, for a hold, a jog cancel or a reset.
    Held,
    /// The step port of this axis faulted, so all axes were stopped.
    Fault {
        /// Whose port.
        axis: Axis,
        /// The fault.
        fault: PortFault,
    },
}

/// The phases of homing one axis, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum HomingPhase {
    /// Towards the switch, fast, until it closes.
    Seek,
    /// Away until it opens.
    BackOff,
    /// Towards it again, slowly, until it closes.
    Latch,
    /// Away by the pull-off distance: the axis's zero.
    PullOff,
}

/// One thing that happened.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Event {
    /// A run began: until all axes stand still again, the instants of its moves count from one instant.
    Run {
        /// The instant from which they count.
        start: Instant,
        /// The places where each axis stood.
        origin_steps: [i32; AXES],
        /// The shaping of the axes. What is reported of its moves is the motion that goes into the shapers.
        shaping: Option<Shaping>,
    },
    /// A move has been taken into the look-ahead. Moves have consecutive numbers, by which the events name them.
    Taken {
        /// Its number, which follows that of the move before it, and 65,535 is followed by 0.
        number: u16,
        /// The move as it was asked for.
        asked: Move,
    },
    /// Another move will be made in the run. It begins when its plan does, and the move before it ends then. After a hold it may
    /// be what is left of a move.
    Move {
        /// Its number.
        number: u16,
        /// The plan of all axes.
        plan: SyncMove<AXES>,
    },
    /// Another move will be made in the run. It begins with a blend round the corner before it, and the move before it
    /// ends where that begins.
    Blend {
        /// Its number.
        number: u16,
        /// The plan of the corner.
        blend: Blend<AXES>,
        /// The place where it ends, steps of the longest axis from the beginning of the move.
        end_steps: f64,
    },
    /// The move that was reported last is made together with others that go straight on: at this place another of them begins.
    Mark {
        /// The number of the one that begins.
        number: u16,
        /// Steps of the longest axis from the beginning of the move.
        place_steps: u32,
    },
    /// The move that was reported last goes on by another plan, from the first step of that plan on.
    Replan {
        /// The plan of all axes.
        plan: SyncMove<AXES>,
    },
    /// The run ended.
    RunEnd {
        /// Its end.
        finish: Finish,
        /// The place where the move that was reported last was to stop, steps of the longest axis from its beginning: its end,
        /// unless it was held.
        held_at_steps: f64,
        /// The instant at which that is, s from the start of the run: half a step after the last edge; if the run is shaped,
        /// when the last impulse has passed. No other run starts before.
        plan_s: f64,
        /// The places where each axis stands.
        position_steps: [i32; AXES],
    },
    /// A phase of homing begins.
    Homing {
        /// The axis that is being homed.
        axis: Axis,
        /// The phase.
        phase: HomingPhase,
    },
    /// This axis stands at its zero.
    Homed {
        /// The axis.
        axis: Axis,
    },
    /// The coordinator changed the state.
    State(State),
}
