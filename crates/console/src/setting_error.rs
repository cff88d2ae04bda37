//! Why `$n=v` was refused: the value, the limit and the remedy. How settings must work together is in `relation`.

use core::fmt;

use crate::{AXES, Error, Fixed};

/// Why a setting was refused. Nothing has changed then. Displays as the text of a `[MSG:...]`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(
    missing_docs,
    reason = "the fields are the setting's number, the value asked for, and the limit with its unit"
)]
#[non_exhaustive]
pub enum SettingError {
    /// There is no such setting.
    Unknown { number: u16 },
    /// The setting may not be negative.
    Negative { number: u16, value: f32 },
    /// The setting takes whole numbers.
    NotInteger { number: u16, value: f32 },
    /// The value is below the setting's range.
    TooLow { number: u16, value: f32, min: f32, unit: &'static str },
    /// The value is above the setting's range, or not a number.
    TooHigh { number: u16, value: f32, max: f32, unit: &'static str },
    /// `$901` must name each of 1, 2 and 3 once, and 4 once at most.
    HomingOrder { digits: u16 },
    /// `$905` is 0 on a board without outputs for a second motor.
    NoSecondMotor,
    /// The microsteps of an axis, `$150`-`$152`, must be a power of two.
    Microsteps { axis: usize, microsteps: u16 },
    /// The setting is about Trinamic drivers, which this board does not have.
    NoTrinamic { number: u16 },
    /// `$744` names no axis on a board without inputs for the alarms of drives, and X alone on one with a wire for all.
    NoDriveAlarm { mask: u16, inputs: u16 },
}

impl SettingError {
    /// Grbl's error for this, or the most similar one.
    pub const fn error(&self) -> Error {
        match self {
            Self::Unknown { .. } | Self::NoTrinamic { .. } => Error::UnknownStatement,
            Self::Negative { .. } => Error::Negative,
            Self::NotInteger { .. } => Error::IntegerRequired,
            Self::TooLow { .. }
            | Self::TooHigh { .. }
            | Self::HomingOrder { .. }
            | Self::NoSecondMotor
            | Self::NoDriveAlarm { .. }
            | Self::Microsteps { .. } => Error::BadNumber,
        }
    }
}

/// Formats a value as people write it: whole numbers without decimals.
pub(crate) fn plain(value: f32) -> Fixed {
    Fixed { value, decimals: if value % 1.0 == 0.0 { 0 } else { 3 } }
}

/// The content of a homing order.
const HOMING_ORDER: &str = match AXES {
    2 => "each of 1 (X) and 2 (Y) once, as in 12",
    3 => "each of 1 (X), 2 (Y) and 3 (Z) once, as in 312",
    _ => "each of 1 (X), 2 (Y) and 3 (Z) once, and 4 (A) if it homes, as in 312",
};

/// A limit and its unit, if it has one.
struct Limit(f32, &'static str);

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let gap = if self.1.is_empty() { "" } else { " " };
        write!(f, "{}{gap}{}", plain(self.0), self.1)
    }
}

impl fmt::Display for SettingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Unknown { number } => write!(f, "there is no ${number}: $$ lists the settings"),
            Self::Negative { number, value } => {
                write!(f, "${number}={} is negative: give 0 or more", plain(value))
            }
            Self::NotInteger { number, value } => {
                write!(f, "${number}={} is not a whole number: remove the fraction", plain(value))
            }
            Self::TooLow { number, value, min, unit } => {
                write!(f, "${number}={} is below the least, {}: raise it", plain(value), Limit(min, unit))
            }
            Self::TooHigh { number, value, max, unit } => {
                write!(f, "${number}={} is above the most, {}: lower it", plain(value), Limit(max, unit))
            }
            Self::HomingOrder { digits } => {
                write!(f, "$901={digits} is no order: give {HOMING_ORDER}")
            }
            Self::NoSecondMotor => f.write_str(
                "this firmware has no outputs for a second motor: leave $905=0, or flash that for three axes",
            ),
            Self::NoDriveAlarm { mask, inputs: 0 } => {
                write!(
                    f,
                    "$744={mask}: this firmware has no input for alarms of drives: leave it 0, and wire them into the emergency stop"
                )
            }
            Self::NoDriveAlarm { mask, inputs } => {
                write!(
                    f,
                    "$744={mask}: this firmware has one input for the alarms of all drives: give {inputs}, or 0 for none"
                )
            }
            Self::Microsteps { axis, microsteps } => {
                let number = 150 + axis;
                write!(f, "${number}={microsteps} is not a power of two: give 1, 2, 4, 8, 16, 32, 64, 128 or 256")
            }
            Self::NoTrinamic { number } => {
                write!(f, "${number} is about UART drivers, which this board does not have: set them by their jumpers")
            }
        }
    }
}

impl core::error::Error for SettingError {}
