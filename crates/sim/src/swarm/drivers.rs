//! Worlds with UART drivers: one in four has a board with them, on which they are set, asked and fail: one or several at once,
//! for an instant or longer, again and again, while they are set anew, and as soon as the machine is unlocked.
//!
//! They are drawn apart from all else, so that a seed's world is the same but for them.

use std::fmt;

use isostep_motion::{AXES, Motor};
use oorandom::Rand64;

use super::Random;
use super::scenario::{Act, Scenario};
use crate::config::{Board, Config};
use crate::drivers::DriverFault;
use crate::faults::Trouble;

/// The speed at which such worlds seek, full steps/s: fast enough for a stall to be detected.
const SEEK_FULL_STEPS_S: f32 = 80.0;
/// `SG_RESULT` is 300 of a motor that turns freely, 80 less or more with noise of the load, and 10 at a stall.
const THRESHOLD: u16 = 60;
/// Worlds in which a machine has UART drivers: one in so many.
const HAS_UART_DRIVERS: u64 = 4;
/// Of these, worlds whose axes home by stall, as far as they can: one in so many.
const STALLS: u64 = 2;
const LONGEST_US: f64 = 600_000.0;
/// The longest time from a fault that is over to the next one of the same driver.
const APART_US: f64 = 300_000.0;
/// As long as it takes to set one of the drivers anew, and longer than two rounds in which they are asked.
const SETTING_US: u64 = 40_000;
const ROUNDS_US: u64 = 250_000;

/// A driver that fails for a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failing {
    /// The motor of the driver.
    pub motor: Motor,
    /// Its fault.
    pub fault: DriverFault,
    /// When that begins, us from the beginning of the act.
    pub after_us: u64,
    /// Its duration, us.
    pub us: u64,
}

impl Failing {
    /// The fault in words of [`Fault`](crate::faults::Fault).
    pub(super) fn trouble(&self) -> Trouble {
        Trouble::Driver(self.motor, self.fault)
    }

    /// True if the machine must have stopped for this fault half a second after it began.
    pub(super) fn must_stop(&self, has_motor: impl Fn(Motor) -> bool) -> bool {
        let is_reported = match self.fault {
            // Somebody must ask while it lasts, and ask again.
            DriverFault::Late => self.us > 400_000,
            DriverFault::Off | DriverFault::Overheated | DriverFault::Shorted => true,
            DriverFault::Garbled | DriverFault::Hot | DriverFault::OpenCoil => false,
        };
        is_reported && has_motor(self.motor)
    }
}

impl fmt::Display for Failing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} after {} us for {} us", self.trouble(), self.after_us, self.us)
    }
}

/// The scenario of this seed, with UART drivers if its world has them.
pub(super) fn with_uart_drivers(seed: u64, mut scenario: Scenario) -> Scenario {
    let mut random = Random(Rand64::new(u128::from(seed) | 1 << 64));
    if !random.one_in(HAS_UART_DRIVERS) {
        return scenario;
    }
    let board = Board::SkrPico;
    (scenario.config.board, scenario.config.driver) = (board, board.driver());
    for _ in 0..random.below(6) {
        let at = random.below(scenario.acts.len() as u64 + 1) as usize;
        scenario.acts.splice(at..at, random.about_drivers());
    }
    if random.one_in(STALLS) {
        home_by_stall(&mut scenario.config, &mut random);
    }
    scenario
}

/// Wires the first drivers' DIAG to the limit inputs, and has their axes home by stall. Where a seek is too fast for an axis, or
/// its run-up too long, homing is refused.
fn home_by_stall(config: &mut Config, random: &mut Random) {
    let settings = &mut config.settings;
    let axes = (0..Board::JUMPERS).filter(|&axis| settings.second_motor() != Some(axis));
    let mask = axes.clone().fold(0, |mask, axis| mask | 1 << axis);
    let full_steps_mm = |axis: usize| settings.steps_per_mm[axis] / f32::from(settings.microsteps[axis]);
    let slowest_mm_min = axes.map(|axis| SEEK_FULL_STEPS_S * 60.0 / full_steps_mm(axis)).fold(0.0, f32::max);
    settings.stall_homing_mask = mask;
    settings.homing_seek_mm_min = slowest_mm_min;
    // Two full steps at least.
    settings.homing_pull_off_mm = settings.homing_pull_off_mm.max(1.0);
    settings.stealth_mm_min = [2.0 * slowest_mm_min; AXES];
    settings.stall_threshold = [THRESHOLD; AXES];
    config.diag = std::array::from_fn(|axis| mask & (1 << axis) != 0);
    config.load_noise = if random.one_in(2) { 0.2 } else { 0.0 };
}

impl Random {
    /// A line about drivers, or drivers that fail: in most cases of a machine at rest that is not locked, in some while they are set
    /// anew, and in some again as soon as the machine is unlocked.
    fn about_drivers(&mut self) -> Vec<Act> {
        let send = |line: String| Act::Line(0, line);
        let motor = self.motor();
        if self.one_in(4) {
            return vec![send(self.driver_line(motor))];
        }
        let mut acts = Vec::new();
        if !self.one_in(3) {
            acts.extend([Act::Rest, send("$X".to_owned())]);
        }
        if !self.one_in(3) {
            acts.extend([send(self.driver_line(motor)), Act::Wait(self.below(SETTING_US))]);
        }
        acts.push(self.failings(motor));
        if self.one_in(2) {
            let unlock = self.of(&["$X", "$X", "$H"]).to_owned();
            acts.extend([send(unlock), Act::Wait(self.below(ROUNDS_US)), self.failings(motor)]);
        }
        acts
    }

    /// The message about a motor's driver. All of them stay watched.
    fn driver_line(&mut self, motor: Motor) -> String {
        let axis = motor.axis as usize;
        match self.below(8) {
            0 => "M122".to_owned(),
            1 => format!("$15{axis}={}", self.of(&[8, 16, 32])),
            2 => format!("$98{axis}={}", self.of(&[0, 600, 1200])),
            3 => format!("$21{axis}={}", 10 + self.below(90)),
            _ => format!("$14{axis}={}", 500 + self.below(700)),
        }
    }

    /// A motor's driver that fails again and again, or several that fail at once or soon after each other.
    fn failings(&mut self, mut motor: Motor) -> Act {
        let (count, comes_back) = (self.of(&[1, 1, 2, 3, 4]), self.one_in(2));
        let (mut failings, mut after_us) = (Vec::<Failing>::new(), 0);
        for _ in 0..count {
            let fault = self.of(&DriverFault::ALL);
            let failing = Failing { motor, fault, after_us, us: self.between(1.0, LONGEST_US) as u64 };
            let apart_us = self.between(1.0, APART_US) as u64;
            if comes_back {
                after_us += failing.us + apart_us;
            } else {
                motor = self.motor();
                after_us += if self.one_in(2) { 0 } else { apart_us };
            }
            // A driver has one fault at a time.
            if comes_back || failings.iter().all(|other| other.motor != failing.motor) {
                failings.push(failing);
            }
        }
        Act::Drivers(failings)
    }
}
