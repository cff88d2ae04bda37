//! Counts the bytes that a sender has sent and the controller has not answered yet. They must fit in the controller's
//! buffer. The console counts them to stay within the buffer; a machine on a pseudo-terminal counts them to report
//! whether its sender did.

use std::collections::VecDeque;

use isostep_console::realtime::{self, Realtime};

/// The size of Grbl's receive buffer, which senders rely on. A pseudo-terminal itself never overflows.
pub const WINDOW_BYTES: usize = 128;

/// The traffic of a console, counted in the way of senders that count characters.
#[derive(Debug, Default)]
pub struct Flight {
    /// Bytes of the line that has not ended yet.
    partial: usize,
    /// Length of each unanswered line, its line end included.
    unanswered: VecDeque<usize>,
    /// The same of the lines of a program that wait for the end of a change of the tool, while the sender sends others.
    waiting: VecDeque<usize>,
    in_flight: usize,
    /// Lines by hand without an answer. They are answered before lines that wait for a change of the tool.
    by_hand: usize,
    /// Set between a reset and the welcome: nothing sent before the reset is answered, so an `ok` belongs to no line.
    restarting: bool,
    /// The highest number of unanswered bytes.
    pub most: usize,
    /// The times that the unanswered bytes have exceeded the window.
    pub times_over: u32,
    /// Lines sent. A reset subtracts those not answered.
    pub lines: u64,
    /// Lines answered, by `ok` or an error.
    pub answered: u64,
    /// Lines answered by an error.
    pub refused: u64,
    /// Alarms reported.
    pub alarms: u64,
}

