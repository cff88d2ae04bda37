//! The bytes of a console's lines that wait to be carried out.
//!
//! While a tool is changed in the middle of a program, the lines behind M6 have to wait, but a person wants to jog. So a sender that
//! knows of this says (0xA3) that what comes behind it is by hand: what waits then stays where it is, as the first bytes, and is
//! read when the change is over.

use core::cell::{Cell, RefCell};

use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;
use isostep_console::{LineAssembler, MAX_LINE_CHARS};

/// Four times the window that is advertised to senders.
const INPUT_BYTES: usize = 512;
/// With room for a line that is put back.
const ROOM_BYTES: usize = INPUT_BYTES + MAX_LINE_CHARS + 1;

/// Bytes in the order in which they have come, of one writer and one reader.
pub(crate) struct Input {
    waiting: RefCell<Waiting>,
    gate: Cell<Gate>,
    /// The next line that is read is one that was put back.
    sends_again: Cell<bool>,
    /// The last line that was read is.
    is_sent_again: Cell<bool>,
    filled: Signal<NoopRawMutex, ()>,
    drained: Signal<NoopRawMutex, ()>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Gate {
    /// All are read.
    Open,
    /// None are.
    Shut,
    /// Those behind so many are.
    Behind(usize),
}

struct Waiting {
    bytes: [u8; ROOM_BYTES],
    first: usize,
    end: usize,
}

impl Input {
    pub const fn new() -> Self {
        Self {
            waiting: RefCell::new(Waiting { bytes: [0; ROOM_BYTES], first: 0, end: 0 }),
            gate: Cell::new(Gate::Open),
            sends_again: Cell::new(false),
            is_sent_again: Cell::new(false),
            filled: Signal::new(),
            drained: Signal::new(),
        }
    }

    /// The number of bytes that wait.
    pub fn len(&self) -> usize {
        self.waiting.borrow().len()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub fn free_bytes(&self) -> usize {
        INPUT_BYTES.saturating_sub(self.len())
    }

    /// Forgets all, and reads what comes next.
    pub fn clear(&self) {
        let mut waiting = self.waiting.borrow_mut();
        (waiting.first, waiting.end) = (0, 0);
        self.gate.set(Gate::Open);
        self.sends_again.set(false);
        self.drained.signal(());
    }

    /// Takes all these bytes, if there is room for them.
    pub fn take(&self, bytes: &[u8]) -> bool {
        let has_room = bytes.len() <= self.free_bytes();
        if has_room {
            self.waiting.borrow_mut().push(bytes);
            self.filled.signal(());
        }
        has_room
    }

    /// Takes as many bytes as there is room for, one at least. Returns how many.
    ///
    /// # Cancellation
    /// Safe: no byte is taken then.
    pub async fn write(&self, bytes: &[u8]) -> usize {
        while self.free_bytes() == 0 {
            self.drained.wait().await;
        }
        let count = bytes.len().min(self.free_bytes());
        self.take(&bytes[..count]);
        count
    }

    /// Reads the next line, and adds the number of its bytes to `length`.
    ///
    /// # Cancellation
    /// Safe: what has been read of a line is in `assembler`, and counted.
    pub async fn read_line(&self, assembler: &mut LineAssembler, length: &mut usize) {
        while !self.take_line(assembler, length) {
            self.filled.wait().await;
        }
    }

    fn take_line(&self, assembler: &mut LineAssembler, length: &mut usize) -> bool {
        let behind = match self.gate.get() {
            Gate::Open => 0,
            Gate::Behind(count) => count,
            Gate::Shut => return false,
        };
        let mut waiting = self.waiting.borrow_mut();
        let mut left = &waiting.bytes[waiting.first + behind..waiting.end];
        if left.is_empty() {
            return false;
        }
        let is_sent_again = self.sends_again.take();
        if is_sent_again {
            // What has been typed of a line by hand is no beginning of the program's.
            assembler.reset();
            *length = 0;
        }
        self.is_sent_again.set(is_sent_again);
        let before = left.len();
        let is_whole = assembler.end(&mut left);
        let count = before - left.len();
        waiting.remove(behind, count);
        *length += count;
        self.drained.signal(());
        is_whole
    }

    /// Puts a line back before all that waits, and reads nothing before [`open`](Self::open).
    #[cold]
    #[inline(never)]
    pub fn put_back(&self, line: &str) {
        self.waiting.borrow_mut().push_front(line.as_bytes());
        self.gate.set(Gate::Shut);
    }

    /// Reads what comes from now on, if it was shut.
    #[cold]
    #[inline(never)]
    pub fn read_behind(&self) {
        if self.gate.get() == Gate::Shut {
            self.gate.set(Gate::Behind(self.len()));
        }
    }

    /// Reads all from now on, beginning with the line that was put back.
    #[cold]
    #[inline(never)]
    pub fn open(&self) {
        self.gate.set(Gate::Open);
        self.sends_again.set(true);
        self.filled.signal(());
    }

    /// True if the last line that was read is one that was put back.
    pub fn is_sent_again(&self) -> bool {
        self.is_sent_again.get()
    }

    /// True if a line was put back and has not been read.
    pub fn waits_behind_line(&self) -> bool {
        self.gate.get() != Gate::Open
    }
}

impl Waiting {
    fn len(&self) -> usize {
        self.end - self.first
    }

    /// Adds bytes for which there is room.
    fn push(&mut self, bytes: &[u8]) {
        if self.end + bytes.len() > ROOM_BYTES {
            self.move_to(0);
        }
        self.bytes[self.end..][..bytes.len()].copy_from_slice(bytes);
        self.end += bytes.len();
    }

