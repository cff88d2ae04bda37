//! The console on UART0: GP0 TX, GP1 RX, 115200 8N1.

use core::future::poll_fn;
use core::pin::{Pin, pin};
use core::task::{Context, Poll};

use embassy_rp::peripherals::UART0;
use embassy_rp::uart::{self, BufferedInterruptHandler, BufferedUart, BufferedUartRx, BufferedUartTx};
use embassy_rp::{bind_interrupts, pac};
use embedded_io_async::{ErrorType, Read};
use static_cell::StaticCell;

use crate::pins::UartPins;

bind_interrupts!(struct Irqs {
    UART0_IRQ => BufferedInterruptHandler<UART0>;
});

/// A sender that counts characters keeps at most 128 unanswered. Beside them there is room for what comes in 33 ms. The
/// console's task is never away for longer: the most that the coordinator compiles without yielding are 96 segments (the
/// beginning of an axis's run, by a curved speed profile), which take up to 25 ms.
const RX_BYTES: usize = 512;
/// Room for some two status reports; what is longer waits in the console's output.
const TX_BYTES: usize = 256;

/// Receives bytes.
pub struct UartRx(BufferedUartRx);

/// Opens both directions of the port.
pub fn open(pins: UartPins) -> (UartRx, BufferedUartTx) {
    static RX: StaticCell<[u8; RX_BYTES]> = StaticCell::new();
    static TX: StaticCell<[u8; TX_BYTES]> = StaticCell::new();
    let (tx_buffer, rx_buffer) = (TX.init([0; TX_BYTES]), RX.init([0; RX_BYTES]));
    // 115200 8N1 is the driver's default.
    let (tx, rx) =
        BufferedUart::new(pins.uart, pins.tx, pins.rx, Irqs, tx_buffer, rx_buffer, uart::Config::default()).split();
    // An idle line is high. With nothing connected, noise would be read as commands.
    pac::PADS_BANK0.gpio(1).modify(|pad| pad.set_pue(true));
    (UartRx(rx), tx)
}

impl ErrorType for UartRx {
    type Error = uart::Error;
}

impl Read for UartRx {
    /// A byte with an error is logged and dropped: the line it belongs to will be refused.
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, uart::Error> {
        loop {
            let mut reading = pin!(self.0.read(buffer));
            match poll_fn(|context| poll_read(reading.as_mut(), context)).await {
                Err(error) => defmt::warn!("UART0: {}", error),
                received => return received,
            }
        }
    }
}

/// Not inlined: the console is in flash, and the driver's critical sections must not be.
#[inline(never)]
fn poll_read<F: Future>(reading: Pin<&mut F>, context: &mut Context<'_>) -> Poll<F::Output> {
    reading.poll(context)
}
