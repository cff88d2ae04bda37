//! Prints decimals with integer arithmetic: `core::fmt` for floats would cost some kilobytes of the chip's flash.

use core::fmt;

/// Prints a value with a fixed number of decimals, rounded half away from zero; never `-0.000`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fixed {
    /// What to print; NaN prints as 0.
    pub value: f32,
    /// Number of decimals, 0 to 4.
    pub decimals: usize,
}

impl Fixed {
    /// A coordinate: millimetres with 3 decimals, or inches with 4.
    pub const fn coordinate(mm: f32, inches: bool) -> Self {
        if inches { Self { value: mm / 25.4, decimals: 4 } } else { Self { value: mm, decimals: 3 } }
    }

    /// A rate: whole mm/min, or in/min with 1 decimal.
    pub const fn rate(mm_min: f32, inches: bool) -> Self {
        if inches { Self { value: mm_min / 25.4, decimals: 1 } } else { Self { value: mm_min, decimals: 0 } }
    }
}

impl fmt::Display for Fixed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let scale = 10u64.pow(self.decimals as u32);
        // Exact: 24 bits of mantissa and 14 of scale fit a double's 53.
        let scaled = f64::from(self.value) * scale as f64;
        let magnitude = (scaled.abs() + 0.5) as u64;
        if scaled < 0.0 && magnitude > 0 {
            f.write_str("-")?;
        }
        write!(f, "{}", magnitude / scale)?;
        if self.decimals > 0 {
            write!(f, ".{:0width$}", magnitude % scale, width = self.decimals)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::{format, string::ToString};

    use proptest::prelude::*;

    use super::*;

    #[test]
    fn rounds_half_away_from_zero_and_knows_no_negative_zero() {
        let rows: &[(f32, usize, &str)] = &[
            (0.0, 3, "0.000"),
            (-0.0, 3, "0.000"),
            (-0.0004, 3, "0.000"),
            (-0.0006, 3, "-0.001"),
            (-0.5, 3, "-0.500"),
            (-1.0, 3, "-1.000"),
            (0.9996, 3, "1.000"),
            (2880.0, 3, "2880.000"),
            (0.5, 0, "1"),
            (-2.5, 0, "-3"),
            (12.25, 1, "12.3"),
            (f32::NAN, 3, "0.000"),
        ];
        for &(value, decimals, text) in rows {
            assert_eq!(Fixed { value, decimals }.to_string(), text);
        }
        assert_eq!(Fixed::coordinate(25.4, true).to_string(), "1.0000");
        assert_eq!(Fixed::rate(254.0, true).to_string(), "10.0");
    }

    proptest! {
        #[test]
        fn stays_within_half_a_digit(value in -1e9f32..1e9, decimals in 0usize..=4) {
            let printed: f64 = format!("{}", Fixed { value, decimals }).parse().expect("a decimal");
            let half = 0.5 / 10f64.powi(decimals as i32);
            prop_assert!((printed - f64::from(value)).abs() <= half * (1.0 + 1e-9) + 1e-6);
        }
    }
}
