//! The texts of a board about itself; and preparing for new firmware: what it asks of its consoles before it goes to a boot
//! loader.

use embassy_time::Timer;
use embedded_storage_async::nor_flash::NorFlash;
use isostep_console::AXES;
use isostep_console::report::messages;

use crate::controller::{Controller, Mode};
#[cfg(feature = "trinamic")]
use crate::drivers::{DriverHardware, Drivers};
use crate::output::Message;

impl<F: NorFlash> Controller<'_, F> {
    /// Names the board, for `$I`.
    #[must_use]
    pub fn on_board(mut self, name: &'static str) -> Self {
        self.board = name;
        self
    }

    /// Says that there is a boot loader, which is a USB drive of this name and is started by the caller of
    /// [`boot_asked`](Self::boot_asked). Without one `$BOOT` is refused.
    #[must_use]
    pub fn with_boot_loader(mut self, drive: &'static str) -> Self {
        self.boot_drive = drive;
        self
    }

    /// Says that the board has no outputs for a second motor: `$905` is refused.
    #[must_use]
    pub fn without_second_motor(mut self) -> Self {
        self.has_second_motor = false;
        self
    }

    /// Says that the board has an input for the alarm of each axis's drive. Without one `$744` is refused.
    #[must_use]
    pub fn with_drive_alarms(mut self) -> Self {
        self.drive_alarm_inputs = (1 << AXES) - 1;
        self
    }

    /// Says that the board has one input for the alarms of all drives, which is X's.
    #[must_use]
    pub fn with_one_drive_alarm(mut self) -> Self {
        self.drive_alarm_inputs = 1;
        self
    }

    /// Says that the board has these drivers, which [`watch_drivers`](Self::watch_drivers) sets and watches. Without them their
    /// settings are not listed, and refused.
    #[cfg(feature = "trinamic")]
    #[must_use]
    pub fn with_drivers(mut self, hardware: DriverHardware) -> Self {
        self.drivers = Some(Drivers::new(hardware));
        self
    }

    /// Waits for `$BOOT`. When it returns, the machine is at rest and nothing can begin any more, everything is stored,
    /// and the answer is being sent to the host.
    ///
    /// # Cancellation
    /// Safe: if `$BOOT` comes meanwhile, the next call returns at once.
    pub async fn boot_asked(&self) {
        self.boot.wait().await;
    }

    /// Brings the machine to the same state without `$BOOT`, whatever it is doing, by a reset, and waits until all
    /// changes are stored.
    ///
    /// # Cancellation
    /// It brakes from the first poll on, and nothing begins any more. If it is dropped before its end, something may
    /// still move, and changes may not be stored.
    pub async fn retire(&self) {
        self.machine.reset();
        self.leave();
        self.begin_restart();
        self.machine.emptied().await;
        // A line stores its changes while it has its turn. If the reset has ended a line early, the next welcome stores
        // its changes.
        while self.turn.try_lock().is_err() || self.with(|program| program.unsaved.any()) {
            Timer::after_millis(1).await;
        }
    }

    /// Says what becomes of the board.
    // Not inlined, so that the lines of a program run through less code in flash.
    #[cold]
    #[inline(never)]
    pub(crate) fn say_booting(&self, text: &mut Message) {
        text.say(messages::Booting(self.boot_drive));
    }

    /// Goes to the boot loader, after `$BOOT` has been answered.
    pub(crate) fn boot(&self) {
        self.leave();
        self.boot.signal(());
    }

    /// From now on refuses every line that moves or changes anything.
    fn leave(&self) {
        self.with(|program| program.mode = Mode::Left);
    }
}
