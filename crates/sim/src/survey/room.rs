//! Where a machine's carriages can go, and whether a program that leaves it would fit if it began elsewhere.

use isostep_console::{Coordinates, Interpreter, Settings};
use isostep_motion::{AXES, Axis, Direction};
use serde::Serialize;

use super::Reader;

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

/// Where the program fits that `reader` has read: before homing the carriages may stand elsewhere, behind it the origin may.
pub(super) fn fit(
    program: &[Vec<u8>],
    settings: &Settings,
    start_mm: [f64; AXES],
    reader: &Reader,
    homed: bool,
) -> Fit {
    let room = if homed { Room::homed(&reader.settings) } else { Room::before_homing(&reader.settings, start_mm) };
    let mut shift_mm = [0.0; AXES];
    for (axis, reach_mm) in reader.reach_mm[usize::from(homed)].into_iter().enumerate() {
        let (Some((least, most)), (low, high)) = (reach_mm, room.mm[axis]) else { continue };
        match shift(least, most, low, high) {
            Some(mm) => shift_mm[axis] = mm,
            None => return Fit::TooWide(axis, most - least, high - low),
        }
    }
    if homed {
        at_origin(program, settings, start_mm, shift_mm)
    } else {
        at_start(program, settings, start_mm, shift_mm)
    }
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

fn at_start(program: &[Vec<u8>], settings: &Settings, start_mm: [f64; AXES], shift_mm: [f64; AXES]) -> Fit {
    let towards = isostep_controller::config(settings).homing.towards;
    let start_mm = std::array::from_fn(|axis| {
        let away = if towards[axis] == Direction::Negative { 1.0 } else { -1.0 };
        rounded(start_mm[axis] + away * shift_mm[axis])
    });
    let survey = super::read(program, settings, start_mm, Interpreter::new()).survey;
    if survey.outside.is_none() { Fit::StartAt(start_mm) } else { Fit::Nowhere }
}

fn at_origin(program: &[Vec<u8>], settings: &Settings, start_mm: [f64; AXES], shift_mm: [f64; AXES]) -> Fit {
    let mut coordinates = Coordinates::default();
    let origin_mm = shift_mm.map(rounded);
    coordinates.work_offsets_mm[0] = origin_mm.map(|mm| mm as f32);
    let mut interpreter = Interpreter::new();
    interpreter.set_coordinates(coordinates);
    let survey = super::read(program, settings, start_mm, interpreter).survey;
    if survey.outside.is_none() { Fit::OriginAt(origin_mm) } else { Fit::Nowhere }
}

/// Without the dust of binary fractions.
fn rounded(mm: f64) -> f64 {
    (mm * 1e4).round() / 1e4
}
