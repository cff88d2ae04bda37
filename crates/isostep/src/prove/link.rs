//! The wire between this tool and a board, as lines: a serial port, or a machine in virtual time.

use std::io::ErrorKind;

use anyhow::{Context, Result, bail};
use isostep_sim::link::Lines;
use serialport::SerialPort;
use std::collections::VecDeque;

use crate::console::port;
use crate::stopwatch::Stopwatch;

/// Bytes to a board and lines from it, with the time that passes for both.
pub trait Link {
    /// Sends bytes, all of them in one write, so that USB carries short ones in one packet.
    ///
    /// # Errors
    /// When the board is gone.
    fn send(&mut self, bytes: &[u8]) -> Result<()>;

    /// The next line; `None` if there is none within `patience_s`.
    ///
    /// # Errors
    /// When the board is gone.
    fn line(&mut self, patience_s: f64) -> Result<Option<String>>;

    /// Time since the link was opened, s: by the clock of this computer, or of the machine where time is virtual.
    fn now_s(&self) -> f64;
}

/// A board on a serial port, in real time.
pub struct Serial {
    port: Box<dyn SerialPort>,
    lines: Lines,
    heard: VecDeque<String>,
    since: Stopwatch,
}

impl Serial {
    /// Opens the port for this program alone.
    ///
    /// # Errors
    /// When it is not there, or another program has it; the error says what to do.
    pub fn open(name: &str) -> Result<Self> {
        // A USB port has a rate of its own; this one touches no board (1200 would).
        let port = port::open(name, 115_200)?;
        Ok(Self { port, lines: Lines::default(), heard: VecDeque::new(), since: Stopwatch::start() })
    }

    fn read(&mut self) -> Result<()> {
        let mut bytes = [0; 4096];
        match self.port.read(&mut bytes) {
            Ok(0) => bail!("the port was closed at the other end"),
            Ok(count) => self.heard.extend(self.lines.push(&bytes[..count])),
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {}
            Err(error) => return Err(error).context("the port cannot be read"),
        }
        Ok(())
    }
}

impl Link for Serial {
    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.port.write_all(bytes).context("the port does not take what is sent")
    }

    fn line(&mut self, patience_s: f64) -> Result<Option<String>> {
        let waited = Stopwatch::start();
        while self.heard.is_empty() && waited.elapsed_s() < patience_s {
            self.read()?;
        }
        Ok(self.heard.pop_front())
    }

    fn now_s(&self) -> f64 {
        self.since.elapsed_s()
    }
}

#[cfg(unix)]
pub use virtual_time::Virtual;

#[cfg(unix)]
mod virtual_time {
    use std::collections::VecDeque;

    use anyhow::Result;
    use isostep_sim::link::Lines;

    use super::Link;
    use crate::pty::Machine;

    /// Time that the machine runs before its lines are looked for, ns.
    const STRIDE_NS: u64 = 500_000;

    /// The shortest wait, ns: more than a cycle, so that time passes.
    const LEAST_NS: u64 = 1_000;

    /// A machine in virtual time, which runs only while somebody waits for a line. So every figure is the same however
    /// busy this computer is.
    pub struct Virtual<'m, M> {
        machine: &'m mut M,
        lines: Lines,
        heard: VecDeque<String>,
    }

    impl<'m, M: Machine> Virtual<'m, M> {
        /// This machine, whose port is open.
        pub fn new(machine: &'m mut M) -> Self {
            Self { machine, lines: Lines::default(), heard: VecDeque::new() }
        }
    }

    impl<M: Machine> Link for Virtual<'_, M> {
        fn send(&mut self, bytes: &[u8]) -> Result<()> {
            self.machine.send(bytes)
        }

        fn line(&mut self, patience_s: f64) -> Result<Option<String>> {
            let until_ns = self.machine.now_ns() + ((patience_s * 1e9) as u64).max(LEAST_NS);
            while self.heard.is_empty() && self.machine.now_ns() < until_ns {
                let said = self.machine.run_to((self.machine.now_ns() + STRIDE_NS).min(until_ns))?;
                self.heard.extend(self.lines.push(&said));
            }
            Ok(self.heard.pop_front())
        }

        fn now_s(&self) -> f64 {
            self.machine.now_ns() as f64 * 1e-9
        }
    }
}
