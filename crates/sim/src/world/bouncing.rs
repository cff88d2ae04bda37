//! Switches whose contacts bounce.

use std::future::poll_fn;
use std::task::Poll;

use embassy_futures::select::select;

use super::Shared;

/// The task that makes switches bounce. Never ends.
///
/// # Cancellation
/// Dropping it freezes the contacts in their present state; no axis is affected.
pub async fn bounce(world: Shared) {
    let clock = world.borrow().clock.clone();
    loop {
        let next_flip_ns = world.borrow().next_flip_ns();
        let Some(at_ns) = next_flip_ns else {
            bounce_begins(&world).await;
            continue;
        };
        // A new bounce may come earlier than the awaited one.
        select(clock.until(at_ns), bounce_begins(&world)).await;
        world.borrow_mut().flip();
    }
}

async fn bounce_begins(world: &Shared) {
    let mut asked = false;
    poll_fn(|context| {
        if std::mem::replace(&mut asked, true) && world.borrow().bouncer.is_none() {
            return Poll::Ready(());
        }
        world.borrow_mut().bouncer = Some(context.waker().clone());
        Poll::Pending
    })
    .await;
}
