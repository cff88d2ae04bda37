//! G-code words: each is a letter and a number.
//!
//! Each line of a program is read by this module, which takes much of its time: on a chip it may be in fast memory, and the rest
//! of the crate in slow memory.

pub(crate) mod block;
pub(crate) mod decimal;

use self::decimal::Decimal;
use crate::{AXES, Error, axes};

/// One word of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Word {
    /// G with its number in hundredths: 9110 is G91.1.
    G(u32),
    /// M with its number in hundredths.
    M(u32),
    /// A letter that gives a length or an angle, and its value in 10^-8 mm, inch or degree.
    Length(u8, i64),
    /// Any other upper-case letter and its value, finite.
    Value(u8, f32),
}

/// Calls `take` for each word of `line` until it refuses one. `line` then begins with that word.
///
/// # Errors
/// [`Error::LetterMissing`] or [`Error::BadNumber`] where the line does not consist of words, [`Error::IntegerRequired`]
/// where H, L, N or T have a fraction; otherwise the error of `take`.
pub(crate) fn for_each(line: &mut &[u8], mut take: impl FnMut(Word) -> Result<(), Error>) -> Result<(), Error> {
    while let [letter, number @ ..] = *line {
        if !letter.is_ascii_alphabetic() {
            return Err(Error::LetterMissing);
        }
        let (decimal, after) = Decimal::read(number).ok_or(Error::BadNumber)?;
        take(word(letter.to_ascii_uppercase(), decimal)?)?;
        *line = after;
    }
    Ok(())
}

fn word(letter: u8, number: Decimal) -> Result<Word, Error> {
    let code = || number.code_hundredths().ok_or(Error::BadNumber);
    let length = || number.length().map(|value| Word::Length(letter, value)).ok_or(Error::BadNumber);
    match letter {
        b'G' => code().map(Word::G),
        b'M' => code().map(Word::M),
        b'I'..=b'K' | b'Q' | b'R' | b'X' | b'Y' => length(),
        b'Z' if AXES > axes::Z => length(),
        b'A' if AXES > axes::A => length(),
        b'H' | b'L' | b'N' | b'T' if !number.is_whole() => Err(Error::IntegerRequired),
        _ => number.value().map(|value| Word::Value(letter, value)).ok_or(Error::BadNumber),
    }
}

#[cfg(test)]
mod tests {
    use std::{string::String, vec, vec::Vec};

    use proptest::prelude::*;

    use super::*;

    fn words(line: &str) -> Result<Vec<Word>, Error> {
        let mut words = Vec::new();
        for_each(&mut line.as_bytes(), |word| {
            words.push(word);
            Ok(())
        })
        .map(|()| words)
    }

    #[test]
    fn words_come_in_order_with_exact_values() {
        use Word::{G, Length, M, Value};
        let line = "N10G01X-1.5Y+.25Z0.1M3.S1000G91.1T7F5.G5.006";
        let expected = vec![
            Value(b'N', 10.0),
            G(100),
            Length(b'X', -150_000_000),
            Length(b'Y', 25_000_000),
            Length(b'Z', 10_000_000),
            M(300),
            Value(b'S', 1000.0),
            G(9110),
            Value(b'T', 7.0),
            Value(b'F', 5.0),
            G(501),
        ];
        assert_eq!(words(line), Ok(expected));
        assert_eq!(words("G1N9999999X2"), Ok(vec![G(100), Value(b'N', 9_999_999.0), Length(b'X', 200_000_000)]));
        assert_eq!(words(""), Ok(vec![]));
    }

    #[test]
    fn what_is_no_word_is_refused() {
        use Error::{BadNumber, LetterMissing};
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
            ("N99999999999", BadNumber),
            ("G1N", BadNumber),
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
