//! Measured points, connected by lines, over a logarithmic scale.

use plotters::prelude::*;

use super::super::theme::{self, Area, Drawn, GRID, INK};
use super::{Series, colour, label, short};

/// Draws the picture: a curve with a dot at each (x, y) of every series; x is above 0, y is 0 or more.
pub fn curves(title: &str, x_name: &str, y_name: &str, series: &[Series<(f64, f64)>]) -> String {
    theme::svg((860, 340), title, |area| draw(area, x_name, y_name, series))
}

fn draw(area: &Area, x_name: &str, y_name: &str, series: &[Series<(f64, f64)>]) -> Drawn {
    let points = || series.iter().flat_map(|one| one.values.iter().copied());
    let (from, to) = theme::range(points().map(|(x, _)| x));
    let (from, to) = (from.max(f64::MIN_POSITIVE) * 0.7, to.max(1.0) * 1.4);
    let high = points().map(|(_, y)| y).fold(0.0, f64::max).max(1e-9) * 1.15;
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .margin_right(24)
        .x_label_area_size(46)
        .y_label_area_size(68)
        .build_cartesian_2d((from..to).log_scale(), 0.0..high)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(INK)
        .label_style(theme::font(14))
        .axis_desc_style(theme::font(15))
        .x_desc(x_name)
        .y_desc(y_name)
        .x_label_formatter(&|value| label(*value))
        .y_label_formatter(&|value| short(*value))
        .y_labels(6)
        .draw()?;
    for (index, one) in series.iter().enumerate() {
        let colour = colour(index);
        chart.draw_series(LineSeries::new(one.values.iter().copied(), colour.stroke_width(2)))?;
        chart.draw_series(one.values.iter().map(|&point| Circle::new(point, 4, colour.filled())))?;
    }
    Ok(())
}
