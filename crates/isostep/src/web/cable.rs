//! The serial port of a board, while a page has it.

use std::io::{ErrorKind, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use anyhow::{Context, Result};
use isostep_sim::link::Lines;
use serialport::SerialPort;
use tokio::sync::mpsc::{self, Receiver, Sender};
use tokio::time;

use super::Board;
use crate::console::port;
use crate::flight::Flight;

/// The most that is kept of the board's words. A reader that is slower lets the board wait, or drop its words.
const AHEAD: usize = 64;
/// Time that a board may take to say what it does. One that says nothing may move.
const LAST_WORDS: Duration = Duration::from_secs(1);
/// A board that has said nothing for so long has answered all that it was asked.
const SILENCE: Duration = Duration::from_millis(100);
const JOG_CANCEL: u8 = 0x85;

/// The board's words, or why it says nothing more.
type Heard = Result<Vec<u8>, String>;

/// An open port.
pub struct Cable {
    port: Box<dyn SerialPort>,
    heard: Receiver<Heard>,
    is_over: Arc<AtomicBool>,
    reader: Option<JoinHandle<()>>,
    lines: Lines,
    flight: Flight,
    /// The last report.
    report: Option<String>,
}

impl Cable {
    /// Opens the board's port, and raises DTR.
    ///
    /// # Errors
    /// When it is not there, or another program has it.
    pub fn open(board: &Board) -> Result<Self> {
        let name = board.name()?;
        let port = port::open(&name, board.baud)?;
        let reader = port.try_clone().with_context(|| format!("{name} cannot be read and written at once"))?;
        let (words, heard) = mpsc::channel(AHEAD);
        let is_over = Arc::new(AtomicBool::new(false));
        let asked = is_over.clone();
        let reader = Some(thread::spawn(move || read(reader, &words, &asked)));
        Ok(Self { port, heard, is_over, reader, lines: Lines::default(), flight: Flight::default(), report: None })
    }

    /// The board's next words.
    ///
    /// # Errors
    /// Why it says nothing more. When this future is dropped, nothing is lost.
    pub async fn hear(&mut self) -> Heard {
        let bytes = self.heard.recv().await.unwrap_or_else(|| Err("its reader has ended".to_owned()))?;
        for line in self.lines.push(&bytes) {
            self.flight.heard(&line);
            if line.starts_with('<') {
                self.report = Some(line);
            }
        }
        Ok(bytes)
    }

    /// Sends bytes to the board. It waits 20 ms at most.
    ///
    /// # Errors
    /// When the board does not take them.
    pub fn send(&mut self, bytes: &[u8]) -> Result<(), String> {
        self.flight.sent(bytes);
        self.port.write_all(bytes).map_err(|error| error.to_string())
    }

    /// Nobody looks at the machine any more: a jog is cancelled and a program held. Says what was done.
    pub async fn leave(mut self) -> &'static str {
        if self.send(&[JOG_CANCEL]).is_err() {
            return "the board is gone too";
        }
        if time::timeout(LAST_WORDS, self.is_idle()).await.unwrap_or(false) {
            return "the machine was idle";
        }
        let _ = self.send(b"!");
        "a jog is cancelled, a program held"
    }

    /// The machine says that it is idle, twice: the first report may be an answer to the page, and of a time before
    /// its last line.
    async fn is_idle(&mut self) -> bool {
        if !self.says_idle().await {
            return false;
        }
        while let Ok(Ok(_)) = time::timeout(SILENCE, self.hear()).await {}
        self.says_idle().await
    }

    /// Asks whether the machine is idle, and whether it has answered every line.
    async fn says_idle(&mut self) -> bool {
        self.report = None;
        let _ = self.send(b"?");
        while self.report.is_none() && self.hear().await.is_ok() {}
        self.flight.in_flight() == 0 && self.report.as_ref().is_some_and(|report| report.starts_with("<Idle"))
    }
}

/// Frees the port, for which its reader has to end: 20 ms at most.
impl Drop for Cable {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        self.heard.close();
        // A thread that panicked has already printed its message.
        let _ = self.reader.take().map(JoinHandle::join);
    }
}

/// Passes on what the board says, until the port fails or nobody listens.
fn read(mut port: Box<dyn SerialPort>, words: &Sender<Heard>, is_over: &AtomicBool) {
    let mut bytes = [0; 1024];
    while !is_over.load(Ordering::Relaxed) {
        let heard = match port.read(&mut bytes) {
            Ok(0) => Err("it was closed at the other end".to_owned()),
            Ok(count) => Ok(bytes[..count].to_vec()),
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => continue,
            Err(error) => Err(error.to_string()),
        };
        let is_last = heard.is_err();
        if words.blocking_send(heard).is_err() || is_last {
            return;
        }
    }
}
