//! Lengths and coordinates as whole numbers of picometres (pm, 10^-9 mm).
//!
//! A number in mm or inches with at most 8 decimals is a whole number of picometres: 10^-8 mm is 10 pm, and 10^-8 inch
//! is 254 pm. So sums of such numbers are exact, however many there are, and two ways to the same place are equal. Sums
//! of floats would drift.

/// Picometres of a millimetre. A double holds every coordinate in picometres exactly.
pub const PM_PER_MM: f64 = 1e9;

/// Picometres of 10^-8 mm and of 10^-8 inch.
const PM_OF_MM_WORD: i64 = 10;
const PM_OF_INCH_WORD: i64 = 254;

/// A length in mm, as the nearest double.
#[must_use]
pub fn to_mm(pm: i64) -> f64 {
    pm as f64 / PM_PER_MM
}

/// A length in mm as the nearest whole number of picometres; 0 for what is no number.
#[must_use]
pub fn from_mm(mm: f64) -> i64 {
    libm::round(mm * PM_PER_MM) as i64
}

/// The length of a word's value, which is in 10^-8 mm or inch.
pub(crate) const fn of_word(value: i64, inches: bool) -> i64 {
    // A word's value is below 10^16. On the chip, to look for an overflow takes three more products.
    value.wrapping_mul(if inches { PM_OF_INCH_WORD } else { PM_OF_MM_WORD })
}
