//! Ringing: a load on a spring behind each axis, driven by the axis's edges.
//!
//! # Model
//! The edges of STEP move the foot of a damped spring, a whole step at each ([`Oscillator::shift`]); between two edges
//! the load swings on its own, in closed form. So there is no time step, and the only error is rounding. The load has
//! one mode, and does not pull at the motor: the edges and the rest of the world are the same with it and without.
//!
//! # What is reported
//! The *deviation* is how far the load is from where its axis is. At an edge the axis is in the middle of its step, as
//! in the closed form of a move; between two edges it is where the last one has put it, so a deviation is good to half
//! a step. [`figures`] tells, for each axis with a load:
//! - after *stops*: the amplitude with which the load goes on swinging when the plan of a move that ends at rest is over;
//! - after *corners*: the largest deviation from a corner on (with a blend: from its beginning), up to one period of the
//!   load after it, or to the next corner. A corner is where a move follows another without a stop, by a blend or with a
//!   jump of the speed of any axis;
//! - *anywhere*: the largest deviation there is.
//!
//! Homing drives the load too, but is not reported. While an axis accelerates by a, its load lags by a/ω², and after each
//! change of a it swings about that place: so a deviation is not 0 where nothing rings.

mod swing;

use isostep_motion::Axis;
use serde::Serialize;

pub use self::swing::{Swing, swings};
use isostep_sim::MoveRecord;
use isostep_sim::Outcome;
use isostep_sim::analysis::Oscillator;
use isostep_sim::corners;
use isostep_sim::lines_of_moves::Source;

/// A deviation, and the move that it belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Deviation {
    /// Its size, mm.
    pub mm: f64,
    /// Number of the move, from 1: the one that stopped, or the one behind the corner.
    pub move_number: usize,
    /// Its line in the program, from 1; null if unknown.
    pub line: Option<usize>,
}

/// The ringing of an axis in a program: see [`ringing`](self).
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RingingFigures {
    /// Name of the axis.
    pub axis: String,
    /// Frequency of its load when undamped, Hz.
    pub natural_hz: f64,
    /// Damping of its load as a fraction of that which just prevents oscillation.
    pub damping_ratio: f64,
    /// The largest amplitude after a stop.
    pub after_stops: Option<Deviation>,
    /// The largest deviation after a corner; null if no move follows another without a stop.
    pub after_corners: Option<Deviation>,
    /// The largest deviation at all, mm.
    pub anywhere_mm: f64,
}

/// The figures of every axis that has a spring; `sources` are those of all moves.
pub fn figures(outcome: &Outcome, sources: &[Option<Source>]) -> Vec<RingingFigures> {
    let springs = Axis::ALL.into_iter().zip(outcome.config.springs.0);
    let place = |(mm, index): (f64, usize)| Deviation {
        mm,
        move_number: outcome.move_number(index),
        line: sources[index].map(|source| source.line),
    };
    let of = |(axis, spring): (Axis, Option<Oscillator>)| {
        let oscillator = spring?;
        let residual = residual(outcome, axis, oscillator);
        Some(RingingFigures {
            axis: axis.to_string(),
            natural_hz: oscillator.natural_hz(),
            damping_ratio: oscillator.damping_ratio(),
            after_stops: residual.after_stops.map(place),
            after_corners: residual.after_corners.map(place),
            anywhere_mm: residual.anywhere_mm,
        })
    };
    springs.filter_map(of).collect()
}

/// The rest of the vibration of one load.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Residual {
    /// The largest amplitude after a stop, mm, and the index of the move that ends there.
    pub after_stops: Option<(f64, usize)>,
    /// The largest deviation after a corner, mm, and the index of the move behind it.
    pub after_corners: Option<(f64, usize)>,
    /// The largest deviation in the program, mm.
    pub anywhere_mm: f64,
}

/// The swinging of a load with the spring `oscillator` on `axis`, whether or not the run has one there.
pub fn residual(outcome: &Outcome, axis: Axis, oscillator: Oscillator) -> Residual {
    let places = places(outcome, 1.0 / oscillator.natural_hz());
    let mut places = places.into_iter().peekable();
    let mut residual = Residual::default();
    for swing in swings(outcome, axis, oscillator) {
        if !outcome.moves[swing.index].homing {
            residual.anywhere_mm = residual.anywhere_mm.max(swing.largest(swing.begin_s, swing.end_s));
        }
        while let Some(place) = places.next_if(|place| place.to_s <= swing.end_s) {
            residual.look(&swing, &place);
        }
        if let Some(place) = places.peek() {
            residual.look(&swing, place);
        }
    }
    residual
}

impl Residual {
    /// Looks at the part of a place that a swing has, if it has one.
    fn look(&mut self, swing: &Swing, place: &Place) {
        let (from_s, to_s) = (place.from_s.max(swing.begin_s), place.to_s.min(swing.end_s));
        if from_s > to_s {
            return;
        }
        let (most, mm) = match place.is_stop {
            true => (&mut self.after_stops, swing.amplitude(from_s)),
            false => (&mut self.after_corners, swing.largest(from_s, to_s)),
        };
        if most.is_none_or(|(most_mm, _)| mm > most_mm) {
            *most = Some((mm, place.index));
        }
    }
}

/// A stop, or a corner with the time that counts as after it.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// Since power-up.
    from_s: f64,
    /// No later than the next place.
    to_s: f64,
    is_stop: bool,
    /// Index of its move in [`Outcome::moves`].
    index: usize,
}

/// The stops and corners of the program, in order.
fn places(outcome: &Outcome, period_s: f64) -> Vec<Place> {
    let mut places: Vec<Place> = Vec::new();
    for (index, record) in outcome.moves.iter().enumerate().filter(|(_, record)| !record.homing) {
        let begin_s = record.start_ns as f64 * 1e-9;
        let before =
            index.checked_sub(1).map(|before| &outcome.moves[before]).filter(|before| before.run == record.run);
        if before.is_some_and(|before| is_corner(outcome, before, record)) {
            let late_s = begin_s + record.delay_s();
            let from_s = late_s + record.begin_s();
            let to_s = late_s + record.blend.map_or(record.begin_s(), |blend| blend.end_s()) + period_s;
            places.push(Place { from_s, to_s, is_stop: false, index });
        }
        if is_stop(record, outcome.moves.get(index + 1)) {
            let stop_s = if record.is_whole() { begin_s + record.plan_s } else { record.end_ns as f64 * 1e-9 };
            places.push(Place { from_s: stop_s, to_s: stop_s, is_stop: true, index });
        }
    }
    for index in 1..places.len() {
        places[index - 1].to_s = places[index - 1].to_s.min(places[index].from_s);
    }
    places
}

fn is_corner(outcome: &Outcome, before: &MoveRecord, after: &MoveRecord) -> bool {
    let jumps_mm_s = corners::jumps_mm_s(outcome, [before, after]);
    after.blend.is_some() || jumps_mm_s.iter().any(|mm_s| *mm_s > corners::NO_JUMP_MM_S)
}

/// True if a move ends at rest.
fn is_stop(record: &MoveRecord, next: Option<&MoveRecord>) -> bool {
    let flows_on = next.is_some_and(|next| next.run == record.run);
    !flows_on || !record.ends_in_blend && record.last_part().profile.exit_speed_steps_s() == 0.0
}
