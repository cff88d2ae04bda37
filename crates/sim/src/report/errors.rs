//! How far every step was from its closed-form instant.

use plotters::prelude::*;

use super::theme::{self, AXIS, Area, BOUND, Drawn, GRID, INK};
use crate::outcome::Outcome;
use crate::verify::{self, TICK_NS};

/// Columns of the picture, in each of which only the earliest and the latest step of an axis are drawn.
const COLUMNS: usize = 240;

/// The picture.
pub fn picture(outcome: &Outcome) -> String {
    theme::svg((860, 340), "Distance of each step from its closed-form instant", |area| draw(area, outcome))
}

fn draw(area: &Area, outcome: &Outcome) -> Drawn {
    let errors = [0, 1, 2].map(|axis| errors(outcome, axis));
    let (from_s, to_s) = theme::range(errors.iter().flatten().map(|point| point.0));
    let (low, high) = theme::range(errors.iter().flatten().map(|point| point.1));
    let reach = low.abs().max(high.abs()).max(TICK_NS) * 1.25;
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
        .x_label_formatter(&|s| format!("{s:.0}"))
        .y_label_formatter(&|ns| format!("{ns:.0}"))
        .y_labels(7)
        .draw()?;
    for side in [-1.0, 1.0] {
        let line = [(from_s, side * TICK_NS), (to_s, side * TICK_NS)];
        chart.draw_series(DashedLineSeries::new(line, 6, 5, BOUND.stroke_width(2)))?;
    }
    for (index, errors) in errors.into_iter().enumerate().filter(|(_, errors)| !errors.is_empty()) {
        let colour = AXIS[index];
        let points = extremes(errors, from_s, to_s);
        chart.draw_series(points.into_iter().map(|point| Circle::new(point, 2, colour.filled())))?;
    }
    Ok(())
}

/// Instant from power-up, s, and error, ns, of every step of the program.
fn errors(outcome: &Outcome, axis: usize) -> Vec<(f64, f64)> {
    let program = outcome.moves.iter().filter(|record| !record.homing);
    program
        .flat_map(|record| {
            let times_s = verify::axis_times_s(record, &outcome.edges[record.edges.clone()]);
            let start_s = record.start_ns as f64 * 1e-9;
            let errors = verify::errors_ns(record, axis, &times_s[axis]);
            errors.map(|(t_s, error_ns)| (start_s + t_s, error_ns)).collect::<Vec<_>>()
        })
        .collect()
}

/// The earliest and the latest in each column.
fn extremes(errors: Vec<(f64, f64)>, from_s: f64, to_s: f64) -> Vec<(f64, f64)> {
    let column = |point: &(f64, f64)| ((point.0 - from_s) / (to_s - from_s).max(1e-9) * COLUMNS as f64) as usize;
    let columns = errors.chunk_by(|one, next| column(one) == column(next));
    let by_error = |one: &&(f64, f64), other: &&(f64, f64)| one.1.total_cmp(&other.1);
    columns
        .flat_map(|points| [points.iter().min_by(by_error), points.iter().max_by(by_error)])
        .flatten()
        .copied()
        .collect()
}
