//! Prints decimals with integer arithmetic: `core::fmt` for floats would cost some kilobytes of the chip's flash.

use core::fmt;

/// The last decimals that are printed of coordinates in mm and in inches.
const MICROMETRE_PM: u64 = 1_000_000;
const TENTH_OF_MIL_PM: u64 = 2_540_000;

/// Prints a value with a fixed number of decimals, rounded half away from zero; never `-0.000`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fixed {
    /// The number to print; NaN prints as 0.
    pub value: f32,
    /// Number of decimals, 0 to 4.
    pub decimals: usize,
}

impl Fixed {
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
        print(f, scaled < 0.0, (scaled.abs() + 0.5) as u64, self.decimals)
    }
}

/// Prints a coordinate: millimetres with 3 decimals or inches with 4, rounded half away from zero; never `-0.000`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Coordinate {
    /// The coordinate in [picometres](crate::length).
    pub pm: i64,
    /// True to print inches.
    pub inches: bool,
}

impl fmt::Display for Coordinate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (unit_pm, decimals) = if self.inches { (TENTH_OF_MIL_PM, 4) } else { (MICROMETRE_PM, 3) };
        print(f, self.pm < 0, (self.pm.unsigned_abs() + unit_pm / 2) / unit_pm, decimals)
    }
}

/// Prints a number that is `magnitude` in units of its last decimal.
fn print(f: &mut fmt::Formatter<'_>, negative: bool, magnitude: u64, decimals: usize) -> fmt::Result {
    let scale = 10u64.pow(decimals as u32);
    if negative && magnitude > 0 {
        f.write_str("-")?;
    }
    write!(f, "{}", magnitude / scale)?;
    if decimals > 0 {
        write!(f, ".{:0decimals$}", magnitude % scale)?;
    }
    Ok(())
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
        let rows: &[(i64, bool, &str)] = &[
            (25_400_000_000, true, "1.0000"),
            (-25_400_000_000, false, "-25.400"),
            (-499_999, false, "0.000"),
            (-500_000, false, "-0.001"),
            (37_500_000, false, "0.038"),
            (1_269_999, true, "0.0000"),
            (-1_270_000, true, "-0.0001"),
        ];
        for &(pm, inches, text) in rows {
            assert_eq!(Coordinate { pm, inches }.to_string(), text);
        }
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
