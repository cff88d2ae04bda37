//! Making way for new firmware: what a board asks of its consoles before it leaves for a boot loader.

use embassy_time::Timer;
use embedded_storage_async::nor_flash::NorFlash;

use crate::controller::{Controller, Mode};

impl<F: NorFlash> Controller<'_, F> {
    /// There is a boot loader, and who waits for [`boot_asked`](Self::boot_asked) starts it. Without, `$BOOT` is refused.
    #[must_use]
    pub fn with_boot_loader(mut self) -> Self {
        self.has_boot_loader = true;
        self
    }

    /// Waits for `$BOOT`. Then the machine is at rest and nothing can begin any more, all is stored, and the answer is on its
    /// way to the host.
    ///
    /// # Cancellation
    /// Safe: what was asked for meanwhile is known to the next call.
    pub async fn boot_asked(&self) {
        self.boot.wait().await;
    }

    /// Brings about the same without being asked, whatever goes on: brakes, as a reset does, and waits until what has changed
    /// is stored.
    ///
    /// # Cancellation
    /// It brakes from the first poll on, and only what a line had begun by then may follow. Before the end something may
    /// move, and what has changed may not be stored.
    pub async fn retire(&self) {
        self.machine.reset();
        self.leave();
        self.woken.signal(());
        self.machine.emptied().await;
        // A line stores what it changes while it has its turn; where a reset has cut one short, the next welcome does.
        while self.turn.try_lock().is_err() || self.with(|program| program.unsaved.any()) {
            Timer::after_millis(1).await;
        }
        // The line that had its turn may have begun a move.
        self.machine.reset();
        self.machine.emptied().await;
    }

    /// `$BOOT` has been answered.
    pub(crate) fn boot(&self) {
        self.leave();
        self.boot.signal(());
    }

    /// Takes no line any more that moves or changes anything.
    fn leave(&self) {
        self.with(|program| program.mode = Mode::Left);
    }
}
