//! The swinging of the loads on springs: a table, and the deviation of each load over time.

use isostep_motion::Axis;

use super::chart::{self, Chart, Curve, Style};
use super::document::{Picture, Section, Table};
use super::theme::{AXIS, AXIS_NAMES};
use crate::again::Rule;
use crate::ringing::{self, Deviation, RingingFigures, swings};
use isostep_sim::Outcome;
use isostep_sim::analysis::Oscillator;
use isostep_sim::lines_of_moves;

/// Number of time spans, each with its least and its greatest deviation.
const SPANS: usize = 760;
/// The number of periods that are shown after the last plan.
const PERIODS_AFTER: f64 = 8.0;

/// A row of the table: the rule at corners, and what one load does.
pub struct Row {
    rule: String,
    load: RingingFigures,
}

/// The rows of a run: one for each load.
pub fn rows(rule: &Rule, outcome: &Outcome) -> Vec<Row> {
    let rule = format!("{}, {}", rule.name, rule.whose());
    let loads = ringing::figures(outcome, &lines_of_moves::of_moves(outcome));
    loads.into_iter().map(|load| Row { rule: rule.clone(), load }).collect()
}

/// The table, with rows of the same program without shapers, and the picture; `None` if no axis has a spring, or nothing moves.
pub fn section(outcome: &Outcome, rows: &[Row], unshaped: &[RingingFigures]) -> Option<Section> {
    let head = ["load", "corners", "after stops: amplitude, mm", "after corners: deviation, mm", "anywhere, mm"];
    let shaped = rows.iter().map(|Row { rule, load }| row(rule, load));
    let all = shaped.chain(unshaped.iter().map(|load| row("without shapers, for comparison", load)));
    let table = Table::new(&head, all.collect());
    let caption = "How far each load on a spring is from where the edges have put its axis, in this run: the band is the least to \
                   the greatest deviation of each span of time, good to half a step. While an axis accelerates its load lags, so \
                   a deviation is not 0 where nothing rings; what is left after a stop is ringing alone.";
    let picture = Picture::new("ringing", picture(outcome)?, caption);
    Some(Section::new("Ringing").with_pictures([picture]).with_tables([table]))
}

fn row(rule: &str, one: &RingingFigures) -> Vec<String> {
    let cell = |found: Option<Deviation>| {
        let line = |line: usize| format!(", line {line}");
        found.map_or("-".to_owned(), |Deviation { mm, move_number, line: at }| {
            format!("{mm:.4}: move {move_number}{}", at.map_or(String::new(), line))
        })
    };
    vec![
        format!("{} {} Hz, {}", one.axis, one.natural_hz, one.damping_ratio),
        rule.to_owned(),
        cell(one.after_stops),
        cell(one.after_corners),
        format!("{:.4}", one.anywhere_mm),
    ]
}

/// The deviation of each load over time; `None` if no axis has a spring, or nothing moves.
pub fn picture(outcome: &Outcome) -> Option<String> {
    let springs = Axis::ALL.into_iter().zip(outcome.config.springs.0);
    let loads: Vec<_> = springs.filter_map(|(axis, spring)| Some((axis, spring?))).collect();
    let mut program = outcome.program_moves();
    let first = program.next()?;
    let last = program.next_back().unwrap_or(first);
    let slowest_hz = loads.iter().map(|(_, spring)| spring.natural_hz()).reduce(f64::min)?;
    let begin_s = first.begin_ns() as f64 * 1e-9;
    let end_s = last.start_ns as f64 * 1e-9 + last.plan_s + PERIODS_AFTER / slowest_hz;
    let bands: Vec<_> =
        loads.iter().map(|&(axis, spring)| (axis, Band::of(outcome, axis, spring, [begin_s, end_s]))).collect();
    Some(chart::picture("Deviation of the loads on springs over time", &[], 1, 180, &charts(&bands)))
}

/// The deviation of a load from the start of the first move on.
struct Band {
    /// The duration of a span, s.
    span_s: f64,
    /// The least and the greatest deviation in each span, mm. A load that no edge has moved yet is at 0.
    ranges_mm: Vec<(f64, f64)>,
}

impl Band {
    fn of(outcome: &Outcome, axis: Axis, spring: Oscillator, [begin_s, end_s]: [f64; 2]) -> Self {
        let span_s = (end_s - begin_s) / SPANS as f64;
        let mut ranges: Vec<Option<(f64, f64)>> = vec![None; SPANS];
        let mut swings = swings(outcome, axis, spring).peekable();
        while let Some(mut swing) = swings.next() {
            if swings.peek().is_none() {
                // The last one ends with the run, and the load swings on.
                swing.end_s = swing.end_s.max(end_s);
            }
            if swing.end_s <= begin_s || swing.begin_s >= end_s {
                continue;
            }
            let span = |t_s: f64| (((t_s - begin_s) / span_s).max(0.0) as usize).min(SPANS - 1);
            // Cut within a step, a swing is good to half a step only: short ones are taken whole.
            let is_short = swing.end_s - swing.begin_s < span_s;
            for (number, range) in (0..).zip(&mut ranges).take(span(swing.end_s) + 1).skip(span(swing.begin_s)) {
                let [begins_s, ends_s] = [0.0, 1.0].map(|more| begin_s + (f64::from(number) + more) * span_s);
                let (from_s, to_s) = match is_short {
                    true => (swing.begin_s, swing.end_s),
                    false => (swing.begin_s.max(begins_s), swing.end_s.min(ends_s)),
                };
                if from_s <= to_s {
                    let (low, high) = swing.range(from_s, to_s);
                    *range = Some(range.map_or((low, high), |(least, most)| (least.min(low), most.max(high))));
                }
            }
        }
        Self { span_s, ranges_mm: ranges.into_iter().map(Option::unwrap_or_default).collect() }
    }

