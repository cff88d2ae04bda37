//! How the loads on springs swing: a table, and the deviation of each load over time.

use isostep_motion::Axis;
use maud::{Markup, html};
use plotters::prelude::*;

use super::other_rule::Rule;
use super::theme::{self, AXIS, AXIS_NAMES, Area, Drawn, GRID, INK};
use crate::ringing::{self, Deviation, RingingFigures, swings};
use isostep_sim::Outcome;
use isostep_sim::analysis::Oscillator;
use isostep_sim::lines_of_moves;

/// Number of time spans, each with its least and its greatest deviation.
const SPANS: usize = 760;
/// plotters rounds points to whole pixels. Drawn at this scale, the error is not visible.
const FINE: u32 = 4;
/// Size of the chart of one load, pixels, and what the name of the time axis takes below the last.
const PANEL: (u32, u32) = (860, 150);
const TIME: u32 = 30;
/// How many periods are shown after the last plan.
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
pub fn section(outcome: &Outcome, rows: &[Row], unshaped: &[RingingFigures]) -> Option<Markup> {
    let picture = picture(outcome)?;
    Some(html! {
        h2 { "Ringing" }
        div.scroll { table {
            thead { tr {
                th { "load" } th { "corners" } th { "after stops: amplitude, mm" } th { "after corners: deviation, mm" } th { "anywhere, mm" }
            } }
            tbody {
                @for Row { rule, load } in rows { (row(rule, load)) }
                @for load in unshaped { (row("without shapers, for comparison", load)) }
            }
        } }
        figure { (maud::PreEscaped(picture)) figcaption {
            "How far each load on a spring is from where the edges have put its axis, in this run: the band is the least to the greatest \
             deviation of each span of time, good to half a step. While an axis accelerates its load lags, so a deviation is not 0 \
             where nothing rings; what is left after a stop is ringing alone."
        } }
    })
}

fn row(rule: &str, one: &RingingFigures) -> Markup {
    let cell = |found: Option<Deviation>| {
        let line = |line: usize| format!(", line {line}");
        found.map_or("-".to_owned(), |Deviation { mm, move_number, line: at }| {
            format!("{mm:.4}: move {move_number}{}", at.map_or(String::new(), line))
        })
    };
    html! { tr {
        td { (one.axis) " " (one.natural_hz) " Hz, " (one.damping_ratio) } td { (rule) }
        td { (cell(one.after_stops)) } td { (cell(one.after_corners)) } td { (format!("{:.4}", one.anywhere_mm)) }
    } }
}

/// The deviation of each load over time; `None` if no axis has a spring, or nothing moves.
pub fn picture(outcome: &Outcome) -> Option<String> {
    let springs = Axis::ALL.into_iter().zip(outcome.config.springs.0);
    let loads: Vec<_> = springs.filter_map(|(axis, spring)| Some((axis, spring?))).collect();
    let mut program = outcome.moves.iter().filter(|record| !record.homing);
    let first = program.next()?;
    let last = program.next_back().unwrap_or(first);
    let slowest_hz = loads.iter().map(|(_, spring)| spring.natural_hz()).reduce(f64::min)?;
    let begin_s = first.begin_ns() as f64 * 1e-9;
    let end_s = last.start_ns as f64 * 1e-9 + last.plan_s + PERIODS_AFTER / slowest_hz;
    let bands: Vec<_> =
        loads.iter().map(|&(axis, spring)| (axis, Band::of(outcome, axis, spring, [begin_s, end_s]))).collect();
    let size = (PANEL.0 * FINE, (PANEL.1 * bands.len() as u32 + TIME) * FINE);
    Some(theme::svg(size, "Deviation of the loads on springs over time", |area| draw(area, &bands)))
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

fn draw(area: &Area, bands: &[(Axis, Band)]) -> Drawn {
    // All loads have one scale, so that they can be compared.
    let top_mm = 1.1 * bands.iter().map(|(_, band)| band.highest_mm()).fold(1e-6, f64::max);
    let mut rest = area.clone();
    for (number, (axis, band)) in bands.iter().enumerate() {
        let is_last = number + 1 == bands.len();
        let (own, below) = rest.split_vertically((PANEL.1 + if is_last { TIME } else { 0 }) * FINE);
        rest = below;
        panel(&own, *axis, band, top_mm, is_last)?;
    }
    Ok(())
}

fn panel(area: &Area, axis: Axis, band: &Band, top_mm: f64, names_time: bool) -> Drawn {
    let end_s = band.span_s * SPANS as f64;
    let mut chart = ChartBuilder::on(area)
        .margin(8 * FINE)
        .margin_right(16 * FINE)
        .x_label_area_size(if names_time { 46 } else { 16 } * FINE)
        .y_label_area_size(76 * FINE)
        .build_cartesian_2d(0.0..end_s, -top_mm..top_mm)?;
    let [seconds, decimals] = [end_s, 2.0 * top_mm].map(theme::decimals_of);
    let x_label = |s: &f64| if names_time { format!("{s:.seconds$}") } else { String::new() };
    let y_label = |mm: &f64| format!("{mm:.decimals$}");
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(TRANSPARENT).bold_line_style(GRID.stroke_width(FINE)).axis_style(INK.stroke_width(FINE));
    mesh.label_style(theme::font(14 * FINE)).axis_desc_style(theme::font(15 * FINE)).set_all_tick_mark_size(5 * FINE);
    mesh.x_label_formatter(&x_label).y_label_formatter(&y_label).y_labels(5);
    mesh.y_desc(format!("{}, mm", AXIS_NAMES[axis as usize]));
    if names_time {
        mesh.x_desc("time from the start of the first move, s");
    }
    mesh.draw()?;
    let colour = AXIS[axis as usize];
    let at = |number: usize| (number as f64 + 0.5) * band.span_s;
    let above = band.ranges_mm.iter().enumerate().map(|(number, range)| (at(number), range.1));
    let below = band.ranges_mm.iter().enumerate().rev().map(|(number, range)| (at(number), range.0));
    let outline: Vec<_> = above.chain(below).collect();
    chart.draw_series([Polygon::new(outline.clone(), colour.mix(0.5))])?;
    chart.draw_series([PathElement::new(outline, colour.stroke_width(FINE))])?;
    Ok(())
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
            section(outcome, &both.ringing, &[]).map(Markup::into_string)
        };
        assert!(page(&outcome(""), None).is_none());
        let ringing = outcome("X:8:0.05,Y:6:0.05");
        let alone = page(&ringing, None).unwrap();
        assert_eq!(alone.matches("<td>X 8 Hz, 0.05</td>").count(), 1, "{alone}");
        assert_eq!(alone.matches("<polygon").count(), 2);
        let both = page(&ringing, Some(ringing.clone())).unwrap();
        assert_eq!(both.matches("<td>Y 6 Hz, 0.05</td>").count(), 2, "{both}");
        assert_eq!(both.matches("<polygon").count(), 2);
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
        let (low, high) = band.ranges_mm[SPANS - 1];
        assert!(high - low < 0.1 * residual.anywhere_mm, "{low} to {high}");
    }
}
