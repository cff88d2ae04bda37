//! An emulated board that runs only as far as it is asked, by two pipes: see `tests/emulator/src/live.mjs`.

use std::fmt::Write as _;

use serde_json::Value;

use super::{Board, Process};

/// The board, from power-up on.
pub struct Live {
    board: Board,
    process: Process,
    now_ns: u64,
}

impl Live {
    /// # Panics
    /// When Node does not start.
    pub(super) fn start(mut board: Board) -> Self {
        board.options.push("--live".to_owned());
        Self { process: Process::begin(&board.options), board, now_ns: 0 }
    }

    /// The machine time.
    #[must_use]
    pub const fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// Sends bytes, runs to an instant, and returns what was received.
    ///
    /// # Errors
    /// The reason why the board has ended.
    pub fn run_to(&mut self, at_ns: u64, bytes: &[u8]) -> Result<Vec<u8>, String> {
        let hex = bytes.iter().fold(String::new(), |mut text, byte| {
            _ = write!(text, "{byte:02x}");
            text
        });
        let answer = self.ask(&format!("run {at_ns} {}", if hex.is_empty() { "-" } else { &hex }))?;
        let mut words = answer.split_whitespace();
        let now_ns = words.next().and_then(|word| word.parse().ok());
        let (Some(now_ns), Some(received)) = (now_ns, words.nth(1)) else { return Err(ended(&answer)) };
        self.now_ns = now_ns;
        let received = received.trim_start_matches('-');
        let byte = |at: usize| u8::from_str_radix(received.get(at..at + 2)?, 16).ok();
        (0..received.len()).step_by(2).map(byte).collect::<Option<_>>().ok_or(answer)
    }

    /// Carries out a command of a script.
    ///
    /// # Errors
    /// Why it cannot, or what it found wrong.
    pub fn act(&mut self, command: &str) -> Result<(), String> {
        let answer = self.ask(&format!("do {command}"))?;
        let now_ns = answer.strip_prefix("done ").and_then(|at_ns| at_ns.trim().parse().ok());
        self.now_ns = now_ns.ok_or_else(|| ended(&answer))?;
        Ok(())
    }

    /// The figures as they are now.
    ///
    /// # Errors
    /// The reason why the board has ended.
    pub fn look(&mut self) -> Result<Value, String> {
        let answer = self.ask("look")?;
        serde_json::from_str(&answer).map_err(|error| format!("{error}: {answer}"))
    }

    /// Ends the board and returns its figures.
    ///
    /// # Errors
    /// The faults of the run.
    ///
    /// # Panics
    /// When a handler or critical section used flash.
    pub fn end(mut self) -> Result<Value, String> {
        let answer = self.ask("end")?;
        let figures = serde_json::from_str(&answer).map_err(|error| format!("{error}: {answer}"))?;
        self.process.end();
        self.board.assert_in_time(&figures);
        Ok(figures)
    }

    fn ask(&mut self, request: &str) -> Result<String, String> {
        // If the board has ended, its answer says why.
        self.process.say(request);
        let answer = self.process.line();
        if answer.is_empty() { Err("the emulated board has ended without a word".to_owned()) } else { Ok(answer) }
    }
}

/// The reason why the board ended, from its summary, or why it did not do a command.
fn ended(answer: &str) -> String {
    let figures: Value = serde_json::from_str(answer).unwrap_or_default();
    figures["error"].as_str().unwrap_or(answer.trim()).to_owned()
}
