//! Assembles bytes to lines and strips them as Grbl does.

use heapless::Vec;

use crate::Error;

/// The longest line, in characters that remain after spaces and comments have been stripped.
pub const MAX_LINE_CHARS: usize = 79;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Comment {
    None,
    Parentheses,
    ToEndOfLine,
}

/// Collects bytes until CR or LF ends the line. Strips spaces, tabs, `/`, `(...)` and `;...`, and converts to upper
/// case.
#[derive(Debug, Clone)]
pub struct LineAssembler {
    /// ASCII.
    text: Vec<u8, MAX_LINE_CHARS>,
    comment: Comment,
    fault: Option<Error>,
    ended: bool,
}

impl LineAssembler {
    /// An assembler at the beginning of a line.
    pub const fn new() -> Self {
        Self { text: Vec::new(), comment: Comment::None, fault: None, ended: false }
    }

    /// Discards the unfinished line, as a reset does.
    pub fn reset(&mut self) {
        *self = Self::new();
    }

    /// Takes bytes off the front of `bytes` up to the end of a line, and returns the line. `None` if they end before it
    /// does.
    ///
    /// # Errors
    /// Once per line, when the line ends: [`Error::LineTooLong`] above [`MAX_LINE_CHARS`], or
    /// [`Error::LetterMissing`] for a control character or a byte above 0x7E outside comments.
    pub fn take(&mut self, bytes: &mut &[u8]) -> Option<Result<&str, Error>> {
        if self.ended {
            self.reset();
        }
        loop {
            if self.comment == Comment::None {
                let plain = bytes.iter().take_while(|&&byte| is_plain(byte)).count();
                let (plain, rest) = bytes.split_at(plain);
                self.keep(plain);
                *bytes = rest;
            }
            let [byte, rest @ ..] = *bytes else { break };
            *bytes = rest;
            match (self.comment, byte) {
                (_, b'\r' | b'\n') => {
                    self.ended = true;
                    break;
                }
                (Comment::Parentheses, b')') => self.comment = Comment::None,
                (Comment::Parentheses | Comment::ToEndOfLine, _) => {}
                (Comment::None, b'(') => self.comment = Comment::Parentheses,
                (Comment::None, b';') => self.comment = Comment::ToEndOfLine,
                (Comment::None, b' ' | b'\t' | b'/') => {}
                (Comment::None, _) => self.fail(Error::LetterMissing),
            }
        }
        self.ended.then(|| self.fault.map_or_else(|| str::from_utf8(&self.text).map_err(|_| Error::LetterMissing), Err))
    }

    /// Takes the next byte. Returns the line if this byte ends it.
    ///
    /// # Errors
    /// As [`take`](Self::take).
    pub fn push(&mut self, byte: u8) -> Option<Result<&str, Error>> {
        self.take(&mut [byte].as_slice())
    }

    fn keep(&mut self, bytes: &[u8]) {
        let before = self.text.len();
        let fits = bytes.len().min(MAX_LINE_CHARS - before);
        let _ = self.text.extend_from_slice(&bytes[..fits]);
        self.text[before..].make_ascii_uppercase();
        if fits < bytes.len() {
            self.fail(Error::LineTooLong);
        }
    }

    /// Only the first fault of a line is reported.
    fn fail(&mut self, error: Error) {
        self.fault.get_or_insert(error);
    }
}

/// Whether a character stays in the line, and begins no comment.
#[inline(always)]
fn is_plain(byte: u8) -> bool {
    matches!(byte, b'!'..=b'~') && !matches!(byte, b'(' | b';' | b'/')
}

impl Default for LineAssembler {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use std::{format, string::String, vec::Vec};

    use proptest::prelude::*;

    use super::*;

    fn lines(bytes: &[u8]) -> Vec<Result<String, Error>> {
        let (mut assembler, mut left, mut lines) = (LineAssembler::new(), bytes, Vec::new());
        while let Some(line) = assembler.take(&mut left) {
            lines.push(line.map(String::from));
        }
        assert!(left.is_empty());
        lines
    }

    #[test]
    fn strips_and_upper_cases_as_grbl_does() {
        let rows: &[(&str, &str)] = &[
            ("g1 x1.5\n", "G1X1.5"),
            ("g1(fast; not (so))x2\n", "G1)X2"),
            ("G0 X1 ; go (there\n", "G0X1"),
            ("/g28\n", "G28"),
            ("$ 110 = 2 (rate)\n", "$110=2"),
            ("\tM30\t\n", "M30"),
            ("(never closed\n", ""),
        ];
        for &(sent, line) in rows {
            assert_eq!(lines(sent.as_bytes()), [Ok(line.into())], "{sent:?}");
        }
    }

    #[test]
    fn an_empty_line_is_a_line_and_crlf_ends_two() {
        assert_eq!(lines(b"\nG0\r\n"), [Ok("".into()), Ok("G0".into()), Ok("".into())]);
    }

    #[test]
    fn a_comment_ends_with_its_line() {
        assert_eq!(lines(b"(a\nG0\n;b\nG1\n"), ["", "G0", "", "G1"].map(|line| Ok(line.into())));
    }

    #[test]
    fn the_79th_character_fits_and_the_80th_costs_one_error() {
        let longest = "X".repeat(79);
        assert_eq!(lines(format!("{longest} (not counted)\n").as_bytes()), [Ok(longest.clone())]);
        assert_eq!(lines(format!("{longest}Y\n").as_bytes()), [Err(Error::LineTooLong)]);
        let endless = format!("{}\nG0\n", "X".repeat(10_000));
        assert_eq!(lines(endless.as_bytes()), [Err(Error::LineTooLong), Ok("G0".into())]);
    }

    #[test]
    fn binary_costs_one_error_a_line() {
        assert_eq!(lines(b"\x7fELF\x01\x00\xffG0\nG0\n"), [Err(Error::LetterMissing), Ok("G0".into())]);
        assert_eq!(lines(b"(\x00\x07)G0\n"), [Ok("G0".into())]);
    }

    proptest! {
        #[test]
        fn any_bytes_give_one_line_for_each_end_of_line(bytes in prop::collection::vec(any::<u8>(), 0..2000)) {
            let ends = bytes.iter().filter(|byte| matches!(byte, b'\r' | b'\n')).count();
            let lines = lines(&bytes);
            prop_assert_eq!(lines.len(), ends);
            for line in lines.into_iter().flatten() {
                prop_assert!(line.len() <= MAX_LINE_CHARS && line.bytes().all(|byte| byte.is_ascii_graphic()));
            }
        }
    }
}
