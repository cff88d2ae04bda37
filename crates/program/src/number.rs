//! Numbers as text.

use crate::Problem;

/// Values of words must be less than this.
const VALUE_BOUND: f64 = 1e8;
/// Two numbers that differ by less are equal, as in LinuxCNC.
pub(crate) const SAME: f64 = 1e-6;
/// A number is whole if it is this near to a whole one, as in LinuxCNC.
const WHOLE: f64 = 1e-4;

/// The value of a word in plain decimals, rounded to the nearest millionth: a millimetre to 0.5 nm and an inch to 13 nm.
/// There is no exponent, no zero at the end, and no negative zero.
pub(crate) fn text(value: f64) -> Result<String, Problem> {
    if value.abs() >= VALUE_BOUND {
        return Err(Problem::TooLarge(shown(value)));
    }
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    Ok(if text == "-0" { "0".to_owned() } else { text.to_owned() })
}

/// A value for a message.
pub(crate) fn shown(value: f64) -> String {
    if value.abs() < VALUE_BOUND { value.to_string() } else { format!("{value:e}") }
}

/// The whole number that a value is; `None` if it is none, or too large to be counted.
pub(crate) fn whole(value: f64) -> Option<i64> {
    let nearest = libm::round(value);
    ((value - nearest).abs() <= WHOLE && nearest.abs() < 1e15).then_some(nearest as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_plain_decimals_to_a_millionth() {
        for (value, expected) in [
            (0.0, "0"),
            (-0.0, "0"),
            (-0.000_000_4, "0"),
            (12.5, "12.5"),
            (100.0, "100"),
            (-0.1, "-0.1"),
            (1.0 / 3.0, "0.333333"),
            (2.0 / 3.0, "0.666667"),
            (-1e-6, "-0.000001"),
            (99_999_999.5, "99999999.5"),
        ] {
            assert_eq!(text(value), Ok(expected.to_owned()));
        }
        assert_eq!(text(1e8), Err(Problem::TooLarge("1e8".to_owned())));
    }

    #[test]
    fn a_number_that_is_nearly_whole_is_whole() {
        let rows = [(3.0, Some(3)), (2.999_95, Some(3)), (-1.000_05, Some(-1)), (0.5, None), (1e300, None)];
        for (value, expected) in rows {
            assert_eq!(whole(value), expected, "{value}");
        }
    }
}
