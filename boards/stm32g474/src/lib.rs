//! The chip's parts that both firmwares use: clock, pins, steps, switches, executors. README.md says where each is, and
//! which of them a machine may leave out.
#![no_std]

pub mod clock;
pub mod executors;
pub mod flash;
pub mod pins;
pub mod steps;
pub mod tasks;
mod wake_up;

use core::panic::PanicInfo;

/// Stops for ever, with no more edges: the interrupts are masked. What else must be off then, such as a laser, is for the
/// machine's maker to see to here.
#[panic_handler]
fn panic(_info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    loop {
        cortex_m::asm::nop();
    }
}
