//! Finds the word of a line at which reading stopped, and says what to do about a word that the machine does not know.

use core::{fmt, ops::Range};

use crate::{
    CycleFault, Error, Interpreter, Misfit, Modal, rotary::Rotary, words::block::BlockWords, words::decimal::Decimal,
};

/// Words that many machines know but this one does not: the letter, the first and the last of its numbers without
/// decimals, and what to do. Letters other than G and M count as number 0.
// A constant rather than a static: then it has no symbol name, and data without a name stays in the chip's flash.
const REMEDIES: &[(u8, u8, u8, &str)] = &[
    (b'G', 5, 5, "no splines here: let the CAM program give lines and arcs"),
    (b'G', 18, 19, "no plane with Z here: remove it"),
    (b'G', 33, 33, "no threads here, the spindle does not say where it stands: remove it"),
    (b'G', 38, 38, "probing is G38.2 to G38.5: give one of them"),
    (b'G', 41, 42, CUTTER),
    (b'G', 43, 43, TOOLS),
    (b'G', 44, 44, "no negative lengths here: give the length below 0, and G43"),
    (b'G', 51, 51, "no scaling here: let the CAM program scale"),
    (b'G', 68, 68, "no rotation here: let the CAM program rotate"),
    (b'G', 73, 73, CYCLES),
    (b'G', 74, 74, TAPPING),
    (b'G', 76, 76, "no threads here, the spindle does not say where it stands: remove it"),
    (b'G', 81, 83, CYCLES),
    (b'G', 84, 84, TAPPING),
    (b'G', 85, 89, CYCLES),
    (b'G', 90, 90, "arc centres are incremental here: use I J K from the start"),
    (b'M', 98, 99, "no subprograms here: isostep console --stream makes plain lines of them"),
    (
        b'O',
        0,
        0,
        "a program number stands alone on its line; isostep console --stream makes plain lines of subprograms",
    ),
    (b'A', 0, 0, FOURTH_AXIS),
    (b'B', 0, 0, AXES),
    (b'C', 0, 0, AXES),
    (b'D', 0, 0, CUTTER),
    (b'E', 0, 0, "no extruder here, and numbers have no exponents: use a post-processor for mills"),
    (b'U', 0, 0, AXES),
    (b'V', 0, 0, AXES),
    (b'W', 0, 0, AXES),
    (b'Z', 0, 0, AXES),
];
const CUTTER: &str = "no cutter compensation here: let the CAM program compensate";
const TOOLS: &str = "no tools without Z here: remove G43 and its H";
const CYCLES: &str = match crate::AXES {
    2 => "no canned cycles without Z: let the post-processor expand them",
    _ => "the canned cycles are G73 G81 G82 G83 G85 G86 G89: let the post-processor expand others",
};
const TAPPING: &str = "no tapping here, the spindle does not say where it stands: tap by hand, or mill the thread";
const AXES: &str = match crate::AXES {
    2 => "two axes only, X Y: remove it",
    3 => "three axes only, X Y Z: remove it",
    _ => "four axes only, X Y Z A: remove it",
};
/// An image of another number of axes has A.
const FOURTH_AXIS: &str = match crate::AXES {
    2 => "two axes only, X Y: remove it, or flash the firmware with 4-axes in its name",
    3 => "three axes only, X Y Z: remove it, or flash the firmware with 4-axes in its name",
    _ => AXES,
};
const NESTED: &str = "a comment ends at its first ): leave brackets out of it";
const COMMA: &str = "no commas here: write a decimal point, and nothing between words";
const EXPRESSIONS: &str =
    "no variables, expressions, checksums here: isostep console --stream makes plain lines of the first two";

