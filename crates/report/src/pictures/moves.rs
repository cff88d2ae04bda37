//! The table of moves: all of them, or a selection of the most interesting if there are many.

use super::document::{Section, Table};
use super::theme::AXIS_NAMES;
use crate::figures::{Figures, MoveFigures};
use isostep_motion::AXES;
use isostep_sim::measure::Intervals;

/// Up to this number, all moves of a program are in the table.
const ALL_MAX: usize = 100;
/// Otherwise the table has this many first moves, this many of the longest, and this many of those with the largest
/// error.
const SOME: usize = 20;

/// The tables of moves.
pub fn section(figures: &Figures) -> Section {
    let about = "Planned intervals hold for every axis. Measured ones come from each axis's own edges alone, by fitting its ramps and \
                 its cruise; a dash stands for an axis at rest or with too few edges to fit.";
    let section = Section::new("Moves").with_text(about);
    if figures.moves_total <= ALL_MAX {
        return section.with_tables([table(figures.moves.iter())]);
    }
    let longest = most(&figures.moves, MoveFigures::duration_s);
    let latest = most(&figures.moves, MoveFigures::error_max_ns);
    let some = format!(
        "{} moves: here are the first {SOME}, and the {SOME} each that last longest and whose steps are farthest from their \
         instants. {} moves are left out: --moves lists them all.",
        figures.moves_total,
        figures.moves_total - shown(&figures.moves, &[&longest, &latest])
    );
    section.with_text(some).with_tables([
        table(figures.moves.iter().take(SOME)).captioned("The first"),
        table(longest).captioned("The longest"),
        table(latest).captioned("The largest errors"),
    ])
}

/// The moves with the greatest `value`, the greatest first.
fn most(moves: &[MoveFigures], value: fn(&MoveFigures) -> f64) -> Vec<&MoveFigures> {
    let mut most: Vec<&MoveFigures> = Vec::with_capacity(SOME + 1);
    for one in moves {
        let rank = most.partition_point(|other| value(other) >= value(one));
        if rank < SOME {
            most.insert(rank, one);
            most.truncate(SOME);
        }
    }
    most
}

/// Number of different moves in the tables.
fn shown(moves: &[MoveFigures], others: &[&[&MoveFigures]]) -> usize {
    let mut numbers: Vec<_> = moves.iter().take(SOME).map(|one| one.number).collect();
    numbers.extend(others.iter().flat_map(|others| others.iter().map(|one| one.number)));
    numbers.sort_unstable();
    numbers.dedup();
    numbers.len()
}

fn table<'a>(moves: impl IntoIterator<Item = &'a MoveFigures>) -> Table {
    let head =
        ["#", "line", "to, mm", "steps", "", "accelerate, s", "cruise, s", "decelerate, s", "±, ns", "max. error, ns"];
    Table::new(&head, moves.into_iter().flat_map(rows).collect())
}

/// A row of the plan, and one of each axis that moves.
fn rows(one: &MoveFigures) -> Vec<Vec<String>> {
    let or_dash = |text: Option<String>| text.unwrap_or("-".to_owned());
    let planned = [
        one.number.to_string(),
        or_dash(one.line.map(|line| line.to_string())),
        one.to_mm.map(|mm| format!("{mm:.2}")).join(", "),
        one.steps.map(|n| n.to_string()).join(", "),
        "planned".to_owned(),
    ];
    let planned = [&planned[..], &interval_cells(Some(one.planned)), &[String::new(), String::new()]].concat();
    let axes = (0..AXES).filter(|&axis| one.steps[axis] != 0).map(|axis| {
        let measured = one.measured[axis];
        let name = format!("{} measured", AXIS_NAMES[axis]);
        let ends = [measured.map(|measured| measured.resolution_s * 1e9), one.error_max_ns[axis]];
        let ends = ends.map(|ns| or_dash(ns.map(|ns| format!("{ns:.0}"))));
        let blank = [const { String::new() }; 4];
        [&blank[..], &[name], &interval_cells(measured.map(|measured| measured.intervals)), &ends].concat()
    });
    [planned].into_iter().chain(axes).collect()
}

fn interval_cells(intervals: Option<Intervals>) -> [String; 3] {
    let cells = intervals.map(|intervals| [intervals.accel_s, intervals.cruise_s, intervals.decel_s]);
    cells.map_or([const { "-" }; 3].map(str::to_owned), |cells| cells.map(|s| format!("{:.6}", s.abs())))
}

#[cfg(test)]
mod tests {
    use crate::{Figures, pictures};
    use isostep_sim::{Config, run};

    fn page(moves: usize) -> String {
        let program = format!("G91 G1 F1200\n{}X9\n", "X0.5\nY0.5\n".repeat(moves / 2));
        let mut config = Config::default();
        config.settings.soft_limits = false;
        let outcome = run(program.as_bytes(), &config).unwrap();
        pictures::page(&outcome, &pictures::BothRules::of(&outcome, None), &Figures::new("many", &outcome)).html()
    }

    #[test]
    fn of_many_moves_the_table_has_those_that_tell_most() {
        let page = page(300);
        let moves = page.split(">Moves</h2>").nth(1).unwrap();
        let moves = moves.split("<h2").next().unwrap();
        assert_eq!(moves.matches("tr class=\"first\"").count(), 60);
        assert!(moves.contains(">301</td>") && moves.contains("301 moves: here are the first 20"), "{moves}");
        assert!(moves.contains("--moves"));
    }

    #[test]
    fn of_few_moves_the_table_has_all() {
        let page = page(60);
        let moves = page.split(">Moves</h2>").nth(1).unwrap();
        assert_eq!(moves.matches("tr class=\"first\"").count(), 61);
        assert!(!moves.contains("left out"));
    }
}
