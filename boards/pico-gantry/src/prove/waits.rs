//! The longest time that an interrupt of the highest priority waits: for a critical section, or for another of its priority.
//!
//! # Design
//! A slice of the PWM that drives no pin wraps again and again, and interrupts. Its counter then says how many cycles
//! ago that was. The period divides no other of the machine's, so that with time every section is met everywhere. A wait
//! longer than a period would be taken for a shorter one. While nothing is measured the slice stands still.

use core::sync::atomic::{AtomicBool, AtomicU16, Ordering};

use embassy_rp::interrupt;
use embassy_rp::interrupt::{InterruptExt, Priority};
use embassy_rp::pac::PWM;

use crate::chip::prove::{WRAP_INTERRUPT, interrupt_at_wrap};
use crate::priority;

/// The PWM slice; that of the tool is slice 6.
const SLICE: usize = 7;
/// 160 us of an RP2040: some thousand looks a second, for 0.2 % of the core. It is a prime.
const PERIOD_CYCLES: u16 = 20_011;

static IS_MEASURING: AtomicBool = AtomicBool::new(false);
/// Cycles from the wrap to the handler: the longest, and the shortest, which is its way there.
static LONGEST: AtomicU16 = AtomicU16::new(0);
static SHORTEST: AtomicU16 = AtomicU16::new(0);

/// Begins to measure, or ends it. Returns the longest wait since it began, cycles; 0 at the beginning.
pub fn begin_or_end() -> u32 {
    let was_measuring = IS_MEASURING.load(Ordering::Relaxed);
    IS_MEASURING.store(!was_measuring, Ordering::Relaxed);
    let slice = PWM.ch(SLICE);
    slice.csr().modify(|csr| csr.set_en(!was_measuring));
    if was_measuring {
        return u32::from(LONGEST.load(Ordering::Relaxed).saturating_sub(SHORTEST.load(Ordering::Relaxed)));
    }
    LONGEST.store(0, Ordering::Relaxed);
    SHORTEST.store(PERIOD_CYCLES, Ordering::Relaxed);
    slice.top().write(|top| top.set_top(PERIOD_CYCLES - 1));
    interrupt_at_wrap(SLICE);
    WRAP_INTERRUPT.set_priority(Priority::P0);
    priority::enable_waits();
    0
}

#[cfg(not(rp2350))]
#[interrupt]
fn PWM_IRQ_WRAP() {
    note();
}

#[cfg(rp2350)]
#[interrupt]
fn PWM_IRQ_WRAP_0() {
    note();
}

/// Notes how long the interrupt has waited.
#[inline(always)]
fn note() {
    let waited = PWM.ch(SLICE).ctr().read().ctr();
    PWM.intr().write(|raised| raised.0 = 1 << SLICE);
    LONGEST.store(waited.max(LONGEST.load(Ordering::Relaxed)), Ordering::Relaxed);
    SHORTEST.store(waited.min(SHORTEST.load(Ordering::Relaxed)), Ordering::Relaxed);
}
