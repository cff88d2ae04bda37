//! Runs programs in virtual time only to find how long they take.

use isostep_console::{AXES, Settings};
use isostep_sim::program::Program;
use isostep_sim::{Config, Flash, Outcome};

use crate::remarks::{meaning, shortened};

/// The middle of the travel. Such runs make no edges, so the carriages stay there and never meet a switch.
pub fn middle_mm(settings: &Settings) -> [f64; AXES] {
    std::array::from_fn(|axis| f64::from(settings.reach_mm(axis)) / 2.0)
}

/// Runs a program to its end.
///
/// # Errors
/// Why the program does not reach its end, in words: an alarm, or the first line that was refused.
pub fn made(program: Program, config: &Config) -> Result<Outcome, String> {
    made_watched(program, config, &mut |_| {})
}

/// As [`made`]. Calls `watch` now and then with the number of lines that are answered.
///
/// # Errors
/// As [`made`].
pub(crate) fn made_watched(program: Program, config: &Config, watch: &mut dyn FnMut(usize)) -> Result<Outcome, String> {
    let outcome = isostep_sim::run_watched(program, config, Flash::blank(), &mut |progress| watch(progress.answered));
    let outcome = outcome.map_err(|error| error.to_string())?;
    stopped(&outcome).map_or(Ok(outcome), Err)
}

/// Why a run did not reach the end of its program, in words: an alarm, or the first line that was refused.
#[must_use]
pub fn stopped(outcome: &Outcome) -> Option<String> {
    if let Some(alarm) = outcome.alarm() {
        let code = outcome.alarm_code.map_or(String::new(), |code| format!("ALARM:{code}: "));
        return Some(format!("{code}{alarm}"));
    }
    let refusal = outcome.refusals.first()?;
    let words = refusal.words.clone().unwrap_or_else(|| meaning(refusal.code));
    let (line, text, code) = (refusal.line, shortened(&refusal.text), refusal.code);
    Some(format!("line {line} `{text}` was refused: error:{code} {words}"))
}
