//! The interrupts that wake an axis task: a block has been sent, or a state machine has halted.
//!
//! The handlers have the priority of the axis tasks, so neither interrupts the other. What both change (which
//! interrupts are enabled) therefore needs no lock.

use embassy_rp::interrupt;
use embassy_rp::pac::{DMA, PIO0};
use embassy_rp::peripherals;
use embassy_rp::{bind_interrupts, pio};
use embassy_sync::waitqueue::AtomicWaker;
use isostep_motion::AXES;

bind_interrupts!(pub struct Irqs {
    PIO0_IRQ_0 => pio::InterruptHandler<peripherals::PIO0>;
});

/// Wakers of the axis tasks.
pub static WAKERS: [AtomicWaker; AXES] = [const { AtomicWaker::new() }; AXES];

/// Enables one interrupt for the halt of the axis's state machine, which wakes the axis.
pub fn expect_halt(axis: usize) {
    PIO0.irqs(1).inte().modify(|enabled| enabled.0 |= halt_bit(axis));
}

fn halt_bit(axis: usize) -> u32 {
    // In this register the flags of the state machines come after the eight levels of the FIFOs.
    1 << (8 + axis)
}

/// Blocks have been sent. Each raises the interrupt once; arming the block enables it again.
#[interrupt]
fn DMA_IRQ_1() {
    let sent = DMA.ints(1).read();
    DMA.inte(1).modify(|enabled| *enabled &= !sent);
    for (axis, waker) in WAKERS.iter().enumerate() {
        if sent & 0b11 << (2 * axis) != 0 {
            waker.wake();
        }
    }
}

/// State machines have halted.
#[interrupt]
fn PIO0_IRQ_1() {
    let halted = PIO0.irqs(1).ints().read().0;
    PIO0.irqs(1).inte().modify(|enabled| enabled.0 &= !halted);
    for (axis, waker) in WAKERS.iter().enumerate() {
        if halted & halt_bit(axis) != 0 {
            waker.wake();
        }
    }
}
