//! How much is measured.

use super::search;

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
    /// How long the load is measured at a steady rate, s.
    pub load_s: f64,
    /// Stops by each input.
    pub stops: u32,
}

impl Effort {
    /// Some minutes.
    pub fn full() -> Self {
        Self { axes: &[1, 2, 3], rates: search::fine(), cruise_s: 0.2, long_move_s: 10.0, load_s: 0.5, stops: 24 }
    }

    /// Below two minutes, firmware built.
    pub fn quick() -> Self {
        Self { axes: &[3], rates: search::coarse(), cruise_s: 0.05, long_move_s: 1.0, load_s: 0.1, stops: 4 }
    }
}
