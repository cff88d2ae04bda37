//! Charts of curves, one or several in a picture.

use plotters::prelude::*;

use isostep_report::pictures::bench::short;
use isostep_report::pictures::theme::{self, Area, CURVE, Drawn, GRID, INK, INTERVAL};
use isostep_report::pictures::thin;

/// plotters rounds points to whole pixels, which would distort smooth curves. Drawn at this scale, the error is not
/// visible.
const FINE: u32 = 4;
/// Width of a picture, pixels.
const WIDTH: u32 = 860;
/// A chart begins at 0 if its first x is less than this fraction of its last.
const NEAR: f64 = 0.06;
/// The largest number of columns that are distinguished.
const COLUMNS: usize = 1_200;

/// One chart of a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    /// Name of the x axis, with its unit.
    pub x_name: String,
    /// Name of the y axis, with its unit.
    pub y_name: String,
    /// The curves in the order drawn; later ones are on top.
    pub curves: Vec<Curve>,
    /// Ranges of x that are shaded.
    pub bands: Vec<Band>,
    /// The scale of the y axis.
    pub scale: Scale,
    /// The lowest and the highest value shown; if `None`, those of the curves.
    pub range: Option<(f64, f64)>,
}

/// Points and their style.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Index of one of the seven colours of curves.
    pub colour: usize,
    /// The style.
    pub style: Style,
    /// (x, y), in the order in which they are connected.
    pub points: Vec<(f64, f64)>,
}

/// Style of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// A line.
    Line,
    /// A line of half the width.
    Thin,
    /// A dashed line.
    Dashed,
    /// A dot at each point.
    Dots,
}

/// A shaded range of x; the third value means accelerating (0), cruising (1) or decelerating (2).
pub type Band = (f64, f64, usize);

/// The scale of the y axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// Linear: equal distances are equal differences.
    #[default]
    Linear,
    /// Logarithmic: equal distances are equal factors; values must be above 0.
    Decades,
    /// Linear, but without labels because the values have no meaning.
    Levels,
}

/// A picture of `charts`, with `columns` charts per row, each `height` pixels high.
///
/// # Panics
/// If `columns` is 0.
pub fn charts(title: &str, columns: usize, height: u32, charts: &[Chart]) -> String {
    let rows = charts.len().div_ceil(columns).max(1);
    let size = (WIDTH * FINE, height * FINE * rows as u32);
    theme::svg(size, title, |area| {
        let places = area.split_evenly((rows, columns));
        charts.iter().zip(&places).try_for_each(|(chart, place)| draw(place, chart))
    })
}

fn draw(area: &Area, chart: &Chart) -> Drawn {
    let (x, y) = (extent_x(chart), extent_y(chart));
    let mut context = ChartBuilder::on(area)
        .margin(8 * FINE)
        .margin_right(16 * FINE)
        .x_label_area_size(44 * FINE)
        .y_label_area_size(66 * FINE)
        .build_cartesian_2d(x.0..x.1, y.0..y.1)?;
    let bands = chart
        .bands
        .iter()
        .map(|&(from, to, which)| Rectangle::new([(from, y.0), (to, y.1)], INTERVAL[which % INTERVAL.len()].filled()));
    context.draw_series(bands)?;
    let y_label = |value: &f64| label(chart.scale, *value);
    context
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID.stroke_width(FINE))
        .axis_style(INK.stroke_width(FINE))
        .label_style(theme::font(14 * FINE))
        .axis_desc_style(theme::font(15 * FINE))
        .set_all_tick_mark_size(5 * FINE)
        .x_desc(&chart.x_name)
        .y_desc(&chart.y_name)
        .x_labels(7)
        .y_labels(6)
        .x_label_formatter(&|value| tidy(*value, x))
        .y_label_formatter(&y_label)
        .draw()?;
    for curve in &chart.curves {
        let colour = CURVE[curve.colour % CURVE.len()];
        let points = visible(curve, chart.scale, x, y);
        let (thin, thick) = (colour.stroke_width(FINE), colour.stroke_width(2 * FINE));
        match curve.style {
            Style::Line => context.draw_series(LineSeries::new(points, thick))?,
            Style::Thin => context.draw_series(LineSeries::new(points, thin))?,
            Style::Dashed => context.draw_series(DashedLineSeries::new(points, 6 * FINE, 5 * FINE, thick))?,
            Style::Dots => {
                context.draw_series(points.into_iter().map(|point| Circle::new(point, 2 * FINE, colour.filled())))?
            }
        };
    }
    Ok(())
}

