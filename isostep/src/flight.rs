//! The bytes that a sender has sent and that are not answered yet: what it must keep within a controller's buffer. The
//! console counts them so as to keep within it, a machine on a pseudo-terminal to say whether its sender did.

use std::collections::VecDeque;

use isostep_console::realtime::{self, Realtime};

/// Grbl's receive buffer, which senders count against. A pseudo-terminal itself never overflows.
pub const WINDOW_BYTES: usize = 128;

/// What went over a console's wire, counted as a sender that counts characters does.
#[derive(Debug, Default)]
pub struct Flight {
    /// Bytes of the line that has not ended yet.
    partial: usize,
    /// Length of each line not yet answered, its end included.
    unanswered: VecDeque<usize>,
    in_flight: usize,
    /// After a reset nothing sent before is answered: until the welcome comes, an `ok` belongs to no line.
    restarting: bool,
    /// The most bytes in flight at once.
    pub most: usize,
    /// How often they grew beyond the window.
    pub times_over: u32,
    /// Lines sent; a reset forgets those not answered.
    pub lines: u64,
    /// Lines answered, by `ok` or an error.
    pub answered: u64,
    /// Lines answered by an error.
    pub refused: u64,
    /// Alarms told.
    pub alarms: u64,
}

impl Flight {
    /// Bytes go to the machine. Real-time ones are acted on at once, and never answered.
    pub fn sent(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            match realtime::classify(byte) {
                Some(Realtime::Reset) => self.restart(),
                Some(_) => {}
                None => self.line_byte(byte),
            }
        }
    }

    /// The machine has said a line. Whether it answers one of ours: the one of number [`Self::answered`], from 1.
    pub fn heard(&mut self, line: &str) -> bool {
        let refused = line.starts_with("error:");
        if line.starts_with("Grbl") {
            if !self.restarting {
                // It has reset by itself.
                self.restart();
            }
            self.restarting = false;
        } else if line.starts_with("ALARM:") {
            self.alarms += 1;
        }
        (refused || line == "ok") && !self.restarting && self.answer(refused)
    }

    /// Bytes not answered yet.
    pub fn in_flight(&self) -> usize {
        self.in_flight
    }

    /// Whether a line of that length, its end included, keeps within the window. One longer than the window goes alone.
    pub fn has_room(&self, length: usize) -> bool {
        self.in_flight == 0 || self.in_flight + length <= WINDOW_BYTES
    }

    /// The machine forgets what it has not carried out, and says its welcome.
    pub fn restart(&mut self) {
        (self.partial, self.in_flight, self.restarting) = (0, 0, true);
        self.lines -= self.unanswered.len() as u64;
        self.unanswered.clear();
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
