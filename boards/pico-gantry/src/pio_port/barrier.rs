//! The start barrier and the inhibit of the step program, which are flags of PIO0.

use core::cell::Cell;

use embassy_rp::pac::PIO0;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_time::Instant;

use crate::pio_port::program::{BARRIER, INHIBIT};

/// Closes the start barrier: every state machine that is started from now on waits before its first word.
pub fn close_barrier() {
    PIO0.irq_force().write(|flags| flags.set_irq_force(BARRIER));
}

/// Opens the start barrier, so that all state machines start on the same cycle. Returns when it was opened, which may have been
/// earlier.
pub fn open_barrier() -> Instant {
    static OPENED: Mutex<CriticalSectionRawMutex, Cell<Instant>> = Mutex::new(Cell::new(Instant::MIN));

    OPENED.lock(|opened| {
        if PIO0.irq().read().irq() & BARRIER != 0 {
            PIO0.irq().write(|flags| flags.set_irq(BARRIER));
            opened.set(Instant::now());
        }
        opened.get()
    })
}

/// Engages the inhibit, which is that of all axes.
#[inline(always)]
pub fn inhibit_all() {
    inhibit(true);
}

/// Engages or releases the inhibit. No edge rises while it is engaged.
pub fn inhibit(engaged: bool) {
    if engaged {
        PIO0.irq_force().write(|flags| flags.set_irq_force(INHIBIT));
    } else {
        PIO0.irq().write(|flags| flags.set_irq(INHIBIT));
    }
}
