//! What a console sends, whole message by whole message.

use core::fmt;

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_sync::pipe::Pipe;
use heapless::String;

const BYTES: usize = 1024;
/// The longest message: a `[MSG:...]` with a refused setting's value, limit and remedy.
const MESSAGE_BYTES: usize = 256;

/// One message, whole.
pub(crate) type Message = String<MESSAGE_BYTES>;

/// What does not fit is cut: better than nothing, and no message of ours is that long.
pub(crate) fn message(write: impl FnOnce(&mut Message) -> fmt::Result) -> Message {
    let mut message = String::new();
    let _ = write(&mut message);
    message
}

/// Bytes on their way to one console.
pub(crate) struct Output {
    pipe: Pipe<CriticalSectionRawMutex, BYTES>,
    turn: Mutex<CriticalSectionRawMutex, ()>,
}

impl Output {
    pub const fn new() -> Self {
        Self { pipe: Pipe::new(), turn: Mutex::new(()) }
    }

    /// Sends one message, waiting for room. It is never mixed with another.
    pub async fn send(&self, message: &str) {
        let _turn = self.turn.lock().await;
        self.pipe.write_all(message.as_bytes()).await;
    }

    /// Sends one message if there is room at once; a status report that is late is worth nothing.
    pub fn offer(&self, write: impl FnOnce(&mut Message) -> fmt::Result) {
        let mut message = String::new();
        if write(&mut message).is_err() || self.pipe.free_capacity() < message.len() {
            return;
        }
        if let Ok(_turn) = self.turn.try_lock() {
            // There is room for all of it, but the pipe takes it in two parts where its ring ends.
            let mut left = message.as_bytes();
            while let Ok(written @ 1..) = self.pipe.try_write(left) {
                left = &left[written..];
            }
        }
    }

    pub async fn read(&self, bytes: &mut [u8]) -> usize {
        self.pipe.read(bytes).await
    }
}
