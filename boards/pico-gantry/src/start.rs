//! The start of the firmware, which runs once: `memory.x` leaves it in flash.

use embassy_executor::Spawner;
use isostep_controller::{Controller, Settings, config};
use isostep_motion::Machine;
use static_cell::StaticCell;

#[cfg(feature = "skr-pico")]
use crate::driver_wire;
use crate::fail_still::RestartCause;
use crate::flash::{self, Flash};
use crate::pins::{self, Board};
#[cfg(feature = "prove")]
use crate::prove;
use crate::{
    board_words, boot, chip, console, led, motion, output_watchdog, priority, rs485, time_driver, usb, vectors, watch,
};

/// Starts all tasks.
///
/// # Cancellation
/// It is never dropped: it is all that the main task does.
pub async fn start(spawner: Spawner) {
    static MACHINE: StaticCell<Machine> = StaticCell::new();
    static CONTROLLER: StaticCell<Controller<'static, Flash>> = StaticCell::new();

    vectors::move_to_ram();
    chip::link_floats();
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
    let controller = Controller::new(machine, Settings::DEFAULT, flash::open(flash))
        .with_boot_loader(chip::BOOT_DRIVE)
        .on_board(pins::NAME);
    #[cfg(feature = "prove")]
    let controller = controller.with_prove(prove::answer);
    #[cfg(feature = "skr-pico")]
    let controller = controller.with_drivers(pins::DRIVERS);
    #[cfg(drive_alarm)]
    let controller = controller.with_one_drive_alarm();
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
    let takes_vfd = controller.takes_vfd();
    if takes_vfd {
        switches.spawn(rs485::release().unwrap());
    }
    console::spawn(spawner, controller, restart, usb::open(spawner, board.usb), board.uart, takes_vfd);
    #[cfg(feature = "skr-pico")]
    spawner.spawn(driver_wire::watch(controller, wire).unwrap());
    spawner.spawn(boot::make_way(machine, controller).unwrap());
    if let Some(led) = board.led {
        spawner.spawn(led::show(machine, led).unwrap());
    }
    #[cfg(feature = "prove")]
    prove::ready();
}
