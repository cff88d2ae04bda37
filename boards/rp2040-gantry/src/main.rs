//! Firmware of the parking gantry on a Raspberry Pi Pico: pins, priorities and consoles for the tasks of
//! `isostep-motion` and `isostep-controller`, which run in simulation just the same.
#![no_std]
#![no_main]

mod console;
mod fail_still;
mod led;
mod motion;
mod pins;
mod priority;
mod uart;
mod usb;
mod watch;

use defmt_rtt as _;
use embassy_executor::Spawner;
use embassy_futures::select::select;
use embassy_rp::peripherals::USB;
use embassy_rp::usb::Driver;
use embassy_usb::UsbDevice;
use isostep_motion::Machine;
use portable_atomic as _;
use static_cell::StaticCell;

use crate::fail_still::Cause;
use crate::pins::Board;

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let board = Board::new(embassy_rp::init(Default::default()));
    let restart = Cause::of_last_restart();
    if let Some(cause) = restart {
        defmt::warn!("restarted by the watchdog: {}", cause);
    }
    spawner.spawn(watch::feed(board.watchdog).unwrap());

    static MACHINE: StaticCell<Machine> = StaticCell::new();
    let machine = &*MACHINE.init(Machine::new(interim_config()));
    let urgent = priority::start_motion_executor();
    urgent.spawn(watch::beat().unwrap());
    motion::spawn_axes(urgent, machine, board.axes, board.emergency_stop);
    motion::spawn_coordinator(spawner, machine, board.enable);
    spawner.spawn(led::show(machine, board.led).unwrap());

    let (device, port) = usb::open(board.usb);
    let (rx, tx) = uart::open(board.uart, board.uart_tx, board.uart_rx);
    spawner.spawn(usb_device(device).unwrap());
    spawner.spawn(usb_console(port).unwrap());
    spawner.spawn(uart_console(rx, tx).unwrap());
}

#[embassy_executor::task]
async fn usb_device(mut device: UsbDevice<'static, Driver<'static, USB>>) -> ! {
    device.run().await
}

#[embassy_executor::task]
async fn usb_console(mut port: usb::Port) -> ! {
    loop {
        port.rx.wait_connection().await;
        select(console::serve(&mut port.rx, &mut port.tx), port.lines.dtr_rises()).await;
    }
}

#[embassy_executor::task]
async fn uart_console(mut rx: uart::Rx, mut tx: embassy_rp::uart::BufferedUartTx) -> ! {
    loop {
        console::serve(&mut rx, &mut tx).await;
    }
}

fn interim_config() -> isostep_motion::Config {
    use isostep_motion::*;
    use isostep_profile::*;
    let limits =
        Limits { start_speed_steps_s: 0.0, top_speed_steps_s: 2400.0, accel_steps_s2: 2500.0, decel_steps_s2: 2500.0 };
    Config {
        limits: [limits; 3],
        steps_per_mm: [50.0; 3],
        travel_mm: [350.0, 400.0, 100.0],
        law: IntervalLaw::Fastest,
        hard_limits: true,
        switches_inverted: false,
        idle_delay: None,
        homing: HomingConfig {
            order: [Axis::Z, Axis::X, Axis::Y],
            towards: [Direction::Negative; 3],
            seek_mm_s: 10.0,
            latch_mm_s: 1.0,
            pull_off_mm: 2.0,
            debounce: embassy_time::Duration::from_millis(5),
        },
    }
}
