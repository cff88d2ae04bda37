//! Programs in virtual time for how long they take, not for their edges.

use isostep_console::Settings;
use isostep_sim::stream::Program;
use isostep_sim::{Config, Flash, Outcome, State};

use crate::remarks::{meaning, shortened};

/// The middle of the travel. Where no edge is made no carriage leaves it, so a switch is never met.
pub fn middle_mm(settings: &Settings) -> [f64; 3] {
    settings.travel_mm.map(|travel_mm| f64::from(travel_mm) / 2.0)
}

/// Makes a program to its end.
///
/// # Errors
/// Why it does not come there, in words: an alarm, or the first line that was refused.
pub fn made(program: Program, config: &Config) -> Result<Outcome, String> {
    let outcome = isostep_sim::run_watched(program, config, Flash::blank(), &mut |_| {});
    let outcome = outcome.map_err(|error| error.to_string())?;
    if let State::Alarm(alarm) = outcome.state {
        let code = outcome.alarm_code.map_or(String::new(), |code| format!("ALARM:{code}: "));
        return Err(format!("{code}{alarm}"));
    }
    match outcome.refusals.first() {
        None => Ok(outcome),
        Some(refusal) => {
            let words = refusal.words.clone().unwrap_or_else(|| meaning(refusal.code));
            Err(format!(
                "line {} `{}` was refused: error:{} {words}",
                refusal.line,
                shortened(&refusal.text),
                refusal.code
            ))
        }
    }
}
