//! The jogs that wait as lines and are not to be made.
//!
//! A host that jogs while a key is held down has lines on their way when the key is let go. The cancel overtakes them,
//! as a real-time byte does; but they were sent before it, and must not move the machine after it. A jog that comes in a
//! hold is refused, but its line may wait behind M0 or M6 until the resume: it must not move the machine after it either.

use core::cell::Cell;

/// Counts the bytes that wait.
pub(crate) struct Jogs {
    /// The number of bytes taken from the input whose lines have not begun to be carried out.
    in_hand: Cell<usize>,
    /// The number of the bytes that wait and were sent before the last cancel.
    cancelled: Cell<usize>,
    /// The number of them that came before the end of a hold.
    refused: Cell<usize>,
}

/// The fate of a line, if it is a jog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fate {
    /// The machine is asked for it.
    Asked,
    /// It is forgotten, as the jogs that the machine has taken.
    Cancelled,
    /// It is refused, as in a hold.
    Refused,
    /// It is no jog, but a line with M6 that was put back until the tool had been changed.
    SentAgain,
}

impl Jogs {
    pub const fn new() -> Self {
        Self { in_hand: Cell::new(0), cancelled: Cell::new(0), refused: Cell::new(0) }
    }

    /// Says how many bytes have been taken from the input whose lines have not begun to be carried out. Call it before
    /// every wait for the input, and before a line begins to be carried out.
    pub fn hold(&self, bytes: usize) {
        self.in_hand.set(bytes);
    }

    /// A cancel has come; so many bytes wait in the input.
    pub fn cancel(&self, waiting: usize) {
        self.cancelled.set(self.in_hand.get() + waiting);
    }

    /// The machine is held, or was; so many bytes wait in the input that came before the end of the hold.
    pub fn refuse(&self, waiting: usize) {
        self.refused.set(self.in_hand.get() + waiting);
    }

    /// The fate of the next line, of so many bytes, which begins to be carried out. Call it once for every line.
    pub fn fate(&self, line_bytes: usize) -> Fate {
        self.in_hand.set(self.in_hand.get().saturating_sub(line_bytes));
        match [&self.cancelled, &self.refused].map(|count| is_within(count, line_bytes)) {
            [_, true] => Fate::Refused,
            [true, false] => Fate::Cancelled,
            [false, false] => Fate::Asked,
        }
    }

    /// Nothing waits any more.
    pub fn forget(&self) {
        self.in_hand.set(0);
        self.cancelled.set(0);
        self.refused.set(0);
    }
}

/// Takes a line off the bytes that are counted. Returns whether all of it was among them.
fn is_within(count: &Cell<usize>, line_bytes: usize) -> bool {
    let left = count.get().checked_sub(line_bytes);
    count.set(left.unwrap_or(0));
    left.is_some()
}

#[cfg(test)]
mod tests {
    use super::Fate::{Asked, Cancelled, Refused};
    use super::*;

    #[test]
    fn lines_that_wait_are_overtaken_and_later_ones_are_not() {
        let jogs = Jogs::new();
        assert_eq!(jogs.fate(10), Asked);
        // Two lines of 10 bytes in hand, one and a half in the input: the rest of the last one came after the cancel.
        jogs.hold(20);
        jogs.cancel(15);
        assert_eq!([10, 10, 10, 10].map(|bytes| jogs.fate(bytes)), [Cancelled, Cancelled, Cancelled, Asked]);
        assert_eq!(jogs.fate(1), Asked, "what is left of a count is not that of a later line");
        jogs.hold(0);
        jogs.cancel(5);
        jogs.refuse(5);
        jogs.forget();
        assert_eq!(jogs.fate(5), Asked);
    }

    #[test]
    fn a_count_begins_again_with_each_byte_that_counts() {
        let jogs = Jogs::new();
        jogs.hold(10);
        jogs.cancel(20);
        assert_eq!(jogs.fate(10), Cancelled);
        // Of what was in hand nothing is left, and 10 bytes wait in the input: they count once.
        jogs.cancel(10);
        assert_eq!([10, 10].map(|bytes| jogs.fate(bytes)), [Cancelled, Asked]);
        jogs.cancel(20);
        jogs.refuse(10);
        assert_eq!([10, 10, 10].map(|bytes| jogs.fate(bytes)), [Refused, Cancelled, Asked]);
    }
}
