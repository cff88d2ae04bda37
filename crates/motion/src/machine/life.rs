//! The life cycle of a machine: which state it is in, and what each trigger makes of it.
//!
//! All of it is one function, [`Life::on`]. It reads and changes nothing except the [`Life`], so it can be tried on
//! every life that can be reached: see its tests. They also compare it with the table in `docs/states.md`. The machine
//! calls it in a critical section (`Machine::apply`), and afterwards does what the [`Reaction`] says.
//!
//! States and causes are matched, not compared: on a chip a constant to compare with would be read from slow memory.

#[cfg(test)]
mod tests;

use super::Door;
use crate::event::{Alarm, SpindleFault, State};
use crate::motor::Motor;

/// The state of a machine, and what decides on the next one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Life {
    pub state: State,
    /// The number of motions that have been asked for and are not finished.
    pub pending: usize,
    /// A run is under way: axes may move.
    pub moving: bool,
    /// Nothing moves until it is resumed.
    pub held: bool,
    pub forget: Forget,
    /// Why the motion under way was stopped, until it has ended.
    pub cause: Option<Cause>,
    /// The emergency stop is pressed.
    pub emergency: bool,
    pub door: Door,
    /// A reset byte has been heard, and the console has not reported it yet.
    pub reset_heard: bool,
    /// The number of resets that have had all motions forgotten.
    pub resets: u32,
}

/// The motions asked for that are to be forgotten; the one under way brakes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Forget {
    Nothing,
    /// All jogs.
    Jogs,
    /// All motions, for a reset.
    All,
}

/// Why everything was stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cause {
    Reset,
    Limit(Motor),
    EmergencyStop,
    /// The safety door, while homing.
    Door,
    /// A fault of a step port, which has this alarm.
    Fault(Alarm),
    /// The board has switched the tool off by itself.
    ToolCutOff,
    /// The spindle does not turn as it is to.
    Spindle(SpindleFault),
    /// The driver of this motor has failed.
    Driver(Motor),
}

impl Cause {
    /// The alarm for a machine that this cause stopped in `state`.
    pub fn alarm(self, state: State) -> Alarm {
        match (self, state) {
            (Self::Limit(motor), _) => Alarm::HardLimit { motor },
            (Self::EmergencyStop, _) => Alarm::EmergencyStop,
            (Self::Door, _) => Alarm::HomingDoor,
            (Self::Fault(alarm), _) => alarm,
            (Self::ToolCutOff, _) => Alarm::ToolCutOff,
            (Self::Spindle(fault), _) => Alarm::SpindleFailed { fault },
            (Self::Driver(motor), _) => Alarm::DriverFailed { motor },
            (Self::Reset, State::Home) => Alarm::HomingReset,
            (Self::Reset, _) => Alarm::ResetInMotion,
        }
    }
}

/// The kinds of motion that the life cycle tells apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A move, a probing move or a dwell.
    Program,
    Jog,
    Homing,
}

/// An event of a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Trigger {
    /// A motion is asked for.
    Asked(Kind),
    /// An output is to be switched on.
    OutputAsked,
    /// A run begins (`true`), or has ended.
    Moving(bool),
    /// Homing begins.
    Homing,
    /// So many motions have ended, with this result.
    Ended(Result<(), Alarm>, usize),
    /// A motion was given up before it began.
    PassedOver,
    Hold,
    Resume,
    /// The motion that was held goes on: the spindle has its speed.
    GoesOn,
    CancelJog,
    /// A console says that the safety door has been opened.
    OpenDoor,
    /// The input of the safety door, debounced: it is open.
    Door(bool),
    /// A reset byte has been heard; the reset itself follows.
    ResetHeard,
    Reset,
    /// A limit switch was hit.
    Limit(Motor),
    /// The emergency stop has been pressed (`true`) or let go.
    EmergencyStop(bool),
    /// A step port could not go on; the alarm says which.
    Fault(Alarm),
    /// The board has switched the tool off by itself, because the processor was held up.
    ToolCutOff,
    /// The spindle does not turn as it is to, or nobody knows whether it does.
    SpindleFailed(SpindleFault),
    /// The driver of this motor has failed.
    DriverFailed(Motor),
    /// It says by its output that its motor has stalled, or that it has failed.
    Stalled(Motor),
    /// The coordinator was dropped in a run, and another one takes over.
    TakenOver,
    /// The outputs have been switched off, all at once.
    OutputsCut,
    /// Something was found that locks the machine, before anything moved.
    Raise(Alarm),
    Unlock,
}

