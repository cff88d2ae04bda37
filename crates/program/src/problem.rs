//! What can be wrong with a program.

use crate::{LINES_MADE_MAX, NESTED_CALLS_MAX, NESTED_VALUES_MAX, STATEMENTS_MAX};

/// Characters of a line that are shown at most.
const TEXT_CHARS: usize = 80;

/// A text without the blanks around it, or so many characters of it.
pub(crate) fn shortened(text: &str, chars: usize) -> String {
    let text = text.trim();
    match text.char_indices().nth(chars) {
        None => text.to_owned(),
        Some((end, _)) => format!("{}...", &text[..end]),
    }
}

/// A line that cannot be carried out, and why.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[error("line {line} `{text}`: {problem}")]
pub struct LineError {
    /// Its number in the file, from 1.
    pub line: usize,
    /// Its text, without the blanks around it; of a long one the beginning.
    pub text: String,
    /// What is wrong.
    pub problem: Problem,
}

impl LineError {
    pub(crate) fn new(index: usize, line: &[u8], problem: Problem) -> Self {
        Self { line: index + 1, text: shortened(&String::from_utf8_lossy(line), TEXT_CHARS), problem }
    }
}

/// What is wrong with a line, and what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "each says in its words what it is")]
pub enum Problem {
    // Values.
    #[error("`{0}` is no value: write a number, a parameter (#1, #<name>), [...], or a function such as SIN[30]")]
    NoValue(String),
    #[error("`{0}` is no operation: use + - * / ** MOD, EQ NE GT GE LT LE, AND OR XOR, or close the bracket")]
    NoOperation(String),
    #[error("a bracket is not closed: add ]")]
    NotClosed,
    #[error("a value in brackets belongs before `{0}`: write [...]")]
    NoBracket(String),
    #[error("ATAN has two values: write ATAN[y]/[x]")]
    NoSlash,
    #[error("EXISTS takes a parameter and not `{0}`: write EXISTS[#<name>]")]
    NoParameter(String),
    #[error("`{0}` has no letter before it: write a word such as X[...], or a parameter to be set, such as #1=[...]")]
    NoLetter(String),
    #[error(
        "values are nested more than {NESTED_VALUES_MAX} deep: calculate a part of them on a line before, into a parameter"
    )]
    NestedValues,
    #[error("{0} is divided by zero: test the divisor by an o-if before")]
    DivisionByZero(String),
    #[error("{0} ** {1}: a negative number has whole powers only")]
    PowerOfNegative(String, String),
    #[error("{0}[{1}] has no value: it takes {2}")]
    OutOfRange(&'static str, String, &'static str),
    #[error("the result is no finite number: calculate with smaller ones")]
    NotFinite,
    #[error("{0} is too large for a word: values are below 100,000,000")]
    TooLarge(String),
    #[error("{of}{value} is no count: it is a whole number from 0 to {most}")]
    BadCount { of: &'static str, value: String, most: u32 },
    // Parameters.
    #[error("#{0}: a parameter's number is whole")]
    NumberNotWhole(String),
    #[error("#{0}: parameters are #1 to #5000")]
    NumberOutOfRange(i64),
    #[error(
        "{0} is {1}, which is known on the machine only: set a parameter of your own (#1 to #5000) before, and use that"
    )]
    OfMachine(String, &'static str),
    #[error("{0} has never been set: set it on a line before; names without _ belong to the subroutine that sets them")]
    NeverSet(String),
    #[error("{0} can be read and not set: use another name")]
    ReadOnly(String),
    #[error("`{0}` is no name: write <name>")]
    BadName(String),
    #[error("= is missing before `{0}`: write #1=value")]
    NoEqualSign(String),
    // O-words.
    #[error(
        "`{0}`: behind a label comes sub, endsub, return, call, if, elseif, else, endif, while, endwhile, do, repeat, endrepeat, break or continue"
    )]
    NoKeyword(String),
    #[error("`{0}` stands behind the O-word: give it a line of its own")]
    Behind(String),
    #[error("`{0}`: only the label of a call can be computed: write a number or <name>")]
    ComputedLabel(String),
    #[error("{0} is no label: it is a whole number, 0 or more")]
    BadLabel(String),
    #[error("{begun} has no {end}: add it where the block ends")]
    NeverEnds { begun: String, end: String },
    #[error("{word} does not belong to {open} of line {line}, which is to end first: make the labels and words fit")]
    Unmatched { word: String, open: String, line: usize },
    #[error("{0} ends or divides a block that has not begun: begin it before, with the same label")]
    NothingOpen(String),
    #[error("{0} comes behind the else of its block: put it before")]
    BehindElse(String),
    #[error("{0} is in no loop of this label: use the label of the while, do or repeat around it")]
    NoLoop(String),
    #[error("{0} is in no subroutine: put it between a sub and its endsub")]
    NoSubAround(String),
    #[error("a subroutine cannot begin inside {0}: put it before or behind that")]
    NestedSub(String),
    #[error("{what} is in line {line} already: give it another label")]
    Twice { what: String, line: usize },
    #[error("there is no {0} sub in this file, and no other file is read: copy it into this one")]
    NoSub(String),
    #[error("a call has at most 30 values: {0} are too many")]
    Arguments(usize),
    #[error("subroutines are nested more than {NESTED_CALLS_MAX} deep: does one call itself without an end?")]
    NestedCalls,
    // M98 and M99.
    #[error("M98 does not say which program it calls: write M98 P1234 for that of the line O1234")]
    CallWithoutNumber,
    #[error("there is no line O{0} in this file, and no other file is read: copy it into this one")]
    NoProgram(u32),
    #[error("there is no line O{0} in this file: if it is to mean {times} times O{number}, write M98 P{number} L{times}", number = .0 % 10_000, times = .0 / 10_000)]
    NoProgramOfTimes(u32),
    #[error("M98 and M99 stand once on a line, whose P and L are theirs: give each a line of its own")]
    TwoCalls,
    #[error("M99 P{0} goes on at a line by its number, which is not done: use an o-while or o-if")]
    ReturnToLine(String),
    #[error("M99 in the main program repeats it without an end: end it with M2 or M30")]
    Endless,
    #[error("M99 does not end a subroutine that begins with sub: write endsub or return")]
    ReturnFromSub,
    #[error("the program runs into O{number}, which is called from elsewhere: end it with M2 or M30 before")]
    RunsInto { number: u32 },
    #[error("O{number} has no M99 before this line: end it with M99")]
    NoReturn { number: u32 },
    // Limits.
    #[error("{STATEMENTS_MAX} lines were carried out without one for the machine: does a loop have no end?")]
    Statements,
    #[error("more than {LINES_MADE_MAX} lines are made: does a loop have no end? If it has, divide the program")]
    Lines,
    #[error("the program says so: {0}")]
    Aborted(String),
}
