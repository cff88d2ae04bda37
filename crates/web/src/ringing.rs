//! How loads on springs would swing behind X and Y, from the edges of a whole run.

use isostep_motion::Axis;
use isostep_report::ringing::residual;
use isostep_report::timing;
use isostep_sim::analysis::Oscillator;
use isostep_sim::program::Program;
use isostep_sim::{Flash, run_watched};
use serde::Serialize;

use crate::config;
use crate::trouble::Trouble;
use crate::whole::RECORDED_LINES_MAX;

/// The largest swings of either load, mm; `None` where the program has nothing of that kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Swings {
    /// The amplitude after a stop.
    pub after_stops_mm: Option<f64>,
    /// The deviation after a corner.
    pub after_corners_mm: Option<f64>,
}

/// The swings of loads of this frequency and damping, with a program on a machine with these settings: those that
/// `isostep sim --ringing` prints.
///
/// # Errors
/// [`Trouble`] with the line that cannot be, if the program is too long or does not reach its end, or no load swings so.
pub fn swings(program: &[u8], settings: &str, natural_hz: f64, damping_ratio: f64) -> Result<Swings, Trouble> {
    let config = config(settings)?;
    let oscillator = Oscillator::new(natural_hz, damping_ratio).map_err(Trouble::without_line)?;
    let lines = Program::read(program)?;
    if lines.len() > RECORDED_LINES_MAX {
        let words = format!(
            "how loads swing is computed of {RECORDED_LINES_MAX} lines at most on a page, and these are {}: `isostep sim --ringing` does it",
            lines.len()
        );
        return Err(Trouble::without_line(words));
    }
    let outcome = run_watched(lines, &config, Flash::blank(), &mut |_| {})?;
    if let Some(words) = timing::stopped(&outcome) {
        return Err(Trouble::without_line(words));
    }
    let mut swings = Swings::default();
    for axis in Axis::ALL.into_iter().take(2) {
        let residual = residual(&outcome, axis, oscillator);
        let larger = |one: Option<f64>, other: Option<(f64, usize)>| {
            one.into_iter().chain(other.map(|(mm, _)| mm)).reduce(f64::max)
        };
        swings.after_stops_mm = larger(swings.after_stops_mm, residual.after_stops);
        swings.after_corners_mm = larger(swings.after_corners_mm, residual.after_corners);
    }
    Ok(swings)
}