/// The bytes of the word at which reading `line` from left to right stops. `line` is as from
/// [`LineAssembler`](crate::LineAssembler): G-code, `$J=`, `$N0=` or `$N1=`.
///
/// This is the word at fault for the [`Error`](crate::Error)s 1, 20, 21, 23, 24, 25 and 38, and for 2, 4 and 29 if a
/// word caused them. `None` if all words can be read, even if they do not work together, and for other lines.
///
/// ```
/// assert_eq!(isostep_console::stopped_at("G1X5D7F100"), Some(4..6));
/// assert_eq!(isostep_console::stopped_at("$J=X1X2F100"), Some(5..7));
/// assert_eq!(isostep_console::stopped_at("G1X5"), None);
/// ```
pub fn stopped_at(line: &str) -> Option<Range<usize>> {
    let words = match line.strip_prefix('$') {
        None if Interpreter::is_mark(line.as_bytes()) => return None,
        None => line,
        Some(statement) => statement.split_once('=').filter(|(name, _)| name.starts_with(['J', 'N']))?.1,
    };
    let mut left = words.as_bytes();
    BlockWords::new(Modal::default(), Rotary::default()).read(&mut left).err()?;
    let begin = line.len() - left.len();
    Some(begin..begin + word_len(left))
}

/// Length of the word that `left` begins with. It ends after its number, or before the next letter if it has no number.
fn word_len(left: &[u8]) -> usize {
    let number = left.get(1..).unwrap_or_default();
    let rest = match Decimal::read(number) {
        Some((_, rest)) => rest.len(),
        None => number.iter().position(u8::is_ascii_alphabetic).map_or(0, |letter| number.len() - letter),
    };
    left.len() - rest
}

/// The report of a refused line in addition to its error: the word and what to do. Displays as the text of a
/// `[MSG:...]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Refusal<'l> {
    word: &'l str,
    remedy: &'static str,
}

impl<'l> Refusal<'l> {
    /// The refusal of `line`, which may be any line that [`stopped_at`] accepts: if it was refused with
    /// [`Error::Unsupported`], or if it has what is left of a comment in a comment, a comma, variables, expressions or a
    /// checksum. `None` if the error says all.
    pub fn of(line: &'l str, error: Error) -> Option<Self> {
        let stopped = stopped_at(line);
        let word = stopped.clone().and_then(|range| line.get(range)).unwrap_or_default();
        match () {
            () if stopped.is_none() => {}
            () if line.contains(')') => return Some(Self { word: ")", remedy: NESTED }),
            () if line.contains(['#', '[', '*']) => return Some(Self { word, remedy: EXPRESSIONS }),
            () if word.starts_with(',') => return Some(Self { word, remedy: COMMA }),
            () => {}
        }
        if error == Error::IntegerRequired && stopped.is_none() && line.contains("G10") {
            return Some(Self {
                word: "P",
                remedy: "G10 numbers systems and tools by whole numbers: remove the fraction",
            });
        }
        (error == Error::Unsupported).then(|| match stopped {
            Some(_) => Self::of_word(word),
            // All its words are known. G10 is the only code that refuses the values of its words with this error.
            None => Self {
                word: "G10",
                remedy: "L1, L2, L10, L11 or L20 here, without a rotation: correct L, remove R of L2",
            },
        })
    }

    fn of_word(word: &'l str) -> Self {
        let letter = word.bytes().next().unwrap_or_default().to_ascii_uppercase();
        let has_code = matches!(letter, b'G' | b'M');
        let word = if has_code { word } else { word.get(..1).unwrap_or_default() };
        let code = Decimal::read(word.as_bytes().get(1..).unwrap_or_default());
        let code = code.and_then(|(number, _)| number.code_hundredths()).unwrap_or_default() / 100;
        let row = REMEDIES.iter().find(|row| row.0 == letter && (row.1.into()..=row.2.into()).contains(&code));
        Self { word, remedy: row.map_or("unknown here: remove it", |row| row.3) }
    }
}

/// The fault of a refused line beside its error. Displays as the text of a `[MSG:...]`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Explanation<'l> {
    /// A word is not known, or is none.
    Word(Refusal<'l>),
    /// The words of an arc do not fit.
    Arc(Misfit),
    /// A canned cycle cannot be made.
    Cycle(CycleFault),
    /// A word is not used.
    Unused(Unused),
}

impl fmt::Display for Explanation<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Word(refusal) => refusal.fmt(f),
            Self::Arc(misfit) => misfit.fmt(f),
            Self::Cycle(fault) => fault.fmt(f),
            Self::Unused(unused) => unused.fmt(f),
        }
    }
}

