//! The effect of real-time bytes on the machine.

use super::machine::{Model, State};

impl Model {
    /// A byte, at rest or while lines are carried out.
    pub fn byte(&mut self, byte: u8, at_rest: bool) {
        let [feed, rapid, speed] = &mut self.overrides;
        match byte {
            0x90 => *feed = 100,
            0x91..=0x94 => *feed = changed(*feed, byte - 0x91),
            0x95 => *rapid = 100,
            0x96 => *rapid = 50,
            0x97 => *rapid = 25,
            0x99 => *speed = 100,
            0x9A..=0x9D => *speed = changed(*speed, byte - 0x9A),
            0xA0 if at_rest && self.state == State::Idle => self.modes.flood = !self.modes.flood,
            0xA1 if at_rest && self.state == State::Idle => self.modes.mist = !self.modes.mist,
            _ => {}
        }
    }
}

/// 10 % more, 10 % less, 1 % more, 1 % less, from 10 to 200 %.
fn changed(percent: i64, which: u8) -> i64 {
    (percent + [10, -10, 1, -1][usize::from(which)]).clamp(10, 200)
}
