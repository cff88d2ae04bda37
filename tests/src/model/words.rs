//! The words of a line, and how a person may write them.

use std::fmt;

use oorandom::Rand64;

/// Units of a [`Word`]'s value in 1, and of a length in a millimetre: a length is counted in angstroms, in which inches
/// are exact too.
pub const ONE: i64 = 10_000_000;
/// An inch, angstroms.
pub const INCH_ANGSTROM: i64 = 254_000_000;

/// A letter and its value, which is exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Word {
    /// The letter, upper case.
    pub letter: char,
    /// The value, ten-millionths.
    pub value: i64,
}

impl Word {
    /// The word with a whole number.
    #[must_use]
    pub fn whole(letter: char, value: i64) -> Self {
        Self { letter, value: value * ONE }
    }

    /// A G word, such as 382 for G38.2.
    #[must_use]
    pub fn g(tenths: i64) -> Self {
        Self { letter: 'G', value: tenths * ONE / 10 }
    }

    /// An M word.
    #[must_use]
    pub fn m(number: i64) -> Self {
        Self::whole('M', number)
    }

    /// The number of a code, in tenths: 382 for G38.2.
    #[must_use]
    pub fn tenths(&self) -> i64 {
        self.value * 10 / ONE
    }
}

impl fmt::Display for Word {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (whole, part) = (self.value.abs() / ONE, self.value.abs() % ONE);
        let sign = if self.value < 0 { "-" } else { "" };
        let part = format!("{part:07}");
        match part.trim_end_matches('0') {
            "" => write!(f, "{}{sign}{whole}", self.letter),
            part => write!(f, "{}{sign}{whole}.{part}", self.letter),
        }
    }
}

/// The words as a line; spaces, comments, letters and zeros that change nothing are added by chance.
#[must_use]
pub fn written(words: &[Word], random: &mut Rand64) -> String {
    let style = random.rand_range(0..6);
    let mut line = String::new();
    for word in words {
        let mut text = word.to_string();
        match style {
            1 => text = text.to_lowercase(),
            // G1 is G01, X5 is X5.0.
            2 if matches!(word.letter, 'G' | 'M') && text.len() == 2 => text.insert(1, '0'),
            2 if matches!(word.letter, 'X' | 'Y' | 'Z') && !text.contains('.') => text.push_str(".0"),
            _ => {}
        }
        if style != 3 && !line.is_empty() {
            line.push(' ');
        }
        line.push_str(&text);
    }
    match style {
        4 if line.len() < 60 => line + " (note; X9)",
        5 if line.len() < 60 => line + " ; G0 X9",
        _ => line,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_is_written_with_the_digits_that_it_needs() {
        let texts = [Word::g(382), Word::g(10), Word { letter: 'X', value: -12_500_000 }, Word::whole('F', 600)];
        assert_eq!(texts.map(|word| word.to_string()), ["G38.2", "G1", "X-1.25", "F600"]);
    }
}
