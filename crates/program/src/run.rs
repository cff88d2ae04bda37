//! Carries a program out line by line.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use crate::cursor::Cursor;
use crate::expression::{Reader, count};
use crate::glance::Glance;
use crate::label::{Keyword, Label, computed};
use crate::parameters::{ARGUMENTS_MAX, Parameters};
use crate::structure::{Flow, Step, Structure};
use crate::words::Words;
use crate::{LINES_MADE_MAX, LineError, NESTED_CALLS_MAX, Problem, STATEMENTS_MAX};

/// The most times that a repeat asks for.
const TIMES_MAX: u32 = 1_000_000_000;

/// A line for the machine.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PlainLine<'s> {
    /// The number of the line of the file that it is made from, from 1.
    pub number: usize,
    /// Its bytes. A line without parameters, expressions and calls is that of the file.
    pub text: Cow<'s, [u8]>,
}

/// The plain lines of a program, one after another: see [`plain_lines`](crate::plain_lines).
///
/// An error of a line that only moves, or that nobody can read, passes that line over, and the next line follows. Behind any other error nothing follows.
pub struct PlainLines<'s, L> {
    source: &'s [L],
    structure: Structure,
    is_plain: bool,
    parameters: Parameters,
    /// The main program, and the subroutines that have been called.
    frames: Vec<Frame>,
    /// The index of the next line.
    at: usize,
    /// Lines carried out since the last one for the machine.
    statements: u32,
    /// Lines for the machine.
    made: usize,
    /// Lines that were passed over, each of which is reported once.
    faulty: BTreeSet<usize>,
    is_over: bool,
}

/// A subroutine, as far as it has been carried out.
#[derive(Default)]
struct Frame {
    kind: Kind,
    /// The line behind the call.
    back_to: usize,
    /// How often each repeat that has begun is still to be carried out, this time included, by the index of its line.
    repeats: BTreeMap<usize, u32>,
}

#[derive(Default)]
enum Kind {
    #[default]
    Main,
    /// It begins with `sub`.
    Sub,
    /// It is called by M98, and is to be carried out so many times more.
    Numbered { number: u32, begin: usize, times: u32 },
}

impl<'s, L: AsRef<[u8]>> PlainLines<'s, L> {
    pub(crate) fn new(source: &'s [L]) -> Result<Self, LineError> {
        let structure = Structure::of(source)?;
        Ok(Self {
            source,
            is_plain: structure.is_plain(),
            structure,
            parameters: Parameters::new(),
            frames: vec![Frame::default()],
            at: 0,
            statements: 0,
            made: 0,
            faulty: BTreeSet::new(),
            is_over: false,
        })
    }

    /// True if every line goes to the machine as it is.
    pub fn is_plain(&self) -> bool {
        self.is_plain
    }

