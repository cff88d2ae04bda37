//! Plain decimals, as G-code and settings write them: no exponent, no infinity.
//!
//! The standard library would read them too, with a table of powers that takes 13 KiB of a chip's flash.

/// A value must be less than this: Grbl, too, reads 8 digits before the point.
const VALUE_BOUND: f64 = 1e8;
/// So many digits a 64-bit integer holds, and more than a value resolves; further decimals are read and dropped.
const DIGITS_MAX: u32 = 18;
/// Grbl, too, reads 8 digits before the point; it cuts the rest off in silence.
const CODE_DIGITS_MAX: u32 = 8;

/// A number as it is written: `mantissa` without its point, of which `decimals` digits stand behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Decimal {
    signed: bool,
    negative: bool,
    mantissa: u64,
    digits: u32,
    decimals: u32,
    has_point: bool,
    /// More digits before the point than can be held.
    overflown: bool,
}

impl Decimal {
    /// Reads the number that `text` begins with; what comes after it. `None` if it begins with none.
    pub fn read(text: &[u8]) -> Option<(Self, &[u8])> {
        let signed = matches!(text, [b'+' | b'-', ..]);
        let mut rest = &text[usize::from(signed)..];
        let mut number = Self {
            signed,
            negative: text.first() == Some(&b'-'),
            mantissa: 0,
            digits: 0,
            decimals: 0,
            has_point: false,
            overflown: false,
        };
        while let [byte, after @ ..] = rest {
            match byte {
                b'0'..=b'9' => number.push(byte - b'0'),
                b'.' if !number.has_point => number.has_point = true,
                _ => break,
            }
            rest = after;
        }
        (number.digits > 0).then_some((number, rest))
    }

    fn push(&mut self, digit: u8) {
        if self.digits < DIGITS_MAX {
            self.mantissa = 10 * self.mantissa + u64::from(digit);
            self.digits += 1;
            self.decimals += u32::from(self.has_point);
        } else {
            self.overflown |= !self.has_point;
        }
    }

    /// `None` if it is too large.
    pub fn value(&self) -> Option<f32> {
        let magnitude = self.magnitude();
        let value = if self.negative { -magnitude } else { magnitude };
        (magnitude < VALUE_BOUND && !self.overflown).then_some(value as f32)
    }

    /// The number of a code in hundredths, rounded, if it is written without a sign and with at most 8 digits before
    /// the point.
    pub fn code_hundredths(&self) -> Option<u32> {
        let plain = !self.signed && self.digits - self.decimals <= CODE_DIGITS_MAX;
        plain.then(|| (self.magnitude() * 100.0 + 0.5) as u32)
    }

    /// Both are exact in a double up to 2^53 and 10^22, so the quotient is the nearest there is.
    fn magnitude(&self) -> f64 {
        self.mantissa as f64 / (0..self.decimals).fold(1.0, |power, _| 10.0 * power)
    }
}

#[cfg(test)]
mod tests {
    use std::{format, string::ToString};

    use proptest::prelude::*;

    use super::*;

    fn value(text: &str) -> Option<f32> {
        let (number, rest) = Decimal::read(text.as_bytes())?;
        assert!(rest.is_empty(), "{text}");
        number.value()
    }

    #[test]
    fn reads_what_people_write() {
        let rows = [("5", 5.0), ("5.", 5.0), ("+.25", 0.25), ("-0.1", -0.1), ("00012.5000", 12.5), ("-0", 0.0)];
        for (text, expected) in rows {
            assert_eq!(value(text), Some(expected), "{text}");
        }
        for text in ["", ".", "-", "+.", "x", "--5"] {
            assert_eq!(Decimal::read(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn refuses_what_is_too_large_and_drops_decimals_beyond_what_resolves() {
        assert_eq!(value("99999999.9"), Some(1e8), "rounded to the nearest there is");
        assert_eq!(value("100000000"), None);
        assert_eq!(value("1000000000000000000000000"), None);
        assert_eq!(value("0.1000000000000000000000000001"), Some(0.1));
    }

    proptest! {
        #[test]
        fn agrees_with_the_standard_library(whole in 0u32..100_000_000, decimals in "[0-9]{0,12}") {
            let text = format!("{whole}.{decimals}");
            prop_assert_eq!(value(&text), text.parse().ok().filter(|_| text.parse::<f64>().unwrap() < 1e8));
        }

        #[test]
        fn reads_back_what_is_printed(expected in -99_999_999f32..99_999_999f32) {
            prop_assert_eq!(value(&expected.to_string()), Some(expected));
        }
    }
}