/// The action of the machine after a trigger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reaction {
    /// Nothing else.
    None,
    /// To refuse what was asked for; nothing has changed.
    Refuse,
    /// To wake the coordinator, which acts on what was asked for.
    Wake,
    /// To stop all axes within one pulse and switch all outputs off.
    Halt,
    /// To distrust the position of every axis.
    Distrust,
}

impl Life {
    /// At rest, not locked, nothing asked for.
    pub const fn new() -> Self {
        Self {
            state: State::Idle,
            pending: 0,
            moving: false,
            held: false,
            forget: Forget::Nothing,
            cause: None,
            emergency: false,
            door: Door::CLOSED,
            reset_heard: false,
            resets: 0,
        }
    }

    /// The machine is locked.
    pub fn is_locked(&self) -> bool {
        matches!(self.state, State::Alarm(_))
    }

    /// The move under way is to brake, and no other may follow.
    pub fn is_to_brake(&self) -> bool {
        self.held || self.forget != Forget::Nothing
    }

    /// The motion under way is to brake, or has been stopped.
    pub fn is_interrupted(&self) -> bool {
        self.is_to_brake() || self.cause.is_some()
    }

    /// The motion that is held or under way is to be forgotten.
    pub fn is_to_forget(&self) -> bool {
        self.forget != Forget::Nothing || self.cause.is_some()
    }

    /// True if the first edge of a limit switch, or a stall that a driver tells, stops everything.
    pub fn heeds_limits(&self) -> bool {
        self.pending > 0 && !self.is_locked() && !matches!(self.state, State::Home)
    }

    /// True if a reset byte stops everything.
    pub fn heeds_reset_byte(&self) -> bool {
        self.pending > 0 && !self.is_locked() && (self.reset_heard || self.forget == Forget::All)
    }

    /// Changes the state, and what goes with it, as `trigger` demands. What is to be done then is the result.
    pub fn on(&mut self, trigger: Trigger) -> Reaction {
        match trigger {
            Trigger::Asked(kind) => return self.ask(kind),
            Trigger::OutputAsked => return self.ask_output(),
            Trigger::Moving(moving) => self.set_moving(moving),
            // A hold, a reset or a stop that came just before is for the coordinator to obey first.
            Trigger::Homing if self.is_interrupted() => return Reaction::Refuse,
            Trigger::Homing => self.state = State::Home,
            Trigger::Ended(result, motions) => return self.end(result, motions),
            // The last one is judged like a motion that ended: a stop may have come while it waited.
            Trigger::PassedOver if self.pending == 1 && !self.is_locked() => return self.end(Ok(()), 1),
            Trigger::PassedOver => _ = self.take_off(1),
            // A machine that is held already may be braking for a reset, which a hold must not stop.
            Trigger::Hold if !matches!(self.state, State::Hold { .. }) => return self.hold(),
            Trigger::Resume => return self.resume(),
            Trigger::GoesOn => self.door.is_resuming = false,
            Trigger::CancelJog if matches!(self.state, State::Jog) => {
                self.forget = Forget::Jogs;
                return Reaction::Wake;
            }
            Trigger::OpenDoor => return self.open_door(),
            Trigger::Door(is_open) => {
                let was_open = core::mem::replace(&mut self.door.is_open, is_open);
                if is_open && !was_open {
                    return self.open_door();
                }
            }
            Trigger::ResetHeard => {
                let was_heard = core::mem::replace(&mut self.reset_heard, self.pending > 0);
                if was_heard || self.forget == Forget::All {
                    return self.stop(Cause::Reset);
                }
            }
            Trigger::Reset => return self.reset(),
            // Homing looks for its switches.
            Trigger::Limit(motor) if !matches!(self.state, State::Home) => return self.stop(Cause::Limit(motor)),
            Trigger::EmergencyStop(pressed) => {
                self.emergency = pressed;
                if pressed {
                    return self.stop(Cause::EmergencyStop);
                }
            }
            Trigger::Fault(alarm) => return self.stop(Cause::Fault(alarm)),
            Trigger::ToolCutOff => return self.stop(Cause::ToolCutOff),
            Trigger::SpindleFailed(fault) => return self.stop(Cause::Spindle(fault)),
            Trigger::DriverFailed(motor) => return self.stop(Cause::Driver(motor)),
            // Homing looks for stalls, too.
            Trigger::Stalled(motor) if !matches!(self.state, State::Home) => return self.stop(Cause::Driver(motor)),
            Trigger::TakenOver if matches!(self.cause, Some(Cause::Fault(_))) => {
                self.cause = self.emergency.then_some(Cause::EmergencyStop);
                return Reaction::Distrust;
            }
            Trigger::OutputsCut => (self.door.is_held, self.door.is_resuming) = (false, false),
            Trigger::Raise(alarm) if !self.is_locked() => self.state = State::Alarm(alarm),
            Trigger::Unlock => return self.unlock(),
            Trigger::Hold
            | Trigger::CancelJog
            | Trigger::TakenOver
            | Trigger::Limit(_)
            | Trigger::Stalled(_)
            | Trigger::Raise(_) => {}
        }
        Reaction::None
    }

