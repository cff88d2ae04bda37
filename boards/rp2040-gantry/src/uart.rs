//! The console on UART0: GP0 TX, GP1 RX, 115200 8N1.

use embassy_rp::peripherals::UART0;
use embassy_rp::uart::{self, BufferedInterruptHandler, BufferedUart, BufferedUartRx, BufferedUartTx};
use embassy_rp::{bind_interrupts, pac};
use embedded_io_async::{ErrorType, Read};
use static_cell::StaticCell;

use crate::pins::UartPins;

bind_interrupts!(struct Irqs {
    UART0_IRQ => BufferedInterruptHandler<UART0>;
});

/// A sender that counts characters keeps at most 128 unanswered, so there is ample room for one that sends more.
const RX_BYTES: usize = 1024;
/// Room for some five status reports; what is longer waits for the line.
const TX_BYTES: usize = 512;

/// Receives bytes.
pub struct Rx(BufferedUartRx);

/// Opens both directions of the port.
pub fn open(pins: UartPins) -> (Rx, BufferedUartTx) {
    static RX: StaticCell<[u8; RX_BYTES]> = StaticCell::new();
    static TX: StaticCell<[u8; TX_BYTES]> = StaticCell::new();
    let (tx_buffer, rx_buffer) = (TX.init([0; TX_BYTES]), RX.init([0; RX_BYTES]));
    // 115200 8N1 is the driver's default.
    let (tx, rx) =
        BufferedUart::new(pins.uart, pins.tx, pins.rx, Irqs, tx_buffer, rx_buffer, uart::Config::default()).split();
    // An idle line is high. With nothing connected, noise would be read as commands.
    pac::PADS_BANK0.gpio(1).modify(|pad| pad.set_pue(true));
    (Rx(rx), tx)
}

impl ErrorType for Rx {
    type Error = uart::Error;
}

impl Read for Rx {
    /// A byte with an error is logged and dropped: the line it belongs to will be refused.
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, uart::Error> {
        loop {
            match self.0.read(buffer).await {
                Err(error) => defmt::warn!("UART0: {}", error),
                received => return received,
            }
        }
    }
}
