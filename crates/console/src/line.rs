//! Assembles bytes to lines and strips them as Grbl does. What a comment tells the operator is kept.

use heapless::Vec;

use crate::Error;

/// The longest line, in characters that remain after spaces and comments have been stripped.
pub const MAX_LINE_CHARS: usize = 79;

/// The beginning of a comment that is a message to the operator, as in RS274/NGC. Spaces do not count, nor upper and lower case.
const MESSAGE_BEGINS: &[u8] = b"MSG,";
/// The end of a message that is too long, and what stands between two of one line.
const CUT: &[u8] = b"...";
const BETWEEN: &[u8] = b"; ";

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Comment {
    None,
    /// In parentheses, and so many of its characters are those of a message.
    Begun(u8),
    /// In parentheses, a message to the operator.
    Message,
    Parentheses,
    ToEndOfLine,
}

/// Collects bytes until CR or LF ends the line. Strips spaces, tabs, `/`, `(...)` and `;...`, and converts to upper
/// case. Keeps the text of `(MSG, ...)`.
#[derive(Debug, Clone)]
pub struct LineAssembler {
    /// ASCII.
    text: Vec<u8, MAX_LINE_CHARS>,
    /// ASCII.
    message: Vec<u8, MAX_LINE_CHARS>,
    comment: Comment,
    fault: Option<Error>,
    ended: bool,
}

impl LineAssembler {
    /// An assembler at the beginning of a line.
    pub const fn new() -> Self {
        Self { text: Vec::new(), message: Vec::new(), comment: Comment::None, fault: None, ended: false }
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
        self.end(bytes).then(|| self.line())
    }

    /// Takes bytes off the front of `bytes` up to the end of a line, which is [`line`](Self::line) then; false if they end before it
    /// does.
    pub fn end(&mut self, bytes: &mut &[u8]) -> bool {
        if self.ended {
            self.reset();
        }
        loop {
            if self.comment == Comment::None {
                *bytes = self.keep(bytes);
            }
            let [byte, rest @ ..] = *bytes else { break };
            *bytes = rest;
            match (self.comment, byte) {
                (_, b'\r' | b'\n') => {
                    self.ended = true;
                    break;
                }
                (Comment::Begun(_) | Comment::Message | Comment::Parentheses, b')') => self.comment = Comment::None,
                (Comment::Begun(count), _) => self.comment = self.begun(count, *byte),
                (Comment::Message, _) => self.tell(*byte),
                (Comment::Parentheses | Comment::ToEndOfLine, _) => {}
                (Comment::None, b'(') => self.comment = Comment::Begun(0),
                (Comment::None, b';') => self.comment = Comment::ToEndOfLine,
                (Comment::None, b' ' | b'\t' | b'/') => {}
                (Comment::None, _) => self.fail(Error::LetterMissing),
            }
        }
        self.ended
    }

    /// The line that [`take`](Self::take) or [`end`](Self::end) has taken last, until one is called again.
    ///
    /// # Errors
    /// As [`take`](Self::take).
    pub fn line(&self) -> Result<&str, Error> {
        self.fault.map_or_else(|| str::from_utf8(&self.text).map_err(|_| Error::LetterMissing), Err)
    }

    /// The message of the comments of that line to the operator, `(MSG, ...)`; empty if they do not. A text of more than
    /// [`MAX_LINE_CHARS`] ends with `...`.
    pub fn message(&self) -> &str {
        str::from_utf8(self.message.trim_ascii_end()).unwrap_or_default()
    }

    /// Takes the next byte. Returns the line if this byte ends it.
    ///
    /// # Errors
    /// As [`take`](Self::take).
    pub fn push(&mut self, byte: u8) -> Option<Result<&str, Error>> {
        self.take(&mut [byte].as_slice())
    }

    /// Keeps the bytes before the first one that is not plain, and returns the others.
    fn keep<'b>(&mut self, mut bytes: &'b [u8]) -> &'b [u8] {
        while let [byte, rest @ ..] = bytes
            && is_plain(*byte)
        {
            bytes = rest;
            if self.text.push(byte.to_ascii_uppercase()).is_err() {
                self.fail(Error::LineTooLong);
            }
        }
        bytes
    }

    /// The kind of a comment, of which `count` characters are those of a message, after the next one.
    fn begun(&mut self, count: u8, byte: u8) -> Comment {
        match MESSAGE_BEGINS.get(usize::from(count)) {
            _ if matches!(byte, b' ' | b'\t') => Comment::Begun(count),
            Some(&expected) if expected != byte.to_ascii_uppercase() => Comment::Parentheses,
            _ if usize::from(count) + 1 < MESSAGE_BEGINS.len() => Comment::Begun(count + 1),
            _ => {
                if !self.message.is_empty() {
                    BETWEEN.iter().for_each(|&byte| self.tell(byte));
                }
                Comment::Message
            }
        }
    }

    fn tell(&mut self, byte: u8) {
        let is_shown = matches!(byte, b'!'..=b'~') || byte == b' ' && !self.message.is_empty();
        if is_shown && self.message.push(byte).is_err() {
            let kept = self.message.len() - CUT.len();
            self.message[kept..].copy_from_slice(CUT);
        }
    }

    /// Only the first fault of a line is reported.
    fn fail(&mut self, error: Error) {
        self.fault.get_or_insert(error);
    }
}

/// True if a character stays in the line, and begins no comment.
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
    fn a_message_is_kept_whole_or_visibly_cut() {
        let reported = |line: &str| {
            let mut assembler = LineAssembler::new();
            assert!(assembler.take(&mut format!("(MSG, before)\n{line}").as_bytes()).is_some());
            let mut bytes = line.as_bytes();
            assert!(assembler.take(&mut bytes).is_some());
            assert_eq!(assembler.line().map(String::from), lines(line.as_bytes()).remove(0));
            String::from(assembler.message())
        };
        let longest = "x".repeat(79);
        for (line, message) in [
            ("(MSG, Change tool to T2: 3.175 mm, 2 flutes)\n", "Change tool to T2: 3.175 mm, 2 flutes"),
            ("(msg,a)\n", "a"),
            (" ( M s G ,\ta b\x01 )M0\n", "a b"),
            ("M0 (MSG, a) (b) (MSG,b)\n", "a; b"),
            ("(MSG, never closed\n", "never closed"),
            ("(MSG, a (b) c)\n", "a (b"),
            ("(MSG)\n", ""),
            ("(MSGS, a)\n", ""),
            ("(a MSG, b)\n", ""),
            ("; (MSG, a)\n", ""),
            ("(MSG,)\n", ""),
            ("G0 X1\n", ""),
            (&format!("(MSG, {longest})\n"), &longest),
            (&format!("(MSG, {longest}x)\n"), &format!("{}...", "x".repeat(76))),
            (&format!("(MSG, {longest}{longest})(MSG, b)\n"), &format!("{}...", "x".repeat(76))),
        ] {
            assert_eq!(reported(line), message, "{line:?}");
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
