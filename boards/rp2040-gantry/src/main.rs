//! Firmware of the parking gantry on a Raspberry Pi Pico. It provides pins, priorities and consoles for the tasks of
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
mod cold_path;
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
mod time_driver;
#[cfg(feature = "timer-port")]
mod timer_port;
mod tool;
mod touch;
mod two_words;
mod uart;
mod usb;
mod vectors;
mod watch;

use defmt_rtt as _;
use embassy_executor::Spawner;
use isostep_controller::{Controller, Settings, config};
use isostep_motion::Machine;
use portable_atomic as _;
use static_cell::StaticCell;

use crate::fail_still::RestartCause;
use crate::flash::Flash;
use crate::pins::Board;

#[cfg(not(feature = "prove"))]
#[embassy_executor::main]
async fn main(spawner: Spawner) {
    start(spawner).await;
}

#[cfg(feature = "prove")]
#[cortex_m_rt::entry]
fn main() -> ! {
    #[embassy_executor::task]
    async fn main_task(spawner: Spawner) {
        start(spawner).await;
    }

    prove::run(|spawner| spawner.spawn(main_task(spawner).unwrap()))
}

async fn start(spawner: Spawner) {
    static MACHINE: StaticCell<Machine> = StaticCell::new();
    static CONTROLLER: StaticCell<Controller<'static, Flash>> = StaticCell::new();

    vectors::move_to_ram();
    rp2040_floats::link();
    let board = Board::new(embassy_rp::init(Default::default()));
    time_driver::start();
    let restart = RestartCause::of_last_restart();
    if let Some(cause) = restart {
        defmt::warn!("restarted by the watchdog: {}", cause);
    }
    // No variable, which would be kept as long as this waits.
    let machine = &*MACHINE.init(Machine::new(config(&Settings::DEFAULT), board_words::emergency_contact()));
    let flash = flash::take(board.flash);
    #[cfg(feature = "prove")]
    let flash = prove::start(spawner, board.prove, flash);
    let controller =
        Controller::new(machine, Settings::DEFAULT, flash::open(flash)).with_boot_loader().on_board(pins::NAME);
    #[cfg(feature = "prove")]
    let controller = controller.with_prove(prove::answer);
    #[cfg(feature = "skr-pico")]
    let controller = controller.with_drivers(pins::DRIVERS);
    let controller = if pins::HAS_SECOND { controller } else { controller.without_second_motor() };
    let controller = &*CONTROLLER.init(controller);

    let (switches, axes) = priority::start_executors();
    output_watchdog::start(board.output_watchdog);
    watch::spawn(axes, spawner, machine, board.watchdog);
    motion::spawn_axes(axes, machine, board.steps);
    // Must be done before anything reads the settings or moves.
    controller.load().await;
    #[cfg(feature = "skr-pico")]
    let wire = driver_wire::open(controller, board.driver_wire).await;
    motion::spawn_switches(switches, machine, board.switches);
    motion::spawn_tool(switches, machine, board.tool, board.controls);
    #[cfg(not(feature = "prove"))]
    let enable = board.enable;
    #[cfg(feature = "prove")]
    let enable = prove::MotorsOff::new(board.enable, machine);
    motion::spawn_coordinator(spawner, machine, enable);
    console::spawn(spawner, controller, restart, usb::open(spawner, board.usb), uart::open(board.uart));
    #[cfg(feature = "skr-pico")]
    spawner.spawn(driver_wire::watch(controller, wire).unwrap());
    spawner.spawn(boot::make_way(machine, controller).unwrap());
    if let Some(led) = board.led {
        spawner.spawn(led::show(machine, led).unwrap());
    }
    #[cfg(feature = "prove")]
    prove::ready();
}
