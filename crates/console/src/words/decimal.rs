//! Plain decimals, as in G-code and settings: no exponent, no infinity.
//!
//! The standard library could parse them too, but its table of powers takes 13 KiB of the chip's flash.

/// Values must be less than this. Grbl also reads 8 digits before the decimal point.
const VALUE_BOUND: f64 = 1e8;
/// A `u32` holds any number of this many digits.
const HALF_DIGITS: u32 = 9;
/// Digits that are kept, which is more than a value can resolve. Further decimals are read and dropped.
const DIGITS_MAX: u32 = 2 * HALF_DIGITS;
/// An `f32` holds any number of this many digits exactly, and therefore also these powers of ten.
const SHORT_DIGITS: u32 = 7;
static POWERS: [f32; SHORT_DIGITS as usize + 1] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7];
/// Decimals of a length that count. A number of as many digits is always in range, and its digits fit `first`.
const LENGTH_DECIMALS: u32 = 8;
static TENS: [u32; LENGTH_DECIMALS as usize + 1] =
    [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000];
/// Grbl also reads 8 digits before the decimal point, but it silently cuts off the rest.
const CODE_DIGITS_MAX: u32 = 8;

/// A number as written: `digits` digits without the point, the last `decimals` of them after the point.
///
/// The chip multiplies 32 by 32 bits at once, but calls a routine for 64 bits or for an overflow check. So numbers as
/// short as those in usual programs are read without either, and without arithmetic in doubles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Decimal {
    signed: bool,
    negative: bool,
    /// The digits up to `HALF_DIGITS`, as a number.
    first: u32,
    /// The digits after those, as a number.
    second: u32,
    digits: u32,
    decimals: u32,
    has_point: bool,
    /// There are more digits before the point than can be held.
    overflown: bool,
}

