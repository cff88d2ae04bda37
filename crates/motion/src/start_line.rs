//! How the axes of a run start together, and never late.
//!
//! # Design
//! A port gets ready in its own time: it takes its first steps, if there are any, and sees to DIR's set-up time before them,
//! and then waits here. Only when all ports of the run wait is the start instant chosen, by the ports themselves, so nothing that has still to
//! be done can make it late.
//!
//! ```text
//! coordinator --run--> axis task: port gets ready
//!             <-------- armed
//!             --go----> all at once; the first opens the gate of all
//!             <-------- begun: the instant from which segments count
//! ```

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::Instant;

/// An axis's place at the start line: between its port and whoever starts the run.
#[derive(Default)]
pub struct StartLine {
    armed: Signal<CriticalSectionRawMutex, ()>,
    go: Signal<CriticalSectionRawMutex, ()>,
    begun: Signal<CriticalSectionRawMutex, Instant>,
}

/// For ports.
impl StartLine {
    /// Says that the port is ready to make its first step at any moment, and waits to be let go with the other axes.
    ///
    /// # Cancellation
    /// Safe: the run does not start.
    pub async fn armed(&self) {
        self.armed.signal(());
        self.go.wait().await;
    }

    /// Says from which instant the segments of the run count. Ports that start at one gate say the same.
    pub fn begun(&self, at: Instant) {
        self.begun.signal(at);
    }
}

/// For whoever starts a run.
impl StartLine {
    /// Nobody waits.
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
    /// Safe: a port that has armed meanwhile is known to the next call.
    pub async fn wait_armed(&self) {
        self.armed.wait().await;
    }

    /// Lets the port go: now, as nothing is left to be done.
    pub fn go(&self) {
        self.go.signal(());
    }

    /// Waits until the run has begun: the instant from which its segments count.
    ///
    /// # Cancellation
    /// Safe: an instant told meanwhile is known to the next call.
    pub async fn wait_begun(&self) -> Instant {
        self.begun.wait().await
    }
}
