//! The executor of thread mode in a proving image: it knows how long the core sleeps.
//!
//! # Design
//! The executor that embassy has for thread mode sleeps by WFE. An interrupt that wakes it is served before the next
//! instruction, and so would count as sleep. Here interrupts are masked while the core falls asleep and wakes: WFI wakes for
//! one that is pending, which is served after the clock has been read. A task that is woken pends an interrupt that is never
//! enabled, of which only the flag is read.
#![expect(unsafe_code, reason = "an executor may be polled by the code that owns it, and interrupts are unmasked")]

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::interrupt::{InterruptNumber, disable, enable};
use cortex_m::peripheral::NVIC;
use embassy_executor::{Spawner, raw};
use embassy_rp::interrupt::Interrupt;
use static_cell::StaticCell;

use crate::chip::{self, TIMER};

/// Pended by the tasks of this executor.
const WOKEN: Interrupt = Interrupt::SWI_IRQ_4;
const _: () = assert!((WOKEN as usize) < chip::INTERRUPTS);

static ASLEEP_US: AtomicU32 = AtomicU32::new(0);
static SINCE_US: AtomicU32 = AtomicU32::new(0);

/// Microseconds asleep, and in all, since the last call.
pub fn take_us() -> [u32; 2] {
    let now_us = TIMER.timerawl().read();
    let since_us = now_us.wrapping_sub(SINCE_US.load(Ordering::Relaxed));
    let asleep_us = ASLEEP_US.load(Ordering::Relaxed);
    SINCE_US.store(now_us, Ordering::Relaxed);
    ASLEEP_US.store(0, Ordering::Relaxed);
    [asleep_us, since_us]
}

/// Runs the tasks of thread mode for ever.
pub fn run(begin: impl FnOnce(Spawner)) -> ! {
    static EXECUTOR: StaticCell<raw::Executor> = StaticCell::new();

    let executor = &*EXECUTOR.init(raw::Executor::new(usize::from(WOKEN.number()) as *mut ()));
    begin(executor.spawner());
    loop {
        NVIC::unpend(WOKEN);
        // SAFETY: it is polled here alone, and not from within a poll.
        unsafe { executor.poll() };
        while !NVIC::is_pending(WOKEN) {
            let mut times_us = [0; 2];
            disable();
            if !NVIC::is_pending(WOKEN) {
                times_us[0] = TIMER.timerawl().read();
                cortex_m::asm::wfi();
                times_us[1] = TIMER.timerawl().read();
            }
            // At once: an interrupt waits for it.
            // SAFETY: they were unmasked before, and no critical section relies on them being masked.
            unsafe { enable() };
            let slept_us = times_us[1].wrapping_sub(times_us[0]);
            ASLEEP_US.store(ASLEEP_US.load(Ordering::Relaxed).wrapping_add(slept_us), Ordering::Relaxed);
        }
    }
}
