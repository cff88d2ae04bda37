//! The safety door: a hold with all outputs off.

use embassy_time::Instant;

use super::{Cause, Forget, Inner, Machine};
use crate::event::State;

/// What the safety door has done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Door {
    /// It is open now.
    pub is_open: bool,
    /// It was opened, and the machine is held because of that.
    pub is_held: bool,
    /// That hold is over, and the spindle is getting its speed.
    pub is_resuming: bool,
}

impl Door {
    /// The door is closed, and nothing is held because of it.
    pub(super) const CLOSED: Self = Self { is_open: false, is_held: false, is_resuming: false };

    /// The machine is held because of the door, or is resuming after that hold.
    #[must_use]
    pub fn is_about(self) -> bool {
        self.is_held || self.is_resuming
    }

    pub(super) fn keeps_off(self) -> bool {
        self.is_open || self.is_held
    }
}

impl Machine {
    /// The safety door has been opened, or a console says so. The machine holds as with [`hold`](Self::hold), and all
    /// outputs are off once it stands still; a laser goes out at once. Homing is stopped.
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

    /// Sets whether the safety door is open, debounced. While it is open nothing resumes.
    pub fn set_door(&self, is_open: bool) {
        let opens = self.with(|inner| core::mem::replace(&mut inner.door.is_open, is_open) != is_open && is_open);
        if opens {
            self.open_door();
        }
        self.tool.ask();
    }
}

impl Machine {
    /// Sets whether the input of the feed hold is low, debounced. Low means that the button is pressed or, if the
    /// configuration says so, that the safety door is open.
    pub(crate) fn set_hold_input(&self, is_low: bool) {
        let is_door = self.config().hold_is_door;
        let was_pressed = self.with(|inner| core::mem::replace(&mut inner.buttons[0], is_low && !is_door));
        if is_low && !is_door && !was_pressed {
            self.hold();
        }
        self.set_door(is_low && is_door);
    }

    /// Sets whether the button of the cycle start is pressed, for [`Status`](super::Status).
    pub(crate) fn set_start_button(&self, is_pressed: bool) {
        self.with(|inner| inner.buttons[1] = is_pressed);
    }
}

impl Inner {
    /// With the door open an idle machine is held instead of doing what is asked of it. Returns the state that it is in
    /// then.
    pub(super) fn wait_for_door(&mut self, state: State) -> State {
        if !self.door.is_open || state != State::Idle {
            return state;
        }
        self.door.is_held = true;
        self.begin_hold(state)
    }

    /// Holds a machine in `state`, and cancels a jog. Returns the state that it is in then.
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
