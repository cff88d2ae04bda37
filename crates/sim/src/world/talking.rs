//! Drivers that talk, and what their motors do.

use isostep_controller::DriverHardware;

use crate::drivers::{DriverFault, Wire};

/// A motor that has made no step for so long stands, ns.
const STANDS_NS: u64 = 20_000_000;
/// The load of a motor that turns, of what would stall it. (The torque of the plant's load is not computed.)
const TURNING: f64 = 0.25;

/// The drivers, in the order of the sides.
pub(super) struct Talking {
    wire: Wire,
    paces: [Pace; 4],
}

/// The last steps of a motor.
#[derive(Clone, Copy, Default)]
struct Pace {
    last_ns: u64,
    between_ns: u64,
}

impl Talking {
    pub(super) fn new(hardware: DriverHardware) -> Self {
        Self { wire: Wire::new(hardware.addresses), paces: [Pace::default(); 4] }
    }

    pub(super) fn wire(&self) -> &Wire {
        &self.wire
    }

    pub(super) fn set(&mut self, side: usize, fault: Option<DriverFault>) {
        match fault {
            Some(fault) => self.wire.fault(side, fault),
            None => self.wire.mend(side),
        }
    }

    /// Whether the driver makes no step of its motor.
    pub(super) fn is_off(&self, side: usize) -> bool {
        self.wire.is_off(side)
    }

    pub(super) fn step(&mut self, t_ns: u64, side: usize, direction: i32) {
        let pace = &mut self.paces[side];
        *pace = Pace { last_ns: t_ns, between_ns: t_ns - pace.last_ns };
        self.wire.step(side, direction);
    }

    /// What the board hears when it sends this.
    pub(super) fn exchange(&mut self, now_ns: u64, sent: &[u8]) -> Vec<u8> {
        for (side, pace) in self.paces.into_iter().enumerate() {
            let turns = pace.between_ns > 0 && now_ns - pace.last_ns < STANDS_NS;
            let (speed_steps_s, load) = if turns { (1e9 / pace.between_ns as f64, TURNING) } else { (0.0, 0.0) };
            self.wire.set_load(side, speed_steps_s, load);
        }
        self.wire.exchange(sent)
    }
}
