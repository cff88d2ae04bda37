//! Groups of bars over a logarithmic scale.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::super::theme::{self, Area, Drawn, GRID, INK};
use super::{Series, colour, decades, label, short};

/// The fraction of a group's width that its bars take.
const FILLED: f64 = 0.72;

/// Height of a line under a group.
const LINE_PX: i32 = 18;

/// Draws the picture: in each of `groups`, whose names may have several lines, one bar for every series with its value
/// above it. Values that are `None` or not above 0 are left out.
pub fn bars(title: &str, value_name: &str, groups: &[String], series: &[Series<Option<f64>>]) -> String {
    theme::svg((860, 340), title, |area| draw(area, value_name, groups, series))
}

fn draw(area: &Area, value_name: &str, groups: &[String], series: &[Series<Option<f64>>]) -> Drawn {
    let shown = |value: &Option<f64>| value.filter(|value| *value > 0.0);
    let (low, high) = decades(series.iter().flat_map(|one| one.values.iter().filter_map(shown)));
    let lines = groups.iter().map(|name| name.lines().count()).max().unwrap_or(0) as i32;
    // Leaves room for the number above the highest bar.
    let high = high * 2.0;
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .margin_right(16)
        .x_label_area_size(16 + LINE_PX * lines)
        .y_label_area_size(76)
        .build_cartesian_2d(0.0..groups.len() as f64, (low..high).log_scale())?;
    chart
        .configure_mesh()
        .disable_x_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(INK)
        .label_style(theme::font(14))
        .axis_desc_style(theme::font(15))
        .y_desc(value_name)
        .x_labels(0)
        .y_label_formatter(&|value| label(*value))
        .draw()?;
    let width = FILLED / series.len() as f64;
    let above = theme::font(14).pos(Pos::new(HPos::Center, VPos::Bottom));
    for (index, one) in series.iter().enumerate() {
        for (group, value) in one.values.iter().enumerate().filter_map(|(group, value)| Some((group, shown(value)?))) {
            let left = group as f64 + (1.0 - FILLED) / 2.0 + index as f64 * width;
            let corners = [(left, low), (left + width * 0.94, value)];
            chart.draw_series([Rectangle::new(corners, colour(index).filled())])?;
            chart.draw_series([Text::new(short(value), (left + width * 0.47, value * 1.06), above.clone())])?;
        }
    }
    let under = theme::font(15).pos(Pos::new(HPos::Center, VPos::Top));
    for (group, name) in groups.iter().enumerate() {
        for (line, down) in name.lines().zip((9..).step_by(LINE_PX as usize)) {
            let text = Text::new(line.to_owned(), (0, down), under.clone());
            chart.draw_series([EmptyElement::at((group as f64 + 0.5, low)) + text])?;
        }
    }
    Ok(())
}
