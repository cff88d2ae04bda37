//! The plate that the probe touches.

use std::fmt;
use std::str::FromStr;

use isostep_motion::Axis;

/// A conducting plate across an axis, which the probe touches from a certain position on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plate {
    /// The axis that moves towards the plate.
    pub axis: Axis,
    /// Its position, mm above the limit switch.
    pub place_mm: f64,
    /// If true, it is touched at this position and closer to the switch, otherwise at this position and farther from
    /// it.
    pub is_below: bool,
}

impl Plate {
    /// True if the probe touches it at this position of the axis.
    pub(crate) fn is_touched(&self, place_steps: i32, steps_per_mm: f64) -> bool {
        let plate_steps = (self.place_mm * steps_per_mm).round() as i32;
        if self.is_below { place_steps <= plate_steps } else { place_steps >= plate_steps }
    }
}

impl fmt::Display for Plate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { axis, place_mm, is_below } = self;
        write!(f, "{axis},{place_mm},{}", if *is_below { "below" } else { "above" })
    }
}

impl FromStr for Plate {
    type Err = NoPlate;

    fn from_str(text: &str) -> Result<Self, NoPlate> {
        let parts: Vec<&str> = text.split(',').map(str::trim).collect();
        let [axis, place, side] = parts[..] else { return Err(NoPlate::Parts(text.to_owned())) };
        let named = Axis::ALL.into_iter().find(|each| each.to_string().eq_ignore_ascii_case(axis));
        let place_mm = place.parse().ok().filter(|mm: &f64| mm.is_finite());
        Ok(Self {
            axis: named.ok_or_else(|| NoPlate::Axis(axis.to_owned()))?,
            place_mm: place_mm.ok_or_else(|| NoPlate::Place(place.to_owned()))?,
            is_below: match side {
                "below" => true,
                "above" => false,
                _ => return Err(NoPlate::Side(side.to_owned())),
            },
        })
    }
}

/// A text that does not describe a plate.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NoPlate {
    /// It does not have the parts of a plate.
    #[error("`{0}` is not an axis, a place and a side: say it as Z,12.5,below")]
    Parts(String),
    /// There is no such axis.
    #[error("`{0}` is no axis: use {NAMES_OF_AXES}", NAMES_OF_AXES = crate::NAMES_OF_AXES)]
    Axis(String),
    /// The position is not a number.
    #[error("`{0}` is no place: give mm above the axis's limit switch, such as 12.5")]
    Place(String),
    /// There is no such side.
    #[error("`{0}` is no side: use below, for a contact there and nearer to the switch, or above")]
    Side(String),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plate_is_read_as_it_is_written() {
        let plate = Plate { axis: Axis::Z, place_mm: 12.5, is_below: true };
        assert_eq!((plate.to_string().as_str(), "z, 12.5,below".parse()), ("Z,12.5,below", Ok(plate)));
        assert_eq!("X,-3,above".parse(), Ok(Plate { axis: Axis::X, place_mm: -3.0, is_below: false }));
        for (text, reported) in [
            ("Z,12.5", "`Z,12.5` is not an axis, a place and a side: say it as Z,12.5,below"),
            ("Q,1,below", "`Q` is no axis: use X, Y or Z"),
            ("Z,nan,below", "`nan` is no place"),
            ("Z,1,under", "`under` is no side: use below"),
        ] {
            let error = text.parse::<Plate>().unwrap_err().to_string();
            assert!(error.starts_with(reported), "{error}");
        }
    }
}
