//! Stops: their causes, the state after them, and how an alarm is left.

use embassy_futures::select::select;
use embassy_time::{Instant, Timer};

use super::{Busy, Forget, Machine};
use crate::axes::{AXES, Axis};
use crate::config::Config;
use crate::event::{Alarm, State};
use crate::port::Direction;

/// Why everything was stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cause {
    Reset,
    Limit(Axis),
    EmergencyStop,
    /// The safety door, while homing.
    Door,
}

impl Cause {
    /// The alarm for a machine that this cause stopped in `state`.
    pub fn alarm(self, state: State) -> Alarm {
        match (self, state) {
            (Self::Limit(axis), _) => Alarm::HardLimit { axis },
            (Self::EmergencyStop, _) => Alarm::EmergencyStop,
            (Self::Door, _) => Alarm::HomingDoor,
            (Self::Reset, State::Home) => Alarm::HomingReset,
            (Self::Reset, _) => Alarm::ResetInMotion,
        }
    }
}

impl Machine {
    /// Forgets the waiting motions, and brakes the move under way on its path, as a [`hold`](Self::hold) does. Then the
    /// machine is idle, its position trusted. A second reset before that, or a reset while homing, stops everything
    /// within one pulse, and an alarm says that the position is not trusted. At rest a reset ends a hold, and nothing
    /// else. The tool's outputs are off at once.
    pub fn reset(&self) {
        self.cut();
        let brakes = self.transition(|inner, state| match state {
            _ if core::mem::take(&mut inner.reset_heard) && inner.cause.is_some() => (state, false),
            State::Run | State::Jog | State::Hold { .. } if inner.forget != Forget::All => {
                inner.held = false;
                if inner.pending == 0 {
                    return (State::Idle, true);
                }
                inner.forget = Forget::All;
                inner.resets = inner.resets.wrapping_add(1);
                (State::Hold { still: false }, true)
            }
            _ => (state, false),
        });
        if brakes {
            self.ask();
            self.stopped.signal(());
        } else {
            self.stop(Cause::Reset);
        }
    }

    /// Locks the machine with `alarm`, unless it is locked already. It is for what is found before anything moves.
    pub fn raise(&self, alarm: Alarm) {
        self.transition(|_, state| match state {
            State::Alarm(_) => (state, ()),
            _ => (State::Alarm(alarm), ()),
        });
    }

    /// Leaves an alarm; the position is as trusted as the alarm left it.
    ///
    /// # Errors
    /// While the emergency stop is pressed the machine stays in the alarm.
    pub fn unlock(&self) -> Result<(), Busy> {
        self.transition(|inner, state| match state {
            _ if inner.emergency => (state, Err(Busy(state))),
            State::Alarm(_) => (State::Idle, Ok(())),
            _ => (state, Ok(())),
        })
    }
}

/// For an interrupt of the board that notices a switch, or a byte, before the task that handles it does.
impl Machine {
    /// A reset byte has been heard, which [`reset`](Self::reset) will report later. The tool's outputs are off at once.
    /// If the machine still brakes for an earlier reset byte, or that one has not been reported yet, the machine stops
    /// at once. Call it once for each byte, from any context.
    pub fn reset_heard(&self) {
        let is_second = self.with(|inner| {
            let was_heard = core::mem::replace(&mut inner.reset_heard, inner.pending > 0);
            was_heard || inner.forget == Forget::All
        });
        if is_second {
            self.stop(Cause::Reset);
        }
        self.cut();
    }

    /// A limit input has changed, and is now low or high. The first edge of a press stops a running machine at once, if
    /// hard limits are on. It may be called any number of times, from any context.
    pub fn limit_edge(&self, axis: Axis, is_low: bool) {
        let is_press = self.with(|inner| inner.config.hard_limits && is_low != inner.config.switches_inverted);
        // A pressed switch bounces when it is left; that is no press.
        if is_press && !self.switch(axis).is_pressed() {
            self.stop(Cause::Limit(axis));
        }
    }

    /// The emergency-stop input has changed, and is now low or high. The first edge of a press stops the machine at
    /// once. It may be called any number of times, from any context.
    pub fn emergency_stop_edge(&self, is_low: bool) {
        if is_low {
            self.set_emergency(true);
        }
    }
}

