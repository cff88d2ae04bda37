//! The number of resets that have come, and who waits for the next one.

use core::cell::{Cell, RefCell};
use core::future::poll_fn;
use core::task::{Poll, Waker};

use embassy_futures::yield_now;
use embedded_storage_async::nor_flash::NorFlash;
use heapless::Vec;

use crate::controller::Controller;

/// The number of consoles that a reset wakes. Others notice it when something else wakes them, before they go on with a line.
const CONSOLES: usize = 4;

pub(crate) struct Resets {
    count: Cell<u32>,
    waiting: RefCell<Vec<Waker, CONSOLES>>,
}

impl<F: NorFlash> Controller<'_, F> {
    /// Ends the restart that a reset has begun, once nothing moves. Another console may have ended it before.
    ///
    /// # Cancellation
    /// Safe: the next line of any console ends it.
    pub(crate) async fn end_restart(&self) {
        // The machine brakes, or has been stopped; the coordinator has to end that first.
        self.machine.emptied().await;
        // `notify` has to report an alarm before the welcome.
        yield_now().await;
        if self.is_restarting() {
            self.restart_program();
        }
    }
}

impl Resets {
    pub const fn new() -> Self {
        Self { count: Cell::new(0), waiting: RefCell::new(Vec::new()) }
    }

    /// The number of those that have come since power-up.
    pub fn count(&self) -> u32 {
        self.count.get()
    }

    /// One has come.
    pub fn come(&self) {
        self.count.set(self.count().wrapping_add(1));
        core::mem::take(&mut *self.waiting.borrow_mut()).into_iter().for_each(Waker::wake);
    }

    /// Waits until more have come than `known`. It is ready at the first poll after that, whatever the poll is for.
    ///
    /// # Cancellation
    /// Safe: it changes nothing.
    pub async fn after(&self, known: u32) {
        poll_fn(|context| {
            if self.count() != known {
                return Poll::Ready(());
            }
            let mut waiting = self.waiting.borrow_mut();
            if !waiting.iter().any(|waker| waker.will_wake(context.waker())) {
                let _ = waiting.push(context.waker().clone());
            }
            Poll::Pending
        })
        .await;
    }
}

#[cfg(test)]
mod tests {
    use core::pin::pin;

    use embassy_futures::poll_once;

    use super::*;

    #[test]
    fn whoever_waits_hears_of_one_that_came_since() {
        let resets = Resets::new();
        let mut waiting = pin!(resets.after(resets.count()));
        assert!(poll_once(waiting.as_mut()).is_pending());
        resets.come();
        assert!(poll_once(waiting).is_ready());
        assert!(poll_once(pin!(resets.after(resets.count()))).is_pending());
        assert!(poll_once(pin!(resets.after(0))).is_ready(), "it came before");
    }
}