/// The points of a curve as drawn: as many as can be distinguished, and none outside the chart.
fn visible(curve: &Curve, scale: Scale, x: (f64, f64), y: (f64, f64)) -> Vec<(f64, f64)> {
    let points: Vec<_> = curve.points.iter().map(|&(x, value)| (x, height(scale, value).clamp(y.0, y.1))).collect();
    thin(&points, x.0, x.1, COLUMNS)
}

fn height(scale: Scale, value: f64) -> f64 {
    match scale {
        Scale::Linear | Scale::Levels => value,
        Scale::Decades => value.max(f64::MIN_POSITIVE).log10(),
    }
}

/// From the first x to the last; begins at 0 if the first is close to it.
fn extent_x(chart: &Chart) -> (f64, f64) {
    let (from, to) = theme::range(chart.curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.0)));
    let from = if from > 0.0 && from < to * NEAR { 0.0 } else { from };
    if to > from { (from, to) } else { (from - 0.5, from + 0.5) }
}

/// The range of y: room for all values, or the range asked for.
fn extent_y(chart: &Chart) -> (f64, f64) {
    let values = || chart.curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.1));
    let (low, high) = chart.range.unwrap_or_else(|| theme::range(values()));
    let (low, high) = (height(chart.scale, low), height(chart.scale, high));
    let room = if chart.range.is_some() { 0.0 } else { (high - low).max(1e-9) * 0.06 };
    if high > low { (low - room, high + room) } else { (low - 0.5, low + 0.5) }
}

/// Converts a height to the label of its value; for decades, only whole ones have labels.
fn label(scale: Scale, height: f64) -> String {
    match scale {
        Scale::Linear => short(if height.abs() < 1e-9 { 0.0 } else { height }),
        Scale::Decades if (height - height.round()).abs() < 1e-6 => format!("1e{}", height.round()),
        Scale::Decades | Scale::Levels => String::new(),
    }
}

/// A value of x, with enough decimals to distinguish it from its neighbours.
fn tidy(value: f64, extent: (f64, f64)) -> String {
    let decimals = theme::decimals_of(extent.1 - extent.0);
    let text = format!("{value:.decimals$}");
    if text.trim_start_matches('-').chars().all(|digit| digit == '0' || digit == '.') { "0".to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(points: &[(f64, f64)], scale: Scale) -> Chart {
        let styles = [Style::Line, Style::Thin, Style::Dashed, Style::Dots];
        let curves = styles.map(|style| Curve { colour: 4, style, points: points.to_vec() }).to_vec();
        Chart { x_name: "time, s".to_owned(), y_name: "speed".to_owned(), curves, scale, ..Chart::default() }
    }

    #[test]
    fn a_picture_has_its_charts_in_the_colours_of_the_page() {
        let chart = chart(&[(0.0, 1.0), (1.0, 1_000.0)], Scale::Linear);
        let svg = charts("Curves", 2, 200, &[chart.clone(), chart.clone(), chart]);
        assert_eq!(svg.matches("time, s").count(), 3);
        assert!(svg.contains("var(--curve-5)") && svg.contains("var(--ink)") && !svg.contains("#0100"));
    }

    #[test]
    fn decades_are_labelled_by_their_power() {
        let svg = charts("Decades", 1, 200, &[chart(&[(0.0, 1e-6), (1.0, 1e-2)], Scale::Decades)]);
        assert!(svg.contains("1e-4"));
        assert_eq!(label(Scale::Decades, 0.5), "");
    }

    #[test]
    fn nothing_and_a_single_value_can_be_drawn() {
        for points in [&[][..], &[(1.0, 5.0)]] {
            assert!(charts("Few", 1, 200, &[chart(points, Scale::Linear)]).starts_with("<svg"));
        }
    }
}
