//! The interrupts that wake an axis task: a buffer has been sent, or a state machine has halted.
//!
//! The handlers have the priority of the axis tasks, so neither interrupts the other. What both change (which
//! interrupts are enabled) therefore needs no lock.

use core::sync::atomic::{AtomicUsize, Ordering};

use embassy_rp::interrupt;
use embassy_rp::pac::pio::Pio;
use embassy_rp::pac::{DMA, PIO0};
use embassy_rp::peripherals;
use embassy_rp::{bind_interrupts, pio};
use embassy_sync::waitqueue::AtomicWaker;
use isostep_motion::AXES;

#[cfg(five_motors)]
use super::state_machine::MACHINES;
use super::state_machine::StateMachine;
use crate::pins::{HAS_SECOND, SECOND};

bind_interrupts!(pub struct Irqs {
    PIO0_IRQ_0 => pio::InterruptHandler<peripherals::PIO0>;
});
#[cfg(five_motors)]
bind_interrupts!(pub struct FifthIrqs {
    PIO2_IRQ_0 => pio::InterruptHandler<peripherals::PIO2>;
});

/// Wakers of the axis tasks.
pub static WAKERS: [AtomicWaker; AXES] = [const { AtomicWaker::new() }; AXES];

/// The axis that the second motor is on, in the last run of such an axis.
static DOUBLED: AtomicUsize = AtomicUsize::new(0);

/// The second motor makes the steps of `axis` from now on.
pub fn double(axis: usize) {
    DOUBLED.store(axis, Ordering::Relaxed);
}

/// Wakes the axes one of whose motors has its bits in `raised`, where each motor has `width` bits.
#[inline(never)]
fn wake(raised: u32, width: usize) {
    let bits = |motor: usize| ((1 << width) - 1) << (width * motor);
    for (axis, waker) in WAKERS.iter().enumerate() {
        let has_second = HAS_SECOND && DOUBLED.load(Ordering::Relaxed) == axis;
        let second = if has_second { bits(SECOND) } else { 0 };
        if raised & (bits(axis) | second) != 0 {
            waker.wake();
        }
    }
}

/// Enables one interrupt for the halt of a state machine, which wakes its axis.
pub fn expect_halt(machine: StateMachine) {
    machine.block().irqs(1).inte().modify(|enabled| enabled.0 |= u32::from(machine.bit()) << HALTS);
}

/// In this register the flags of the state machines come after the eight levels of the FIFOs.
const HALTS: usize = 8;

/// Buffers have been sent. Each raises the interrupt once; arming the buffer enables it again.
#[interrupt]
fn DMA_IRQ_1() {
    let sent = DMA.ints(1).read();
    DMA.inte(1).modify(|enabled| *enabled &= !sent);
    wake(sent, 2);
}

/// State machines have halted.
#[interrupt]
fn PIO0_IRQ_1() {
    wake(halted_in(PIO0), 1);
}

#[cfg(five_motors)]
#[interrupt]
fn PIO2_IRQ_1() {
    wake(halted_in(embassy_rp::pac::PIO2) << MACHINES, 1);
}

/// The state machines of a block that have halted, each told once.
#[inline(always)]
fn halted_in(block: Pio) -> u32 {
    let halted = block.irqs(1).ints().read().0;
    block.irqs(1).inte().modify(|enabled| enabled.0 &= !halted);
    halted >> HALTS
}
