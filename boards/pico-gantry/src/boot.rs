//! Starts the boot loader in the chip's ROM, to load new firmware without pressing the BOOTSEL button.
//!
//! # Design
//! There are two ways to ask for it. `$BOOT` is for people, on either console: the controller refuses it unless the
//! machine is at rest. The touch is for flashing tools. They cannot ask first, and they consider a board broken if it
//! does not leave. So the touch always works. During a move it first causes a reset, which brakes. If braking takes too
//! long, a second reset stops the machine at once.
//!
//! Then the motors stay energised for a moment, while the last replies leave and the carriages come to rest. In the
//! boot loader nothing drives ENABLE.

use core::pin::pin;

use embassy_futures::select::select;
use embassy_time::{Duration, Timer, with_timeout};
use isostep_controller::Controller;
use isostep_motion::{Machine, cold_path};

use crate::flash::Flash;
use crate::{fail_still, touch};

/// Time for the last replies: a full buffer of the controller's, 768 bytes, and one of the UART's, 256, take 89 ms at
/// 115200 baud. It also lets a host on USB pass them on to its program before the port disappears.
const FAREWELL: Duration = Duration::from_millis(250);
/// Time for braking and for storing changes. Storing rarely takes more than some sector erases of 45 ms.
const PATIENCE: Duration = Duration::from_millis(1_500);

/// Starts the boot loader when a console or a tool asks for it.
#[embassy_executor::task]
pub async fn make_way(machine: &'static Machine, controller: &'static Controller<'static, Flash>) -> ! {
    cold_path(pin!(select(controller.boot_asked(), retire_when_touched(controller)))).await;
    // This has no effect on a machine at rest, and stops at once one that is still braking.
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
