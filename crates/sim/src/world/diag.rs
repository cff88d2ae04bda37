//! What UART drivers make of the steps of their motors, and show by DIAG.

use std::task::Waker;

use super::World;
use crate::record::LossCause;

impl World {
    /// Tells its driver of a step of a motor, and of what kept the motor from it.
    pub(super) fn drivers_step(&mut self, t_ns: u64, index: usize, direction: i32, hindrance: Option<LossCause>) {
        let Some(uart_drivers) = &mut self.uart_drivers else { return };
        let ahead_full =
            f64::from(self.motors[index].carriage.ahead_steps()) / f64::from(uart_drivers.microsteps(index));
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
