//! The path in the XY plane, with the parking gantry's rack.

use plotters::prelude::*;

use super::theme::{self, AXIS, Area, BOUND, Drawn, GRID, INK, RACK};
use crate::outcome::Outcome;

/// The rack of the papers' gantry: where the middles of its bays are, mm.
const COLUMNS_MM: [f64; 3] = [25.0, 175.0, 325.0];
const ROWS_MM: [f64; 3] = [160.0, 240.0, 320.0];
/// Width and height of a bay, mm.
const BAY_MM: (f64, f64) = (150.0, 80.0);
/// Where cars come and go, mm.
const PICK_UP_MM: (f64, f64) = (175.0, 40.0);
/// Points drawn of one move.
const POINTS_PER_MOVE: usize = 200;

/// plotters places points on whole pixels, which would dent straight lines: drawn this much larger, none is seen.
const FINE: u32 = 4;
/// Inside the labels, in fine pixels.
const INNER: (f64, f64) = (2_704.0, 2_592.0);

/// The picture.
pub fn picture(outcome: &Outcome) -> String {
    theme::svg((760 * FINE, 720 * FINE), "Path in the XY plane", |area| draw(area, outcome))
}

fn draw(area: &Area, outcome: &Outcome) -> Drawn {
    let homed = outcome.moves.iter().any(|record| record.homing);
    let path = path(outcome);
    let (x, y) = bounds(&path, homed);
    let decimals = theme::decimals_of(x.1 - x.0);
    let label = |mm: &f64| format!("{mm:.decimals$}");
    let mut chart = ChartBuilder::on(area)
        .margin(12 * FINE)
        .x_label_area_size(48 * FINE)
        .y_label_area_size(60 * FINE)
        .build_cartesian_2d(x.0..x.1, y.0..y.1)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID.stroke_width(FINE))
        .axis_style(INK.stroke_width(FINE))
        .label_style(theme::font(14 * FINE))
        .axis_desc_style(theme::font(15 * FINE))
        .set_all_tick_mark_size(5 * FINE)
        .x_desc("X, mm")
        .y_desc("Y, mm")
        .x_label_formatter(&label)
        .y_label_formatter(&label)
        .draw()?;
    if homed {
        chart.draw_series(rack())?;
        chart.draw_series(names())?;
        let far = (outcome.travel_mm[0], outcome.travel_mm[1]);
        chart.draw_series(DashedLineSeries::new(
            [(0.0, 0.0), (far.0, 0.0), far, (0.0, far.1), (0.0, 0.0)],
            6 * FINE,
            5 * FINE,
            BOUND.stroke_width(FINE),
        ))?;
    }
    for moved in &path {
        chart.draw_series(LineSeries::new(moved.iter().copied(), AXIS[0].stroke_width(3 * FINE)))?;
    }
    let ends = path.iter().filter_map(|moved| moved.last().copied());
    chart.draw_series(ends.map(|end| Circle::new(end, 5 * FINE, AXIS[0].filled())))?;
    if let Some(start) = path.first().and_then(|moved| moved.first()) {
        chart.draw_series([Circle::new(*start, 7 * FINE, AXIS[1].filled())])?;
        let label = EmptyElement::at(*start) + Text::new("start", (-64, 48), theme::font(14 * FINE));
        chart.draw_series([label])?;
    }
    Ok(())
}

/// The XY places of each move of the program, at its edges.
fn path(outcome: &Outcome) -> Vec<Vec<(f64, f64)>> {
    let program = outcome.moves.iter().filter(|record| !record.homing);
    program
        .map(|record| {
            let mut at = record.origin_steps;
            let stride = record.edges.len().div_ceil(POINTS_PER_MOVE).max(1);
            let place = |at: [i32; 3]| {
                let mm = outcome.mm(at);
                (mm[0], mm[1])
            };
            let mut points = vec![place(at)];
            for (index, edge) in outcome.edges[record.edges.clone()].iter().enumerate() {
                at[edge.axis] += edge.direction;
                if index % stride == 0 {
                    points.push(place(at));
                }
            }
            points.push(place(at));
            points
        })
        .filter(|points| points.iter().any(|point| *point != points[0]))
        .collect()
}

/// What is shown, at the same scale both ways.
fn bounds(path: &[Vec<(f64, f64)>], homed: bool) -> ((f64, f64), (f64, f64)) {
    let (mut x, mut y) =
        (theme::range(path.iter().flatten().map(|p| p.0)), theme::range(path.iter().flatten().map(|p| p.1)));
    if homed {
        x = (x.0.min(COLUMNS_MM[0] - BAY_MM.0 / 2.0), x.1.max(COLUMNS_MM[2] + BAY_MM.0 / 2.0));
        y = (y.0.min(0.0), y.1.max(400.0));
    }
    let scale = ((x.1 - x.0) / INNER.0).max((y.1 - y.0) / INNER.1).max(1e-3) * 1.08;
    let around = |range: (f64, f64), pixels: f64| {
        let middle = (range.0 + range.1) / 2.0;
        (middle - scale * pixels / 2.0, middle + scale * pixels / 2.0)
    };
    (around(x, INNER.0), around(y, INNER.1))
}

fn bays() -> impl Iterator<Item = (f64, f64)> {
    ROWS_MM.into_iter().flat_map(|y| COLUMNS_MM.into_iter().map(move |x| (x, y)))
}

fn rack() -> impl Iterator<Item = Rectangle<(f64, f64)>> {
    let (width, height) = BAY_MM;
    bays().flat_map(move |(x, y)| {
        let corners = [(x - width / 2.0, y - height / 2.0), (x + width / 2.0, y + height / 2.0)];
        [Rectangle::new(corners, RACK.mix(0.12).filled()), Rectangle::new(corners, RACK.stroke_width(FINE))]
    })
}

fn names() -> impl Iterator<Item = Text<'static, (f64, f64), String>> {
    let bays = bays().enumerate().map(|(index, (x, y))| {
        Text::new(format!("bay {}", index + 1), (x, y - BAY_MM.1 * 0.36), theme::centred(14 * FINE).color(&RACK))
    });
    let (x, y) = PICK_UP_MM;
    bays.chain([Text::new("pick-up point".to_owned(), (x, y - 16.0), theme::centred(14 * FINE).color(&RACK))])
}
