//! Making way for new firmware: the boot loader in the chip's ROM, without a hand on the BOOTSEL button.
//!
//! # Design
//! Two ways lead there. `$BOOT` is for people, on either console: the controller refuses it unless the machine is at rest.
//! The touch is for tools, which cannot ask and take a board that stays for a broken one: so it always works, and in
//! mid-move it is a reset first, which brakes, and where that takes too long another, which stops at once.
//!
//! Then the motors are held for a moment while the last words leave, and carriages come to rest; in the boot loader nobody
//! drives ENABLE.

use embassy_futures::select::select;
use embassy_time::{Duration, Timer, with_timeout};
use isostep_controller::Controller;
use isostep_motion::Machine;

use crate::flash::Flash;
use crate::{fail_still, touch};

/// For the last words: a full buffer of the controller's and one of the UART's, 1024 bytes each, take 178 ms at 115200 baud. A
/// host on USB has time to hand them to its program, too, before the port is gone.
const FAREWELL: Duration = Duration::from_millis(250);
/// For braking and for storing what has changed: rarely more than some erased sectors of 45 ms.
const PATIENCE: Duration = Duration::from_millis(1_500);

/// Starts the boot loader when a console or a tool asks for it.
#[embassy_executor::task]
pub async fn make_way(machine: &'static Machine, controller: &'static Controller<'static, Flash>) -> ! {
    select(controller.boot_asked(), retire_when_touched(controller)).await;
    // It does nothing to a machine that is still, and stops at once one that still brakes.
    machine.reset();
    defmt::info!("leaving for the boot loader");
    Timer::after(FAREWELL).await;
    fail_still::set_enable_inverted(machine.config().enable_inverted);
    fail_still::start_boot_loader()
}

async fn retire_when_touched(controller: &Controller<'_, Flash>) {
    touch::touched().await;
    let _ = with_timeout(PATIENCE, controller.retire()).await;
}
