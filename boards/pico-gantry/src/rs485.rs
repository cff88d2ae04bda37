//! The direction of RS-485: the board drives the wire while it sends, and no longer.
//!
//! A VFD answers 3.5 characters after the last one at the soonest: 3.6 ms at 9,600 baud, 0.3 ms at 115,200. By then the wire has to be
//! released. Thread mode may be away for 25 ms, so a task of the switches' executor does it. What was heard until then is dropped: it
//! is the board itself.

use embassy_rp::pac;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Instant, Timer};

use crate::pins;

/// The time between two looks whether all has left.
const LOOK: Duration = Duration::from_micros(20);

/// When the last character will have been sent.
static SENT: Signal<CriticalSectionRawMutex, Instant> = Signal::new();

/// Drives the wire.
pub fn drive() {
    pac::SIO.gpio_out(0).value_set().write_value(pins::VFD_SENDS_MASK);
}

/// Has the wire released when all that was written into the FIFO has left, which is at this instant.
#[inline(never)]
pub fn release_at(end: Instant) {
    SENT.signal(end);
}

/// Releases the wire each time.
#[embassy_executor::task]
pub async fn release() -> ! {
    loop {
        let mut at = SENT.wait().await;
        loop {
            Timer::at(at).await;
            // The clock of the UART is rounded, and writing may have been interrupted.
            if !pac::UART0.uartfr().read().busy() {
                break;
            }
            at += LOOK;
        }
        pac::SIO.gpio_out(0).value_clr().write_value(pins::VFD_SENDS_MASK);
        while !pac::UART0.uartfr().read().rxfe() {
            pac::UART0.uartdr().read();
        }
    }
}