    fn ask(&mut self, kind: Kind) -> Reaction {
        let is_refused = match (self.state, kind) {
            // Homing leaves an alarm, as unlocking does.
            (State::Alarm(_), Kind::Homing) => self.is_to_stay_locked(),
            (State::Alarm(_), _) => true,
            // Jogs mix with nothing else.
            (State::Jog, _) => kind != Kind::Jog,
            (State::Idle, _) => false,
            _ => kind == Kind::Jog,
        };
        // Jogs and homing never wait for a door.
        let is_barred = self.door.is_open && kind != Kind::Program;
        // What is taken now would be forgotten with the rest.
        if is_refused || is_barred || self.forget != Forget::Nothing {
            return Reaction::Refuse;
        }
        self.pending += 1;
        self.wait_for_door();
        self.state = match (self.state, kind) {
            (State::Idle | State::Alarm(_), Kind::Homing) => State::Home,
            (State::Idle, Kind::Jog) => State::Jog,
            (State::Idle, Kind::Program) => State::Run,
            (state, _) => state,
        };
        Reaction::None
    }

    fn ask_output(&mut self) -> Reaction {
        if self.is_locked() || self.cause.is_some() || self.forget == Forget::All {
            return Reaction::Refuse;
        }
        self.wait_for_door();
        Reaction::None
    }

    /// With the door open an idle machine is held instead of doing what is asked of it.
    fn wait_for_door(&mut self) {
        if self.door.is_open && matches!(self.state, State::Idle) {
            self.door.is_held = true;
            self.hold();
        }
    }

    /// So it is known at any time whether a hold finds the machine at rest.
    fn set_moving(&mut self, moving: bool) {
        self.moving = moving;
        if self.held && matches!(self.state, State::Hold { .. }) {
            self.state = State::Hold { still: !moving };
        }
    }

    /// Takes `motions` motions off those that are pending. If none is left, the stop, jog cancel or reset that
    /// concerned them has been obeyed, and is forgotten. Returns whether none is left.
    fn take_off(&mut self, motions: usize) -> bool {
        self.pending -= motions;
        let is_last = self.pending == 0;
        if is_last {
            (self.cause, self.forget, self.reset_heard) = (None, Forget::Nothing, false);
        }
        is_last
    }

