//! Who may interrupt whom, and the executors for what must not be late.
//!
//! # Design
//! The RP2040 has four priorities:
//!
//! | priority | interrupt | why there |
//! |---|---|---|
//! | P0 | `TIMER_IRQ_0` | the time driver's alarm: it wakes whose instant has come, and does nothing else |
//! | P0 | `PIO1_IRQ_1` | a switch's edge: it puts on the brake |
//! | P1 | `IO_IRQ_BANK0` | the same edge: it wakes the one who watches, and does nothing else |
//! | P1 | `SWI_IRQ_1` | the executor of the switches: polls what the edge woke |
//! | P2 | `SWI_IRQ_2` | the executor of the axes: writes the next block of steps; with `TimerPort` at P3, it hands on segments |
//! | P2 | `SWI_IRQ_3` | with `TimerPort`, the executor of the task that makes the steps, which may wait for one without sleeping |
//! | P2 | `DMA_IRQ_1`, `PIO0_IRQ_1` | a block was sent, a state machine has halted: they wake the axis |
//! | P1 | `USBCTRL_IRQ` | hears a second reset byte; with `TimerPort`, whose steps it would delay, P3 |
//! | P3 | `UART0_IRQ` | wakes the console, and may wait as long as axes are at work |
//! | thread | the rest | coordinator, console, LED, watchdog |
//!
//! Above all of them are critical sections, which close the door to every interrupt: the timer queue, channels and wakers
//! hold one for microseconds, a log line for as long as defmt takes to encode it. Hence nothing is logged at each step,
//! and the log never waits for a probe.
#![expect(unsafe_code, reason = "an executor may be run from its own interrupt only, and interrupts are unmasked")]

use embassy_executor::{InterruptExecutor, SendSpawner};
use embassy_rp::interrupt;
use embassy_rp::interrupt::{InterruptExt, Priority};

const USB: Priority = if cfg!(feature = "timer-port") { Priority::P3 } else { Priority::P1 };

static SWITCHES: InterruptExecutor = InterruptExecutor::new();
static AXES: InterruptExecutor = InterruptExecutor::new();
#[cfg(feature = "timer-port")]
static STEPS: InterruptExecutor = InterruptExecutor::new();

/// Assigns the priorities, then starts the executors of the switches and of the axes.
pub fn start_executors() -> (SendSpawner, SendSpawner) {
    interrupt::TIMER_IRQ_0.set_priority(Priority::P0);
    interrupt::PIO1_IRQ_1.set_priority(Priority::P0);
    interrupt::IO_IRQ_BANK0.set_priority(Priority::P1);
    interrupt::SWI_IRQ_1.set_priority(Priority::P1);
    interrupt::SWI_IRQ_2.set_priority(Priority::P2);
    interrupt::DMA_IRQ_1.set_priority(Priority::P2);
    interrupt::PIO0_IRQ_1.set_priority(Priority::P2);
    interrupt::USBCTRL_IRQ.set_priority(USB);
    interrupt::UART0_IRQ.set_priority(Priority::P3);
    (SWITCHES.start(interrupt::SWI_IRQ_1), AXES.start(interrupt::SWI_IRQ_2))
}

/// Lets through what hardware-timed ports are told by.
#[cfg(not(feature = "timer-port"))]
pub fn enable_pio_port() {
    // SAFETY: their handlers exist, and nobody counts on them being masked.
    unsafe {
        interrupt::DMA_IRQ_1.enable();
        interrupt::PIO0_IRQ_1.enable();
    }
}

/// Starts the executor of the task that makes steps, and lowers the axes' own to where it does not interrupt them.
#[cfg(feature = "timer-port")]
pub fn start_step_executor() -> SendSpawner {
    interrupt::SWI_IRQ_2.set_priority(Priority::P3);
    interrupt::SWI_IRQ_3.set_priority(Priority::P2);
    STEPS.start(interrupt::SWI_IRQ_3)
}

/// Lets through what the guard is told by.
pub fn enable_guard() {
    // SAFETY: its handler exists, and nobody counts on it being masked.
    unsafe { interrupt::PIO1_IRQ_1.enable() }
}

#[interrupt]
fn SWI_IRQ_1() {
    // SAFETY: this is the executor's interrupt, which `start` unmasks and only a started executor pends.
    unsafe { SWITCHES.on_interrupt() }
}

#[interrupt]
fn SWI_IRQ_2() {
    // SAFETY: as above.
    unsafe { AXES.on_interrupt() }
}

#[cfg(feature = "timer-port")]
#[interrupt]
fn SWI_IRQ_3() {
    // SAFETY: as above.
    unsafe { STEPS.on_interrupt() }
}
