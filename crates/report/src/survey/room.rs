//! The room of a machine's carriages, and whether a program that leaves this range would fit if it began elsewhere.

use isostep_console::Settings;
use isostep_motion::{AXES, Axis, Config, Direction};
use serde::Serialize;

/// Distance that a moved program keeps from the ends of the travel if there is room.
const MARGIN_MM: f64 = 1.0;
/// Positions are rounded to this.
const GRAIN_MM: f64 = 0.1;
/// The switch is at 0. This is the nearest position at which a carriage does not press it.
const OFF_SWITCH_MM: f64 = 0.001;

/// The range of positions of each axis, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Bounds {
    /// The least positions.
    pub low_mm: [f64; AXES],
    /// The greatest positions.
    pub high_mm: [f64; AXES],
}

impl Bounds {
    /// The bounds of one position.
    pub fn at(place_mm: [f64; AXES]) -> Self {
        Self { low_mm: place_mm, high_mm: place_mm }
    }

    /// Extends the bounds to include a position.
    pub fn add(&mut self, place_mm: [f64; AXES]) {
        self.join(&Self::at(place_mm));
    }

    /// Extends the bounds to include others.
    pub fn join(&mut self, other: &Self) {
        for axis in 0..AXES {
            self.low_mm[axis] = self.low_mm[axis].min(other.low_mm[axis]);
            self.high_mm[axis] = self.high_mm[axis].max(other.high_mm[axis]);
        }
    }

    /// The size of the range.
    pub fn size_mm(&self) -> [f64; AXES] {
        std::array::from_fn(|axis| self.high_mm[axis] - self.low_mm[axis])
    }
}

/// The positions that each axis can reach, machine coordinates, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Room {
    /// The least and the greatest position of each axis.
    pub mm: [(f64, f64); AXES],
    /// The travel of each axis, as it is set. Before homing there is more room than that: an axis may also stand between
    /// its switch and its zero.
    pub travel_mm: [f64; AXES],
}

impl Room {
    /// The room of a machine that counts from its present position, `start_mm` from its switches.
    pub fn before_homing(settings: &Settings, start_mm: [f64; AXES]) -> Self {
        let config = isostep_controller::config(settings);
        Self {
            mm: std::array::from_fn(|axis| {
                if config.is_endless[axis] {
                    return everywhere(&config, Axis::ALL[axis]);
                }
                let far_mm = config.homing.pull_off_mm + config.travel_mm[axis];
                let (near, far) = (OFF_SWITCH_MM - start_mm[axis], far_mm - start_mm[axis]);
                match config.homing.towards[axis] {
                    Direction::Negative => (near, far),
                    Direction::Positive => (-far, -near),
                }
            }),
            travel_mm: config.travel_mm,
        }
    }

    /// The room of a homed machine.
    pub fn homed(settings: &Settings) -> Self {
        let config = isostep_controller::config(settings);
        Self { mm: Axis::ALL.map(|axis| everywhere(&config, axis)), travel_mm: config.travel_mm }
    }

    /// The place where the range `way` leaves the room on this axis by more than `same_mm`: the position outside, and the
    /// nearest position inside.
    pub fn beyond(&self, axis: usize, way: &Bounds, same_mm: f64) -> Option<(f64, f64)> {
        let ((low, high), (least, most)) = (self.mm[axis], (way.low_mm[axis], way.high_mm[axis]));
        match (low - least, most - high) {
            (below, above) if below > same_mm && below >= above => Some((least, low)),
            (_, above) if above > same_mm => Some((most, high)),
            _ => None,
        }
    }
}

/// Everywhere that `axis` can go to once it is homed.
fn everywhere(config: &Config, axis: Axis) -> (f64, f64) {
    let range = config.travel_steps(axis);
    (config.mm(axis, *range.start()), config.mm(axis, *range.end()))
}

/// The way in which a program would fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fit {
    /// It fits if the carriages start here, mm from their switches.
    StartAt([f64; AXES]),
    /// It fits if the origin of G54 is here, machine coordinates, mm.
    OriginAt([f64; AXES]),
    /// It would have to be smaller on one axis: its index, the size of the program, and the travel, mm.
    TooWide(usize, f64, f64),
    /// No fit was found: the program uses machine coordinates, or has its own offsets.
    Nowhere,
}

/// The shifts that move the ranges `reach_mm` into the room, for each axis; 0 where the range is already inside.
///
/// # Errors
/// [`Fit::TooWide`].
pub(super) fn shifts_mm(reach_mm: [Option<(f64, f64)>; AXES], room: &Room) -> Result<[f64; AXES], Fit> {
    let mut shifts_mm = [0.0; AXES];
    for (axis, reach_mm) in reach_mm.into_iter().enumerate() {
        let (Some((least, most)), (low, high)) = (reach_mm, room.mm[axis]) else { continue };
        shifts_mm[axis] =
            shift(least, most, low, high).ok_or(Fit::TooWide(axis, most - least, room.travel_mm[axis]))?;
    }
    Ok(shifts_mm)
}

/// The shift that moves the range from `least` to `most` between `low` and `high`; 0 if it is already there.
fn shift(least: f64, most: f64, low: f64, high: f64) -> Option<f64> {
    let (lowest, highest) = (low - least, high - most);
    if lowest > highest {
        return None;
    }
    if lowest <= 0.0 && highest >= 0.0 {
        return Some(0.0);
    }
    let margin = MARGIN_MM.min((highest - lowest) / 2.0);
    let asked = 0.0_f64.clamp(lowest + margin, highest - margin);
    let rounded = (asked / GRAIN_MM).round() * GRAIN_MM;
    Some(if (lowest..=highest).contains(&rounded) { rounded } else { asked })
}

/// Rounds off the error of binary fractions.
pub(super) fn rounded(mm: f64) -> f64 {
    (mm * 1e4).round() / 1e4
}
