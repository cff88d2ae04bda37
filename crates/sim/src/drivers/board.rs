//! The board's end of the wire.

use embassy_time::Timer;

use crate::time::Clock;
use crate::world::Shared;

/// A byte at 115,200 baud, us, rounded up.
const BYTE_US: u64 = 87;
/// A driver answers after 24 bit times, which are 209 us; the firmware waits a bit longer.
const MARGIN_US: u64 = 400;

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
        Timer::after_micros(heard.len() as u64 * BYTE_US + MARGIN_US).await;
        heard.iter_mut().zip(bytes).map(|(heard, byte)| *heard = byte).count()
    }
}
