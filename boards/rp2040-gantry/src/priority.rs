//! Who may interrupt whom, and the executor for what must not be late.
//!
//! # Design
//! The RP2040 has four priorities. What a step waits for, from the alarm at its instant to the edge:
//!
//! | priority | interrupt | why there |
//! |---|---|---|
//! | P0 | `TIMER_IRQ_0` | the time driver's alarm: it wakes the axis whose step is due, and does nothing else |
//! | P1 | `SWI_IRQ_1` | the urgent executor: axes and switches; polls what the alarm woke |
//! | P1 | `IO_IRQ_BANK0` | a switch's edge, served between two polls; at worst it delays a step by its own scan of 30 pins |
//! | P3 | `USBCTRL_IRQ`, `UART0_IRQ` | wake the console, and may wait as long as steps are due |
//! | thread | the rest | coordinator, console, LED, watchdog |
//!
//! So a step is delayed by: the poll of another axis whose step is due too, pulse and all; a switch's edge; and critical
//! sections, which close the door to every interrupt: the timer queue, channels and wakers hold one for microseconds,
//! a log line for as long as defmt takes to encode it. Hence nothing is logged at each step, and the log never waits
//! for a probe.
#![expect(unsafe_code, reason = "InterruptExecutor::on_interrupt may be called from its own interrupt only")]

use embassy_executor::{InterruptExecutor, SendSpawner};
use embassy_rp::interrupt;
use embassy_rp::interrupt::{InterruptExt, Priority};

static URGENT: InterruptExecutor = InterruptExecutor::new();

/// Assigns the priorities, then starts the urgent executor.
pub fn start_urgent_executor() -> SendSpawner {
    interrupt::TIMER_IRQ_0.set_priority(Priority::P0);
    interrupt::SWI_IRQ_1.set_priority(Priority::P1);
    interrupt::IO_IRQ_BANK0.set_priority(Priority::P1);
    interrupt::USBCTRL_IRQ.set_priority(Priority::P3);
    interrupt::UART0_IRQ.set_priority(Priority::P3);
    URGENT.start(interrupt::SWI_IRQ_1)
}

#[interrupt]
fn SWI_IRQ_1() {
    // SAFETY: this is the executor's interrupt, which `start` unmasks and only a started executor pends.
    unsafe { URGENT.on_interrupt() }
}
