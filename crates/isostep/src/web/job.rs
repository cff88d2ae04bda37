//! A program that the server sends: its lines, how far it has come, and why it ended.

use isostep_console::Error;
use isostep_report::remarks::shortened;
use isostep_sim::program::{Program, message, stripped};
use serde::Serialize;

use crate::console::{Status, explained};

/// Characters of a line that the machine takes, without spaces and comments.
const CHARACTERS_MAX: usize = 79;

/// How a job is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    Sending,
    /// The machine waits for somebody: it is held, or its tool is changed.
    Waiting,
    Done,
    Stopped,
}

/// A job, as pages are told of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Now<'a> {
    name: &'a str,
    lines: usize,
    pub answered: usize,
    /// The line of the file that was answered last, 0 for none.
    last: usize,
    /// The line of the file that is answered next.
    line: Option<usize>,
    /// The last line of the file that is sent.
    end: usize,
    pub state: State,
    /// Why it has ended.
    words: &'a str,
}

/// A line for the machine.
struct Line {
    /// Its number in the file, from 1.
    number: usize,
    /// As it is in words.
    text: String,
    /// As it is sent, with its end.
    bytes: Vec<u8>,
}

/// A program that is sent, or was.
pub struct Job {
    pub name: String,
    /// As the page gave it.
    pub text: String,
    /// What the page gave with it, for pages that come later.
    pub before: Vec<String>,
    lines: Vec<Line>,
    sent: usize,
    answered: usize,
    state: State,
    words: String,
    /// A line was refused because the machine is locked: an alarm, which is told a moment later, or a jog.
    is_locked: bool,
}

impl Job {
    /// Reads a program. Parameters, expressions and O-words are carried out, as by `console --stream`.
    ///
    /// # Errors
    /// Why it must not be sent, in words.
    pub fn read(name: String, text: String, before: Vec<String>) -> Result<Self, String> {
        let program = Program::read(text.as_bytes()).map_err(|error| error.to_string())?;
        let lines = lines(&program);
        if lines.is_empty() {
            return Err("the program has no line for the machine".to_owned());
        }
        Ok(Self {
            name,
            text,
            before,
            lines,
            sent: 0,
            answered: 0,
            state: State::Sending,
            words: String::new(),
            is_locked: false,
        })
    }

    /// Nothing of it is sent any more.
    pub fn is_over(&self) -> bool {
        matches!(self.state, State::Done | State::Stopped)
    }

    /// As pages are told.
    pub fn now(&self) -> Now<'_> {
        Now {
            name: &self.name,
            lines: self.lines.len(),
            answered: self.answered,
            last: self.answered.checked_sub(1).map_or(0, |last| self.lines[last].number),
            line: self.lines.get(self.answered).map(|line| line.number),
            end: self.lines.last().map_or(0, |line| line.number),
            state: self.state,
            words: &self.words,
        }
    }

    /// The next line to be sent, with its end.
    pub fn next(&self) -> Option<&[u8]> {
        self.lines.get(self.sent).filter(|_| !self.is_over() && !self.is_locked).map(|line| &*line.bytes)
    }

    /// The next line has been sent.
    pub fn go_on(&mut self) {
        self.sent += 1;
    }

    /// Its next line is answered. Returns false if that ends it: lines behind the refused one are on their way already, and make no
    /// sense without it.
    pub fn answer(&mut self, answer: &str) -> bool {
        self.is_locked |= answer == locked();
        if self.is_over() || self.is_locked {
            return true;
        }
        if answer != "ok" {
            self.refuse(answer);
            return false;
        }
        self.answered += 1;
        true
    }

    /// The machine has said how it is. `waits` for a person. Returns false if that ends the job as a refusal does.
    pub fn look(&mut self, status: &Status, waits: bool) -> bool {
        if self.is_over() {
            return true;
        }
        if self.is_locked && status.state == "Alarm" {
            self.stop(format!("Stopped by an alarm, {}.", self.place()));
            return true;
        }
        if self.is_locked {
            self.refuse(&locked());
            return false;
        }
        let is_at_rest = matches!(status.state.as_str(), "Idle" | "Check");
        if self.answered == self.lines.len() && is_at_rest {
            self.state = State::Done;
            self.words = format!("Done: {} lines.", self.lines.len());
        } else {
            self.state = if waits { State::Waiting } else { State::Sending };
        }
        true
    }

    fn refuse(&mut self, answer: &str) {
        let Line { number, text, .. } = &self.lines[self.answered];
        self.stop(format!("Stopped: line {number} `{text}` was refused. {}", in_words(answer)));
    }

    /// The machine has raised an alarm.
    pub fn alarm(&mut self, alarm: &str) {
        self.stop(format!("Stopped by an alarm, {}: {}", self.place(), in_words(alarm)));
    }

    /// The machine was reset.
    pub fn reset(&mut self) {
        self.stop(format!("Stopped by a reset, {}: the machine has forgotten what it had not made.", self.place()));
    }

    /// There is no board any more.
    pub fn lose(&mut self, why: &str) {
        self.stop(format!("Stopped, {}: {why}", self.place()));
    }

    /// Where it is, in words.
    pub fn place(&self) -> String {
        match self.lines.get(self.answered) {
            Some(line) => format!("line {} was next to be answered", line.number),
            None => "all lines were answered".to_owned(),
        }
    }

    /// Why it has ended; where it is, as long as it has not.
    pub fn words(&self) -> String {
        if self.is_over() { self.words.clone() } else { self.place() }
    }

    fn stop(&mut self, words: String) {
        if !self.is_over() {
            (self.state, self.words) = (State::Stopped, words);
        }
    }
}

