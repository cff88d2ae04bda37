//! Parses numbers that users type.

use anyhow::{Result, anyhow};

use isostep_report::speed_profiles::STEPS_MAX;

/// A whole number of steps, 0 to [`STEPS_MAX`].
pub fn count(text: &str) -> Result<u32, String> {
    let range = format!("a whole number, 0 to {STEPS_MAX}");
    let value: f64 = text.trim().parse().map_err(|_| format!("it takes {range}"))?;
    if value.fract() == 0.0 && (0.0..=f64::from(STEPS_MAX)).contains(&value) {
        Ok(value as u32)
    } else {
        Err(format!("{value} is outside its range: {range}"))
    }
}

/// A whole number of steps, 1 to [`STEPS_MAX`].
pub fn steps(text: &str) -> Result<u32, String> {
    match count(text) {
        Ok(1..) => count(text),
        _ => Err(format!("N, the steps of the move, is a whole number from 1 to {STEPS_MAX}")),
    }
}

/// The value; if it is missing, an error that names the option and gives an example.
pub fn needed<T>(value: Option<T>, speed_profile: &str, option: &str, meaning: &str, example: &str) -> Result<T> {
    value
        .ok_or_else(|| anyhow!("--speed-profile {speed_profile} needs {option}, {meaning}, such as {option} {example}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_whole_and_at_least_one() {
        assert_eq!(steps("120"), Ok(120));
        assert_eq!(steps("1e6"), Ok(1_000_000));
        for text in ["0", "-5", "1.5", "NaN", "inf", "many", "1000001", ""] {
            assert!(steps(text).unwrap_err().contains("from 1 to 1000000"), "{text}");
        }
    }

    #[test]
    fn counts_may_be_zero() {
        assert_eq!(count("0"), Ok(0));
        assert!(count("-1").unwrap_err().contains("-1 is outside its range: a whole number, 0 to 1000000"));
        assert!(count("x").unwrap_err().contains("a whole number"));
    }
}
