//! Worlds with a VFD: one in five has one, of any type, with settings and ramps of its own. It and its wire fail while the spindle
//! turns, while it is to turn, while it is to stop, and at rest, for an instant or longer, and again once the machine is unlocked.
//!
//! They are drawn apart from all else, so that a seed's world is the same but for them.

use isostep_console::Settings;
use oorandom::Rand64;

use super::Random;
use super::scenario::{Act, Scenario};
use crate::vfd::{VfdFault, VfdKind};

/// Worlds that have a VFD: one in so many.
const HAS_VFD: u64 = 5;
const LONGEST_US: f64 = 2e6;
/// The longest time in which the spindle goes on, or not, before something else happens.
const GOES_ON_US: f64 = 3e6;
/// `$394` for a spindle that stops and turns the other way: so much longer than its ramps.
const BESIDE_RAMPS_S: f64 = 1.0;
/// The time to reach a speed with `$394=0`, s.
const REACHES_DEFAULT_S: f64 = 10.0;

/// The scenario of this seed, with a VFD if its world has one.
pub(super) fn with_vfd(seed: u64, mut scenario: Scenario) -> Scenario {
    let mut random = Random(Rand64::new(u128::from(seed) | 1 << 66));
    if !random.one_in(HAS_VFD) {
        return scenario;
    }
    let kind = random.of(&VfdKind::ALL);
    let config = &mut scenario.config;
    (config.vfd, config.vfd_ramp_hz_s) = (Some(kind), random.of(&[50.0, 200.0, 1_000.0]));
    random.turn_by_vfd(kind, config.vfd_ramp_hz_s, &mut config.settings);
    let max_rpm = f64::from(config.settings.spindle_max_rpm);
    for _ in 0..2 + random.below(6) {
        let at = random.below(scenario.acts.len() as u64 + 1) as usize;
        scenario.acts.splice(at..at, random.about_vfd(max_rpm));
    }
    scenario
}

impl Random {
    /// Settings of a machine whose spindle a VFD turns; in a few worlds it cannot be heard, or there is a laser beside it.
    fn turn_by_vfd(&mut self, kind: VfdKind, ramp_hz_s: f64, settings: &mut Settings) {
        settings.spindle_type = 1 + VfdKind::ALL.iter().position(|&other| other == kind).unwrap_or_default() as u16;
        settings.laser_mode = self.one_in(8);
        settings.spindle_max_rpm = self.of(&[1_000.0, 24_000.0, 24_000.0]);
        settings.spindle_min_rpm = self.of(&[0.0, 0.0, settings.spindle_max_rpm / 4.0]);
        if kind != VfdKind::Generic && settings.spindle_max_rpm < 24_000.0 {
            settings.vfd_rpm_per_hz = self.of(&[60, 30]);
        }
        settings.at_speed_percent = self.of(&[1.0, 5.0, 20.0]);
        settings.modbus_timeout_ms = self.of(&[30, 50, 50, 60]);
        settings.modbus_baud_index = if self.one_in(12) { 3 } else { 2 };
        // The highest override is 200 percent, but no S is above the highest.
        let hz = f64::from(settings.spindle_max_rpm) / f64::from(settings.vfd_rpm_per_hz);
        let reverses_s = 2.0 * hz / ramp_hz_s + BESIDE_RAMPS_S;
        let is_default_enough = reverses_s < REACHES_DEFAULT_S && self.one_in(2);
        settings.spin_up_s = if is_default_enough { 0.0 } else { reverses_s.ceil() as f32 };
    }

    /// A spindle that turns, mostly of a machine that is not locked; what happens to it, and the VFD that fails, one before the
    /// other; in some cases again once the machine is unlocked.
    fn about_vfd(&mut self, max_rpm: f64) -> Vec<Act> {
        let send = |line: &str| Act::Line(0, line.to_owned());
        let mut acts = Vec::new();
        if !self.one_in(4) {
            acts.extend([Act::Rest, send("$X")]);
        }
        for _ in 0..self.of(&[1, 1, 2]) {
            acts.push(Act::Line(0, self.turning(max_rpm)));
            acts.push(Act::Wait(self.between(1.0, GOES_ON_US) as u64));
            if self.one_in(2) {
                acts.push(send(self.of(&["G91 G1 X1 Y-1 F300", "G91 G1 X-1 Y1 F60", "G91 G0 X0.5", "G4 P0.3"])));
            }
            if self.one_in(2) {
                acts.push(Act::Wait(self.between(1.0, 300_000.0) as u64));
            }
            let (fails, changes) = (self.fails(), self.changes(max_rpm));
            let apart = Act::Wait(self.between(1.0, 500_000.0) as u64);
            match self.below(5) {
                0 => acts.push(fails),
                1 => acts.push(changes),
                2 => acts.extend([changes, apart, fails]),
                _ => acts.extend([fails, apart, changes]),
            }
            acts.push(Act::Wait(self.between(1.0, GOES_ON_US) as u64));
            if self.one_in(2) {
                acts.push(send("$X"));
            }
        }
        acts
    }

    /// A line that has the spindle turn, or turn otherwise.
    fn turning(&mut self, max_rpm: f64) -> String {
        let rpm = self.between(max_rpm / 20.0, max_rpm);
        let how = self.of(&["M3", "M3", "M3", "M4", ""]);
        format!("{how} S{rpm:.0}")
    }

    /// What changes how the spindle is to turn, or stops it.
    fn changes(&mut self, max_rpm: f64) -> Act {
        match self.below(8) {
            0 => Act::Line(0, self.turning(max_rpm)),
            1 => Act::Line(0, self.of(&["M5", "M5", "M30", "$SLP", "$VFD", "M0", "S0"]).to_owned()),
            2 => Act::Fault(crate::faults::Trouble::EmergencyStop, self.between(10.0, 500_000.0) as u64),
            3 => Act::Fault(crate::faults::Trouble::Hold, self.between(10.0, 500_000.0) as u64),
            4 => Act::Bytes(0, b"!\x9E".to_vec()),
            _ => Act::Bytes(0, vec![self.of(b"!~\x18\x84\x9E\x99\x9A\x9B")]),
        }
    }

    fn fails(&mut self) -> Act {
        Act::Vfd(self.of(&VfdFault::ALL), self.between(1.0, LONGEST_US) as u64)
    }
}
