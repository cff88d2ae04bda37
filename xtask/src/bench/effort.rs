//! How much is measured.

use super::chip::Chip;
use super::search;
use super::trial::AXES;

/// The extent of the measurements: what costs time.
#[derive(Clone, Debug)]
pub struct Effort {
    /// Numbers of axes that move at once, in the search for the highest rate.
    pub axes: &'static [usize],
    /// Rates that are searched, steps/s.
    pub rates: Vec<u32>,
    /// Cruise of a move in that search, s.
    pub cruise_s: f64,
    /// Whole length of the move in which errors and drift are measured, s.
    pub long_move_s: f64,
    /// How long the load is measured at a steady rate, s, if it is.
    pub load_s: Option<f64>,
    /// Stops by each input.
    pub stops: u32,
    /// Starts with the cache cold, and as many with it warm.
    pub starts: u32,
    /// Short moves that are streamed.
    pub moves: usize,
    /// Whether the mathematics of a move is measured.
    pub mathematics: bool,
}

impl Effort {
    /// The chip in full, and the ideal one but for so many stops; with dear misses what has a target.
    pub fn full(chip: Chip) -> Self {
        let all = Self {
            axes: &[1, 2, 3],
            rates: search::fine(),
            cruise_s: 0.2,
            long_move_s: 10.0,
            load_s: Some(0.5),
            stops: 200,
            starts: 50,
            moves: 6_000,
            mathematics: true,
        };
        match chip {
            Chip::AsItIs => all,
            Chip::IdealFlash => Self { stops: 50, ..all },
            Chip::DearMiss => Self { stops: 50, mathematics: true, ..all.of_targets() },
        }
    }

    /// Minutes, firmware built: three axes, shorter moves, and of the other chips what has a target.
    pub fn quick(chip: Chip) -> Self {
        let all = Self {
            axes: &[AXES],
            rates: search::coarse(),
            cruise_s: 0.05,
            long_move_s: 1.0,
            load_s: Some(0.1),
            stops: 24,
            starts: 10,
            moves: 1_500,
            mathematics: true,
        };
        match chip {
            Chip::AsItIs => all,
            Chip::IdealFlash => Self { stops: 8, starts: all.starts, ..all.of_targets() },
            Chip::DearMiss => Self { stops: 8, ..all.of_targets() },
        }
    }

    /// Without what has no target, and without the mathematics, which runs from RAM.
    fn of_targets(&self) -> Self {
        Self { axes: &[AXES], load_s: None, starts: 0, mathematics: false, ..self.clone() }
    }
}
