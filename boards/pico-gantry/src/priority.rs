//! The interrupt priorities, and the executors for what must not be late.
//!
//! # Design
//! The chips have four priorities, or more, of which four are used. By the names of an RP2040's interrupts:
//!
//! | priority | interrupt | why there |
//! |---|---|---|
//! | P0 | `PWM_IRQ_WRAP` | of a proving image, while it measures how long such an interrupt waits |
//! | P0 | `PIO1_IRQ_1` | an edge of a switch: it engages the inhibit |
//! | P1 | `TIMER_IRQ_0` | the time driver's alarm: it only wakes tasks whose time has come, none of them above P1 |
//! | P1 | `IO_IRQ_BANK0` | the same edge: it only wakes the task that watches the switch |
//! | P1 | `SWI_IRQ_1` | the executor of the switches: it polls the tasks that the edge woke, and the tool's; at P2 with `TimerPort`, whose steps they would delay |
//! | P1 | `SWI_IRQ_3` | with `TimerPort`: the executor of the task that makes the steps: while it waits for one, other tasks' times wait |
//! | P2 | `SWI_IRQ_2` | the executor of the axes: writes the next block of steps; at P3 with `TimerPort`, passes on segments |
//! | P2 | `DMA_IRQ_1`, `PIO0_IRQ_1`, with five motors `PIO2_IRQ_1` | a buffer was sent, a state machine has halted: they wake the axis |
//! | P1 | `USBCTRL_IRQ` | detects a second reset byte; at P3 with `TimerPort`, whose steps it would delay |
//! | P3 | `UART0_IRQ` | wakes the console; it can wait while axes are at work |
//! | thread | the rest | coordinator, console, LED, watchdog |
//!
//! Critical sections are above all of them, because they mask every interrupt. The timer queue, channels and wakers
//! hold one for microseconds, a log line for as long as defmt takes to encode it. So nothing is logged at each step,
//! and the log never waits for a debug probe. The time driver has a lock of its own, [`BelowGuard`]: it looks through all tasks
//! that wait, which takes up to 5 us, and a switch must not wait for that.
#![expect(unsafe_code, reason = "an executor may be run from its own interrupt only, and interrupts are unmasked")]

use embassy_executor::{InterruptExecutor, SendSpawner};
use embassy_rp::interrupt;
use embassy_rp::interrupt::{InterruptExt, Priority};
use embassy_sync::blocking_mutex::raw::RawMutex;

use crate::chip;

const USB: Priority = if cfg!(feature = "timer-port") { Priority::P3 } else { Priority::P1 };
const SWITCH_TASKS: Priority = if cfg!(feature = "timer-port") { Priority::P2 } else { Priority::P1 };

const _: () =
    assert!((interrupt::SWI_IRQ_3 as usize) < chip::INTERRUPTS, "the chip has the software interrupts of executors");

static SWITCHES: InterruptExecutor = InterruptExecutor::new();
static AXES: InterruptExecutor = InterruptExecutor::new();
#[cfg(feature = "timer-port")]
static STEPS: InterruptExecutor = InterruptExecutor::new();

/// A lock that masks every interrupt but those of P0, which never take it.
pub struct BelowGuard;

// SAFETY: there is one core, and all code but the handlers of P0 is kept from running. These touch nothing behind such a lock:
// it is the time driver's alone, and they set no timer. After start-up nobody enables or disables an interrupt, so those
// that are restored are those that there were. An RP2350 masks by priority, and so does not mask an interrupt that the HAL has enabled
// and that has no priority here (`PIO0_IRQ_0`): it wakes tasks, and sets no timer either.
unsafe impl RawMutex for BelowGuard {
    const INIT: Self = Self;

    #[inline(always)]
    fn lock<R>(&self, f: impl FnOnce() -> R) -> R {
        chip::masked_below_p0(f)
    }
}

/// Assigns the priorities, then starts the executors of the switches and of the axes.
pub fn start_executors() -> (SendSpawner, SendSpawner) {
    interrupt::PIO1_IRQ_1.set_priority(Priority::P0);
    chip::TIMER_INTERRUPT.set_priority(Priority::P1);
    interrupt::IO_IRQ_BANK0.set_priority(Priority::P1);
    interrupt::SWI_IRQ_1.set_priority(SWITCH_TASKS);
    interrupt::SWI_IRQ_2.set_priority(Priority::P2);
    interrupt::DMA_IRQ_1.set_priority(Priority::P2);
    interrupt::PIO0_IRQ_1.set_priority(Priority::P2);
    #[cfg(five_motors)]
    interrupt::PIO2_IRQ_1.set_priority(Priority::P2);
    interrupt::USBCTRL_IRQ.set_priority(USB);
    interrupt::UART0_IRQ.set_priority(Priority::P3);
    (SWITCHES.start(interrupt::SWI_IRQ_1), AXES.start(interrupt::SWI_IRQ_2))
}

/// Enables the interrupts that hardware-timed ports need.
#[cfg(not(feature = "timer-port"))]
pub fn enable_pio_port() {
    // SAFETY: their handlers exist, and no code relies on these interrupts being masked.
    unsafe {
        interrupt::DMA_IRQ_1.enable();
        interrupt::PIO0_IRQ_1.enable();
        #[cfg(five_motors)]
        interrupt::PIO2_IRQ_1.enable();
    }
}

/// Starts the executor of the task that makes steps, and lowers the axes' executor to a priority at which it does not
/// interrupt that task.
#[cfg(feature = "timer-port")]
pub fn start_step_executor() -> SendSpawner {
    interrupt::SWI_IRQ_2.set_priority(Priority::P3);
    interrupt::SWI_IRQ_3.set_priority(Priority::P1);
    STEPS.start(interrupt::SWI_IRQ_3)
}

/// Enables the interrupt of the time driver.
pub fn enable_timer() {
    // SAFETY: its handler exists, and no code relies on this interrupt being masked.
    unsafe { chip::TIMER_INTERRUPT.enable() }
}

/// Enables the interrupt that measures how long it waits.
#[cfg(feature = "prove")]
pub fn enable_waits() {
    // SAFETY: its handler exists, and no code relies on this interrupt being masked.
    unsafe { chip::prove::WRAP_INTERRUPT.enable() }
}

/// Enables the interrupt that the guard needs.
pub fn enable_guard() {
    // SAFETY: its handler exists, and no code relies on this interrupt being masked.
    unsafe { interrupt::PIO1_IRQ_1.enable() }
}

#[interrupt]
fn SWI_IRQ_1() {
    // SAFETY: this is the executor's interrupt. `start` unmasks it, and only a started executor pends it.
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
