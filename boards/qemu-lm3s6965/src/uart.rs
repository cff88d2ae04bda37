//! The console's link: UART0, which QEMU connects to its standard input and output.

use core::convert::Infallible;

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embedded_io_async::{ErrorType, Read, Write};

use crate::chip::{Irq, Register};

const UART0: u32 = 0x4000_C000;
const DATA: Register = Register::at(UART0, 0x00);
const FLAGS: Register = Register::at(UART0, 0x18);
const LINE_CONTROL: Register = Register::at(UART0, 0x2C);
const CONTROL: Register = Register::at(UART0, 0x30);
const INTERRUPT_MASK: Register = Register::at(UART0, 0x38);
const RX_EMPTY: u32 = 1 << 4;
const TX_FULL: u32 = 1 << 5;
const RECEIVED: u32 = 1 << 4;

/// Bytes have come. While nobody has read them the interrupt is masked, and the FIFO keeps them.
static HAS_BYTES: Signal<CriticalSectionRawMutex, ()> = Signal::new();

/// Opens both directions.
pub fn open() -> (Rx, Tx) {
    CONTROL.write(0);
    // Eight bits, with FIFOs.
    LINE_CONTROL.write(0b111 << 4);
    CONTROL.write(1 | 0b11 << 8);
    Irq::Uart0.enable(4);
    (Rx, Tx)
}

pub extern "C" fn on_interrupt() {
    INTERRUPT_MASK.write(0);
    HAS_BYTES.signal(());
}

/// Receives bytes.
pub struct Rx;

impl ErrorType for Rx {
    type Error = Infallible;
}

impl Read for Rx {
    /// # Cancellation
    /// Safe: no byte is lost.
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        loop {
            let mut count = 0;
            while count < buffer.len() && FLAGS.read() & RX_EMPTY == 0 {
                buffer[count] = DATA.read() as u8;
                count += 1;
            }
            if count > 0 || buffer.is_empty() {
                return Ok(count);
            }
            INTERRUPT_MASK.write(RECEIVED);
            HAS_BYTES.wait().await;
        }
    }
}

/// Sends bytes, which QEMU takes at once.
pub struct Tx;

impl ErrorType for Tx {
    type Error = Infallible;
}

impl Write for Tx {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        for &byte in bytes {
            while FLAGS.read() & TX_FULL != 0 {}
            DATA.write(byte.into());
        }
        Ok(bytes.len())
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// Says a few words without an executor.
pub fn say(words: &str) {
    words.bytes().for_each(|byte| DATA.write(byte.into()));
}
