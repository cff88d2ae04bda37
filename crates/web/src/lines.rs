//! Which line of the program the machine is at, at any time.

use isostep_sim::lines_of_moves::{Source, Stretch, Stretches};
use isostep_sim::{MoveRecord, Outcome};

/// When each line begins to move the machine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lines {
    /// s since power-up, in order.
    pub times_s: Vec<f64>,
    /// The line, from 1; 0 for homing, or where it is not known.
    pub lines: Vec<u32>,
}

/// Gathers moves, whose lines are found at the end of the run.
#[derive(Default)]
pub(crate) struct Followed {
    stretches: Stretches,
    times_s: Vec<f64>,
}

impl Followed {
    /// Adds the moves of a piece of a run.
    pub fn add(&mut self, piece: &Outcome) {
        self.stretches.add(&piece.moves);
        self.times_s.extend(piece.moves.iter().flat_map(begins_s));
    }

    /// The lines, at the end.
    pub fn end(self, end: &Outcome) -> Lines {
        let line = |stretch: Stretch| stretch.source.map_or(0, |Source { line, .. }| line as u32);
        Lines { times_s: self.times_s, lines: self.stretches.of_lines(end).into_iter().map(line).collect() }
    }
}

/// When the stretches of a move begin, s since power-up.
fn begins_s(record: &MoveRecord) -> impl Iterator<Item = f64> + '_ {
    let marks = record.marks_steps.iter().map(|steps| record.place_time_s(f64::from(*steps)));
    std::iter::once(record.begin_s()).chain(marks).map(|s| record.start_ns as f64 * 1e-9 + s)
}