/// A word that no code of its line uses. Displays as the text of a `[MSG:...]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unused {
    pub(crate) letter: u8,
    pub(crate) is_of_arc: bool,
    pub(crate) has_radius: bool,
}

impl fmt::Display for Unused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let remedy = match self.letter {
            b'H' => "it names a tool for G43 and G43.2: add one of them, or remove it",
            b'P' if self.is_of_arc => "an arc has no turns here: write a line for each turn",
            b'I'..=b'K' if self.is_of_arc && self.has_radius => "R has given the arc: keep one of them",
            _ => "no code on the line uses it: remove it, or add the code that does",
        };
        write!(f, "{}: {remedy}", char::from(self.letter))
    }
}

impl fmt::Display for Refusal<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for part in [self.word, ": ", self.remedy] {
            f.write_str(part)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::string::{String, ToString};

    use proptest::prelude::*;

    use super::*;
    use crate::{ReportedState, Settings};

    #[test]
    fn reading_stops_at_the_first_word_that_cannot_be() {
        let rows: &[(&str, u8, &str)] = &[
            ("5X1", 1, "5"),
            ("G1X1.2.3Y1", 1, ".3"),
            ("G1)X2", 1, ")"),
            ("G1*71", 1, "*71"),
            ("X1%", 1, "%"),
            ("G0X1\u{b5}Y2", 1, "\u{b5}"),
            ("G0X", 2, "X"),
            ("G0X--5Y1", 2, "X--5"),
            ("XINF", 2, "X"),
            ("Y1X100000000", 2, "X100000000"),
            ("G1X1F-1", 4, "F-1"),
            ("G64P-1", 4, "P-1"),
            ("G1A1D2", 20, "A1"),
            ("G43.3H1", 23, "G43.3"),
            ("$N1=G0X1G44H1", 20, "G44"),
            ("$J=X1F1D5", 20, "D5"),
            ("G20X1G21", 21, "G21"),
            ("M6T1M6", 21, "M6"),
            ("X1G1.5", 23, "G1.5"),
            ("M3.1S1", 23, "M3.1"),
            ("G0X1G1", 24, "G1"),
            ("X1Y2X3", 25, "X3"),
            ("G59.4", 23, "G59.4"),
            ("X1T100000", 38, "T100000"),
        ];
        for &(line, code, word) in rows {
            let answer = Interpreter::new().interpret(line, ReportedState::Idle, &Settings::DEFAULT);
            assert_eq!(answer.map_err(Error::code), Err(code), "{line}");
            assert_eq!(stopped_at(line).map(|range| &line[range]), Some(word), "{line}");
        }
        for line in
            ["", "%", "G1", "G1X1P1", "G2X1", "G10L3P1X1", "N10000001", "$", "$$", "$100=1e3", "$Q", "$I=Q1", "$J=X1"]
        {
            assert_eq!(stopped_at(line), None, "{line}");
        }
    }

    #[test]
    fn expressions_are_named_whatever_the_error() {
        let said = |line, error| Refusal::of(line, error).map(|refusal| refusal.to_string());
        for (line, error, word) in [("G1X#1F100", Error::BadNumber, "X#1"), ("G1*71", Error::LetterMissing, "*71")] {
            assert_eq!(said(line, error), Some(std::format!("{word}: {EXPRESSIONS}")), "{line}");
        }
        assert_eq!(said("G0X", Error::BadNumber), None);
        assert_eq!(said("$I=#", Error::UnknownStatement), None);
    }

    proptest! {
        #[test]
        fn whatever_the_line_a_word_of_it_is_named(line in "[ -~]{0,79}|([GMTNOXYZF][-+0-9.]{0,12}){0,8}|\\PC{0,40}") {
            let line: String = line;
            let word = stopped_at(&line).map(|range| line[range].to_string());
            prop_assert!(word != Some(String::new()));
            let refusal = Refusal::of(&line, Error::Unsupported);
            prop_assert!(refusal.is_some_and(|refusal| refusal.to_string().contains(": ")));
        }
    }
}
