//! How far every step was from its closed-form instant.

use plotters::prelude::*;

use super::theme::{self, AXIS, Area, BOUND, Drawn, GRID, INK};
use crate::outcome::Outcome;
use crate::verify;

/// Columns of the picture: each spans an axis's steps from the earliest to the latest.
const COLUMNS: usize = 240;

/// The picture.
pub fn picture(outcome: &Outcome) -> String {
    theme::svg((860, 340), "Distance of each step from its closed-form instant", |area| draw(area, outcome))
}

fn draw(area: &Area, outcome: &Outcome) -> Drawn {
    let errors = [0, 1, 2].map(|axis| errors(outcome, axis));
    let (from_s, to_s) = theme::range(errors.iter().flatten().map(|point| point.0));
    let (low, high) = theme::range(errors.iter().flatten().map(|point| point.1));
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
    for (index, errors) in errors.into_iter().enumerate().filter(|(_, errors)| !errors.is_empty()) {
        let colour = AXIS[index];
        chart.draw_series(
            columns(errors, from_s, to_s, tick_ns)
                .into_iter()
                .map(|corners| Rectangle::new(corners, colour.mix(0.55).filled())),
        )?;
    }
    Ok(())
}

/// Instant from power-up, s, and error, ns, of every step of the program.
fn errors(outcome: &Outcome, axis: usize) -> Vec<(f64, f64)> {
    let program = outcome.moves.iter().filter(|record| !record.homing);
    program
        .flat_map(|record| {
            let times_s = verify::axis_times_s(record, &outcome.edges[record.edges.clone()]);
            let start_s = record.begin_ns() as f64 * 1e-9;
            let errors = verify::errors_ns(record, axis, &times_s[axis]);
            errors.map(|(t_s, error_ns)| (start_s + t_s, error_ns)).collect::<Vec<_>>()
        })
        .collect()
}

/// Corners of each column's span.
fn columns(errors: Vec<(f64, f64)>, from_s: f64, to_s: f64, tick_ns: f64) -> Vec<[(f64, f64); 2]> {
    // A single step is still seen.
    let least_ns = tick_ns / 100.0;
    let width_s = (to_s - from_s).max(1e-9) / COLUMNS as f64;
    let column = |point: &(f64, f64)| ((point.0 - from_s) / width_s).floor();
    let groups = errors.chunk_by(|one, next| column(one) == column(next));
    groups
        .map(|points| {
            let (low, high) = theme::range(points.iter().map(|point| point.1));
            let left_s = from_s + column(&points[0]) * width_s;
            [(left_s, low - least_ns), (left_s + width_s, high + least_ns)]
        })
        .collect()
}
