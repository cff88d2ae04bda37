//! The priorities, and an executor for each.
//!
//! | priority | interrupt | why there |
//! |---|---|---|
//! | 0 | TIM2, of the HAL's time driver | the clock and its alarm: they only wake tasks |
//! | 1 | EXTI, and UART4 for an executor | the tasks that watch the switches, and the tool if there is one |
//! | 2 | UART5 for an executor | the task that makes the steps, which may wait without sleeping |
//! | 3 | USART3 for an executor | the tasks of the axes, which pass on segments |
//! | 4 | USART2 | bytes of the console |
//! | thread mode | | coordinator, console |
//!
//! The three peripherals whose interrupts serve an executor are not used for anything else.
#![expect(unsafe_code, reason = "an executor may be run from its own interrupt only")]

use embassy_executor::{InterruptExecutor, SendSpawner};
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::{InterruptExt, Priority};

static SWITCHES: InterruptExecutor = InterruptExecutor::new();
static STEPS: InterruptExecutor = InterruptExecutor::new();
static AXES: InterruptExecutor = InterruptExecutor::new();

/// Starts the executors of the switches, of the steps and of the axes.
pub fn start() -> [SendSpawner; 3] {
    for switch in [interrupt::EXTI0, interrupt::EXTI1, interrupt::EXTI2, interrupt::EXTI9_5, interrupt::UART4] {
        switch.set_priority(Priority::P1);
    }
    interrupt::UART5.set_priority(Priority::P2);
    interrupt::USART3.set_priority(Priority::P3);
    interrupt::USART2.set_priority(Priority::P4);
    [SWITCHES.start(interrupt::UART4), STEPS.start(interrupt::UART5), AXES.start(interrupt::USART3)]
}

#[interrupt]
fn UART4() {
    // SAFETY: this is the interrupt that the executor was started with.
    unsafe { SWITCHES.on_interrupt() }
}

#[interrupt]
fn UART5() {
    // SAFETY: as above.
    unsafe { STEPS.on_interrupt() }
}

#[interrupt]
fn USART3() {
    // SAFETY: as above.
    unsafe { AXES.on_interrupt() }
}
