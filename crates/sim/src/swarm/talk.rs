//! The state of the dialogue on a console, as its host knows it.

use std::collections::VecDeque;

use isostep_console::realtime;

/// The beginning of the welcome.
pub(super) const WELCOME: &str = "Grbl ";
const RESET: u8 = 0x18;

#[derive(Default)]
pub(super) struct Talk {
    /// Lengths of the lines that have not been answered.
    unanswered: VecDeque<usize>,
    /// Bytes of a line that has no end yet.
    partial: usize,
    /// True if lines may have been discarded: by a reset, or because a host opened the console.
    forgets: bool,
    /// Number of welcomes received.
    pub welcomes: u32,
    /// The lines received since the last welcome.
    pub heard: Vec<String>,
}

impl Talk {
    /// A host has opened the console.
    pub fn of_opened_console() -> Self {
        Self { forgets: true, ..Self::default() }
    }

    /// From now on lines may be discarded.
    pub fn may_forget(&mut self) {
        self.forgets = true;
    }

    /// The host sends bytes.
    pub fn say(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            if byte == RESET {
                (self.forgets, self.partial) = (true, 0);
            }
            if realtime::classify(byte).is_some() {
                continue;
            }
            self.partial += 1;
            if byte == b'\n' || byte == b'\r' {
                self.unanswered.push_back(std::mem::take(&mut self.partial));
            }
        }
    }

    /// The host receives a line. False if this is an answer to no line.
    pub fn hear(&mut self, line: &str) -> bool {
        if line.starts_with(WELCOME) {
            if self.welcomes > 0 {
                // A reset discards the lines without an answer, up to those that came after the reset.
                self.forgets = true;
                self.unanswered.clear();
            }
            self.welcomes += 1;
            self.heard.clear();
            return true;
        }
        self.heard.push(line.to_owned());
        !is_answer(line) || self.unanswered.pop_front().is_some() || self.forgets
    }

    /// All lines have been answered or forgotten. From now on every line gets its answer.
    pub fn begin_anew(&mut self) {
        self.unanswered.clear();
        self.forgets = false;
    }

    /// A line has begun and not ended yet.
    pub fn is_in_line(&self) -> bool {
        self.partial > 0
    }

    pub fn unanswered_bytes(&self) -> usize {
        self.unanswered.iter().sum()
    }

    /// Number of lines that should have been answered.
    pub fn missing_answers(&self) -> usize {
        if self.forgets { 0 } else { self.unanswered.len() }
    }
}

pub(super) fn is_answer(line: &str) -> bool {
    line == "ok" || line.starts_with("error:")
}
