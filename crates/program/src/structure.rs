//! The blocks of a program: where each begins and ends, and where its lines lead.
//!
//! All labels are matched before the first line is carried out, so that a program whose blocks do not fit makes no line.

use std::collections::{BTreeMap, BTreeSet};

use crate::cursor::Cursor;
use crate::glance::{Glance, digits};
use crate::label::{Keyword, Label, Labelled};
use crate::{LineError, Problem};

/// Where a line with an O-word leads. Places are indices of lines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Flow {
    /// The definition of a subroutine, passed over to its end.
    Sub {
        end: usize,
    },
    EndSub,
    Return,
    Call,
    /// If it does not hold, the next branch or the end is looked at.
    If {
        next: usize,
    },
    ElseIf {
        next: usize,
        end: usize,
    },
    Else {
        end: usize,
    },
    EndIf,
    While {
        end: usize,
    },
    EndWhile {
        begin: usize,
    },
    Do,
    DoWhile {
        begin: usize,
    },
    Repeat {
        end: usize,
    },
    EndRepeat {
        begin: usize,
    },
    Break {
        end: usize,
    },
    /// To the line that ends the loop, which decides whether it goes on.
    Continue {
        end: usize,
    },
    /// The number of a program.
    Number(u32),
}

/// A line with an O-word.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Step {
    /// `None` if it has to be computed.
    pub label: Option<Label>,
    pub flow: Flow,
    /// The index of the byte behind the keyword.
    pub behind: usize,
}

/// What a program consists of.
#[derive(Default)]
pub(crate) struct Structure {
    /// What each line is.
    pub glances: Vec<Glance>,
    /// The lines with O-words, by index.
    pub steps: BTreeMap<usize, Step>,
    /// What is wrong with O-words that nobody can read.
    pub unread: BTreeMap<usize, Problem>,
    /// Where each subroutine begins.
    pub subs: BTreeMap<Label, usize>,
    /// Where each numbered program begins: at one line, if it can be called.
    pub numbers: BTreeMap<u32, Vec<usize>>,
    /// The numbers that an M98 has.
    pub called: BTreeSet<u32>,
}

/// A block that has not ended yet.
struct Open {
    keyword: Keyword,
    label: Label,
    index: usize,
    /// The lines of its branches: `if`, `elseif` and `else`.
    branches: Vec<usize>,
    /// The lines in it with `break` and `continue`.
    leaving: Vec<usize>,
}

impl Structure {
    pub fn of<L: AsRef<[u8]>>(source: &[L]) -> Result<Self, LineError> {
        let mut structure = Self { glances: Vec::with_capacity(source.len()), ..Self::default() };
        let mut open = Vec::new();
        for (index, line) in source.iter().enumerate() {
            let line = line.as_ref();
            let glance =
                structure.add(index, line, &mut open).map_err(|problem| LineError::new(index, line, problem))?;
            structure.glances.push(glance);
        }
        match open.pop() {
            None => Ok(structure),
            Some(Open { keyword, label, index, .. }) => {
                let problem = Problem::NeverEnds { begun: label.with(keyword), end: label.with(end_of(keyword)) };
                Err(LineError::new(index, source[index].as_ref(), problem))
            }
        }
    }

    /// Every line goes to the machine as it is.
    pub fn is_plain(&self) -> bool {
        let has_flow = self.steps.values().any(|step| !matches!(step.flow, Flow::Number(_)));
        !has_flow && self.unread.is_empty() && !self.glances.contains(&Glance::Words)
    }

    fn add(&mut self, index: usize, line: &[u8], open: &mut Vec<Open>) -> Result<Glance, Problem> {
        let glance = Glance::of(line);
        if glance == Glance::Words {
            self.called.extend(called(line));
        }
        if glance != Glance::Label {
            return Ok(glance);
        }
        let Labelled { label, keyword, behind } = match Labelled::read(line) {
            Ok(Some(labelled)) => labelled,
            Ok(None) => return Ok(Glance::Plain),
            // A block begins or ends there.
            Err(problem @ Problem::Behind(_)) => return Err(problem),
            Err(problem) => {
                self.unread.insert(index, problem);
                return Ok(Glance::Unread);
            }
        };
        let flow = match &label {
            Some(label) => self.flow(index, keyword, label, open)?,
            None => Flow::Call,
        };
        self.steps.insert(index, Step { label, flow, behind });
        Ok(Glance::Label)
    }

