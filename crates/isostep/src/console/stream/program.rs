//! The program that is streamed: its lines are made when there is room for them, and kept for as long as somebody may ask what they
//! were.

use std::collections::VecDeque;
use std::iter::Peekable;
use std::path::Path;

use anyhow::{Context, Result};
use isostep_program::{LineError, PlainLine, PlainLines, plain_lines};
use isostep_report::remarks::shortened;

use crate::console::tool_wait::ToolWait;
use crate::project;

/// A program to be sent.
pub struct Program {
    pub name: String,
    source: Vec<Vec<u8>>,
    /// The number of lines that are sent.
    pub total: usize,
    is_plain: bool,
}

impl Program {
    /// Reads the program, and refuses a program that must not be sent. All its lines are made once, so that none is refused when others
    /// have been carried out.
    pub fn read(path: &Path) -> Result<Self> {
        let name = project::shown(path);
        let bytes = std::fs::read(path).with_context(|| format!("{name} cannot be read"))?;
        let source = isostep_sim::program::lines(&bytes).with_context(|| name.clone())?;
        let (total, is_plain) = measured(&source).with_context(|| name.clone())?;
        Ok(Self { name, source, total, is_plain })
    }

    /// Its lines, none of which has been sent.
    pub fn sending(&self) -> Result<Sending<'_>> {
        Ok(Sending { made: plain_lines(&self.source)?.peekable(), kept: VecDeque::new(), sent: 0 })
    }

    /// These of the lines that are sent, in words.
    pub fn span(&self, from: usize, to: usize) -> String {
        let of = if self.is_plain { String::new() } else { format!(" of the {} made of it", self.total) };
        format!("lines {from} to {to}{of}")
    }

    /// The tool that a message of M6 asks for, with what the program says of it. The line with M6 is this one of the file, from 1.
    pub fn tool_wait(&self, message: &str, number: Option<usize>) -> Option<ToolWait> {
        ToolWait::read(message, &self.source, number.and_then(|number| number.checked_sub(1)))
    }

    /// A line of the file, as an error names it.
    pub fn place(&self, (number, text): &(usize, String)) -> String {
        format!("{}:{number}: `{text}`", self.name)
    }
}

/// The number of lines that are sent, and whether they are those of the file.
fn measured(source: &[Vec<u8>]) -> Result<(usize, bool), LineError> {
    let lines = plain_lines(source)?;
    let is_plain = lines.is_plain();
    let mut total = 0;
    for line in lines {
        line?;
        total += 1;
    }
    Ok((total, is_plain))
}

/// The lines of a program while it is sent.
pub struct Sending<'p> {
    made: Peekable<PlainLines<'p, Vec<u8>>>,
    /// The last lines that were sent.
    kept: VecDeque<PlainLine<'p>>,
    /// Lines sent.
    pub sent: usize,
}

impl Sending<'_> {
    /// The next line.
    pub fn next(&mut self) -> Option<&[u8]> {
        self.made.peek().and_then(|line| line.as_ref().ok()).map(|line| &*line.text)
    }

    /// Goes on to the line behind the next one, which has been sent.
    pub fn go_on(&mut self) {
        if let Some(Ok(line)) = self.made.next() {
            self.kept.push_back(line);
            self.sent += 1;
        }
    }

    /// Forgets the lines before this one of those that were sent, counted from 1: nobody asks for them any more.
    pub fn forget_before(&mut self, number: usize) {
        let first = self.sent - self.kept.len() + 1;
        self.kept.drain(..number.saturating_sub(first).min(self.kept.len()));
    }

    /// The number in the file of one of the last lines that were sent, and its text without comments. They are counted from 1.
    pub fn line(&self, number: usize) -> Option<(usize, String)> {
        let index = (self.kept.len() + number).checked_sub(self.sent + 1)?;
        let line = self.kept.get(index)?;
        Some((line.number, shortened(&String::from_utf8_lossy(&line.text))))
    }
}
