//! The table of moves: all of them, or a selection of the most interesting if there are many.

use maud::{Markup, html};

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
pub fn table(figures: &Figures) -> Markup {
    html! {
        h2 { "Moves" }
        p { "Planned intervals hold for every axis. Measured ones come from each axis's own edges alone, by fitting its ramps and its cruise; a dash stands for an axis at rest or with too few edges to fit." }
        @if figures.moves_total <= ALL_MAX {
            (rows(figures.moves.iter()))
        } @else {
            @let (longest, latest) = (most(&figures.moves, MoveFigures::duration_s), most(&figures.moves, MoveFigures::error_max_ns));
            p {
                (figures.moves_total) " moves: here are the first " (SOME) ", and the " (SOME)
                " each that last longest and whose steps are farthest from their instants. "
                (figures.moves_total - shown(&figures.moves, &[&longest, &latest])) " moves are left out: "
                code { "--moves" } " lists them all."
            }
            h3 { "The first" }
            (rows(figures.moves.iter().take(SOME)))
            h3 { "The longest" }
            (rows(longest.into_iter()))
            h3 { "The largest errors" }
            (rows(latest.into_iter()))
        }
    }
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

fn rows<'a>(moves: impl Iterator<Item = &'a MoveFigures>) -> Markup {
    html! {
        div.scroll { table {
            thead { tr {
                th { "#" } th { "line" } th { "to, mm" } th { "steps" } th { "" }
                th { "accelerate, s" } th { "cruise, s" } th { "decelerate, s" } th { "±, ns" } th { "max. error, ns" }
            } }
            tbody { @for one in moves { (move_rows(one)) } }
        } }
    }
}

fn move_rows(one: &MoveFigures) -> Markup {
    let axes = (0..AXES).filter(|&axis| one.steps[axis] != 0);
    html! {
        tr.first {
            td { (one.number) } td { (one.line.map_or("-".to_owned(), |line| line.to_string())) }
            td { (one.to_mm.map(|mm| format!("{mm:.2}")).join(", ")) } td { (one.steps.map(|n| n.to_string()).join(", ")) }
            td { "planned" } (interval_cells(Some(one.planned))) td {} td {}
        }
        @for axis in axes {
            tr {
                td {} td {} td {} td {}
                td { (AXIS_NAMES[axis]) " measured" } (interval_cells(one.measured[axis].map(|measured| measured.intervals)))
                td { (one.measured[axis].map_or("-".to_owned(), |measured| format!("{:.0}", measured.resolution_s * 1e9))) }
                td { (one.error_max_ns[axis].map_or("-".to_owned(), |ns| format!("{ns:.0}"))) }
            }
        }
    }
}

fn interval_cells(intervals: Option<Intervals>) -> Markup {
    let cells = intervals.map(|intervals| [intervals.accel_s, intervals.cruise_s, intervals.decel_s]);
    html! {
        @match cells {
            Some(cells) => { @for s in cells { td { (format!("{:.6}", s.abs())) } } }
            None => { td { "-" } td { "-" } td { "-" } }
        }
    }
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
        pictures::page(&outcome, &pictures::BothRules::of(&outcome, None), &Figures::new("many", &outcome))
    }

    #[test]
    fn of_many_moves_the_table_has_those_that_tell_most() {
        let page = page(300);
        let moves = page.split("<h2>Moves</h2>").nth(1).unwrap();
        let moves = moves.split("<h2>").next().unwrap();
        assert_eq!(moves.matches("tr class=\"first\"").count(), 60);
        assert!(moves.contains("<td>301</td>") && moves.contains("301 moves: here are the first 20"), "{moves}");
        assert!(moves.contains("--moves"));
    }

    #[test]
    fn of_few_moves_the_table_has_all() {
        let page = page(60);
        let moves = page.split("<h2>Moves</h2>").nth(1).unwrap();
        assert_eq!(moves.matches("tr class=\"first\"").count(), 61);
        assert!(!moves.contains("left out"));
    }
}