    fn flow(&mut self, index: usize, keyword: Keyword, label: &Label, open: &mut Vec<Open>) -> Result<Flow, Problem> {
        let begin = |open: &mut Vec<Open>| {
            open.push(Open { keyword, label: label.clone(), index, branches: vec![index], leaving: Vec::new() });
        };
        // What is not known yet is 0 until the end of the block.
        Ok(match keyword {
            Keyword::Sub => {
                if let Some(other) = open.last() {
                    return Err(Problem::NestedSub(other.label.with(other.keyword)));
                }
                if let Some(other) = self.subs.insert(label.clone(), index) {
                    return Err(Problem::Twice { what: label.with(keyword), line: other + 1 });
                }
                begin(open);
                Flow::Sub { end: 0 }
            }
            Keyword::If => {
                begin(open);
                Flow::If { next: 0 }
            }
            Keyword::Repeat => {
                begin(open);
                Flow::Repeat { end: 0 }
            }
            Keyword::Do => {
                begin(open);
                Flow::Do
            }
            Keyword::While if !open.last().is_some_and(|last| last.keyword == Keyword::Do && last.label == *label) => {
                begin(open);
                Flow::While { end: 0 }
            }
            Keyword::ElseIf | Keyword::Else => {
                let last = innermost(open, keyword, label)?;
                if last.branches.len() > 1
                    && matches!(self.steps[&last.branches[last.branches.len() - 1]].flow, Flow::Else { .. })
                {
                    return Err(Problem::BehindElse(label.with(keyword)));
                }
                last.branches.push(index);
                if keyword == Keyword::Else { Flow::Else { end: 0 } } else { Flow::ElseIf { next: 0, end: 0 } }
            }
            Keyword::Break | Keyword::Continue => {
                let is_loop =
                    |one: &&mut Open| !matches!(one.keyword, Keyword::If | Keyword::Sub) && one.label == *label;
                let around = open.iter_mut().rev().find(is_loop);
                let Some(around) = around else { return Err(Problem::NoLoop(label.with(keyword))) };
                around.leaving.push(index);
                if keyword == Keyword::Break { Flow::Break { end: 0 } } else { Flow::Continue { end: 0 } }
            }
            Keyword::Return => {
                // As in LinuxCNC, its label does not matter.
                if open.first().is_none_or(|first| first.keyword != Keyword::Sub) {
                    return Err(Problem::NoSubAround(label.with(keyword)));
                }
                Flow::Return
            }
            Keyword::Call => Flow::Call,
            Keyword::Number => {
                let number: u32 = label.0.parse().map_err(|_| Problem::NoKeyword(label.with(keyword)))?;
                self.numbers.entry(number).or_default().push(index);
                Flow::Number(number)
            }
            Keyword::EndSub | Keyword::EndIf | Keyword::While | Keyword::EndWhile | Keyword::EndRepeat => {
                innermost(open, keyword, label)?;
                let block = open.pop().expect("the innermost block");
                self.close(&block, index)
            }
        })
    }

    /// Leads the lines of a block that ends at line `end` to where they go.
    fn close(&mut self, block: &Open, end: usize) -> Flow {
        let nexts = block.branches[1..].iter().copied().chain([end]);
        for (branch, to) in block.branches.iter().zip(nexts) {
            self.lead(*branch, to, end);
        }
        block.leaving.iter().for_each(|index| self.lead(*index, end, end));
        let begin = block.index;
        match block.keyword {
            Keyword::Sub => Flow::EndSub,
            Keyword::While => Flow::EndWhile { begin },
            Keyword::Do => Flow::DoWhile { begin },
            Keyword::Repeat => Flow::EndRepeat { begin },
            _ => Flow::EndIf,
        }
    }

    fn lead(&mut self, index: usize, to: usize, block_end: usize) {
        let Some(step) = self.steps.get_mut(&index) else { return };
        match &mut step.flow {
            Flow::If { next } => *next = to,
            Flow::ElseIf { next, end } => (*next, *end) = (to, block_end),
            Flow::Sub { end }
            | Flow::Else { end }
            | Flow::While { end }
            | Flow::Repeat { end }
            | Flow::Break { end }
            | Flow::Continue { end } => *end = block_end,
            _ => {}
        }
    }
}

/// The word that ends a block.
fn end_of(begun: Keyword) -> Keyword {
    match begun {
        Keyword::Sub => Keyword::EndSub,
        Keyword::While => Keyword::EndWhile,
        Keyword::Do => Keyword::While,
        Keyword::Repeat => Keyword::EndRepeat,
        _ => Keyword::EndIf,
    }
}

/// The block that has begun last, if this word and label belong to it.
fn innermost<'o>(open: &'o mut [Open], keyword: Keyword, label: &Label) -> Result<&'o mut Open, Problem> {
    let belongs = |last: &Open| {
        let of_if = last.keyword == Keyword::If && matches!(keyword, Keyword::ElseIf | Keyword::Else);
        last.label == *label && (of_if || end_of(last.keyword) == keyword)
    };
    match open.last_mut() {
        Some(last) if belongs(last) => Ok(last),
        Some(last) => Err(Problem::Unmatched {
            word: label.with(keyword),
            open: last.label.with(last.keyword),
            line: last.index + 1,
        }),
        None => Err(Problem::NothingOpen(label.with(keyword))),
    }
}

/// The program that a line calls by M98 with a plain P.
fn called(line: &[u8]) -> Option<u32> {
    let code = line.split(|byte| matches!(byte, b'(' | b';')).next()?;
    let values = |letter: u8| {
        let places = (1..).zip(code).filter(move |(_, byte)| byte.to_ascii_uppercase() == letter);
        places.filter_map(|(behind, _)| digits(Cursor::new(code, behind)))
    };
    values(b'P').next().filter(|_| values(b'M').any(|number| number == 98))
}
