//! Plain decimals, as G-code and settings write them: no exponent, no infinity.
//!
//! The standard library would read them too, with a table of powers that takes 13 KiB of a chip's flash.

/// A value must be less than this: Grbl, too, reads 8 digits before the point.
const VALUE_BOUND: f64 = 1e8;
/// So many digits a `u32` holds, whatever they are.
const HALF_DIGITS: u32 = 9;
/// More than a value resolves; further decimals are read and dropped.
const DIGITS_MAX: u32 = 2 * HALF_DIGITS;
/// So many digits an `f32` holds exactly, whatever they are, and so a power of ten as long.
const SHORT_DIGITS: u32 = 7;
static POWERS: [f32; SHORT_DIGITS as usize + 1] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7];
/// Grbl, too, reads 8 digits before the point; it cuts the rest off in silence.
const CODE_DIGITS_MAX: u32 = 8;

/// A number as it is written: `digits` digits without their point, of which `decimals` stand behind it.
///
/// Small chips multiply 32 bits by 32 at once, but have to call for 64, or to see whether a product overflows. So nothing
/// here does either, nor a double's arithmetic, for a number as short as those of a program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Decimal {
    signed: bool,
    negative: bool,
    /// The first half of the digits there is room for.
    first: u32,
    /// The second half.
    second: u32,
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
            first: 0,
            second: 0,
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
            let half = if self.digits < HALF_DIGITS { &mut self.first } else { &mut self.second };
            *half = half.wrapping_mul(10).wrapping_add(digit.into());
            self.digits += 1;
            self.decimals += u32::from(self.has_point);
        } else {
            self.overflown |= !self.has_point;
        }
    }

    /// `None` if it is too large.
    pub fn value(&self) -> Option<f32> {
        let magnitude = if self.digits <= SHORT_DIGITS { self.short() } else { self.long()? };
        Some(if self.negative { -magnitude } else { magnitude })
    }

    /// The number of a code in hundredths, rounded, if it is written without a sign and with at most 8 digits before
    /// the point.
    pub fn code_hundredths(&self) -> Option<u32> {
        let plain = !self.signed && self.digits - self.decimals <= CODE_DIGITS_MAX;
        plain.then(|| match self.decimals {
            0 => self.first.saturating_mul(100),
            _ => (self.magnitude() * 100.0 + 0.5) as u32,
        })
    }

    /// A short number without its sign. Both are exact, so the quotient is the nearest there is.
    fn short(&self) -> f32 {
        self.first as f32 / POWERS[self.decimals as usize]
    }

    /// A number without its sign, rounded twice; `None` if it is too large.
    fn long(&self) -> Option<f32> {
        let magnitude = self.magnitude();
        (magnitude < VALUE_BOUND && !self.overflown).then_some(magnitude as f32)
    }

    /// Both are exact in a double up to 2^53 and 10^22, so the quotient is the nearest there is.
    fn magnitude(&self) -> f64 {
        let seconds = self.digits.saturating_sub(HALF_DIGITS);
        let mantissa = u64::from(self.first) * 10u64.pow(seconds) + u64::from(self.second);
        mantissa as f64 / (0..self.decimals).fold(1.0, |power, _| 10.0 * power)
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
        // One digit more than there is room for, of which ten count.
        assert_eq!(value("0.000000009999999999"), Some(1e-8));
    }

    proptest! {
        #[test]
        fn agrees_with_the_standard_library(whole in 0u32..100_000_000, decimals in "[0-9]{0,12}") {
            let text = format!("{whole}.{decimals}");
            prop_assert_eq!(value(&text), text.parse().ok().filter(|_| text.parse::<f64>().unwrap() < 1e8));
        }

        #[test]
        fn a_short_number_is_what_a_double_makes_of_it(text in "[0-9]{0,7}[.][0-9]{0,7}") {
            if let Some((number, _)) = Decimal::read(text.as_bytes()).filter(|(number, _)| number.digits <= SHORT_DIGITS) {
                prop_assert_eq!(Some(number.short()), number.long());
            }
        }

        #[test]
        fn a_whole_code_is_what_a_double_makes_of_it(code in 0u32..=99_999_999) {
            let (number, _) = Decimal::read(code.to_string().as_bytes()).expect("digits");
            let expected = (number.magnitude() * 100.0 + 0.5) as u32;
            prop_assert_eq!(number.code_hundredths(), Some(expected));
        }

        #[test]
        fn reads_back_what_is_printed(expected in -99_999_999f32..99_999_999f32) {
            prop_assert_eq!(value(&expected.to_string()), Some(expected));
        }
    }
}
