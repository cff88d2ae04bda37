//! The priorities, and an executor for each.
//!
//! | priority | interrupt | why there |
//! |---|---|---|
//! | 0 | SysTick, `Timer0A` | the clock and its alarm: they only wake tasks |
//! | 1 | `Switches` | the tasks that watch the switches, and the tool |
//! | 2 | `Steps` | the task that makes the steps, which may wait without sleeping |
//! | 3 | `Axes` | the tasks of the axes, which pass on segments |
//! | 4 | `Uart0` | bytes of the console |
//! | 7 | `Rest` | coordinator, console |
//!
//! The processor sleeps in thread mode. There it waits for an interrupt; an executor there would wait for an event, which
//! QEMU does not: its time would go on instruction by instruction instead of to the next alarm.
#![expect(unsafe_code, reason = "an executor may be run from its own interrupt only")]

use embassy_executor::{InterruptExecutor, SendSpawner};

use crate::chip::Irq;

static SWITCHES: InterruptExecutor = InterruptExecutor::new();
static STEPS: InterruptExecutor = InterruptExecutor::new();
static AXES: InterruptExecutor = InterruptExecutor::new();
static REST: InterruptExecutor = InterruptExecutor::new();

/// Starts the executors of the switches, of the steps, of the axes and of the rest.
pub fn start() -> [SendSpawner; 4] {
    Irq::Switches.set_priority(1);
    Irq::Steps.set_priority(2);
    Irq::Axes.set_priority(3);
    Irq::Rest.set_priority(7);
    [SWITCHES.start(Irq::Switches), STEPS.start(Irq::Steps), AXES.start(Irq::Axes), REST.start(Irq::Rest)]
}

pub extern "C" fn on_switches() {
    // SAFETY: this is the interrupt that the executor was started with.
    unsafe { SWITCHES.on_interrupt() }
}

pub extern "C" fn on_steps() {
    // SAFETY: as above.
    unsafe { STEPS.on_interrupt() }
}

pub extern "C" fn on_axes() {
    // SAFETY: as above.
    unsafe { AXES.on_interrupt() }
}

pub extern "C" fn on_rest() {
    // SAFETY: as above.
    unsafe { REST.on_interrupt() }
}
