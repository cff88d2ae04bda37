//! Which jogs were sent before a jog cancel.
//!
//! A host that jogs while a key is held down has lines on their way when the key is let go. The cancel overtakes them,
//! as a real-time byte does; but they were sent before it, and must not move the machine after it.

use core::cell::Cell;

/// Counts the bytes that wait.
pub(crate) struct JogCancel {
    /// How many bytes have been taken from the input whose lines have not begun to be carried out.
    in_hand: Cell<usize>,
    /// How many of the bytes that wait were sent before the last cancel.
    overtaken: Cell<usize>,
}

impl JogCancel {
    pub const fn new() -> Self {
        Self { in_hand: Cell::new(0), overtaken: Cell::new(0) }
    }

    /// Says how many bytes have been taken from the input whose lines have not begun to be carried out. Call it before
    /// every wait for the input, and when a line begins to be carried out.
    pub fn hold(&self, bytes: usize) {
        self.in_hand.set(bytes);
    }

    /// The cancel has come; so many bytes wait in the input.
    pub fn come(&self, waiting: usize) {
        self.overtaken.set(self.in_hand.get() + waiting);
    }

    /// Whether the next line, of so many bytes, was sent before the last cancel. Call it once for every line.
    pub fn has_overtaken(&self, line_bytes: usize) -> bool {
        let left = self.overtaken.get().checked_sub(line_bytes);
        self.overtaken.set(left.unwrap_or(0));
        left.is_some()
    }

    /// Nothing waits any more.
    pub fn forget(&self) {
        self.in_hand.set(0);
        self.overtaken.set(0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_that_wait_are_overtaken_and_later_ones_are_not() {
        let cancel = JogCancel::new();
        assert!(!cancel.has_overtaken(10));
        // Two lines of 10 bytes in hand, one and a half in the input: the rest of the last one came after the cancel.
        cancel.hold(20);
        cancel.come(15);
        assert_eq!([10, 10, 10, 10].map(|bytes| cancel.has_overtaken(bytes)), [true, true, true, false]);
        assert!(!cancel.has_overtaken(1), "what is left of a count is not that of a later line");
        cancel.hold(0);
        cancel.come(5);
        cancel.forget();
        assert!(!cancel.has_overtaken(5));
    }
}