/// For the tasks of this crate.
impl Machine {
    /// The cause of a stop that was asked for and that the coordinator has not answered yet.
    pub(crate) fn cause(&self) -> Option<Cause> {
        self.with(|inner| inner.cause)
    }

    /// The first axis that `steps` would take further onto its switch. The switch has closed already, so no edge would
    /// report it.
    pub(crate) fn onto_switch(&self, steps: [i32; AXES]) -> Option<Axis> {
        let Config { hard_limits, homing, .. } = self.config();
        let is_towards = |axis: Axis| {
            let steps = steps[axis as usize];
            steps != 0 && Direction::of(steps) == homing.towards[axis as usize]
        };
        Axis::ALL.into_iter().find(|&axis| hard_limits && self.switch(axis).may_be_pressed() && is_towards(axis))
    }

    pub(crate) fn set_emergency(&self, pressed: bool) {
        self.with(|inner| inner.emergency = pressed);
        if pressed {
            self.stop(Cause::EmergencyStop);
        }
    }

    /// Stops the axes within one pulse. Safe at any priority.
    pub(crate) fn halt(&self) {
        for link in &self.links {
            link.brake(true);
        }
        for link in &self.links {
            link.halt.signal(());
        }
    }

    /// Stops everything and notes the cause; the first cause is kept. While homing a limit switch stops nothing here,
    /// because homing looks for it.
    pub(crate) fn stop(&self, cause: Cause) {
        let moving = self.transition(|inner, state| match (state, cause) {
            (State::Alarm(_), _) | (State::Home, Cause::Limit(_)) => (state, false),
            _ if inner.pending > 0 => {
                inner.cause = inner.cause.or(Some(cause));
                (state, true)
            }
            (_, Cause::EmergencyStop) => {
                inner.held = false;
                (State::Alarm(Alarm::EmergencyStop), false)
            }
            _ => (state, false),
        });
        if moving {
            // The steps are stopped first. Meanwhile the outputs stay as they are: nothing switches them on while there
            // is a cause.
            self.halt();
            self.cut();
            self.stopped.signal(());
        }
    }

    /// Ends `motions` motions with `result`, and returns the state that the machine is in then. No stop that comes
    /// meanwhile is lost, because state and cause change in one critical section.
    ///
    /// A stop that found nothing moving any more is judged here. After a reset the machine is ready, its position
    /// trusted, but the cause remains until every waiting motion has been passed over.
    pub(crate) fn conclude(&self, result: Result<(), Alarm>, motions: usize) -> State {
        self.transition(|inner, state| {
            let cause = inner.cause;
            let last = inner.end(motions);
            let next = match (result, cause) {
                (Err(alarm), _) => State::Alarm(alarm),
                // The emergency stop was pressed after a reset, whose cause was kept.
                (Ok(()), _) if inner.emergency => State::Alarm(Alarm::EmergencyStop),
                (Ok(()), Some(cause @ (Cause::Limit(_) | Cause::EmergencyStop | Cause::Door))) => {
                    State::Alarm(cause.alarm(state))
                }
                (Ok(()), None) if inner.held => State::Hold { still: true },
                (Ok(()), _) if last => State::Idle,
                (Ok(()), _) if state == State::Jog || inner.forget == Forget::All => state,
                (Ok(()), _) => State::Run,
            };
            if matches!(next, State::Alarm(_)) {
                (inner.cause, inner.forget) = (None, Forget::Nothing);
            }
            // A stop ends a hold; what was held is forgotten.
            inner.held &= matches!(next, State::Hold { .. });
            // A move that could not be planned has not begun, and a probing move brakes on its path. After any other
            // alarm the motors may have overshot.
            if matches!(next, State::Alarm(alarm) if !alarm.leaves_position()) {
                inner.homed = [false; AXES];
            }
            (next, next)
        })
    }

    /// Waits until `end`, or until everything is stopped; true if it was stopped.
    pub(crate) async fn is_stopped_before(&self, end: Instant) -> bool {
        while self.cause().is_none() {
            if select(self.stopped.wait(), Timer::at(end)).await.is_second() {
                return false;
            }
        }
        true
    }

    pub(crate) fn forget_stopped(&self) {
        self.stopped.reset();
    }
}