    /// A stop that found nothing moving any more is judged here. After a reset the machine is ready, its position
    /// trusted, but the cause remains until every waiting motion has been passed over.
    fn end(&mut self, result: Result<(), Alarm>, motions: usize) -> Reaction {
        let cause = self.cause;
        let is_last = self.take_off(motions);
        self.state = match (result, cause) {
            (Err(alarm), _) => State::Alarm(alarm),
            // The emergency stop was pressed after a reset, whose cause was kept.
            (Ok(()), _) if self.emergency => State::Alarm(Alarm::EmergencyStop),
            (Ok(()), Some(cause)) if !matches!(cause, Cause::Reset) => State::Alarm(cause.alarm(self.state)),
            (Ok(()), None) if self.held => State::Hold { still: true },
            (Ok(()), _) if is_last => State::Idle,
            (Ok(()), _) if matches!(self.state, State::Jog) || self.forget == Forget::All => self.state,
            (Ok(()), _) => State::Run,
        };
        // A stop ends a hold; what was held is forgotten.
        self.held &= matches!(self.state, State::Hold { .. });
        let State::Alarm(alarm) = self.state else { return Reaction::None };
        (self.cause, self.forget) = (None, Forget::Nothing);
        // A move that could not be planned has not begun, and a probing move brakes on its path. After any other alarm
        // the motors may have overshot.
        if alarm.leaves_position() { Reaction::None } else { Reaction::Distrust }
    }

    /// Holds the machine, or cancels a jog.
    fn hold(&mut self) -> Reaction {
        match self.state {
            State::Idle | State::Run | State::Hold { .. } => {
                self.held = true;
                self.state = State::Hold { still: !self.moving };
            }
            State::Jog => (self.held, self.forget) = (self.door.is_held, Forget::Jogs),
            State::Home | State::Alarm(_) => return Reaction::None,
        }
        Reaction::Wake
    }

    fn resume(&mut self) -> Reaction {
        if !matches!(self.state, State::Hold { still: true }) || self.door.is_open {
            return Reaction::None;
        }
        self.held = false;
        self.state = if self.pending == 0 { State::Idle } else { State::Run };
        self.door.is_resuming = self.door.is_held && matches!(self.state, State::Run);
        self.door.is_held = false;
        Reaction::Wake
    }

    fn open_door(&mut self) -> Reaction {
        match self.state {
            State::Alarm(_) => Reaction::None,
            State::Home => self.stop(Cause::Door),
            _ => {
                (self.door.is_held, self.door.is_resuming) = (true, false);
                self.hold()
            }
        }
    }

    fn reset(&mut self) -> Reaction {
        let was_heard = core::mem::take(&mut self.reset_heard);
        let is_braking = self.forget == Forget::All || was_heard && self.cause.is_some();
        if is_braking || !matches!(self.state, State::Run | State::Jog | State::Hold { .. }) {
            return self.stop(Cause::Reset);
        }
        self.held = false;
        if self.pending == 0 {
            self.state = State::Idle;
        } else {
            self.forget = Forget::All;
            self.resets = self.resets.wrapping_add(1);
            self.state = State::Hold { still: false };
        }
        Reaction::Wake
    }

    /// Notes why everything stops; the first cause is kept. At rest only the emergency stop, a tool that was cut off, a
    /// spindle and a driver that have failed mean anything. Only a driver holds an axis at rest, also while the machine is locked.
    fn stop(&mut self, cause: Cause) -> Reaction {
        let is_driver = matches!(cause, Cause::Driver(_));
        if self.is_locked() {
            return if is_driver { Reaction::Distrust } else { Reaction::None };
        }
        if self.pending > 0 {
            // A reset at rest would leave the position trusted.
            let gives_way = is_driver && matches!(self.cause, Some(Cause::Reset));
            self.cause = self.cause.filter(|_| !gives_way).or(Some(cause));
            return Reaction::Halt;
        }
        let (alarm, reaction) = match cause {
            Cause::EmergencyStop => (Alarm::EmergencyStop, Reaction::None),
            Cause::ToolCutOff => (Alarm::ToolCutOff, Reaction::None),
            Cause::Spindle(fault) => (Alarm::SpindleFailed { fault }, Reaction::None),
            Cause::Driver(motor) => (Alarm::DriverFailed { motor }, Reaction::Distrust),
            _ => return Reaction::None,
        };
        self.held = false;
        self.state = State::Alarm(alarm);
        reaction
    }

    fn unlock(&mut self) -> Reaction {
        if !self.is_locked() {
            return if self.emergency { Reaction::Refuse } else { Reaction::None };
        }
        if self.is_to_stay_locked() {
            return Reaction::Refuse;
        }
        self.state = State::Idle;
        Reaction::None
    }

    /// The motions that waited when the machine was locked are passed over first: none of them may still be made.
    fn is_to_stay_locked(&self) -> bool {
        self.emergency || self.pending > 0
    }
}
