//! A byte link in memory: what USB or a UART is to a board.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::future::poll_fn;
use std::rc::Rc;
use std::task::{Poll, Waker};

use embedded_io_async::{ErrorType, Read, Write};

/// Bytes one way, unbounded: flow control is the sender's affair, as with a real console.
#[derive(Clone, Default)]
pub struct Pipe(Rc<RefCell<State>>);

#[derive(Default)]
struct State {
    bytes: VecDeque<u8>,
    reader: Option<Waker>,
}

impl Pipe {
    /// Empty.
    pub fn new() -> Self {
        Self::default()
    }

    /// Appends bytes and wakes the reader.
    pub fn push(&self, bytes: &[u8]) {
        let mut state = self.0.borrow_mut();
        state.bytes.extend(bytes);
        state.reader.take().into_iter().for_each(Waker::wake);
    }

    /// Takes what is there.
    pub fn take(&self) -> Vec<u8> {
        self.0.borrow_mut().bytes.drain(..).collect()
    }

    /// Whether everything was read.
    pub fn is_empty(&self) -> bool {
        self.0.borrow().bytes.is_empty()
    }
}

impl ErrorType for Pipe {
    type Error = Infallible;
}

impl Read for Pipe {
    /// # Cancellation
    /// Safe: no byte is lost.
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        poll_fn(|context| {
            let mut state = self.0.borrow_mut();
            if state.bytes.is_empty() && !buffer.is_empty() {
                state.reader = Some(context.waker().clone());
                return Poll::Pending;
            }
            let count = buffer.len().min(state.bytes.len());
            for (slot, byte) in buffer.iter_mut().zip(state.bytes.drain(..count)) {
                *slot = byte;
            }
            Poll::Ready(Ok(count))
        })
        .await
    }
}

impl Write for Pipe {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        self.push(bytes);
        Ok(bytes.len())
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// Cuts a stream of bytes into lines.
#[derive(Debug, Default)]
pub struct Lines(Vec<u8>);

impl Lines {
    /// Adds bytes; returns the lines they complete, without line ends and without empty ones.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<String> {
        self.0.extend(bytes);
        let Some(end) = self.0.iter().rposition(|&byte| byte == b'\n') else { return Vec::new() };
        let rest = self.0.split_off(end + 1);
        let whole = std::mem::replace(&mut self.0, rest);
        String::from_utf8_lossy(&whole).split(['\r', '\n']).filter(|line| !line.is_empty()).map(str::to_owned).collect()
    }
}

#[cfg(test)]
mod tests {
    use embassy_time::Instant;

    use super::*;
    use crate::executor::Executor;

    #[test]
    fn bytes_cross_in_order_and_wake_the_reader() {
        let mut executor = Executor::new();
        let (there, back) = (Pipe::new(), Pipe::new());
        let (mut rx, mut tx) = (there.clone(), back.clone());
        executor.spawn("echo", async move {
            let mut buffer = [0; 4];
            loop {
                let Ok(count) = rx.read(&mut buffer).await;
                let Ok(()) = tx.write_all(&buffer[..count]).await;
            }
        });
        for text in ["one", "seventeen"] {
            there.push(text.as_bytes());
            executor.run_until_quiescent(Instant::from_secs(1)).unwrap();
            assert_eq!(back.take(), text.as_bytes());
        }
        assert!(there.is_empty());
    }

    #[test]
    fn lines_wait_for_their_end() {
        let mut lines = Lines::default();
        assert_eq!(lines.push(b"\r\nGrbl 1.1h\r\no"), ["Grbl 1.1h"]);
        assert_eq!(lines.push(b"k"), [""; 0]);
        assert_eq!(lines.push(b"\r\nerror:1\r\n"), ["ok", "error:1"]);
    }
}
