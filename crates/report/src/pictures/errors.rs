//! The distance of every step from its closed-form instant.

use isostep_motion::{AXES, Axis};
use plotters::prelude::*;

use super::theme::{self, AXIS, Area, BOUND, Drawn, GRID, INK};
use isostep_sim::Outcome;
use isostep_sim::measure::across;
use isostep_sim::verify::{self, shaped};

/// Columns of the picture. Each shows an axis's range of errors, from the earliest step to the latest.
const COLUMNS: usize = 240;

/// Draws the picture.
pub fn picture(outcome: &Outcome) -> String {
    theme::svg((860, 340), "Distance of each step from its closed-form instant", |area| draw(area, outcome))
}

fn draw(area: &Area, outcome: &Outcome) -> Drawn {
    let (from_s, to_s) = span_s(outcome);
    let columns = columns(outcome, from_s, to_s);
    let (low, high) = theme::range(columns.iter().flatten().flatten().flat_map(|&(low, high)| [low, high]));
    let tick_ns = outcome.config.port.tick_ns();
    let reach = low.abs().max(high.abs()).max(tick_ns) * 1.25;
    let decimals = theme::decimals_of(to_s - from_s);
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .margin_right(16)
        .x_label_area_size(46)
        .y_label_area_size(68)
        .build_cartesian_2d(from_s..to_s.max(from_s + 1e-3), -reach..reach)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(INK)
        .label_style(theme::font(14))
        .axis_desc_style(theme::font(15))
        .x_desc("time from power-up, s")
        .y_desc("late (+) or early (-), ns")
        .x_label_formatter(&|s| format!("{s:.decimals$}"))
        .y_label_formatter(&|ns| format!("{ns:.0}"))
        .y_labels(7)
        .draw()?;
    for side in [-1.0, 1.0] {
        let line = [(from_s, side * tick_ns), (to_s, side * tick_ns)];
        chart.draw_series(DashedLineSeries::new(line, 6, 5, BOUND.stroke_width(2)))?;
    }
    let width_s = (to_s - from_s).max(1e-9) / COLUMNS as f64;
    // The height that makes a single step visible.
    let least_ns = tick_ns / 100.0;
    for (columns, colour) in columns.iter().zip(AXIS) {
        let spans = columns.iter().enumerate().filter_map(|(number, span)| span.map(|span| (number, span)));
        chart.draw_series(spans.map(|(number, (low, high))| {
            let left_s = from_s + number as f64 * width_s;
            Rectangle::new([(left_s, low - least_ns), (left_s + width_s, high + least_ns)], colour.mix(0.55).filled())
        }))?;
    }
    Ok(())
}

/// From the beginning of the first move of the program to the end of the last one, s since power-up.
fn span_s(outcome: &Outcome) -> (f64, f64) {
    let program = outcome.moves.iter().filter(|record| !record.homing);
    theme::range(program.flat_map(|record| [record.begin_ns(), record.end_ns]).map(|ns| ns as f64 * 1e-9))
}

/// For each axis and column, the least and the greatest error, ns; `None` without steps.
fn columns(outcome: &Outcome, from_s: f64, to_s: f64) -> [[Option<(f64, f64)>; COLUMNS]; AXES] {
    let mut columns = [[None; COLUMNS]; AXES];
    let per_s = COLUMNS as f64 / (to_s - from_s).max(1e-9);
    let mut take = |axis: usize, t_s: f64, error_ns: f64| {
        let span = &mut columns[axis][(((t_s - from_s) * per_s).max(0.0) as usize).min(COLUMNS - 1)];
        let (low, high) = span.unwrap_or((error_ns, error_ns));
        *span = Some((low.min(error_ns), high.max(error_ns)));
    };
    for (_, run) in across::runs(outcome) {
        if run[0].shaping.is_some() {
            for axis in Axis::ALL {
                let errors_ns = shaped::errors_ns(outcome, run, axis);
                errors_ns.into_iter().for_each(|(t_s, error_ns)| take(axis as usize, t_s, error_ns));
            }
            continue;
        }
        for record in run {
            let times_s = verify::axis_times_s(record, &outcome.edges[record.edges.clone()]);
            let begin_s = record.begin_ns() as f64 * 1e-9;
            for (axis, times_s) in times_s.iter().enumerate() {
                verify::errors_ns(record, axis, times_s)
                    .for_each(|(t_s, error_ns)| take(axis, begin_s + t_s, error_ns));
            }
        }
    }
    columns
}
