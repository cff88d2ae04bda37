//! The wire to the drivers of an SKR Pico: UART1, whose TX leads through a resistor to the wire that RX hears, so that the
//! board hears itself.
//!
//! A whole exchange has room in the FIFOs of the UART, so it needs neither an interrupt nor DMA: what has a deadline does not
//! notice it.

use core::pin::pin;

use embassy_rp::pac;
use embassy_rp::uart::{Blocking, Config, Uart};
use embassy_time::Timer;
use isostep_controller::{Controller, Wire, exchange_time};
use isostep_motion::cold_path;

use crate::flash::Flash;
use crate::pins::DriverWirePins;

const BAUD: u32 = 115_200;

pub struct DriverWire(Uart<'static, Blocking>);

/// Opens the wire, and sets the drivers.
pub async fn open(controller: &Controller<'static, Flash>, pins: DriverWirePins) -> DriverWire {
    let mut config = Config::default();
    config.baudrate = BAUD;
    let mut wire = DriverWire(Uart::new_blocking(pins.uart, pins.tx, pins.rx, config));
    controller.set_drivers(&mut wire).await;
    wire
}

/// Watches the drivers.
#[embassy_executor::task]
pub async fn watch(controller: &'static Controller<'static, Flash>, wire: DriverWire) -> ! {
    match cold_path(pin!(controller.watch_drivers(wire))).await {}
}

impl Wire for DriverWire {
    async fn exchange(&mut self, sent: &[u8], heard: &mut [u8]) -> usize {
        while received().is_some() {}
        // It has room in the FIFO, so this does not wait.
        let _ = self.0.blocking_write(sent);
        Timer::after(exchange_time(heard.len(), BAUD)).await;
        let bytes = heard.iter_mut().zip(core::iter::from_fn(received));
        bytes.map(|(heard, byte)| *heard = byte).count()
    }
}

/// The next byte in the FIFO. One that was disturbed is like any other: a datagram has a checksum.
fn received() -> Option<u8> {
    (!pac::UART1.uartfr().read().rxfe()).then(|| pac::UART1.uartdr().read().data())
}
