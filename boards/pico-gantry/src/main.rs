//! Firmware of the parking gantry on a Raspberry Pi Pico or Pico 2. It provides pins, priorities and consoles for the tasks of
//! `isostep-motion` and `isostep-controller`. The same tasks run in the simulator.
//!
//! # Design
//! Three executors share the core, and a fourth with the timer port. Two run in interrupts: that of the limit switches
//! and the emergency stop, and below it that of the axes. The third runs in thread mode: the coordinator, which
//! plans ahead of the axes, the consoles, the LED and the watchdog. `priority` says what may delay what, `fail_still`
//! what happens when the firmware cannot continue.
#![no_std]
#![no_main]

mod board_words;
mod boot;
mod chip;
mod console;
#[cfg(feature = "skr-pico")]
mod driver_wire;
mod fail_still;
mod flash;
mod guard;
mod led;
mod motion;
mod output_watchdog;
mod pins;
#[cfg(not(feature = "timer-port"))]
mod pio_port;
mod priority;
#[cfg(feature = "prove")]
mod prove;
mod reset_listener;
mod rs485;
mod start;
mod time_driver;
#[cfg(feature = "timer-port")]
mod timer_port;
mod tool;
mod touch;
mod two_words;
mod uart;
mod usb;
mod vectors;
mod vfd_wire;
mod watch;

use core::pin::pin;

use defmt_rtt as _;
use embassy_executor::Spawner;
use isostep_motion::cold_path;

#[cfg(not(feature = "prove"))]
#[embassy_executor::main]
async fn main(spawner: Spawner) {
    cold_path(pin!(start::start(spawner))).await;
}

#[cfg(feature = "prove")]
#[cortex_m_rt::entry]
fn main() -> ! {
    #[embassy_executor::task]
    async fn main_task(spawner: Spawner) {
        cold_path(pin!(start::start(spawner))).await;
    }

    prove::run(|spawner| spawner.spawn(main_task(spawner).unwrap()))
}
