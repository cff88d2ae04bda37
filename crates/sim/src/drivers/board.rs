//! The board's end of the wire.

use embassy_time::Timer;
use isostep_controller::exchange_time;

use crate::time::Clock;
use crate::world::Shared;

/// That of the firmware.
const BAUD: u32 = 115_200;

/// The board's end of the wire, with the times of the firmware.
pub(crate) struct DriverWire {
    world: Shared,
    clock: Clock,
}

impl DriverWire {
    pub(crate) fn new(world: &Shared, clock: &Clock) -> Self {
        Self { world: world.clone(), clock: clock.clone() }
    }

    pub(crate) fn clock(&self) -> &Clock {
        &self.clock
    }
}

impl isostep_controller::Wire for DriverWire {
    async fn exchange(&mut self, sent: &[u8], heard: &mut [u8]) -> usize {
        let bytes = self.world.borrow_mut().exchange_with_drivers(sent);
        Timer::after(exchange_time(heard.len(), BAUD)).await;
        heard.iter_mut().zip(bytes).map(|(heard, byte)| *heard = byte).count()
    }
}
