//! The edges that stop the machine at once, for an interrupt of the board that inhibits before it takes a lock.
//!
//! # Design
//! The life cycle decides on a stop in a critical section, which takes microseconds. So what it would decide is known before
//! the edge comes: every critical section that changes what it depends on (the life, the configuration, the debounced level
//! of a switch) stores the result in one word. An interrupt comes before such a section or after it, so the word it reads
//! is what the life cycle decides right afterwards. It inhibits by the word, and reports the edge, which decides on the alarm.

use core::sync::atomic::Ordering;

use super::{Inner, Machine, Trigger};
use crate::axes::Axis;
use crate::motor::{LimitInput, Motor};

/// The falling edges of the limit inputs are the lowest bits of the word, in the order of their places; then the rising ones.
const RISING_SHIFT: usize = 12;
const EMERGENCY_STOP: u32 = 1 << 24;
const RESET_BYTE: u32 = 1 << 25;

const _: () = assert!(LimitInput::COUNT <= RISING_SHIFT, "a limit input has two bits of the word");

/// Both edges of the alarms of drives.
const ALARMS: u32 = {
    let falling = (1 << LimitInput::COUNT) - (1 << LimitInput::ALARMS);
    falling | falling << RISING_SHIFT
};

#[inline(always)]
const fn edge(place: usize, is_low: bool) -> u32 {
    (if is_low { 1 } else { 1 << RISING_SHIFT }) << place
}

/// For an interrupt of the board which no critical section and nothing of this crate interrupts. If the answer is yes, the
/// report of the edge that follows stops the machine, so the board may inhibit the axes and the tool before it. Not even a
/// lock is taken.
impl Machine {
    /// True if [`limit_edge`](Self::limit_edge) would stop everything now.
    #[inline(always)]
    #[must_use]
    pub fn stops_at_limit(&self, input: LimitInput, is_low: bool) -> bool {
        self.armed.load(Ordering::Relaxed) & edge(input.index(), is_low) != 0
    }

    /// True if a press that [`emergency_stop_edge`](Self::emergency_stop_edge) reports would lock the machine now.
    #[inline(always)]
    #[must_use]
    pub fn stops_at_emergency(&self) -> bool {
        self.armed.load(Ordering::Relaxed) & EMERGENCY_STOP != 0
    }

    /// True if [`reset_heard`](Self::reset_heard) would stop everything now.
    #[inline(always)]
    #[must_use]
    pub fn stops_at_reset(&self) -> bool {
        self.armed.load(Ordering::Relaxed) & RESET_BYTE != 0
    }

    /// Stores anew which edges stop the machine.
    pub(super) fn arm(&self, inner: &Inner) {
        let of = |is_so: bool, bits: u32| if is_so { bits } else { 0 };
        let (life, presses) = (&inner.life, inner.presses);
        let armed = of(life.heeds_limits(), presses & !ALARMS)
            | of(!life.is_locked(), presses & ALARMS | EMERGENCY_STOP)
            | of(life.heeds_reset_byte(), RESET_BYTE);
        self.armed.store(armed, Ordering::Relaxed);
    }

    /// Sets the debounced level of a limit input.
    pub(crate) fn publish_switch(&self, input: LimitInput, is_pressed: bool) {
        self.with(|inner| {
            self.switches[input.index()].publish(is_pressed);
            self.note_press(inner, input);
            self.arm(inner);
        });
    }

    /// Stores anew which edges are presses, after a change of the configuration.
    pub(super) fn rearm(&self, inner: &mut Inner) {
        for axis in Axis::ALL {
            self.note_press(inner, LimitInput::Of(axis));
            self.note_press(inner, LimitInput::Alarm(axis));
        }
        self.note_press(inner, LimitInput::Second);
        self.arm(inner);
    }

    /// Stores which edge of a limit input is a press, if there is one. A pressed switch bounces when it is left; that is no press.
    #[inline(never)]
    fn note_press(&self, inner: &mut Inner, input: LimitInput) {
        let place = input.index();
        let (is_heeded, is_low) = inner.config.press(input);
        inner.presses &= !((1 << RISING_SHIFT | 1) << place);
        if is_heeded && !self.switches[place].is_pressed() {
            inner.presses |= edge(place, is_low);
        }
    }
}

impl Inner {
    /// The trigger of this edge of a limit input, if it is a press.
    pub(super) fn pressed(&self, input: LimitInput, is_low: bool) -> Option<Trigger> {
        if self.presses & edge(input.index(), is_low) == 0 {
            return None;
        }
        Some(match input {
            LimitInput::Of(axis) if self.config.is_stall(input) => Trigger::Stalled(Motor::first(axis)),
            LimitInput::Of(axis) => Trigger::Limit(Motor::first(axis)),
            LimitInput::Second => Trigger::Limit(Motor::second(self.config.squared?.axis)),
            LimitInput::Alarm(axis) => Trigger::DriverFailed(Motor::first(axis)),
        })
    }
}
