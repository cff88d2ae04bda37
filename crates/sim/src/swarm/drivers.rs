//! Worlds with drivers that talk: one in four has a board with them, on which they are set, asked and fail.
//!
//! They are drawn apart from all else, so that a seed's world is the same but for them.

use isostep_motion::Motor;
use oorandom::Rand64;

use super::random::Random;
use super::scenario::{Act, Scenario};
use crate::config::Board;
use crate::drivers::DriverFault;
use crate::faults::Trouble;

/// Worlds in which a machine's drivers talk: one in so many.
const TALKS: u64 = 4;
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
    scenario
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
