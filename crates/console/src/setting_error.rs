//! Why `$n=v` was refused: the value, the limit and the remedy.

use core::fmt;

use crate::{AXES, AXIS_NAMES, Error, Fixed};

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
    /// `$20=1` requires `$22=1`.
    SoftLimitsNeedHoming,
    /// `$901` must name each of 1, 2 and 3 once, and 4 once at most.
    HomingOrder { digits: u16 },
    /// `$31` must be below `$30`.
    LeastSpeedNotBelowFull { least_rpm: f32, full_rpm: f32 },
    /// `$35` must not be above `$36`.
    LeastDutyAboveFull { least_percent: f32, full_percent: f32 },
    /// The pull-off, `$27`, with the offset of a second motor, must be below the travel of every axis.
    PullOffNotBelowTravel { axis: usize, pull_off_mm: f32, offset_mm: f32, travel_mm: f32, unit: &'static str },
    /// The top speed of an axis needs a higher step rate than the step outputs support with this pulse width.
    RateTooHigh {
        axis: usize,
        asked_mm_min: f32,
        max_mm_min: f32,
        steps_per_mm: f32,
        pulse_us: u16,
        unit: &'static str,
    },
    /// The start speed of an axis is above its top speed.
    StartAboveTop { axis: usize, start_mm_min: f32, top_mm_min: f32, unit: &'static str },
    /// Speed law number `law`, `$940`, needs a start speed, but an axis has none.
    LawNeedsStart { axis: usize, law: u16 },
    /// An axis has shaper number `kind`, and speed law number `law`, `$940`, is not the trapezoid.
    ShapedCurve { axis: usize, kind: u16, law: u16 },
    /// `$905` is 0 on a board without outputs for a second motor.
    NoSecondMotor,
    /// The microsteps of an axis, `$150`-`$152`, must be a power of two.
    Microsteps { axis: usize, microsteps: u16 },
    /// The setting is about Trinamic drivers, which this board does not have.
    NoTrinamic { number: u16 },
}

impl SettingError {
    /// Grbl's error for this, or the most similar one.
    pub const fn error(&self) -> Error {
        match self {
            Self::Unknown { .. } | Self::NoTrinamic { .. } => Error::UnknownStatement,
            Self::Negative { .. } => Error::Negative,
            Self::NotInteger { .. } => Error::IntegerRequired,
            Self::TooLow { .. } | Self::TooHigh { .. } | Self::HomingOrder { .. } => Error::BadNumber,
            Self::SoftLimitsNeedHoming => Error::SoftLimitsNeedHoming,
            Self::RateTooHigh { .. } | Self::StartAboveTop { .. } => Error::RateTooHigh,
            Self::LeastSpeedNotBelowFull { .. }
            | Self::LeastDutyAboveFull { .. }
            | Self::PullOffNotBelowTravel { .. }
            | Self::LawNeedsStart { .. }
            | Self::ShapedCurve { .. }
            | Self::NoSecondMotor
            | Self::Microsteps { .. } => Error::BadNumber,
        }
    }
}

/// Formats a value as people write it: whole numbers without decimals.
fn plain(value: f32) -> Fixed {
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
            Self::SoftLimitsNeedHoming => f.write_str("$20=1 needs a machine that homes: set $22=1 or $20=0"),
            Self::HomingOrder { digits } => {
                write!(f, "$901={digits} is no order: give {HOMING_ORDER}")
            }
            Self::LeastSpeedNotBelowFull { least_rpm, full_rpm } => {
                let (least, full) = (plain(least_rpm), plain(full_rpm));
                write!(f, "$31={least} is not below the S at full duty, $30={full} rpm: lower $31 or raise $30")
            }
            Self::LeastDutyAboveFull { least_percent, full_percent } => {
                let (least, full) = (plain(least_percent), plain(full_percent));
                write!(f, "$35={least} is above the duty at $30, $36={full} %: lower $35 or raise $36")
            }
            Self::PullOffNotBelowTravel { axis, pull_off_mm, offset_mm, travel_mm, unit } => {
                let (letter, travel) = (AXIS_NAMES[axis], 130 + axis);
                let (asked, most) = (plain(pull_off_mm), plain(travel_mm));
                write!(f, "$27={asked} ")?;
                if offset_mm != 0.0 {
                    write!(f, "with the offset of the second motor, ${}={}, ", 170 + axis, plain(offset_mm))?;
                }
                write!(f, "is not below the travel of {letter}, ${travel}={most} {unit}: lower $27 or raise ${travel}")
            }
            Self::RateTooHigh { axis, asked_mm_min, max_mm_min, steps_per_mm, pulse_us, unit } => {
                let (rate, scale) = (110 + axis, 100 + axis);
                let (asked, steps) = (plain(asked_mm_min), plain(steps_per_mm));
                // Truncated, not rounded, so that the value in the message is itself acceptable.
                let most = max_mm_min as u32;
                write!(
                    f,
                    "${rate}={asked} is above the {most} {unit}/min that the step outputs carry with $0={pulse_us} \
                     at ${scale}={steps} steps/{unit}: lower one of the three"
                )
            }
            Self::StartAboveTop { axis, start_mm_min, top_mm_min, unit } => {
                let (start, top) = (910 + axis, 110 + axis);
                let (asked, most) = (plain(start_mm_min), plain(top_mm_min));
                write!(
                    f,
                    "${start}={asked} is above the top speed, ${top}={most} {unit}/min: lower ${start} or raise ${top}"
                )
            }
            Self::LawNeedsStart { axis, law } => {
                let start = 910 + axis;
                write!(
                    f,
                    "$940={law} is a law over displacement and never leaves standstill: raise ${start} above 0, or lower $940"
                )
            }
            Self::ShapedCurve { axis, kind, law } => {
                let shaper = 950 + axis;
                write!(
                    f,
                    "${shaper}={kind} and $940={law} do not work together, as only the trapezoid is shaped: set ${shaper}=0 or $940=0"
                )
            }
            Self::NoSecondMotor => f.write_str(
                "this firmware has no outputs for a second motor: leave $905=0, or flash that for three axes",
            ),
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

/// Why settings do not work together. They are kept, but nothing moves with them. Displays as the text of a `[MSG:...]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unfit(pub SettingError);

impl fmt::Display for Unfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; until then nothing moves", self.0)
    }
}
