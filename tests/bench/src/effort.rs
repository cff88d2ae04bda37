//! The extent of the measurements.

use isostep::measure::planned_move::PROVED;
use isostep::measure::search;

use super::chip::Chip;

/// The settings that determine how long the measurements take.
#[derive(Clone, Debug)]
pub struct Effort {
    /// Numbers of axes that move at once in the search for the highest rate.
    pub axes: &'static [usize],
    /// The rates to choose from in the search, steps/s.
    pub rates: Vec<u32>,
    /// Duration of the cruise in each move of the search, s.
    pub cruise_s: f64,
    /// Total length of the move in which errors and drift are measured, s.
    pub long_move_s: f64,
    /// Duration for which the load is measured at a steady rate, s. `None` to skip this measurement.
    pub load_s: Option<f64>,
    /// Number of stops by each input.
    pub stops: u32,
    /// Number of starts with a cold cache, and also of those with a warm one.
    pub starts: u32,
    /// Number of short moves that are streamed.
    pub moves: usize,
    /// The cost of the mathematics of a move is measured too.
    pub mathematics: bool,
}

impl Effort {
    /// All measurements on the real chip, and on the ideal one with fewer stops. On the chip with costly misses, only
    /// those that have a target.
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
            _ => Self { stops: 50, mathematics: true, ..all.of_targets() },
        }
    }

    /// Measurements that take minutes once the firmware is built: three axes and shorter moves. On the other chips,
    /// only those that have a target.
    pub fn quick(chip: Chip) -> Self {
        let all = Self {
            axes: &[PROVED],
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
            _ => Self { stops: 8, ..all.of_targets() },
        }
    }

    /// The same for the machine with a second motor: all axes at once, at rates near the highest without one, a shorter
    /// move and fewer stops.
    pub fn with_second(&self, highest_steps_s: Option<u32>) -> Self {
        let highest = highest_steps_s.unwrap_or(u32::MAX);
        let rates = self.rates.iter().copied().filter(|&rate| rate <= highest && rate >= highest / 2).collect();
        Self {
            axes: &[PROVED],
            rates,
            long_move_s: self.long_move_s / 2.0,
            stops: self.stops.div_ceil(6),
            ..self.clone()
        }
    }

    /// Without the measurements that have no target, and without the mathematics, which runs from RAM.
    fn of_targets(&self) -> Self {
        Self { axes: &[PROVED], load_s: None, starts: 0, mathematics: false, ..self.clone() }
    }
}