    fn line(&self, index: usize) -> &'s [u8] {
        self.source[index].as_ref()
    }

    /// The next line, as it is.
    fn unchanged(&mut self) -> Option<PlainLine<'s>> {
        let text = Cow::Borrowed(self.source.get(self.at)?.as_ref());
        self.at += 1;
        Some(PlainLine { number: self.at, text })
    }

    /// Carries out the next line. Returns what it makes for the machine.
    fn step(&mut self) -> Result<Option<Cow<'s, [u8]>>, Problem> {
        let (index, line) = (self.at, self.line(self.at));
        self.at += 1;
        match self.structure.glances[index] {
            Glance::Plain => Ok(Some(Cow::Borrowed(line))),
            Glance::Ends => {
                self.is_over = true;
                Ok(Some(Cow::Borrowed(line)))
            }
            Glance::Aborts => Err(Problem::Aborted(aborted(line))),
            Glance::Unread => Err(self.structure.unread[&index].clone()),
            Glance::Words => self.words(line),
            Glance::Label => self.label(index, line),
        }
    }

    fn words(&mut self, line: &'s [u8]) -> Result<Option<Cow<'s, [u8]>>, Problem> {
        let words = Words::read(line, &self.parameters)?;
        words.sets.into_iter().for_each(|(parameter, value)| self.parameters.set(parameter, value));
        self.is_over |= words.ends;
        if let Some((number, times)) = words.call {
            self.call_number(number, times)?;
        }
        if words.returns {
            self.end_number()?;
        }
        Ok((!words.text.is_empty()).then_some(Cow::Owned(words.text)))
    }

    fn label(&mut self, index: usize, line: &'s [u8]) -> Result<Option<Cow<'s, [u8]>>, Problem> {
        let Step { label, flow, behind } = self.structure.steps[&index].clone();
        match flow {
            Flow::Number(number) => return self.number(number, line),
            Flow::Call => {
                let (label, behind) = match label {
                    Some(label) => (label, behind),
                    None => computed(line, &self.parameters)?,
                };
                self.call(&label, line, behind)?;
            }
            Flow::EndSub | Flow::Return => self.end_sub(label, line, behind)?,
            Flow::If { next } => self.branch(line, behind, next)?,
            Flow::Sub { end } | Flow::Break { end } => self.at = end + 1,
            // They are reached from the branch before them, which was carried out.
            Flow::ElseIf { end, .. } | Flow::Else { end } => self.at = end + 1,
            Flow::EndIf | Flow::Do => {}
            Flow::While { end } if !self.holds(line, behind)? => self.at = end + 1,
            Flow::While { .. } => {}
            Flow::DoWhile { begin } if self.holds(line, behind)? => self.at = begin + 1,
            Flow::DoWhile { .. } => {}
            Flow::EndWhile { begin } => self.at = begin,
            Flow::Repeat { end } => match self.times(line, behind)? {
                0 => self.at = end + 1,
                times => drop(self.frame().repeats.insert(index, times)),
            },
            Flow::EndRepeat { begin } => {
                let left = self.frame().repeats.get_mut(&begin);
                if left.is_some_and(|left| {
                    *left -= 1;
                    *left > 0
                }) {
                    self.at = begin + 1;
                }
            }
            Flow::Continue { end } => self.at = end,
        }
        Ok(None)
    }

    fn frame(&mut self) -> &mut Frame {
        self.frames.last_mut().expect("the main program stays")
    }

    /// Reads the one value behind the O-word of a line.
    fn value(&self, line: &[u8], behind: usize) -> Result<f64, Problem> {
        let mut reader = Reader::new(Cursor::new(line, behind), &self.parameters);
        let value = reader.expression()?;
        if reader.cursor.is_over() { Ok(value) } else { Err(Problem::Behind(reader.cursor.rest())) }
    }

    fn holds(&self, line: &[u8], behind: usize) -> Result<bool, Problem> {
        Ok(self.value(line, behind)? != 0.0)
    }

    /// The count of a repeat: the nearest whole number, 0 for a negative one.
    fn times(&self, line: &[u8], behind: usize) -> Result<u32, Problem> {
        count(libm::round(self.value(line, behind)?).max(0.0), "", TIMES_MAX)
    }

    /// Goes into the first branch of an `if` whose condition holds.
    fn branch(&mut self, mut line: &'s [u8], mut behind: usize, mut next: usize) -> Result<(), Problem> {
        while !self.holds(line, behind)? {
            self.at = next + 1;
            let step = &self.structure.steps[&next];
            let Flow::ElseIf { next: another, .. } = step.flow else { return Ok(()) };
            (line, behind, next) = (self.line(next), step.behind, another);
            self.parameters.line = self.at;
        }
        Ok(())
    }

    fn call(&mut self, label: &Label, line: &[u8], behind: usize) -> Result<(), Problem> {
        let begin = self.structure.subs.get(label).copied();
        let begin = begin.ok_or_else(|| Problem::NoSub(label.with(Keyword::Number)))?;
        let mut reader = Reader::new(Cursor::new(line, behind), &self.parameters);
        let mut arguments = Vec::new();
        reader.cursor.go_behind_comments();
        while reader.cursor.peek() == Some(b'[') {
            arguments.push(reader.expression()?);
            reader.cursor.go_behind_comments();
        }
        if !reader.cursor.is_over() {
            return Err(Problem::NoBracket(reader.cursor.rest()));
        }
        if arguments.len() > ARGUMENTS_MAX {
            return Err(Problem::Arguments(arguments.len()));
        }
        self.enter(Kind::Sub, begin)?;
        self.parameters.enter(Some(&arguments));
        self.parameters.returned(None);
        Ok(())
    }

    fn end_sub(&mut self, label: Option<Label>, line: &[u8], behind: usize) -> Result<(), Problem> {
        let has_value = !Cursor::new(line, behind).is_over();
        let value = if has_value { Some(self.value(line, behind)?) } else { None };
        match self.frame().kind {
            Kind::Sub => {
                self.parameters.returned(value);
                self.leave();
                Ok(())
            }
            Kind::Numbered { number, .. } => Err(Problem::NoReturn { number }),
            Kind::Main => Err(Problem::NoSubAround(label.map_or(String::new(), |label| label.with(Keyword::EndSub)))),
        }
    }

    fn enter(&mut self, kind: Kind, begin: usize) -> Result<(), Problem> {
        if self.frames.len() > NESTED_CALLS_MAX {
            return Err(Problem::NestedCalls);
        }
        self.frames.push(Frame { kind, back_to: self.at, repeats: BTreeMap::new() });
        self.at = begin + 1;
        Ok(())
    }

    fn leave(&mut self) {
        self.parameters.leave();
        if let Some(frame) = self.frames.pop() {
            self.at = frame.back_to;
        }
    }

    /// A line that is the number of a program.
    fn number(&mut self, number: u32, line: &'s [u8]) -> Result<Option<Cow<'s, [u8]>>, Problem> {
        if let Kind::Numbered { number, .. } = self.frame().kind {
            return Err(Problem::NoReturn { number });
        }
        if self.structure.called.contains(&number) {
            return Err(Problem::RunsInto { number });
        }
        Ok(Some(Cow::Borrowed(line)))
    }

    fn call_number(&mut self, number: u32, times: u32) -> Result<(), Problem> {
        let begin = match self.structure.numbers.get(&number).map(Vec::as_slice) {
            Some(&[begin]) => begin,
            Some(lines) => return Err(Problem::Twice { what: format!("O{number}"), line: lines[0] + 1 }),
            None if number >= 10_000 => return Err(Problem::NoProgramOfTimes(number)),
            None => return Err(Problem::NoProgram(number)),
        };
        if times > 0 {
            self.enter(Kind::Numbered { number, begin, times: times - 1 }, begin)?;
            self.parameters.enter(None);
        }
        Ok(())
    }

    fn end_number(&mut self) -> Result<(), Problem> {
        let frame = self.frame();
        match &mut frame.kind {
            Kind::Main => return Err(Problem::Endless),
            Kind::Sub => return Err(Problem::ReturnFromSub),
            Kind::Numbered { begin, times, .. } if *times > 0 => {
                *times -= 1;
                let begin = *begin;
                frame.repeats.clear();
                self.parameters.leave();
                self.parameters.enter(None);
                self.at = begin + 1;
            }
            Kind::Numbered { .. } => self.leave(),
        }
        Ok(())
    }

    /// Says what is wrong at line `index`, and whether anything can follow.
    fn fail(&mut self, index: usize, problem: Problem) -> Option<LineError> {
        let line = self.line(index);
        let passes_over = match self.structure.glances[index] {
            Glance::Words => !line.contains(&b'=') && self.at == index + 1,
            glance => glance == Glance::Unread,
        };
        self.is_over |= !passes_over || matches!(problem, Problem::Statements | Problem::Lines);
        let is_new = self.faulty.insert(index);
        is_new.then(|| LineError::new(index, line, problem))
    }

    /// Carries out the next line, within the limits.
    fn limited_step(&mut self) -> Result<Option<Cow<'s, [u8]>>, Problem> {
        self.parameters.line = self.at + 1;
        match self.step()? {
            None if self.statements == STATEMENTS_MAX => Err(Problem::Statements),
            None => {
                self.statements += 1;
                Ok(None)
            }
            Some(_) if self.made == LINES_MADE_MAX.max(self.source.len()) => Err(Problem::Lines),
            Some(text) => {
                self.statements = 0;
                self.made += 1;
                Ok(Some(text))
            }
        }
    }
}

/// The message of a comment that ends the program.
fn aborted(line: &[u8]) -> String {
    let text = String::from_utf8_lossy(line);
    let message = text.split_once(',').map_or("", |(_, message)| message);
    message.split(')').next().unwrap_or_default().trim().to_owned()
}

impl<'s, L: AsRef<[u8]>> Iterator for PlainLines<'s, L> {
    type Item = Result<PlainLine<'s>, LineError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.is_plain {
            return self.unchanged().map(Ok);
        }
        while !self.is_over {
            let index = self.at;
            if index >= self.source.len() {
                self.is_over = true;
                let Kind::Numbered { number, .. } = self.frame().kind else { return None };
                return self.fail(index - 1, Problem::NoReturn { number }).map(Err);
            }
            match self.limited_step() {
                Ok(None) => {}
                Ok(Some(text)) => return Some(Ok(PlainLine { number: index + 1, text })),
                Err(problem) => {
                    if let Some(error) = self.fail(index, problem) {
                        return Some(Err(error));
                    }
                }
            }
        }
        None
    }
}
