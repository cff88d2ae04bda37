//! UART drivers, and what their motors do.

use isostep_motion::AXES;
use oorandom::Rand32;

use crate::config::Config;
use crate::drivers::{DriverFault, Wire};

/// A motor that has made no step for so long stands, ns.
const STANDS_NS: u64 = 20_000_000;
/// The load of a motor that turns, of what would stall it. (The torque of the plant's load is not computed.)
const TURNING: f64 = 0.25;

/// The drivers, in the order of the motors.
pub(super) struct UartDrivers {
    wire: Wire,
    paces: [Pace; 4],
    /// The axes whose limit input is wired to DIAG.
    diag: [bool; AXES],
    load_noise: f64,
    random: Rand32,
}

/// The last steps of a motor.
#[derive(Clone, Copy, Default)]
struct Pace {
    last_ns: u64,
    between_ns: u64,
    load: f64,
}

impl UartDrivers {
    /// The drivers of a board on which they have a UART.
    pub(super) fn new(config: &Config) -> Option<Self> {
        let mut addresses = config.board.uart_drivers()?.addresses;
        // The last driver is that of the second motor, however many axes there are.
        let last = addresses.len() - 1;
        addresses.swap(AXES.min(last), last);
        let wire = Wire::new(addresses);
        let (diag, load_noise, random) = (config.diag, config.load_noise, Rand32::new(config.seed));
        Some(Self { wire, paces: [Pace::default(); 4], diag, load_noise, random })
    }

    pub(super) fn wire(&self) -> &Wire {
        &self.wire
    }

    pub(super) fn set(&mut self, motor: usize, fault: Option<DriverFault>) {
        match fault {
            Some(fault) => self.wire.fault(motor, fault),
            None => self.wire.mend(motor),
        }
    }

    /// Whether the driver makes no step of its motor.
    pub(super) fn is_off(&self, motor: usize) -> bool {
        self.wire.is_off(motor)
    }

    /// Microsteps of a full step.
    pub(super) fn microsteps(&self, motor: usize) -> i32 {
        self.wire.microsteps(motor).into()
    }

    /// Whether a driver's DIAG is high, if a limit input is wired to it.
    pub(super) fn diag(&self, motor: usize) -> Option<bool> {
        let is_wired = self.diag.get(motor) == Some(&true);
        is_wired.then(|| self.wire.diag(motor))
    }

    /// When a driver's DIAG falls that tells of a stall at a limit input, if no step is made until then.
    pub(super) fn stall_ends_ns(&self, motor: usize) -> Option<u64> {
        self.diag(motor)?;
        let after_ns = self.wire.stall_ends_after_ns(motor)?;
        Some(self.paces[motor].last_ns + after_ns.min(STANDS_NS))
    }

    /// Makes a step at a driver's pin STEP. Something blocks the motor by so many full steps: one is a stall.
    pub(super) fn step(&mut self, t_ns: u64, motor: usize, direction: i32, blocked_full: f64) {
        let load = self.load(blocked_full);
        let pace = &mut self.paces[motor];
        *pace = Pace { last_ns: t_ns, between_ns: t_ns - pace.last_ns, load };
        self.wire.set_load(motor, pace.speed_steps_s(t_ns), load);
        self.wire.step(motor, direction);
    }

    /// The load of a motor that turns, or as the field winds up that of one that does not.
    fn load(&mut self, blocked_full: f64) -> f64 {
        let turning = TURNING + self.load_noise * f64::from(2.0 * self.random.rand_float() - 1.0);
        turning + (1.0 - turning) * blocked_full.min(1.0)
    }

    /// Makes the drivers follow time, in which motors come to rest.
    pub(super) fn follow(&mut self, now_ns: u64) {
        for (motor, pace) in self.paces.into_iter().enumerate() {
            self.wire.set_load(motor, pace.speed_steps_s(now_ns), pace.load);
        }
    }

    /// What the board hears when it sends this.
    pub(super) fn exchange(&mut self, now_ns: u64, sent: &[u8]) -> Vec<u8> {
        self.follow(now_ns);
        self.wire.exchange(sent)
    }
}

impl Pace {
    /// By the last interval, or by the present one if that is longer already. A task that delays is ahead of the others, so its
    /// last step may be later than now.
    fn speed_steps_s(self, now_ns: u64) -> f64 {
        let since_ns = now_ns.saturating_sub(self.last_ns);
        let turns = self.between_ns > 0 && since_ns < STANDS_NS;
        if turns { 1e9 / self.between_ns.max(since_ns) as f64 } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Board;

    /// The task of a timer port delays after an edge, and is ahead of the task that asks the drivers then.
    #[test]
    fn a_driver_may_be_asked_before_its_last_step() {
        let mut uart_drivers = UartDrivers::new(&Config { board: Board::SkrPico, ..Config::default() }).unwrap();
        uart_drivers.step(1_000_000, 0, 1, 0.0);
        uart_drivers.step(2_000_000, 0, 1, 0.0);
        uart_drivers.follow(1_999_000);
        assert_eq!(uart_drivers.paces[0].speed_steps_s(1_999_000), 1_000.0);
        uart_drivers.follow(2_000_000 + STANDS_NS);
        assert_eq!(uart_drivers.paces[0].speed_steps_s(2_000_000 + STANDS_NS), 0.0);
    }
}
