//! The critical section of a proving image: that of one core, which can measure how long interrupts are masked.
#![expect(unsafe_code, reason = "a critical section is what other code's safety rests on")]

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use critical_section::{Impl, RawRestoreState, set_impl};

use super::cycles;

static IS_MEASURING: AtomicBool = AtomicBool::new(false);
static BEGUN: AtomicU32 = AtomicU32::new(0);
static LONGEST_CYCLES: AtomicU32 = AtomicU32::new(0);

/// The longest critical section, cycles, since the last call. The first call begins to measure.
pub fn take_longest_cycles() -> u32 {
    IS_MEASURING.store(true, Ordering::Relaxed);
    let longest = LONGEST_CYCLES.load(Ordering::Relaxed);
    LONGEST_CYCLES.store(0, Ordering::Relaxed);
    longest
}

struct SingleCore;
set_impl!(SingleCore);

// SAFETY: with interrupts masked nothing else runs on the only core that does, and the outermost section alone unmasks them.
unsafe impl Impl for SingleCore {
    #[inline(always)]
    unsafe fn acquire() -> RawRestoreState {
        let is_outermost = cortex_m::register::primask::read().is_active();
        cortex_m::interrupt::disable();
        if is_outermost && IS_MEASURING.load(Ordering::Relaxed) {
            begin();
        }
        is_outermost
    }

    #[inline(always)]
    unsafe fn release(is_outermost: RawRestoreState) {
        if is_outermost {
            if IS_MEASURING.load(Ordering::Relaxed) {
                end();
            }
            // SAFETY: they were unmasked before this section.
            unsafe { cortex_m::interrupt::enable() }
        }
    }
}

// Not inlined, as there are hundreds of sections.
#[inline(never)]
fn begin() {
    BEGUN.store(cycles::now(), Ordering::Relaxed);
}

#[inline(never)]
fn end() {
    let section_cycles = cycles::since(BEGUN.load(Ordering::Relaxed));
    // Nothing comes between: interrupts are masked.
    if section_cycles > LONGEST_CYCLES.load(Ordering::Relaxed) {
        LONGEST_CYCLES.store(section_cycles, Ordering::Relaxed);
    }
}
