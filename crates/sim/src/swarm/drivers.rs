//! Worlds with drivers that talk: one in four has a board with them, on which they are set, asked and fail.
//!
//! They are drawn apart from all else, so that a seed's world is the same but for them.

use isostep_motion::{AXES, Motor};
use oorandom::Rand64;

use super::random::Random;
use super::scenario::{Act, Scenario};
use crate::config::{Board, Config};
use crate::drivers::DriverFault;
use crate::faults::Trouble;

/// How fast such worlds seek, full steps/s: fast enough for a stall to be told.
const SEEK_FULL_STEPS_S: f32 = 80.0;
/// `SG_RESULT` is 300 of a motor that turns freely, 80 less or more with noise of the load, and 10 at a stall.
const THRESHOLD: u16 = 60;
/// Worlds in which a machine's drivers talk: one in so many.
const TALKS: u64 = 4;
/// Of these, worlds whose axes home by stall, as far as they can: one in so many.
const STALLS: u64 = 2;
const LONGEST_US: f64 = 600_000.0;
/// What is said of drivers. All of them stay watched.
const LINES: [&str; 8] = ["M122", "$140=900", "$151=32", "$152=8", "$211=20", "$980=600", "$908=0", "$151=16"];

/// The scenario of this seed, with drivers that talk if its world has them.
pub(super) fn talk(seed: u64, mut scenario: Scenario) -> Scenario {
    let mut random = Random(Rand64::new(u128::from(seed) | 1 << 64));
    if !random.one_in(TALKS) {
        return scenario;
    }
    let board = Board::SkrPico;
    (scenario.config.board, scenario.config.driver) = (board, board.driver());
    for _ in 0..random.below(6) {
        let at = random.below(scenario.acts.len() as u64 + 1) as usize;
        let act = if random.one_in(2) { Act::Line(0, random.of(&LINES).to_owned()) } else { random.driver_fault() };
        scenario.acts.insert(at, act);
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
    settings.stealth_mm_min = [2.0 * slowest_mm_min; AXES];
    settings.stall_threshold = [THRESHOLD; AXES];
    config.diag = std::array::from_fn(|axis| mask & (1 << axis) != 0);
    config.load_noise = if random.one_in(2) { 0.2 } else { 0.0 };
}

impl Random {
    fn driver_fault(&mut self) -> Act {
        let motor = self.motor();
        let fault = self.of(&DriverFault::ALL);
        Act::Fault(Trouble::Driver(motor, fault), self.between(1.0, LONGEST_US) as u64)
    }
}

/// Whether the machine must have stopped for this fault, which lasts for `us` and began half a second ago.
pub(super) fn must_stop(trouble: Trouble, us: u64, has_motor: impl Fn(Motor) -> bool) -> bool {
    let Trouble::Driver(motor, fault) = trouble else { return false };
    let is_told = match fault {
        // Somebody must ask while it lasts, and ask again.
        DriverFault::Late => us > 400_000,
        DriverFault::Off | DriverFault::Overheated | DriverFault::Shorted => true,
        DriverFault::Garbled | DriverFault::Hot | DriverFault::OpenCoil => false,
    };
    is_told && has_motor(motor)
}
