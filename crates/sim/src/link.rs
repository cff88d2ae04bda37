//! A byte link in memory, which stands for USB or a UART.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::future::poll_fn;
use std::rc::Rc;
use std::task::{Poll, Waker};

use embedded_io_async::{ErrorType, Read, Write};

use crate::time::Clock;

/// Bytes in one direction, unbounded. Flow control is left to the sender, as with a real console.
#[derive(Clone, Default)]
pub struct Pipe(Rc<RefCell<State>>);

#[derive(Default)]
struct State {
    bytes: VecDeque<u8>,
    reader: Option<Waker>,
    /// Nobody takes the written bytes.
    is_stalled: bool,
    writer: Option<Waker>,
}

impl Pipe {
    /// An empty pipe.
    pub fn new() -> Self {
        Self::default()
    }

    /// Stops or resumes taking written bytes. A stalled pipe is a host that does not read, and the pipe has no buffer
    /// for it.
    pub fn stall(&self, is_stalled: bool) {
        let mut state = self.0.borrow_mut();
        state.is_stalled = is_stalled;
        state.writer.take().into_iter().for_each(Waker::wake);
    }

    /// Waits until the pipe is not stalled.
    async fn flowing(&self) {
        poll_fn(|context| {
            let mut state = self.0.borrow_mut();
            if !state.is_stalled {
                return Poll::Ready(());
            }
            state.writer = Some(context.waker().clone());
            Poll::Pending
        })
        .await;
    }

    /// Appends bytes and wakes the reader.
    pub fn push(&self, bytes: &[u8]) {
        let mut state = self.0.borrow_mut();
        state.bytes.extend(bytes);
        state.reader.take().into_iter().for_each(Waker::wake);
    }

    /// Takes all bytes.
    pub fn take(&self) -> Vec<u8> {
        self.0.borrow_mut().bytes.drain(..).collect()
    }

    /// Number of bytes in the pipe.
    pub fn len(&self) -> usize {
        self.0.borrow().bytes.len()
    }

    /// True if all bytes have been read.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Waits until the pipe has bytes.
    async fn filled(&self) {
        poll_fn(|context| {
            let mut state = self.0.borrow_mut();
            if state.bytes.is_empty() {
                state.reader = Some(context.waker().clone());
                return Poll::Pending;
            }
            Poll::Ready(())
        })
        .await;
    }
}

impl ErrorType for Pipe {
    type Error = Infallible;
}

impl Read for Pipe {
    /// # Cancellation
    /// Safe: no byte is lost.
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        if buffer.is_empty() {
            return Ok(0);
        }
        self.filled().await;
        let bytes = &mut self.0.borrow_mut().bytes;
        let count = buffer.len().min(bytes.len());
        for (slot, byte) in buffer.iter_mut().zip(bytes.drain(..count)) {
            *slot = byte;
        }
        Ok(count)
    }
}

impl Write for Pipe {
    /// # Cancellation
    /// Safe: nothing was written.
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        self.flowing().await;
        self.push(bytes);
        Ok(bytes.len())
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// One start bit, eight data bits and one stop bit.
const BITS_PER_BYTE: u64 = 10;

/// A UART's end of one wire. Each byte that is read from the pipe or written to it takes its time on the wire. A byte
/// is sent when it is asked for; a reader that does nothing but read asks at once.
pub(crate) struct Uart {
    pipe: Pipe,
    clock: Clock,
    byte_ns: u64,
    /// When the last byte has left the wire.
    free_ns: u64,
}

impl Uart {
    /// The end of a wire of `baud`, which must not be zero. The pipe is the rest of the wire.
    pub fn new(pipe: Pipe, clock: Clock, baud: u32) -> Self {
        Self { pipe, clock, byte_ns: BITS_PER_BYTE * 1_000_000_000 / u64::from(baud), free_ns: 0 }
    }

    /// Waits until the wire has transferred one more byte, which begins now or when the wire is free.
    async fn carry(&mut self) {
        let at_ns = self.free_ns.max(self.clock.now_ns()) + self.byte_ns;
        self.clock.until(at_ns).await;
        self.free_ns = at_ns;
    }
}

impl ErrorType for Uart {
    type Error = Infallible;
}

impl Read for Uart {
    /// # Cancellation
    /// Safe: no byte is lost; a byte that was on its way is sent again from its start.
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        if buffer.is_empty() {
            return Ok(0);
        }
        self.pipe.filled().await;
        self.carry().await;
        self.pipe.read(&mut buffer[..1]).await
    }
}

impl Write for Uart {
    /// # Cancellation
    /// Safe: a byte on its way was not written.
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        let Some(first) = bytes.get(..1) else { return Ok(0) };
        self.pipe.flowing().await;
        self.carry().await;
        self.pipe.write(first).await
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// Splits a stream of bytes into lines.
#[derive(Debug, Default)]
pub struct Lines(Vec<u8>);

impl Lines {
    /// Adds bytes and returns the lines that they complete, without line ends and without empty lines.
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
    fn a_uart_takes_its_time_for_every_byte_both_ways() {
        let mut executor = Executor::new();
        let (there, back) = (Pipe::new(), Pipe::new());
        let uart = |pipe: &Pipe| Uart::new(pipe.clone(), executor.clock().clone(), 115_200);
        let (mut rx, mut tx) = (uart(&there), uart(&back));
        executor.spawn("reader", async move {
            loop {
                let Ok(_) = rx.read(&mut [0; 8]).await;
            }
        });
        executor.spawn("writer", async move {
            let Ok(()) = tx.write_all(b"yes").await;
        });
        const BYTE_NS: u64 = 86_805;
        executor.run_to(BYTE_NS - 1).unwrap();
        assert_eq!(back.len(), 0);
        executor.run_to(2 * BYTE_NS).unwrap();
        assert_eq!(back.take(), b"ye");
        there.push(b"abc");
        executor.run_to(3 * BYTE_NS).unwrap();
        assert_eq!((there.len(), back.take()), (2, b"s".to_vec()));
        executor.run_to(5 * BYTE_NS).unwrap();
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
