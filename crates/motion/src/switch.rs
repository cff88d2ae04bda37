//! A limit switch, debounced, and the contacts of the emergency stop and of drives' alarms.

use core::future::poll_fn;
use core::pin::pin;
use core::sync::atomic::{AtomicBool, Ordering};
use core::task::{Context, Poll};

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;

/// A contact to ground, with a pull-up at the input: the emergency stop, which is a property of the board's wiring, so no
/// configuration changes it; or the alarm of a drive, which is pressed in an alarm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Contact {
    /// Closed while it is pressed. A broken wire disables it.
    #[default]
    NormallyOpen,
    /// Open while it is pressed. A broken wire is a press.
    NormallyClosed,
}

impl Contact {
    /// True if the input is low while it is pressed.
    #[must_use]
    pub const fn pressed_is_low(self) -> bool {
        matches!(self, Self::NormallyOpen)
    }
}

/// A limit input, debounced.
pub(crate) struct Switch {
    pressed: AtomicBool,
    /// It has opened or closed, and is not debounced yet.
    is_unsettled: AtomicBool,
    changed: Signal<CriticalSectionRawMutex, ()>,
    /// Another level of its input means pressed now, or may.
    reread: Signal<CriticalSectionRawMutex, ()>,
}

impl Switch {
    /// A switch that is not pressed.
    pub const fn new() -> Self {
        Self {
            pressed: AtomicBool::new(false),
            is_unsettled: AtomicBool::new(false),
            changed: Signal::new(),
            reread: Signal::new(),
        }
    }

    pub fn is_pressed(&self) -> bool {
        self.pressed.load(Ordering::Relaxed)
    }

    /// True if it is pressed, or may be: its first edge has come, and is not debounced yet.
    pub fn may_be_pressed(&self) -> bool {
        self.is_pressed() || self.is_unsettled()
    }

    fn is_unsettled(&self) -> bool {
        self.is_unsettled.load(Ordering::Relaxed)
    }

    /// Notes an edge.
    pub fn touch(&self) {
        self.is_unsettled.store(true, Ordering::Relaxed);
        self.changed.signal(());
    }

    /// Sets its debounced level.
    pub fn publish(&self, pressed: bool) {
        self.pressed.store(pressed, Ordering::Relaxed);
        self.is_unsettled.store(false, Ordering::Relaxed);
        self.changed.signal(());
    }

    /// Has its task read the input anew. Not inlined: see below.
    #[inline(never)]
    pub fn reread(&self) {
        self.reread.signal(());
    }

    /// Waits until the input is to be read anew. Only its task may wait.
    pub async fn wait_reread(&self) {
        self.reread.wait().await;
    }

    /// Waits until it is pressed, or may be. Only the coordinator may wait: the signal has room for one waiter.
    pub async fn wait_touched(&self) {
        while !self.may_be_pressed() {
            poll_fn(|context| self.poll_changed(context)).await;
        }
    }

    /// Waits until its level is debounced. Only the coordinator may wait.
    pub async fn wait_settled(&self) {
        while self.is_unsettled() {
            poll_fn(|context| self.poll_changed(context)).await;
        }
    }

    /// Not inlined: on a chip homing and settings are in slow memory, and no critical section may be.
    #[inline(never)]
    fn poll_changed(&self, context: &mut Context<'_>) -> Poll<()> {
        pin!(self.changed.wait()).poll(context)
    }
}
