//! The springs behind the axes, by which their loads swing.

use std::fmt;
use std::str::FromStr;

use isostep_motion::{AXES, Axis};

use crate::NAMES_OF_AXES;
use crate::analysis::Oscillator;

/// Natural frequencies that make sense for a machine: below, a load hangs loose; above, steps are too coarse to tell.
const NATURAL_HZ: std::ops::RangeInclusive<f64> = 0.5..=1_000.0;

/// The springs of the axes; no spring is a rigid axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Springs(pub [Option<Oscillator>; AXES]);

impl FromStr for Springs {
    type Err = String;

    /// Reads `X:40:0.05,Y:35:0.05`: axis, natural frequency in Hz, damping ratio.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut springs = Self::default();
        for spring in text.split(',') {
            let (axis, oscillator) = spring_of(spring.trim())?;
            if springs.0[axis as usize].replace(oscillator).is_some() {
                return Err(format!("{axis} has two springs: give each axis one at most"));
            }
        }
        Ok(springs)
    }
}

fn spring_of(text: &str) -> Result<(Axis, Oscillator), String> {
    let parts: Vec<&str> = text.split(':').collect();
    let [name, natural_hz, damping_ratio] = parts[..] else {
        return Err(format!("`{text}` is no spring: give an axis, Hz and a damping ratio, such as X:40:0.05"));
    };
    let axis = Axis::ALL.into_iter().find(|axis| axis.to_string().eq_ignore_ascii_case(name));
    let axis = axis.ok_or_else(|| format!("`{name}` is no axis: use {NAMES_OF_AXES}"))?;
    oscillator(natural_hz, damping_ratio)
        .map(|oscillator| (axis, oscillator))
        .map_err(|error| format!("{axis}: {error}"))
}

/// Reads the natural frequency of a load in Hz and its damping ratio.
///
/// # Errors
/// The value that is out of range, its range, and what to give.
pub fn oscillator(natural_hz: &str, damping_ratio: &str) -> Result<Oscillator, String> {
    let number = |text: &str, what: &str, example: &str| {
        text.trim().parse::<f64>().map_err(|_| format!("{what} `{text}` is no number: give one such as {example}"))
    };
    let natural_hz = number(natural_hz, "natural frequency", "40")?;
    let damping_ratio = number(damping_ratio, "damping ratio", "0.05")?;
    if !NATURAL_HZ.contains(&natural_hz) {
        let (least, most) = (NATURAL_HZ.start(), NATURAL_HZ.end());
        return Err(format!(
            "natural frequency {natural_hz} Hz is outside {least} to {most} Hz: machines have some 5 to 100"
        ));
    }
    Oscillator::new(natural_hz, damping_ratio).map_err(|error| format!("{error}; machines have some 0.02 to 0.1"))
}

impl fmt::Display for Springs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let springs = Axis::ALL.into_iter().zip(self.0);
        let springs = springs.filter_map(|(axis, spring)| {
            spring.map(|spring| format!("{axis}:{}:{}", spring.natural_hz(), spring.damping_ratio()))
        });
        f.write_str(&springs.collect::<Vec<_>>().join(","))
    }
}