    fn highest_mm(&self) -> f64 {
        self.ranges_mm.iter().map(|(low, high)| high.max(-low)).fold(0.0, f64::max)
    }
}

/// A chart of each load. All have one scale, so that they can be compared.
fn charts(bands: &[(Axis, Band)]) -> Vec<Chart> {
    let top_mm = 1.1 * bands.iter().map(|(_, band)| band.highest_mm()).fold(1e-6, f64::max);
    let chart = |(axis, band): &(Axis, Band)| {
        let at = |number: usize| (number as f64 + 0.5) * band.span_s;
        let above = band.ranges_mm.iter().enumerate().map(|(number, range)| (at(number), range.1));
        let below = band.ranges_mm.iter().enumerate().rev().map(|(number, range)| (at(number), range.0));
        let outline: Vec<_> = above.chain(below).collect();
        let colour = AXIS[*axis as usize];
        let area = Curve::new(Style::Area, colour, outline.iter().copied()).faint(0.5);
        let x = chart::Axis::from("time from the start of the first move, s");
        let y = chart::Axis::from(format!("{}, mm", AXIS_NAMES[*axis as usize]));
        Chart::new(
            x.within(0.0, band.span_s * SPANS as f64),
            y.within(-top_mm, top_mm),
            vec![area, Curve::new(Style::Thin, colour, outline)],
        )
    };
    chart::over_one_x(bands.iter().map(chart).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pictures::BothRules;
    use isostep_sim::{Config, run};

    fn made(program: &str, springs: &str) -> Outcome {
        let config = Config { springs: springs.parse().unwrap_or_default(), ..Config::default() };
        run(program.as_bytes(), &config).unwrap()
    }

    fn outcome(springs: &str) -> Outcome {
        made("G1 X10 F1200\nY10\n", springs)
    }

    /// The last edge of a run is not the end of the swinging.
    #[test]
    fn a_load_swings_on_behind_the_last_stop() {
        let outcome = made("G1 X10 F1200\n", "X:8:0.05");
        let spring = outcome.config.springs.0[0].unwrap();
        let (mm, _) = ringing::residual(&outcome, Axis::X, spring).after_stops.unwrap();
        let stop_s = outcome.moves[0].start_ns as f64 * 1e-9 + outcome.moves[0].plan_s;
        let band = Band::of(&outcome, Axis::X, spring, [stop_s, stop_s + 0.125]);
        assert!((0.8 * mm..=mm).contains(&band.highest_mm()), "{} of {mm}", band.highest_mm());
    }

    #[test]
    fn every_load_has_its_row_and_its_chart_and_a_rigid_machine_has_none() {
        let page = |outcome: &Outcome, other: Option<Outcome>| {
            let both = BothRules::of(outcome, other);
            section(outcome, &both.ringing, &[])
        };
        assert!(page(&outcome(""), None).is_none());
        let ringing = outcome("X:8:0.05,Y:6:0.05");
        for (other, loads) in [
            (None, vec!["X 8 Hz, 0.05", "Y 6 Hz, 0.05"]),
            (Some(ringing.clone()), vec!["X 8 Hz, 0.05", "Y 6 Hz, 0.05", "X 8 Hz, 0.05", "Y 6 Hz, 0.05"]),
        ] {
            let section = page(&ringing, other).unwrap();
            assert_eq!(section.tables[0].rows.iter().map(|row| row[0].as_str()).collect::<Vec<_>>(), loads);
            assert_eq!(section.pictures[0].svg.matches("<polygon").count(), 2);
        }
    }

    /// The chart has what the table says, and comes to rest as the load does.
    #[test]
    fn the_band_is_the_deviation() {
        let outcome = outcome("X:8:0.05");
        let spring = outcome.config.springs.0[0].unwrap();
        let residual = ringing::residual(&outcome, Axis::X, spring);
        let end_s = outcome.moves.last().unwrap().plan_s + outcome.moves[0].start_ns as f64 * 1e-9;
        let band = Band::of(&outcome, Axis::X, spring, [0.0, end_s]);
        let more_steps = (band.highest_mm() - residual.anywhere_mm) * outcome.steps_per_mm[0];
        assert!((-1e-9..=0.5).contains(&more_steps), "{more_steps} steps, {residual:?}");
        let (highest_mm, (low, high)) = (band.highest_mm(), band.ranges_mm[SPANS - 1]);
        let drawn = &charts(&[(Axis::X, band)])[0].curves[0].points;
        assert_eq!(drawn.len(), 2 * SPANS);
        assert_eq!(drawn.iter().map(|point| point.1.abs()).fold(0.0, f64::max), highest_mm);
        assert!(high - low < 0.1 * residual.anywhere_mm, "{low} to {high}");
    }
}
