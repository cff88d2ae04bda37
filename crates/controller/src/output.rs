//! The output of a console, in whole messages.

use core::cell::Cell;
use core::fmt::{self, Display};
use core::ops::Deref;

use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_sync::pipe::Pipe;
use embassy_sync::signal::Signal;
use heapless::String;
use isostep_console::{Error, report};

/// Two of the longest messages: one that is being sent, and the next.
const BYTES: usize = 2 * MESSAGE_BYTES;
/// The longest message: a `[MSG:...]` with a refused setting's value, limit and remedy.
const MESSAGE_BYTES: usize = 256;

/// Lines that are sent together. Text that does not fit is cut off: that is better than nothing, and no message of ours
/// is so long.
pub(crate) struct Message(String<MESSAGE_BYTES>);

impl Message {
    pub const fn new() -> Self {
        Self(String::new())
    }

    pub fn clear(&mut self) {
        self.0.clear();
    }

    // Inlined, so that what is printed stands with its command, and not with what every line passes through.
    #[inline(always)]
    pub fn print<E>(&mut self, print: impl FnOnce(&mut String<MESSAGE_BYTES>) -> Result<(), E>) {
        let _ = print(&mut self.0);
    }

    /// `[MSG:...]`.
    pub fn say(&mut self, words: impl Display) {
        let _ = report::message(&mut self.0, words);
    }

    /// `ok`, or `error:N`.
    pub fn answer(&mut self, answer: Result<(), Error>) {
        let _ = report::answer(&mut self.0, answer);
    }
}

impl Deref for Message {
    type Target = str;

    fn deref(&self) -> &str {
        &self.0
    }
}

/// The bytes that wait to be sent to one console.
pub(crate) struct Output {
    pipe: Pipe<NoopRawMutex, BYTES>,
    turn: Mutex<NoopRawMutex, ()>,
    /// Some bytes have been taken, or have left.
    drained: Signal<NoopRawMutex, ()>,
    /// The bytes that were taken last have not left yet.
    leaving: Cell<bool>,
}

impl Output {
    pub const fn new() -> Self {
        Self { pipe: Pipe::new(), turn: Mutex::new(()), drained: Signal::new(), leaving: Cell::new(false) }
    }

    /// Sends one message, waiting for room. It is never mixed with another.
    ///
    /// # Cancellation
    /// Safe: the message is sent whole or not at all. A reset cuts no message short.
    pub async fn send(&self, message: &Message) {
        let _turn = self.turn.lock().await;
        self.has_room(message.len()).await;
        self.put(message);
    }

    /// Sends one message like [`send`](Self::send). It is written when there is room for the longest, so it takes no memory
    /// while it waits.
    pub async fn send_written(&self, write: impl FnOnce(&mut Message)) {
        let _turn = self.turn.lock().await;
        self.has_room(MESSAGE_BYTES).await;
        let mut message = Message::new();
        write(&mut message);
        self.put(&message);
    }

    async fn has_room(&self, bytes: usize) {
        while self.pipe.free_capacity() < bytes {
            self.drained.wait().await;
        }
    }

    /// Sends one message if there is room at once; otherwise it is dropped, because a late status report is worth
    /// nothing.
    pub fn offer(&self, write: impl FnOnce(&mut String<MESSAGE_BYTES>) -> fmt::Result) {
        let mut message = String::new();
        if write(&mut message).is_err() || self.pipe.free_capacity() < message.len() {
            return;
        }
        if let Ok(_turn) = self.turn.try_lock() {
            self.put(&message);
        }
    }

    /// Puts a message into the pipe, which has room for all of it but takes it in two parts where its ring ends.
    fn put(&self, message: &str) {
        let mut left = message.as_bytes();
        while let Ok(written @ 1..) = self.pipe.try_write(left) {
            left = &left[written..];
        }
    }

    /// Waits until all messages have left for the host.
    ///
    /// # Cancellation
    /// Safe: it changes nothing.
    pub async fn emptied(&self) {
        let _turn = self.turn.lock().await;
        while !self.pipe.is_empty() || self.leaving.get() {
            self.drained.wait().await;
        }
    }

    /// Takes the next bytes that are to leave. The next call says that they have left.
    pub async fn read(&self, bytes: &mut [u8]) -> usize {
        self.leaving.set(false);
        self.drained.signal(());
        let count = self.pipe.read(bytes).await;
        self.leaving.set(true);
        self.drained.signal(());
        count
    }

    /// Takes more bytes that are to leave with the last ones, if there are any.
    pub fn read_more(&self, bytes: &mut [u8]) -> usize {
        self.pipe.try_read(bytes).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use embassy_futures::{block_on, poll_once};

    use super::*;

    fn message(text: &str) -> Message {
        let mut message = Message::new();
        message.print(|to| to.push_str(text));
        message
    }

    /// All that waits to be sent.
    fn drained(output: &Output) -> usize {
        let (mut bytes, mut count) = ([0; BYTES], 0);
        while let core::task::Poll::Ready(more) = poll_once(output.read(&mut bytes)) {
            count += more;
        }
        count
    }

    #[test]
    fn a_report_without_room_is_dropped_whole() {
        let output = Output::new();
        let line = [b'-'; 200];
        let line = core::str::from_utf8(&line).unwrap();
        for _ in 0..BYTES / line.len() {
            block_on(output.send(&message(line)));
        }
        let report = |length: usize| output.offer(move |to| to.push_str(&line[..length]).map_err(|_| fmt::Error));
        let left = BYTES % line.len();
        report(left + 1);
        report(left - 1);
        assert_eq!(drained(&output), BYTES - 1, "only the one that fits");
    }

    #[test]
    fn a_message_waits_for_room() {
        let output = Output::new();
        let line = [b'-'; MESSAGE_BYTES];
        let line = message(core::str::from_utf8(&line).unwrap());
        // They fit to the byte.
        for _ in 0..BYTES / MESSAGE_BYTES {
            block_on(output.send(&line));
        }
        let mut more = core::pin::pin!(output.send(&line));
        assert!(poll_once(more.as_mut()).is_pending());
        assert_eq!(drained(&output), BYTES);
        assert!(poll_once(more).is_ready());
        assert_eq!(drained(&output), MESSAGE_BYTES);
    }

    #[test]
    fn a_message_is_written_when_there_is_room_for_the_longest() {
        let output = Output::new();
        // One byte is missing.
        for _ in 0..=BYTES - MESSAGE_BYTES {
            block_on(output.send(&message("-")));
        }
        let words = Cell::new("early");
        let mut late = core::pin::pin!(output.send_written(|text| text.print(|to| to.push_str(words.get()))));
        assert!(poll_once(late.as_mut()).is_pending());
        words.set("as it is now");
        assert_eq!(drained(&output), BYTES - MESSAGE_BYTES + 1);
        assert!(poll_once(late).is_ready());
        assert_eq!(drained(&output), words.get().len());
    }
}
