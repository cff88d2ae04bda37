//! The wire to a VFD: UART0, which is the console otherwise, and a module for RS-485.
//!
//! A whole exchange has room in the FIFOs of the UART, so it needs neither an interrupt nor DMA, and it does not matter when a reply
//! is read. What has a deadline is the direction of the wire (`rs485`).

use core::mem;

use embassy_rp::pac;
use embassy_rp::uart::{Blocking, Config, Uart};
use embassy_time::{Duration, Instant, Timer};
use isostep_controller::{LineFormat, Parity};

use crate::pins::UartPins;
use crate::rs485;

/// What may be heard as the wire changes hands, before a reply: no address is so.
const NOISE: [u8; 2] = [0x00, 0xFF];
/// How often it is looked whether a reply is complete, once it may be.
const LOOK_MS: u64 = 2;

pub struct Rs485 {
    uart: Uart<'static, Blocking>,
    line: Option<LineFormat>,
}

/// Opens the wire, which is not driven.
pub fn open(pins: UartPins) -> Rs485 {
    // The pin stays an output for ever.
    mem::forget(pins.vfd_sends);
    let uart = Uart::new_blocking(pins.uart, pins.tx, pins.rx, Config::default());
    // Nobody may drive the receiver's output while the board sends.
    pac::PADS_BANK0.gpio(1).modify(|pad| pad.set_pue(true));
    Rs485 { uart, line: None }
}

impl Rs485 {
    fn set(&mut self, line: LineFormat) {
        if self.line.replace(line) != Some(line) {
            pac::UART0.uartlcr_h().modify(|control| {
                control.set_pen(line.parity != Parity::None);
                control.set_eps(line.parity == Parity::Even);
            });
            self.uart.set_baudrate(line.baud);
        }
    }
}

impl isostep_controller::VfdWire for Rs485 {
    async fn exchange(&mut self, line: LineFormat, sent: &[u8], heard: &mut [u8], limit: Duration) -> usize {
        self.set(line);
        rs485::drive();
        // It has room in the FIFO, so this does not wait.
        let _ = self.uart.blocking_write(sent);
        let sent_at = Instant::now() + line.time(sent.len());
        rs485::release_at(sent_at);
        Timer::at(sent_at + line.time(heard.len())).await;
        let mut count = 0;
        loop {
            while count < heard.len()
                && let Some(byte) = received()
            {
                if count > 0 || !NOISE.contains(&byte) {
                    heard[count] = byte;
                    count += 1;
                }
            }
            if count == heard.len() || Instant::now() >= sent_at + limit {
                return count;
            }
            Timer::after_millis(LOOK_MS).await;
        }
    }
}

/// The next byte in the FIFO. One that was disturbed is like any other: a frame has a checksum.
fn received() -> Option<u8> {
    (!pac::UART0.uartfr().read().rxfe()).then(|| pac::UART0.uartdr().read().data())
}