/// The answer of a machine that is locked.
fn locked() -> String {
    format!("error:{}", Error::Locked.code())
}

/// An answer or an alarm with its meaning.
fn in_words(line: &str) -> String {
    explained(line).replacen("  ", ": ", 1)
}

/// The lines that say something.
fn lines(program: &Program) -> Vec<Line> {
    let is_numbered = program.iter().any(|line| has_number(line));
    let mut lines = Vec::new();
    for (index, line) in program.iter().enumerate() {
        let number = program.number(index + 1);
        if let Some(bytes) = sent(line, (!is_numbered).then_some(number)) {
            lines.push(Line { number, text: shortened(&String::from_utf8_lossy(line)), bytes });
        }
    }
    lines
}

/// The line has N of its own.
fn has_number(line: &[u8]) -> bool {
    let is_number = |pair: &[u8]| pair[0] == b'N' && pair[1].is_ascii_digit();
    stripped(line).is_ok_and(|bare| !bare.starts_with(['$', '%']) && bare.as_bytes().windows(2).any(is_number))
}

/// A line as it is sent: without comments, unless one is for the operator, and with its number as N, so that reports tell which is under
/// way. `None` if it says nothing.
fn sent(line: &[u8], number: Option<usize>) -> Option<Vec<u8>> {
    // One that is too long is refused by the machine.
    let Ok(bare) = stripped(line) else { return Some([line, b"\n"].concat()) };
    let has_message = !message(line).is_empty();
    if bare.is_empty() && !has_message {
        return None;
    }
    let name = number.map(|number| format!("N{number}")).filter(|name| takes_name(&bare, name)).unwrap_or_default();
    let rest = if has_message { line } else { bare.as_bytes() };
    Some([name.as_bytes(), rest, b"\n"].concat())
}

/// Behind N a mark or a command would be another line.
fn takes_name(bare: &str, name: &str) -> bool {
    !bare.is_empty() && !bare.starts_with(['$', '%', 'O', ':']) && name.len() + bare.len() <= CHARACTERS_MAX
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sent(program: &str) -> Vec<String> {
        let job = Job::read("a.nc".to_owned(), program.to_owned(), Vec::new()).unwrap();
        job.lines.iter().map(|line| String::from_utf8_lossy(&line.bytes).trim_end().to_owned()).collect()
    }

    fn refused(program: &str) -> String {
        Job::read("a.nc".to_owned(), program.to_owned(), Vec::new()).err().unwrap()
    }

    #[test]
    fn each_line_that_says_something_has_its_number() {
        let long = format!("G1 X{}", "1".repeat(76));
        let program = format!("%\nO12\n(head?)\n\ng1 x 1 (right)\n$H\n{long}\n(MSG, look)\n");
        assert_eq!(sent(&program), ["%", "O12", "N5G1X1", "$H", &long.replace(' ', ""), "(MSG, look)"]);
        assert_eq!(sent("N7 G0 X1\nG0 X2\n"), ["N7G0X1", "G0X2"]);
        assert_eq!(sent("#1=2\no1 repeat [2]\nG0 X#1\no1 endrepeat\n"), ["N3G0X2", "N3G0X2"]);
    }

    #[test]
    fn what_must_not_be_sent_is_refused_in_words() {
        assert!(refused("G0 X1\nG0 X2 ?\n").starts_with("line 2: '?' is a real-time command"));
        assert!(refused("G0 X1\nG0 Ä\n").starts_with("line 2: byte 0xc3 is not text"));
        assert!(refused(" \n").starts_with("the program is empty"));
        assert_eq!(refused("(nothing)\n"), "the program has no line for the machine");
        assert!(refused("G0 X[1/0]\n").contains("line 1"));
    }
}
