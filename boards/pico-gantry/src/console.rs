//! The consoles, one task each; they share one controller.

use core::pin::pin;

use embassy_executor::Spawner;
use embassy_futures::select::select;
use embedded_io_async::{Read, Write};
use isostep_controller::{Controller, FlowControl};
use isostep_motion::cold_path;

use crate::fail_still::RestartCause;
use crate::flash::Flash;
use crate::pins::UartPins;
use crate::{uart, usb, vfd_wire};

/// Serves both consoles, or that of USB and a VFD. Each session begins with the cause of the last restart, if the user did not cause it.
pub fn spawn(
    spawner: Spawner,
    controller: &'static Controller<'static, Flash>,
    restart: Option<RestartCause>,
    usb: usb::UsbPort,
    uart: UartPins,
    takes_vfd: bool,
) {
    spawner.spawn(serve_usb(controller, restart, usb).unwrap());
    spawner.spawn(serve_uart(controller, restart, uart, takes_vfd).unwrap());
}

#[embassy_executor::task]
async fn serve_usb(
    controller: &'static Controller<'static, Flash>,
    restart: Option<RestartCause>,
    mut port: usb::UsbPort,
) -> ! {
    loop {
        port.rx.wait_connection().await;
        select(session(controller, restart, &mut port.rx, &mut port.tx, FlowControl::Link), port.lines.dtr_rises())
            .await;
    }
}

#[embassy_executor::task]
async fn serve_uart(
    controller: &'static Controller<'static, Flash>,
    restart: Option<RestartCause>,
    pins: UartPins,
    takes_vfd: bool,
) -> ! {
    // A line takes longer on the cable than in the cache.
    cold_path(pin!(serve_wired(controller, restart, pins, takes_vfd))).await
}

/// Serves the wired console, or turns a spindle by a VFD on its wires.
async fn serve_wired(
    controller: &Controller<'_, Flash>,
    restart: Option<RestartCause>,
    pins: UartPins,
    takes_vfd: bool,
) -> ! {
    if takes_vfd {
        match controller.watch_vfd(vfd_wire::open(pins)).await {}
    }
    let (mut rx, mut tx) = uart::open(pins);
    loop {
        session(controller, restart, &mut rx, &mut tx, FlowControl::None).await;
    }
}

/// Serves a console until the link fails.
async fn session<R: Read, W: Write>(
    controller: &Controller<'_, Flash>,
    restart: Option<RestartCause>,
    rx: R,
    mut tx: W,
    flow_control: FlowControl,
) {
    if let Some(cause) = restart {
        // If the link fails here, it fails again below.
        let _ = cold_path(pin!(tx.write_all(cause.message().as_bytes()))).await;
    }
    if controller.serve(rx, tx, flow_control).await.is_err() {
        defmt::info!("a console has lost its link");
    }
}
