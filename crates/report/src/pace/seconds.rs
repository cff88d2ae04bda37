//! The slowest and the busiest second of a program.

use std::collections::VecDeque;

use serde::Serialize;

use super::phases::Phase;
use isostep_sim::lines_of_moves::Source;

/// The seconds that are compared begin at multiples of this, s.
const GRID_S: f64 = 0.1;
/// Number of cells in a second.
const CELLS: usize = 10;
/// A second counts as all in motion if less than this is missing, because of rounding, s.
const MISSING_S: f64 = 1e-6;

/// A second of a program.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Second {
    /// When it begins, s from the start of the first move.
    pub start_s: f64,
    /// Its mean speed along the path, mm/s.
    pub mean_mm_s: f64,
    /// Number of moves that begin in it.
    pub moves_begun: usize,
    /// The lines of its first and its last move, from 1, if known.
    pub lines: [Option<usize>; 2],
}

/// A tenth of a second, the unit of the search.
#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    distance_mm: f64,
    moving_s: f64,
    begun: usize,
    /// Indices of the first and the last move in it.
    moves: Option<[usize; 2]>,
}

/// Finds the slowest and the busiest second from phases that come in order.
#[derive(Default)]
pub struct Clock {
    /// The cells of the last second; the newest is being filled.
    cells: VecDeque<Cell>,
    /// The number of the newest cell.
    newest: usize,
    /// Index of the move that began last.
    last_move: Option<usize>,
    slowest: Option<(Second, [usize; 2])>,
    busiest: Option<(Second, [usize; 2])>,
}

impl Clock {
    /// Adds the next phase.
    pub fn take(&mut self, phase: &Phase) {
        self.advance_to(number(phase.begin_s));
        if self.last_move != Some(phase.index) {
            self.last_move = Some(phase.index);
            self.newest().begun += 1;
        }
        let (mut from_s, mut made_mm) = (phase.begin_s, 0.0);
        while from_s < phase.end_s() {
            let to_s = phase.end_s().min((self.newest + 1) as f64 * GRID_S);
            let to_mm = phase.made_mm(to_s);
            let cell = self.newest();
            cell.distance_mm += to_mm - made_mm;
            cell.moving_s += (to_s - from_s).max(0.0);
            cell.moves = Some([cell.moves.map_or(phase.index, |moves| moves[0]), phase.index]);
            (from_s, made_mm) = (to_s, to_mm);
            if from_s < phase.end_s() {
                self.advance_to(self.newest + 1);
            }
        }
    }

    /// The slowest and the busiest second; `None` if there is no such second.
    pub fn finish(mut self, sources: &[Option<Source>]) -> [Option<Second>; 2] {
        // If the last cell is not complete, except for rounding, no second ends with it.
        let last = self.cells.back().copied().unwrap_or_default();
        if last.moving_s >= GRID_S - MISSING_S {
            self.judge();
        }
        let line = |index: usize| sources.get(index).copied().flatten().map(|source| source.line);
        [self.slowest, self.busiest]
            .map(|second| second.map(|(second, moves)| Second { lines: moves.map(line), ..second }))
    }

    fn newest(&mut self) -> &mut Cell {
        if self.cells.is_empty() {
            self.cells.push_back(Cell::default());
        }
        self.cells.back_mut().expect("there is one")
    }

    fn advance_to(&mut self, number: usize) {
        while self.newest < number {
            self.judge();
            self.newest();
            self.cells.push_back(Cell::default());
            if self.cells.len() > CELLS {
                self.cells.pop_front();
            }
            self.newest += 1;
        }
    }

    /// Judges the second that ends with the newest cell.
    fn judge(&mut self) {
        if self.cells.len() < CELLS {
            return;
        }
        let sum = |value: fn(&Cell) -> f64| self.cells.iter().map(value).sum::<f64>();
        let mut moves = self.cells.iter().filter_map(|cell| cell.moves);
        let Some([first, last]) = moves.next() else { return };
        let last = moves.next_back().map_or(last, |moves| moves[1]);
        let second = Second {
            start_s: (self.newest + 1 - CELLS) as f64 * GRID_S,
            mean_mm_s: sum(|cell| cell.distance_mm),
            moves_begun: self.cells.iter().map(|cell| cell.begun).sum(),
            lines: [None; 2],
        };
        let is_under_way = sum(|cell| cell.moving_s) >= 1.0 - MISSING_S;
        if is_under_way && self.slowest.is_none_or(|(other, _)| second.mean_mm_s < other.mean_mm_s) {
            self.slowest = Some((second, [first, last]));
        }
        if self.busiest.is_none_or(|(other, _)| second.moves_begun > other.moves_begun) {
            self.busiest = Some((second, [first, last]));
        }
    }
}

fn number(t_s: f64) -> usize {
    (t_s.max(0.0) / GRID_S) as usize
}
