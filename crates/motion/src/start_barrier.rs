//! The start of a run: all axes together, and never late.
//!
//! # Design
//! A port gets ready in its own time: it takes its first steps, if there are any, makes sure of DIR's set-up time
//! before them, and then waits here. When all ports of the run wait, they choose the start instant themselves. So
//! nothing that still has to be done can make the start late. They start at the same instant: the coordinator compares what
//! they report.
//!
//! ```text
//! coordinator --run--> axis task: port gets ready
//!             <-------- armed
//!             --go----> all at once, with the present instant; the first opens the barrier of all, if they have one
//!             <-------- begun: the instant from which segments count
//! ```

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::Instant;

/// An axis's place at the start barrier, shared by its port and the task that starts the run.
#[derive(Default)]
pub struct StartBarrier {
    armed: Signal<CriticalSectionRawMutex, ()>,
    go: Signal<CriticalSectionRawMutex, Instant>,
    begun: Signal<CriticalSectionRawMutex, Instant>,
}

/// For ports.
impl StartBarrier {
    /// Reports that the port is ready to make its first step at any moment, and waits until it is let go with the other
    /// axes. Returns when that was: the same instant for all axes of the run.
    ///
    /// Ports without a flag in common start some time after that instant: the same time for all, and long enough for
    /// the task of each to go on.
    ///
    /// # Cancellation
    /// Safe: the run does not start.
    pub async fn armed(&self) -> Instant {
        self.armed.signal(());
        self.go.wait().await
    }

    /// Reports the instant from which the segments of the run count. It is the same for all axes.
    pub fn begun(&self, at: Instant) {
        self.begun.signal(at);
    }
}

/// For the task that starts a run.
impl StartBarrier {
    /// A start barrier at which nobody waits.
    #[must_use]
    pub const fn new() -> Self {
        Self { armed: Signal::new(), go: Signal::new(), begun: Signal::new() }
    }

    /// Forgets an earlier run.
    pub fn reset(&self) {
        self.armed.reset();
        self.go.reset();
        self.begun.reset();
    }

    /// Waits until the port is armed.
    ///
    /// # Cancellation
    /// Safe: if the port arms meanwhile, the next call returns at once.
    pub async fn wait_armed(&self) {
        self.armed.wait().await;
    }

    /// Lets the port go, with those of the other axes, to which the same instant is reported. It starts now, as nothing is
    /// left to be done.
    pub fn go(&self, at: Instant) {
        self.go.signal(at);
    }

    /// Waits until the run has begun. Returns the instant from which its segments count.
    ///
    /// # Cancellation
    /// Safe: the next call returns an instant that was reported meanwhile.
    pub async fn wait_begun(&self) -> Instant {
        self.begun.wait().await
    }
}
