//! A place in a line, where blanks do not count, nor upper and lower case.

use crate::problem::shortened;

/// Characters of a line that a message shows at most.
const SHOWN_CHARS: usize = 24;

#[derive(Clone, Copy)]
pub(crate) struct Cursor<'t> {
    line: &'t [u8],
    at: usize,
}

impl<'t> Cursor<'t> {
    /// At this byte of the line.
    pub fn new(line: &'t [u8], at: usize) -> Self {
        Self { line, at }
    }

    /// The index of the next byte, which may be a blank.
    pub fn at(&self) -> usize {
        self.at
    }

    /// The next byte that is no blank, in lower case.
    pub fn peek(&self) -> Option<u8> {
        self.line.get(self.place()).map(u8::to_ascii_lowercase)
    }

    /// As [`peek`](Self::peek), and goes behind it.
    pub fn next(&mut self) -> Option<u8> {
        let byte = self.peek();
        self.at = (self.place() + 1).min(self.line.len());
        byte
    }

    /// Goes behind `byte` if it is next.
    pub fn take(&mut self, byte: u8) -> bool {
        let is_next = self.peek() == Some(byte);
        if is_next {
            self.next();
        }
        is_next
    }

    /// Goes behind `word`, in lower case, if it is next.
    pub fn take_word(&mut self, word: &str) -> bool {
        let mut ahead = *self;
        let is_next = word.bytes().all(|byte| ahead.take(byte));
        if is_next {
            *self = ahead;
        }
        is_next
    }

    /// Goes to the byte behind the next `byte` as it is written, or to the end of the line.
    pub fn go_behind(&mut self, byte: u8) {
        let found = self.line[self.at..].iter().position(|other| *other == byte);
        self.at = found.map_or(self.line.len(), |found| self.at + found + 1);
    }

    /// The bytes from index `from` to here, as they are written.
    pub fn since(&self, from: usize) -> &'t [u8] {
        &self.line[from..self.at]
    }

    /// True if nothing but comments comes.
    pub fn is_over(mut self) -> bool {
        self.go_behind_comments();
        matches!(self.peek(), None | Some(b';'))
    }

    /// Goes behind comments in parentheses.
    pub fn go_behind_comments(&mut self) {
        while self.peek() == Some(b'(') {
            self.go_behind(b')');
        }
    }

    /// What comes, for a message.
    pub fn rest(&self) -> String {
        shortened(&String::from_utf8_lossy(&self.line[self.place()..]), SHOWN_CHARS)
    }

    fn place(&self) -> usize {
        let blanks = self.line[self.at..].iter().take_while(|byte| matches!(byte, b' ' | b'\t' | b'\r')).count();
        self.at + blanks
    }
}
