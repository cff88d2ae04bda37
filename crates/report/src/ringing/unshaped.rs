//! The same program without shapers.

use std::sync::Arc;

use isostep_motion::{AXES, State};

use isostep_sim::Outcome;
use isostep_sim::config::Config;
use isostep_sim::program::stripped;
use isostep_sim::stream::Program;

/// The program and the machine that show how the loads swing without shapers; `None` if nothing was shaped or there is no
/// load. None of a run with faults, which come at an instant, and of one that did not reach its end.
pub fn unshaped(outcome: &Outcome) -> Option<(Program, Config)> {
    let is_whole = outcome.alarm_code.is_none() && outcome.state == State::Idle && !outcome.cut_short;
    let is_shaped = outcome.moves.iter().any(|record| record.shaping.is_some());
    let has_load = outcome.config.springs.0.iter().any(Option::is_some);
    if !(is_whole && is_shaped && has_load && outcome.config.faults.is_empty()) {
        return None;
    }
    let mut config = Config { keep_waves: false, ..outcome.config.clone() };
    config.settings.shaper_kind = [0; AXES];
    let program: Vec<_> = outcome.program.iter().map(|line| without_shaper(line)).collect();
    Some((Arc::from(program), config))
}

/// A line, empty if it sets the kind of a shaper.
fn without_shaper(line: &[u8]) -> Vec<u8> {
    let sets = |text: String| (950..950 + AXES).any(|number| text.starts_with(&format!("${number}=")));
    if stripped(line).is_ok_and(sets) { Vec::new() } else { line.to_vec() }
}
