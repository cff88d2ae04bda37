//! The safety door: a hold with all outputs off.

use embassy_time::Instant;

use super::{Cause, Forget, Inner, Machine};
use crate::event::State;

/// What the safety door has done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Door {
    /// It is open now.
    pub is_open: bool,
    /// It was opened, and the machine is held for that.
    pub is_held: bool,
    /// That hold is over, and the spindle gets its speed.
    pub is_resuming: bool,
}

impl Door {
    /// It has done nothing, and is closed.
    pub(super) const CLOSED: Self = Self { is_open: false, is_held: false, is_resuming: false };

    /// The machine is held for it, or gets going again.
    #[must_use]
    pub fn is_about(self) -> bool {
        self.is_held || self.is_resuming
    }

    pub(super) fn keeps_off(self) -> bool {
        self.is_open || self.is_held
    }
}

impl Machine {
    /// The safety door has been opened, or somebody says so: holds as [`hold`](Self::hold) does, with all outputs off once it
    /// stands still; a laser goes out at once. Homing is stopped.
    pub fn open_door(&self) {
        let homes = self.transition(|inner, state| match state {
            State::Alarm(_) => (state, false),
            State::Home => (state, true),
            _ => {
                inner.door = Door { is_held: true, is_resuming: false, ..inner.door };
                (inner.begin_hold(state), false)
            }
        });
        if homes {
            self.stop(Cause::Door);
        }
        self.tool.ask();
        self.ask();
    }

    /// What the safety door has done.
    #[must_use]
    pub fn door(&self) -> Door {
        self.with(|inner| {
            let is_resuming = inner.door.is_resuming && Instant::now() < inner.outputs.ready_at;
            Door { is_resuming, ..inner.door }
        })
    }

    /// The safety door is open, or closed, debounced. While it is open nothing resumes.
    pub fn set_door(&self, is_open: bool) {
        let opens = self.with(|inner| core::mem::replace(&mut inner.door.is_open, is_open) != is_open && is_open);
        if opens {
            self.open_door();
        }
        self.tool.ask();
    }
}

impl Machine {
    /// The input of the feed hold is low, debounced, or high: a button that is pressed, or, if the configuration says so, the
    /// safety door's switch, low while that is open.
    pub(crate) fn set_hold_input(&self, is_low: bool) {
        let is_door = self.config().hold_is_door;
        let was_pressed = self.with(|inner| core::mem::replace(&mut inner.buttons[0], is_low && !is_door));
        if is_low && !is_door && !was_pressed {
            self.hold();
        }
        self.set_door(is_low && is_door);
    }

    /// The button of the cycle start is pressed, or not, for [`Status`](super::Status).
    pub(crate) fn set_start_button(&self, is_pressed: bool) {
        self.with(|inner| inner.buttons[1] = is_pressed);
    }
}

impl Inner {
    /// With the door open an idle machine is held rather than do what is asked of it: what it is in then.
    pub(super) fn wait_for_door(&mut self, state: State) -> State {
        if !self.door.is_open || state != State::Idle {
            return state;
        }
        self.door.is_held = true;
        self.begin_hold(state)
    }

    /// Holds a machine in `state`: what it is in then. A jog is cancelled.
    pub(super) fn begin_hold(&mut self, state: State) -> State {
        match state {
            State::Idle | State::Run | State::Hold { .. } => {
                self.held = true;
                State::Hold { still: !self.moving }
            }
            State::Jog => {
                (self.held, self.forget) = (self.door.is_held, Forget::Jogs);
                state
            }
            _ => state,
        }
    }
}
