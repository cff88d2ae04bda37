//! G-code words from the `gcode` crate's allocation-free parser.
//!
//! That parser recovers from errors and goes on, as editors like it; a machine must not. So the first
//! diagnostic, or the first word refused, decides the line. Codes are checked beforehand: the parser overflows above
//! 8 digits, takes G91.01 for G91.1, and reports a malformed code by a type it does not export.

use gcode::core::{
    BlockVisitor, CommandVisitor, ControlFlow, Diagnostics, HasDiagnostics, Number, ProgramVisitor, Span, TokenType,
    Value,
};

use crate::Error;

/// Grbl, too, reads 8 digits before the point; it cuts the rest off in silence.
const MAX_WHOLE_DIGITS: usize = 8;
/// The same for values.
pub(crate) const VALUE_BOUND: f32 = 1e8;

/// One word of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Word {
    /// G with its number in tenths: 911 is G91.1.
    G(u32),
    /// M with its number in tenths.
    M(u32),
    /// Any other upper-case letter and its value, finite.
    Value(u8, f32),
}

/// Calls `take` for each word of `line`, until it refuses one.
///
/// # Errors
/// [`Error::LetterMissing`] or [`Error::BadNumber`] where the line is not words; else what `take` says.
pub(crate) fn for_each(line: &str, mut take: impl FnMut(Word) -> Result<(), Error>) -> Result<(), Error> {
    if !line.split(['G', 'M', 'T', 'g', 'm', 't']).skip(1).all(begins_with_code_number) {
        return Err(Error::BadNumber);
    }
    let mut reader = Reader { line, take: &mut take, result: Ok(()) };
    gcode::core::parse(line, &mut reader);
    reader.result
}

/// At most 8 digits, then at most one decimal; what is no number at all is left to the parser.
fn begins_with_code_number(text: &str) -> bool {
    let end = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    match text[..end].split_once('.') {
        None => end <= MAX_WHOLE_DIGITS,
        Some((whole, tenths)) => (1..=MAX_WHOLE_DIGITS).contains(&whole.len()) && tenths.len() == 1,
    }
}

struct Reader<'a> {
    line: &'a str,
    take: &'a mut dyn FnMut(Word) -> Result<(), Error>,
    result: Result<(), Error>,
}

impl Reader<'_> {
    fn word(&mut self, word: Word) {
        if self.result.is_ok() {
            self.result = (self.take)(word);
        }
    }

    fn value(&mut self, letter: char, value: Value<'_>) {
        match value {
            Value::Literal(value) if value.abs() < VALUE_BOUND => {
                self.word(Word::Value(letter.to_ascii_uppercase() as u8, value));
            }
            _ => self.fail(Error::BadNumber),
        }
    }

    fn fail(&mut self, error: Error) {
        if self.result.is_ok() {
            self.result = Err(error);
        }
    }

    /// The parser wants N and O before the first code; Grbl takes N anywhere.
    fn late_number(&mut self, letter: &str, span: Span) {
        let text = self.line.get(span.start + 1..span.end()).unwrap_or_default();
        match (letter, text.parse::<u32>()) {
            ("N", Ok(number)) => self.word(Word::Value(b'N', number as f32)),
            ("N", Err(_)) => self.fail(Error::BadNumber),
            _ => self.fail(Error::Unsupported),
        }
    }
}

const fn tenths(number: Number) -> u32 {
    number.major() * 10
        + match number.minor() {
            Some(minor) => minor.get(),
            None => 0,
        }
}

impl ProgramVisitor for Reader<'_> {
    fn start_block(&mut self) -> ControlFlow<impl BlockVisitor + '_> {
        ControlFlow::Continue(Visitor(self))
    }
}

impl Diagnostics for Reader<'_> {
    fn emit_unknown_content(&mut self, _text: &str, _span: Span) {
        self.fail(Error::LetterMissing);
    }

    fn emit_unexpected(&mut self, actual: &str, expected: &[TokenType], span: Span) {
        match expected {
            [TokenType::Letter, TokenType::Number] => self.late_number(actual, span),
            [TokenType::Letter, ..] => self.fail(Error::LetterMissing),
            _ => self.fail(Error::BadNumber),
        }
    }

    fn emit_parse_int_error(&mut self, _value: &str, _error: core::num::ParseIntError, _span: Span) {
        self.fail(Error::BadNumber);
    }
}

/// The parser consumes its visitors of blocks and codes; all of them write to the one reader.
struct Visitor<'a, 'r>(&'a mut Reader<'r>);

