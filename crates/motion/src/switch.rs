//! A limit switch, debounced.

use core::sync::atomic::{AtomicBool, Ordering};

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;

/// A limit switch, debounced.
pub(crate) struct Switch {
    pressed: AtomicBool,
    changed: Signal<CriticalSectionRawMutex, ()>,
}

impl Switch {
    /// Not pressed.
    pub const fn new() -> Self {
        Self { pressed: AtomicBool::new(false), changed: Signal::new() }
    }

    pub fn is_pressed(&self) -> bool {
        self.pressed.load(Ordering::Relaxed)
    }

    pub fn publish(&self, pressed: bool) {
        self.pressed.store(pressed, Ordering::Relaxed);
        self.changed.signal(());
    }

    /// Waits until it is pressed. Only the coordinator waits.
    pub async fn wait_pressed(&self) {
        while !self.is_pressed() {
            self.changed.wait().await;
        }
    }
}
