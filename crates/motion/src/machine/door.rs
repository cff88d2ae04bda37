//! The safety door: a hold with all outputs off.

use super::{Machine, State, Trigger};

/// The state of the safety door.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Door {
    /// It is open now.
    pub is_open: bool,
    /// It was opened, and the machine is held because of that.
    pub is_held: bool,
    /// The hold is over, and the spindle is getting its speed.
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
        self.on(Trigger::OpenDoor);
        self.tool.ask();
    }

    /// The state of the safety door.
    #[must_use]
    pub fn door(&self) -> Door {
        self.life().door
    }
}

impl Machine {
    /// Sets whether the input of the feed hold is low, debounced. Low means that the button is pressed or, if the
    /// configuration says so, that the safety door is open.
    pub(crate) fn set_hold_input(&self, is_low: bool) {
        self.take_hold_input(Some(is_low));
    }

    /// Takes the input of the feed hold for what the configuration says from now on.
    pub(crate) fn reread_hold_input(&self) {
        self.take_hold_input(None);
    }

    /// Takes a new level of the input, or the one it has. That is looked up in the critical section in which it takes
    /// effect. Otherwise the task that watches the input could come in between, and a door that has just been opened would
    /// count as closed.
    fn take_hold_input(&self, level: Option<bool>) {
        let (holds, reaction) = self.with(|inner| {
            let is_door = inner.config.hold_is_door;
            let is_low = level.unwrap_or(inner.buttons[0] || inner.life.door.is_open);
            let was_pressed = core::mem::replace(&mut inner.buttons[0], is_low && !is_door);
            (is_low && !is_door && !was_pressed, self.apply(inner, Trigger::Door(is_low && is_door)))
        });
        self.react(reaction);
        if holds {
            self.hold();
        }
        self.tool.ask();
    }

    /// Sets whether the button of the cycle start is pressed, for [`Status`](super::Status). Who watches a machine at rest hears of it:
    /// what the press means there is not the machine's to say.
    pub(crate) fn set_start_button(&self, is_pressed: bool) {
        self.with(|inner| inner.buttons[1] = is_pressed);
        self.announce();
    }

    /// Wakes all that watch the state, if the machine is at rest: something else has changed that they look at.
    #[cold]
    pub fn announce(&self) {
        // In one critical section: an alarm that came between would be told as rest.
        self.with(|inner| {
            if inner.life.state == State::Idle {
                self.state.dyn_sender().send(State::Idle);
            }
        });
    }
}
