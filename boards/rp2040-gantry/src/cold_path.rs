//! The cold path: futures without a deadline, whose code `memory.x` leaves in flash.

use core::future::{Future, poll_fn};
use core::pin::Pin;
use core::task::{Context, Poll};

/// Carries out a future without a deadline. Pin it first: here it takes room in the task once.
pub async fn cold_path<F: Future>(mut future: Pin<&mut F>) -> F::Output {
    poll_fn(|context| poll(future.as_mut(), context)).await
}

/// It is a function of its own, with a name by which `memory.x` finds it.
#[inline(never)]
fn poll<F: Future>(future: Pin<&mut F>, context: &mut Context<'_>) -> Poll<F::Output> {
    future.poll(context)
}
