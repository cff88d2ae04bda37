//! The gate and the brake of the step program, by the flags of PIO0.

use embassy_rp::pac::PIO0;

use crate::pio_port::program::{BRAKE, GATE};

/// Keeps every state machine that is started from now on from its first word.
pub fn close_gate() {
    PIO0.irq_force().write(|flags| flags.set_irq_force(GATE));
}

/// Lets them all go, on one cycle.
pub fn open_gate() {
    PIO0.irq().write(|flags| flags.set_irq(GATE));
}

/// No edge rises while it is engaged.
pub fn brake(engaged: bool) {
    if engaged {
        PIO0.irq_force().write(|flags| flags.set_irq_force(BRAKE));
    } else {
        PIO0.irq().write(|flags| flags.set_irq(BRAKE));
    }
}