impl Decimal {
    /// Reads the number at the beginning of `text`; also returns the text after it. `None` if `text` does not begin
    /// with one.
    pub fn read(text: &[u8]) -> Option<(Self, &[u8])> {
        let signed = matches!(text, [b'+' | b'-', ..]);
        let mut rest = &text[usize::from(signed)..];
        // Most numbers are no longer than this, and end in this loop.
        let (mut first, mut digits, mut point) = (0_u32, 0_u32, None);
        while let [byte, after @ ..] = rest
            && digits < HALF_DIGITS
        {
            match byte {
                b'0'..=b'9' => {
                    first = first.wrapping_mul(10).wrapping_add((byte - b'0').into());
                    digits += 1;
                }
                b'.' if point.is_none() => point = Some(digits),
                _ => break,
            }
            rest = after;
        }
        let mut number = Self {
            signed,
            negative: text.first() == Some(&b'-'),
            first,
            second: 0,
            digits,
            decimals: point.map_or(0, |point| digits - point),
            has_point: point.is_some(),
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

    /// Takes a digit behind the first [`HALF_DIGITS`].
    fn push(&mut self, digit: u8) {
        if self.digits < DIGITS_MAX {
            self.second = self.second.wrapping_mul(10).wrapping_add(digit.into());
            self.digits += 1;
            self.decimals += u32::from(self.has_point);
        } else {
            self.overflown |= !self.has_point;
        }
    }

    /// The value; `None` if it is too large.
    pub fn value(&self) -> Option<f32> {
        let magnitude = if self.digits <= SHORT_DIGITS { self.short() } else { self.long()? };
        Some(if self.negative { -magnitude } else { magnitude })
    }

    /// True if all its decimals are 0.
    pub fn is_whole(&self) -> bool {
        self.decimals == 0 || self.mantissa().is_multiple_of(10u64.pow(self.decimals))
    }

    /// The value in 10^-8, rounded half away from zero; `None` if it is too large.
    pub fn length(&self) -> Option<i64> {
        let magnitude = if self.digits <= LENGTH_DECIMALS {
            product(self.first, TENS[(LENGTH_DECIMALS - self.decimals) as usize])
        } else {
            self.long_length()?
        } as i64;
        Some(if self.negative { -magnitude } else { magnitude })
    }

    /// A code's number in hundredths, rounded. `None` if it has a sign or more than 8 digits before the point.
    pub fn code_hundredths(&self) -> Option<u32> {
        let plain = !self.signed && self.digits - self.decimals <= CODE_DIGITS_MAX;
        plain.then(|| match self.decimals {
            // Saturates, without a product of 64 bits.
            0 if self.first > u32::MAX / 100 => u32::MAX,
            0 => self.first * 100,
            _ => (self.magnitude() * 100.0 + 0.5) as u32,
        })
    }

    /// The magnitude of a short number. Numerator and denominator are exact, so the quotient is correctly rounded.
    fn short(&self) -> f32 {
        self.first as f32 / POWERS[self.decimals as usize]
    }

    /// The magnitude of a longer number, rounded twice; `None` if it is too large.
    fn long(&self) -> Option<f32> {
        let magnitude = self.magnitude();
        (magnitude < VALUE_BOUND && !self.overflown).then_some(magnitude as f32)
    }

    /// The magnitude of a length of more digits; `None` if it is too large.
    #[cold]
    fn long_length(&self) -> Option<u64> {
        self.long()?;
        Some(match self.decimals.checked_sub(LENGTH_DECIMALS) {
            None => self.mantissa() * 10u64.pow(LENGTH_DECIMALS - self.decimals),
            Some(surplus) => {
                let unit = 10u64.pow(surplus);
                (self.mantissa() + unit / 2) / unit
            }
        })
    }

    /// Integers up to 2^53 and powers of ten up to 10^22 are exact in a double, so the quotient is correctly rounded.
    fn magnitude(&self) -> f64 {
        self.mantissa() as f64 / (0..self.decimals).fold(1.0, |power, _| 10.0 * power)
    }

    /// All digits as a number.
    #[cold]
    fn mantissa(&self) -> u64 {
        u64::from(self.first) * 10u64.pow(self.digits.saturating_sub(HALF_DIGITS)) + u64::from(self.second)
    }
}

/// The product of two numbers, from their halves.
fn product(a: u32, b: u32) -> u64 {
    let (a_low, a_high, b_low, b_high) = (a & 0xffff, a >> 16, b & 0xffff, b >> 16);
    let inner = (u64::from(a_high * b_low) << 16).wrapping_add(u64::from(a_low * b_high) << 16);
    (u64::from(a_high * b_high) << 32 | u64::from(a_low * b_low)).wrapping_add(inner)
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
        // The digit that counts is one of those that are not kept: it must not read as 0.
        assert_eq!(value("00000000000000000005"), None);
        assert_eq!(value("0.1000000000000000000000000001"), Some(0.1));
        // One digit more than are kept; ten of them are significant.
        assert_eq!(value("0.000000009999999999"), Some(1e-8));
    }

    #[test]
    fn a_length_is_exact_to_eight_decimals_and_rounds_the_rest() {
        let rows = [
            ("1", Some(100_000_000)),
            ("-0.001", Some(-100_000)),
            ("99999999", Some(9_999_999_900_000_000)),
            ("0.00000001", Some(1)),
            ("-123.123456785", Some(-12_312_345_679)),
            ("0.0000000049999999999999", Some(0)),
            ("000000000.5", Some(50_000_000)),
            ("12345678.87654321", Some(1_234_567_887_654_321)),
            ("100000000", None),
            ("00000000000000000005", None),
        ];
        for (text, length) in rows {
            assert_eq!(Decimal::read(text.as_bytes()).unwrap().0.length(), length, "{text}");
        }
    }

    #[test]
    fn a_code_may_have_many_decimals_and_few_digits_before_them() {
        let code = |text: &str| Decimal::read(text.as_bytes()).unwrap().0.code_hundredths();
        assert_eq!((code("38.2"), code("1.00000000"), code("12345678")), (Some(3_820), Some(100), Some(1_234_567_800)));
        assert_eq!((code("123456789"), code("-1"), code("+1")), (None, None, None));
    }

    proptest! {
        #[test]
        fn a_length_is_its_digits(whole in 0i64..100_000_000, decimals in "[0-9]{0,8}") {
            let (number, _) = Decimal::read(format!("-{whole}.{decimals}").as_bytes()).map(|(n, rest)| (n, rest.len())).expect("digits");
            let digits: i64 = format!("{decimals:0<8}").parse().expect("digits");
            prop_assert_eq!(number.length(), Some(-(whole * 100_000_000 + digits)));
        }

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
