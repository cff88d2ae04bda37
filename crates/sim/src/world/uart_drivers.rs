//! UART drivers: what they make of the steps of their motors, and show by DIAG.

use std::task::Waker;

use isostep_motion::AXES;
use oorandom::Rand32;

use super::World;
use crate::config::Config;
use crate::drivers::Wire;
use crate::record::LossCause;

/// A motor that has made no step for so long stands, ns.
const STANDS_NS: u64 = 20_000_000;
/// The load of a motor that turns, of what would stall it. (The torque of the plant's load is not computed.)
const TURNING: f64 = 0.25;

/// The drivers, in the order of the motors.
pub(super) struct UartDrivers {
    pub(super) wire: Wire,
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

    /// True if a driver's DIAG is high, if a limit input is wired to it.
    pub(super) fn diag(&self, motor: usize) -> Option<bool> {
        let is_wired = self.diag.get(motor) == Some(&true);
        is_wired.then(|| self.wire[motor].diag())
    }

    /// When a driver's DIAG falls that tells of a stall at a limit input, if no step is made until then.
    pub(super) fn stall_ends_ns(&self, motor: usize) -> Option<u64> {
        self.diag(motor)?;
        let after_ns = self.wire[motor].stall_ends_after_ns()?;
        Some(self.paces[motor].last_ns + after_ns.min(STANDS_NS))
    }

    /// Makes a step at a driver's pin STEP. Something blocks the motor by so many full steps: one is a stall.
    pub(super) fn step(&mut self, t_ns: u64, motor: usize, direction: i32, blocked_full: f64) {
        let load = self.load(blocked_full);
        let pace = &mut self.paces[motor];
        *pace = Pace { last_ns: t_ns, between_ns: t_ns - pace.last_ns, load };
        self.wire[motor].set_load(pace.speed_steps_s(t_ns), load);
        self.wire[motor].step(direction);
    }

    /// The load of a motor that turns, or as the field winds up that of one that does not.
    fn load(&mut self, blocked_full: f64) -> f64 {
        let turning = TURNING + self.load_noise * f64::from(2.0 * self.random.rand_float() - 1.0);
        turning + (1.0 - turning) * blocked_full.min(1.0)
    }

    /// Makes the drivers follow time, in which motors come to rest.
    pub(super) fn follow(&mut self, now_ns: u64) {
        for (motor, pace) in self.paces.into_iter().enumerate() {
            self.wire[motor].set_load(pace.speed_steps_s(now_ns), pace.load);
        }
    }

    /// The bytes that the board hears when it sends this.
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

impl World {
    /// Tells its driver of a step of a motor, and of what kept the motor from it.
    pub(super) fn drivers_step(&mut self, t_ns: u64, index: usize, direction: i32, hindrance: Option<LossCause>) {
        let Some(uart_drivers) = &mut self.uart_drivers else { return };
        let ahead_full =
            f64::from(self.motors[index].carriage.ahead_steps()) / f64::from(uart_drivers.wire[index].microsteps());
        let is_held = matches!(hindrance, Some(LossCause::Stalled | LossCause::Bound));
        let blocked_full = if is_held { 1.0 } else { ahead_full.abs() };
        uart_drivers.step(t_ns, index, direction, blocked_full);
        self.refresh_diags();
    }

    /// Shows at the limit inputs what the drivers show that are wired to them.
    pub(super) fn refresh_diags(&mut self) {
        for index in 0..self.motors.len() {
            if self.uart_drivers.as_ref().is_some_and(|uart_drivers| uart_drivers.diag(index).is_some()) {
                self.refresh_limit(index);
            }
        }
        if self.next_stall_end_ns().is_some() {
            self.bouncer.take().into_iter().for_each(Waker::wake);
        }
    }

    /// When the first DIAG falls that tells of a stall at a limit input, if no step is made until then.
    pub(super) fn next_stall_end_ns(&self) -> Option<u64> {
        let motors = 0..self.motors.len();
        self.uart_drivers
            .as_ref()
            .and_then(|uart_drivers| motors.filter_map(|motor| uart_drivers.stall_ends_ns(motor)).min())
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