impl Flight {
    /// Counts bytes that go to the machine. Real-time bytes do not count, because they act at once and are never
    /// answered. What is sent by hand in a change of the tool has the window for itself.
    pub fn sent(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            match realtime::classify(byte) {
                Some(Realtime::Reset) => self.restart(),
                Some(Realtime::ToolChange) => self.set_aside(),
                Some(Realtime::Resume) => self.bring_back(),
                Some(_) => {}
                None => self.line_byte(byte),
            }
        }
    }

    /// Takes a line that the machine has sent. Returns whether it answers one of our lines; that line's number, counted
    /// from 1, is then [`Self::answered`].
    pub fn heard(&mut self, line: &str) -> bool {
        let refused = line.starts_with("error:");
        if line.starts_with("Grbl") {
            if !self.restarting {
                // The machine has reset by itself.
                self.restart();
            }
            self.restarting = false;
        } else if line.starts_with("ALARM:") {
            self.alarms += 1;
        }
        (refused || line == "ok") && !self.restarting && self.answer(refused)
    }

    /// Notes a line that goes to the machine by hand, past the lines that wait.
    pub fn sent_by_hand(&mut self) {
        self.by_hand += 1;
    }

    /// Every line by hand has been answered.
    pub fn hand_is_empty(&self) -> bool {
        self.by_hand == 0
    }

    /// Bytes not answered yet.
    pub fn in_flight(&self) -> usize {
        self.in_flight
    }

    /// A line of this length, its end included, fits in the window. A line longer than the window is sent when
    /// no other is unanswered.
    pub fn has_room(&self, length: usize) -> bool {
        self.in_flight == 0 || self.in_flight + length <= WINDOW_BYTES
    }

    /// Counts a reset: the machine discards what it has not carried out, and will send its welcome.
    pub fn restart(&mut self) {
        (self.partial, self.in_flight, self.by_hand, self.restarting) = (0, 0, 0, true);
        self.lines -= (self.unanswered.len() + self.waiting.len()) as u64;
        self.unanswered.clear();
        self.waiting.clear();
    }

    /// The sender knows of the change of the tool: what comes now is by hand, and is answered first.
    fn set_aside(&mut self) {
        self.waiting.append(&mut self.unanswered);
        self.in_flight = self.partial;
    }

    /// The change of the tool may be over.
    fn bring_back(&mut self) {
        self.in_flight += self.waiting.iter().sum::<usize>();
        self.unanswered.append(&mut self.waiting);
    }

    fn line_byte(&mut self, byte: u8) {
        let was_over = self.in_flight > WINDOW_BYTES;
        self.partial += 1;
        self.in_flight += 1;
        self.most = self.most.max(self.in_flight);
        self.times_over += u32::from(!was_over && self.in_flight > WINDOW_BYTES);
        if byte == b'\n' || byte == b'\r' {
            self.unanswered.push_back(std::mem::take(&mut self.partial));
            self.lines += 1;
        }
    }

    fn answer(&mut self, refused: bool) -> bool {
        if self.by_hand > 0 {
            self.by_hand -= 1;
            return false;
        }
        let Some(length) = self.unanswered.pop_front() else { return false };
        self.in_flight -= length;
        self.answered += 1;
        self.refused += u64::from(refused);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_count_until_they_are_answered_and_real_time_bytes_never() {
        let mut flight = Flight::default();
        flight.sent(b"G0 X1\n?G0");
        assert_eq!(flight.in_flight, 8);
        assert!(!flight.heard("<Idle|MPos:0,0,0>"));
        assert_eq!(flight.in_flight, 8);
        assert!(flight.heard("ok"));
        assert_eq!((flight.in_flight, flight.lines, flight.answered), (2, 1, 1));
        flight.sent(b" Y1\r\n");
        assert!(flight.heard("error:20") && flight.heard("ok") && !flight.heard("ok"));
        assert_eq!((flight.in_flight, flight.lines, flight.answered, flight.refused), (0, 3, 3, 1));
        assert_eq!((flight.most, flight.times_over), (8, 0));
    }

    #[test]
    fn a_line_by_hand_is_answered_before_those_that_wait() {
        let mut flight = Flight::default();
        flight.sent(b"G0 X1\nG0 X2\n");
        flight.sent_by_hand();
        assert!(!flight.heard("error:9") && flight.hand_is_empty());
        assert_eq!((flight.in_flight, flight.answered, flight.refused), (12, 0, 0));
        assert!(flight.heard("ok") && flight.heard("ok"));
        assert_eq!((flight.in_flight, flight.answered), (0, 2));
        flight.sent_by_hand();
        flight.restart();
        assert!(flight.hand_is_empty());
    }

    #[test]
    fn growing_beyond_the_window_counts_once_each_time() {
        let mut flight = Flight::default();
        let line = [&[b'('; 99][..], b"\n"].concat();
        for _ in 0..2 {
            flight.sent(&line);
            flight.sent(&line);
            assert!(!flight.has_room(1));
            assert!(flight.heard("ok") && flight.has_room(28) && !flight.has_room(29));
            assert!(flight.heard("ok") && flight.has_room(200));
        }
        assert_eq!((flight.most, flight.times_over, flight.in_flight), (200, 2, 0));
    }

    #[test]
    fn lines_by_hand_in_a_change_of_the_tool_are_answered_before_those_that_wait() {
        let mut flight = Flight::default();
        let line = [&[b'('; 99][..], b"\n"].concat();
        flight.sent(&[b"T1 M6\n", &line[..]].concat());
        assert!(flight.heard("ok"));
        flight.sent(b"\xA3$TPW\n");
        assert_eq!((flight.in_flight, flight.most), (5, 106));
        assert!(flight.heard("ok"));
        flight.sent(b"~");
        assert_eq!((flight.in_flight, flight.lines, flight.answered), (100, 3, 2));
        flight.sent(b"\xA3\x18$$\n");
        assert!(!flight.heard("Grbl 1.1h") && flight.heard("ok"));
        assert_eq!((flight.in_flight, flight.lines, flight.answered), (0, 3, 3));
        assert_eq!((flight.most, flight.times_over), (106, 0));
    }

    #[test]
    fn a_reset_forgets_what_was_not_answered_and_answers_that_were_under_way() {
        let mut flight = Flight::default();
        flight.sent(b"G0 X1\nG0 X2\n\x18$$\n");
        assert!(!flight.heard("ok") && !flight.heard("Grbl 1.1h"));
        assert_eq!((flight.in_flight, flight.lines, flight.answered), (3, 1, 0));
        assert!(flight.heard("ok"));
        assert_eq!((flight.in_flight, flight.lines, flight.answered), (0, 1, 1));
        flight.sent(b"$$\n");
        assert!(!flight.heard("Grbl 1.1h"));
        assert_eq!((flight.in_flight, flight.lines, flight.answered), (0, 1, 1));
    }
}
