//! The line of the program that the machine is at, at any time.

use isostep_sim::lines_of_moves::{Source, sections};
use isostep_sim::{MoveRecord, Outcome};

/// The instants at which each line begins to move the machine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lines {
    /// s since power-up, in order.
    pub times_s: Vec<f64>,
    /// The line, from 1; 0 for homing, or where no line asks for the move.
    pub lines: Vec<u32>,
}

impl Lines {
    /// Adds the moves of a piece of a run.
    pub fn add(&mut self, piece: &Outcome) {
        self.times_s.extend(piece.moves.iter().flat_map(begins_s));
        let line = |source: Option<Source>| source.map_or(0, |source| source.line as u32);
        self.lines.extend(sections(piece).into_iter().map(|section| line(section.source)));
    }
}

/// The beginnings of the sections of a move, s since power-up.
fn begins_s(record: &MoveRecord) -> impl Iterator<Item = f64> + '_ {
    let marks = record.marks_steps.iter().map(|steps| record.place_time_s(f64::from(*steps)));
    std::iter::once(record.begin_s()).chain(marks).map(|s| record.start_ns as f64 * 1e-9 + s)
}
