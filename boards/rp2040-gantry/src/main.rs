//! Firmware of the parking gantry on a Raspberry Pi Pico: pins, priorities and consoles for the tasks of
//! `isostep-motion` and `isostep-controller`, which run in simulation just the same.
#![no_std]
#![no_main]

mod console;
mod fail_still;
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
use portable_atomic as _;

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

    let motion = priority::start_motion_executor();
    motion.spawn(watch::beat().unwrap());

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