impl HasDiagnostics for Visitor<'_, '_> {
    fn diagnostics(&mut self) -> &mut dyn Diagnostics {
        self.0
    }
}

impl BlockVisitor for Visitor<'_, '_> {
    fn line_number(&mut self, number: u32, _span: Span) {
        self.0.word(Word::Value(b'N', number as f32));
    }

    fn program_number(&mut self, _number: u32, _span: Span) {
        self.0.fail(Error::Unsupported);
    }

    fn program_delimiter(&mut self, _span: Span) {
        self.0.fail(Error::LetterMissing);
    }

    fn word_address(&mut self, letter: char, value: Value<'_>, _span: Span) {
        self.0.value(letter, value);
    }

    fn start_general_code(&mut self, number: Number) -> ControlFlow<impl CommandVisitor + '_> {
        self.0.word(Word::G(tenths(number)));
        ControlFlow::Continue(Visitor(self.0))
    }

    fn start_miscellaneous_code(&mut self, number: Number) -> ControlFlow<impl CommandVisitor + '_> {
        self.0.word(Word::M(tenths(number)));
        ControlFlow::Continue(Visitor(self.0))
    }

    fn start_tool_change_code(&mut self, number: Number) -> ControlFlow<impl CommandVisitor + '_> {
        self.0.word(Word::Value(b'T', number.major() as f32));
        ControlFlow::Continue(Visitor(self.0))
    }
}

impl CommandVisitor for Visitor<'_, '_> {
    fn argument(&mut self, letter: char, value: Value<'_>, _span: Span) {
        self.0.value(letter, value);
    }
}

#[cfg(test)]
mod tests {
    use std::{string::String, vec, vec::Vec};

    use proptest::prelude::*;

    use super::*;

    fn words(line: &str) -> Result<Vec<Word>, Error> {
        let mut words = Vec::new();
        for_each(line, |word| {
            words.push(word);
            Ok(())
        })
        .map(|()| words)
    }

    #[test]
    fn words_come_in_order_with_exact_values() {
        use Word::{G, M, Value};
        let line = "N10G01X-1.5Y+.25Z0.1M3S1000G91.1T7F5.";
        let expected = vec![
            Value(b'N', 10.0),
            G(10),
            Value(b'X', -1.5),
            Value(b'Y', 0.25),
            Value(b'Z', 0.1),
            M(30),
            Value(b'S', 1000.0),
            G(911),
            Value(b'T', 7.0),
            Value(b'F', 5.0),
        ];
        assert_eq!(words(line), Ok(expected));
        assert_eq!(words("G1N9999999X2"), Ok(vec![G(10), Value(b'N', 9_999_999.0), Value(b'X', 2.0)]));
        assert_eq!(words(""), Ok(vec![]));
    }

    #[test]
    fn what_is_no_word_is_refused() {
        use Error::{BadNumber, LetterMissing, Unsupported};
        let rows: &[(&str, Error)] = &[
            ("5X1", LetterMissing),
            ("X1.5.5", LetterMissing),
            ("%", LetterMissing),
            ("-X1", LetterMissing),
            ("G1)X2", LetterMissing),
            ("#1=2", LetterMissing),
            ("G1*71", LetterMissing),
            ("X", BadNumber),
            ("G", BadNumber),
            ("GX1", BadNumber),
            ("X--5", BadNumber),
            ("X.", BadNumber),
            ("X#1", BadNumber),
            ("XINF", BadNumber),
            ("XNAN", BadNumber),
            ("X100000000", BadNumber),
            ("G-1", BadNumber),
            ("G999999999", BadNumber),
            ("M4294967295", BadNumber),
            ("T999999999", BadNumber),
            ("G1.", BadNumber),
            ("G91.01", BadNumber),
            ("N-5", BadNumber),
            ("N99999999999", BadNumber),
            ("G1N-5", BadNumber),
            ("G1N", BadNumber),
            ("O100", Unsupported),
            ("G1O100", Unsupported),
        ];
        for &(line, error) in rows {
            assert_eq!(words(line), Err(error), "{line}");
        }
    }

    proptest! {
        #[test]
        fn any_text_is_words_or_an_error(line in "[ -~]{0,79}|([GMTNOXYZF][-+0-9.]{0,12}){0,8}|\\PC{0,40}") {
            let line: String = line;
            for word in words(&line).unwrap_or_default() {
                prop_assert!(!matches!(word, Word::Value(_, value) if !value.is_finite()));
            }
        }
    }
}
