//! The serial port of a board, while it is lent.

use std::io::{ErrorKind, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

use anyhow::{Context, Result};
use isostep_sim::link::Lines;
use serialport::SerialPort;
use tokio::sync::mpsc::{self, Receiver, Sender};

use super::Board;
use crate::console::port;

/// The most that is kept of the board's words. A reader that is slower lets the board wait, or drop its words.
const AHEAD: usize = 64;

/// The board's words, or why it says nothing more.
type Heard = Result<Vec<u8>, String>;

/// An open port.
pub struct Cable {
    port: Box<dyn SerialPort>,
    heard: Receiver<Heard>,
    is_over: Arc<AtomicBool>,
    reader: Option<JoinHandle<()>>,
    lines: Lines,
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
        Ok(Self { port, heard, is_over, reader, lines: Lines::default() })
    }

    /// The lines that the board has said next, perhaps none.
    ///
    /// # Errors
    /// Why it says nothing more. When this future is dropped, nothing is lost.
    pub async fn hear(&mut self) -> Result<Vec<String>, String> {
        let bytes = self.heard.recv().await.unwrap_or_else(|| Err("its reader has ended".to_owned()))?;
        Ok(self.lines.push(&bytes))
    }

    /// Sends bytes to the board. It waits 20 ms at most.
    ///
    /// # Errors
    /// When the board does not take them.
    pub fn send(&mut self, bytes: &[u8]) -> Result<(), String> {
        self.port.write_all(bytes).map_err(|error| error.to_string())
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