    /// Adds a line, with its end, before the others.
    fn push_front(&mut self, line: &[u8]) {
        if self.first <= line.len() {
            self.move_to(line.len() + 1);
        }
        self.first -= line.len() + 1;
        self.bytes[self.first..][..line.len()].copy_from_slice(line);
        self.bytes[self.first + line.len()] = b'\n';
    }

    fn move_to(&mut self, first: usize) {
        self.bytes.copy_within(self.first..self.end, first);
        (self.first, self.end) = (first, first + self.len());
    }

    /// Removes `count` bytes behind the first ones.
    fn remove(&mut self, behind: usize, count: usize) {
        if behind > 0 {
            let from = self.first + behind;
            self.bytes.copy_within(from + count..self.end, from);
            self.end -= count;
        } else {
            self.first += count;
            if self.first == self.end {
                (self.first, self.end) = (0, 0);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use core::pin::pin;

    use embassy_futures::{block_on, poll_once};

    use super::*;

    /// The lines that are read now.
    fn lines(input: &Input, assembler: &mut LineAssembler) -> std::vec::Vec<std::string::String> {
        let mut lines = std::vec::Vec::new();
        while input.take_line(assembler, &mut 0) {
            lines.push(assembler.line().unwrap().into());
        }
        lines
    }

    fn write(input: &Input, text: &str) {
        assert_eq!(block_on(input.write(text.as_bytes())), text.len());
    }

    #[test]
    fn lines_come_in_their_order_however_they_are_cut() {
        let (input, mut assembler, mut length) = (Input::new(), LineAssembler::new(), 0);
        write(&input, "G1 X1\nG1 ");
        assert_eq!(lines(&input, &mut assembler), ["G1X1"]);
        assert!(input.is_empty(), "a part of a line has been read, too");
        write(&input, "X2\nX3\n");
        assert!(input.take_line(&mut assembler, &mut length) && assembler.line() == Ok("G1X2") && length == 3);
        assert_eq!((input.len(), input.free_bytes()), (3, INPUT_BYTES - 3));
        assert_eq!(lines(&input, &mut assembler), ["X3"]);
    }

    #[test]
    fn a_writer_waits_for_room_and_a_reader_for_a_line() {
        let (input, mut assembler, mut length) = (Input::new(), LineAssembler::new(), 0);
        let line = "G1X123.4567\n";
        for _ in 0..INPUT_BYTES / line.len() {
            write(&input, line);
        }
        let free = input.free_bytes();
        assert_eq!(block_on(input.write(line.as_bytes())), free, "as much as there is room for");
        {
            let mut late = pin!(input.write(&line.as_bytes()[free..]));
            assert!(poll_once(late.as_mut()).is_pending());
            assert!(input.take_line(&mut assembler, &mut length));
            assert_eq!(poll_once(late), core::task::Poll::Ready(line.len() - free));
        }
        assert_eq!(lines(&input, &mut assembler).len(), INPUT_BYTES / line.len());
        let mut reader = pin!(input.read_line(&mut assembler, &mut length));
        assert!(poll_once(reader.as_mut()).is_pending());
        write(&input, "G4 P0\n");
        assert!(poll_once(reader).is_ready());
    }

    #[test]
    fn lines_behind_one_that_is_put_back_wait_and_those_by_hand_do_not() {
        let (input, mut assembler) = (Input::new(), LineAssembler::new());
        write(&input, "M6T2\nG43H2\nG0 ");
        assert!(input.take_line(&mut assembler, &mut 0));
        input.put_back("M6T2");
        assert_eq!((lines(&input, &mut assembler).len(), input.waits_behind_line()), (0, true));
        write(&input, "X5\n");
        assert_eq!(lines(&input, &mut assembler).len(), 0, "they may be the program's");
        input.read_behind();
        write(&input, "$J=X1F1\n$TP");
        assert_eq!(lines(&input, &mut assembler), ["$J=X1F1"]);
        write(&input, "W\n$J=X");
        assert!(input.take_line(&mut assembler, &mut 0) && assembler.line() == Ok("$TPW") && !input.is_sent_again());
        assert_eq!(lines(&input, &mut assembler).len(), 0, "half a line by hand has been read");
        input.open();
        let mut length = 5;
        assert!(input.take_line(&mut assembler, &mut length) && assembler.line() == Ok("M6T2"));
        assert_eq!((input.is_sent_again(), length), (true, 5));
        assert_eq!(lines(&input, &mut assembler), ["G43H2", "G0X5"]);
        assert!(!input.is_sent_again());
        assert!(!input.waits_behind_line() && input.is_empty());
    }

    #[test]
    fn a_line_is_put_back_however_full_it_is_and_forgotten_with_the_others() {
        let (input, mut assembler) = (Input::new(), LineAssembler::new());
        let longest = "M6(".to_owned() + &"-".repeat(INPUT_BYTES - 5) + ")\n";
        write(&input, &longest);
        assert!(input.take_line(&mut assembler, &mut 0));
        for _ in 0..INPUT_BYTES / 2 {
            write(&input, "\n\n");
        }
        let line = "M6".to_owned() + &"G".repeat(MAX_LINE_CHARS - 2);
        input.put_back(&line);
        assert_eq!((input.len(), input.free_bytes()), (ROOM_BYTES, 0));
        input.open();
        assert_eq!(lines(&input, &mut assembler)[0], line);
        input.put_back("M6");
        input.clear();
        write(&input, "G0\n");
        assert_eq!(lines(&input, &mut assembler), ["G0"]);
    }

    use std::borrow::ToOwned;
}
