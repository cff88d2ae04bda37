//! The inputs that have changed, and their levels, so that no change is lost. It uses nothing of the chip, so that a test
//! on the host can change the inputs between any two accesses (`tests/tests/registers.rs`).

use core::sync::atomic::{AtomicU32, Ordering};

/// The levels of inputs after each change, in order. While there are some, the interrupt is requested.
pub trait Changes {
    /// True if there are some.
    fn are_there(&mut self) -> bool;
    /// Takes the first.
    fn take(&mut self) -> u32;
}

/// The inputs that have changed, and the levels that came with the change, if there is one. `reported` holds the levels
/// that were reported last, and only the handler changes it. One change is taken at a time: the interrupt comes again for
/// the next, after others of its priority.
#[inline(always)]
pub fn take(changes: &mut impl Changes, reported: &AtomicU32) -> Option<(u32, u32)> {
    if !changes.are_there() {
        return None;
    }
    let levels = changes.take();
    let changed = levels ^ reported.load(Ordering::Relaxed);
    reported.store(levels, Ordering::Relaxed);
    Some((changed, levels))
}
