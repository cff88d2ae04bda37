//! The distances of a laser's changes of level from the beginnings of their moves, or where one move is made for several lines,
//! of their lines.
//!
//! A move of constant power (M3) has one level. Where it begins with another level than before, the duty must change.
//! The change nearest to its beginning is searched for. Power that follows the speed (M4) changes all the time, and is
//! left out.

use isostep_motion::Power;
use serde::Serialize;

use isostep_sim::MoveRecord;
use isostep_sim::Outcome;
use isostep_sim::lines_of_moves::{Section, Source, sections};
use isostep_sim::tool::ToolOutput;

/// The distances of changes of level from the beginnings of their moves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Beginnings {
    /// Number of moves with another level than before.
    pub total: usize,
    /// The 99th percentile of the distance to the nearest change, us.
    pub p99_us: f64,
    /// The largest distance, us.
    pub most_us: f64,
}

/// The distances in a run; `None` if the level never has to change.
pub fn of(outcome: &Outcome) -> Option<Beginnings> {
    let changes_ns: Vec<u64> =
        outcome.tool.iter().filter(|change| change.output == ToolOutput::Pwm).map(|change| change.t_ns).collect();
    let sections = sections(outcome);
    let distances_us = changing(outcome, &sections)
        .map(|section| nearest_us(&outcome.moves[section.index], section.from_steps, &changes_ns));
    let mut distances_us: Vec<f64> = distances_us.collect();
    distances_us.sort_by(f64::total_cmp);
    let total = distances_us.len();
    let p99_us = *distances_us.get((total * 99).div_ceil(100).checked_sub(1)?)?;
    Some(Beginnings { total, p99_us, most_us: *distances_us.last()? })
}

/// The sections at whose beginning the duty has to change.
fn changing<'a>(outcome: &'a Outcome, sections: &'a [Section]) -> impl Iterator<Item = &'a Section> {
    let duties = outcome.tool_config.duties;
    let duty = move |source: &Option<Source>| match source.as_ref()?.power {
        Power::Off => Some(0),
        Power::Constant(level) => Some(duties.duty(level)),
        Power::BySpeed(_) => None,
    };
    // In the order made, each with its run and its duty. At the end of a run the laser is dark.
    let mut last = (None, Some(0));
    sections.iter().filter_map(move |section| {
        let run = outcome.moves[section.index].run;
        let before = if last.0 == Some(run) { last.1 } else { Some(0) };
        let now = duty(&section.source);
        last = (Some(run), now);
        (before? != now?).then_some(section)
    })
}

/// Distance of the nearest change from a place of a move, us.
fn nearest_us(record: &MoveRecord, place_steps: f64, changes_ns: &[u64]) -> f64 {
    let begin_us = (record.place_time_s(place_steps) + record.delay_s()) * 1e6;
    let next = changes_ns.partition_point(|&t_ns| t_ns < record.start_ns + (begin_us * 1e3).round() as u64);
    let around = changes_ns[next.saturating_sub(1)..].iter().take(2);
    let distances_us = around.map(|&t_ns| ((t_ns as f64 - record.start_ns as f64) * 1e-3 - begin_us).abs());
    distances_us.fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use isostep_sim::{Config, run};

    fn outcome() -> Outcome {
        let program = "$32=1\nG91 G1 F600 M3 S500\nX5\nX5\nX5 S700\nX5 S0\nG4 P1\nX5\nM4 S300 X5\nX5 S100\nM5\n";
        run(program.as_bytes(), &Config::default()).unwrap()
    }

    #[test]
    fn only_moves_of_constant_power_with_another_level_are_looked_at() {
        let outcome = outcome();
        let sections = sections(&outcome);
        let lines: Vec<_> = changing(&outcome, &sections).map(|section| section.source.unwrap().line).collect();
        assert_eq!(lines, [3, 5, 6]);
        let found = of(&outcome).unwrap();
        assert!(found.total == 3 && found.p99_us <= found.most_us && found.most_us < 1.0, "{found:?}");
    }

    /// A change of level that is late or missing is detected.
    #[test]
    fn a_late_change_is_as_far_as_it_is_late() {
        let mut outcome = outcome();
        let second = outcome.tool.iter().filter(|change| change.output == ToolOutput::Pwm).nth(1).unwrap().t_ns;
        outcome.tool.iter_mut().filter(|change| change.t_ns == second).for_each(|change| change.t_ns += 30_000);
        let found = of(&outcome).unwrap();
        assert!((29.5..30.5).contains(&found.most_us), "{found:?}");
        outcome.tool.clear();
        assert_eq!(of(&outcome).unwrap().most_us, f64::INFINITY);
    }
}
