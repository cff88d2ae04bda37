//! Where a machine's carriages can go, and whether a program that leaves it would fit if it began elsewhere.

use isostep_console::Settings;
use isostep_motion::{AXES, Axis, Direction};
use serde::Serialize;

/// How far from the ends of the travel a program is moved if there is room.
const MARGIN_MM: f64 = 1.0;
/// Places are told to this.
const GRAIN_MM: f64 = 0.1;
/// The switch is at 0: nearest to it that a carriage can be without pressing it.
const OFF_SWITCH_MM: f64 = 0.001;

/// The least and the greatest place of each axis, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Bounds {
    /// The least.
    pub low_mm: [f64; AXES],
    /// The greatest.
    pub high_mm: [f64; AXES],
}

impl Bounds {
    /// Of one place.
    pub fn at(place_mm: [f64; AXES]) -> Self {
        Self { low_mm: place_mm, high_mm: place_mm }
    }

    /// Takes in another place.
    pub fn add(&mut self, place_mm: [f64; AXES]) {
        self.join(&Self::at(place_mm));
    }

    /// Takes in others.
    pub fn join(&mut self, other: &Self) {
        for axis in 0..AXES {
            self.low_mm[axis] = self.low_mm[axis].min(other.low_mm[axis]);
            self.high_mm[axis] = self.high_mm[axis].max(other.high_mm[axis]);
        }
    }

    /// How wide they are.
    pub fn size_mm(&self) -> [f64; AXES] {
        std::array::from_fn(|axis| self.high_mm[axis] - self.low_mm[axis])
    }
}

/// The places that each axis can be at, machine coordinates, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    /// The least and the greatest of each axis.
    pub mm: [(f64, f64); AXES],
}

impl Room {
    /// Of a machine that counts from where it stands, `start_mm` from its switches.
    pub fn before_homing(settings: &Settings, start_mm: [f64; AXES]) -> Self {
        let config = isostep_controller::config(settings);
        Self {
            mm: std::array::from_fn(|axis| {
                let far_mm = config.homing.pull_off_mm + config.travel_mm[axis];
                let (near, far) = (OFF_SWITCH_MM - start_mm[axis], far_mm - start_mm[axis]);
                match config.homing.towards[axis] {
                    Direction::Negative => (near, far),
                    Direction::Positive => (-far, -near),
                }
            }),
        }
    }

    /// Of a machine that is homed.
    pub fn homed(settings: &Settings) -> Self {
        let config = isostep_controller::config(settings);
        Self {
            mm: Axis::ALL.map(|axis| {
                let range = config.travel_steps(axis);
                (config.mm(axis, *range.start()), config.mm(axis, *range.end()))
            }),
        }
    }

    /// Where `way` leaves it on this axis by more than `same_mm`: how far it goes, and the nearest place that is in it.
    pub fn beyond(&self, axis: usize, way: &Bounds, same_mm: f64) -> Option<(f64, f64)> {
        let ((low, high), (least, most)) = (self.mm[axis], (way.low_mm[axis], way.high_mm[axis]));
        match (low - least, most - high) {
            (below, above) if below > same_mm && below >= above => Some((least, low)),
            (_, above) if above > same_mm => Some((most, high)),
            _ => None,
        }
    }
}

/// Where a program would fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fit {
    /// If the carriages stand here at first, mm from their switches.
    StartAt([f64; AXES]),
    /// If the origin of G54 is here, machine coordinates, mm.
    OriginAt([f64; AXES]),
    /// If it were no wider than this on that axis, mm: its index, how wide it is, and the travel.
    TooWide(usize, f64, f64),
    /// Not that was found: it goes to machine coordinates, or has offsets of its own.
    Nowhere,
}

/// By how much to move what reaches from the least to the greatest of `reach_mm` on each axis, so that it is in the room: not at
/// all where it is already.
///
/// # Errors
/// [`Fit::TooWide`].
pub(super) fn shifts_mm(reach_mm: [Option<(f64, f64)>; AXES], room: &Room) -> Result<[f64; AXES], Fit> {
    let mut shifts_mm = [0.0; AXES];
    for (axis, reach_mm) in reach_mm.into_iter().enumerate() {
        let (Some((least, most)), (low, high)) = (reach_mm, room.mm[axis]) else { continue };
        shifts_mm[axis] = shift(least, most, low, high).ok_or(Fit::TooWide(axis, most - least, high - low))?;
    }
    Ok(shifts_mm)
}

/// By how much to move what goes from `least` to `most` so that it is between `low` and `high`: not at all if it is already.
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

/// Without the dust of binary fractions.
pub(super) fn rounded(mm: f64) -> f64 {
    (mm * 1e4).round() / 1e4
}
