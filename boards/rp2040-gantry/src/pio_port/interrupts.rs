//! Whom a block that was sent, or a state machine that has halted, wakes.
//!
//! The handlers have the priority of the axis tasks, so neither interrupts the other, and what both change (which
//! interrupts are enabled) needs no lock.

use embassy_rp::interrupt;
use embassy_rp::pac::{DMA, PIO0};
use embassy_rp::peripherals;
use embassy_rp::{bind_interrupts, pio};
use embassy_sync::waitqueue::AtomicWaker;
use isostep_motion::AXES;

bind_interrupts!(pub struct Irqs {
    PIO0_IRQ_0 => pio::InterruptHandler<peripherals::PIO0>;
});

/// The task of each axis.
pub static WAKERS: [AtomicWaker; AXES] = [const { AtomicWaker::new() }; AXES];

/// Has the axis woken once when its state machine halts.
pub fn expect_halt(axis: usize) {
    PIO0.irqs(1).inte().modify(|enabled| enabled.0 |= halt_bit(axis));
}

fn halt_bit(axis: usize) -> u32 {
    // The state machines' flags follow the levels of eight FIFOs.
    1 << (8 + axis)
}

/// Blocks sent: each tells once, and is told of again when it is armed again.
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

/// State machines halted.
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
