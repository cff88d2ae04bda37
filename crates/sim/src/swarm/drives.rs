//! Worlds with drives that close their own loop: one in four of those without UART drivers has their alarms wired, to each axis or on
//! one wire, with contacts of either kind. The drives alarm by themselves, for an instant or longer, or for steps that are lost.
//!
//! They are drawn apart from all else, so that a seed's world is the same but for them.

use isostep_motion::{AXES, Motor};
use oorandom::Rand64;

use super::Random;
use super::scenario::{Act, Scenario};
use crate::config::Board;

/// Worlds that have their alarms wired: one in so many.
const HAS_ALARMS: u64 = 4;
const LONGEST_US: f64 = 500_000.0;

/// The scenario of this seed, with drives that alarm if its world has them.
pub(super) fn with_drives(seed: u64, mut scenario: Scenario) -> Scenario {
    let mut random = Random(Rand64::new(u128::from(seed) | 1 << 65));
    if scenario.config.board != Board::Pico || !random.one_in(HAS_ALARMS) {
        return scenario;
    }
    let all: u16 = (1 << AXES) - 1;
    let config = &mut scenario.config;
    (config.closed_loop, config.one_alarm_wire) = (random.one_in(2), random.one_in(2));
    config.settings.drive_alarm_mask = if config.one_alarm_wire { 1 } else { random.of(&[all, all, 3]) };
    config.settings.drive_alarm_closed_mask = random.below(u64::from(all) + 1) as u16;
    for _ in 0..1 + random.below(5) {
        let at = random.below(scenario.acts.len() as u64 + 1) as usize;
        scenario.acts.splice(at..at, random.about_drives());
    }
    scenario
}

impl Random {
    /// A drive that alarms: in most cases of a machine that is not locked, in some again while it is being unlocked.
    fn about_drives(&mut self) -> Vec<Act> {
        let send = |line: &str| Act::Line(0, line.to_owned());
        let mut acts = Vec::new();
        if !self.one_in(3) {
            acts.extend([Act::Rest, send("$X"), Act::Wait(self.between(1.0, 1.5e6) as u64)]);
        }
        if self.one_in(2) {
            acts.push(send("G91 G1 X1 Y-1 F300"));
            acts.push(Act::Wait(self.between(1.0, 300_000.0) as u64));
        }
        acts.push(self.alarm());
        if self.one_in(2) {
            let unlock = self.of(&["$X", "$X", "$H"]);
            acts.extend([send(unlock), Act::Wait(self.between(1.0, 1.5e6) as u64), self.alarm()]);
        }
        acts
    }

    fn alarm(&mut self) -> Act {
        Act::Drive(Motor::first(self.axis()), self.between(1.0, LONGEST_US) as u64)
    }
}
