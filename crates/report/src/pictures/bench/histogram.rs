//! A histogram of errors.

use plotters::prelude::*;

use super::super::theme::{self, Area, BOUND, Drawn, GRID, INK};
use super::{colour, label, short};

/// Draws the picture: one bar for each of `bins`, which are the middle of the bin, ns, and its fraction of all errors.
/// The scale is logarithmic, so that rare errors are visible too. Dashed lines are at `bound_ns` on either side.
/// `index` is that of the colour.
pub fn histogram(title: &str, bins: &[(f64, f64)], bound_ns: f64, index: usize) -> String {
    theme::svg((860, 320), title, |area| draw(area, bins, bound_ns, index))
}

fn draw(area: &Area, bins: &[(f64, f64)], bound_ns: f64, index: usize) -> Drawn {
    let width_ns = bins.windows(2).next().map_or(1.0, |pair| pair[1].0 - pair[0].0);
    let (early_ns, late_ns) = theme::range(bins.iter().map(|bin| bin.0));
    let reach_ns = (early_ns.abs().max(late_ns.abs()) + width_ns).max(bound_ns * 1.1);
    let rarest = bins.iter().map(|bin| bin.1).filter(|share| *share > 0.0).fold(1.0, f64::min);
    let floor = 10_f64.powf(rarest.log10().floor());
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .margin_right(16)
        .x_label_area_size(46)
        .y_label_area_size(76)
        .build_cartesian_2d(-reach_ns..reach_ns, (floor * 100.0..200.0).log_scale())?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(INK)
        .label_style(theme::font(14))
        .axis_desc_style(theme::font(15))
        .x_desc("late (+) or early (-), ns")
        .y_desc("share of the edges, %")
        .x_label_formatter(&|ns| short(*ns))
        .y_label_formatter(&|percent| label(*percent))
        .draw()?;
    let filled = bins.iter().filter(|bin| bin.1 > 0.0);
    chart.draw_series(filled.map(|&(middle_ns, share)| {
        let corners = [(middle_ns - width_ns / 2.0, floor * 100.0), (middle_ns + width_ns / 2.0, share * 100.0)];
        Rectangle::new(corners, colour(index).filled())
    }))?;
    for side_ns in [-bound_ns, bound_ns] {
        let line = [(side_ns, floor * 100.0), (side_ns, 200.0)];
        chart.draw_series(DashedLineSeries::new(line, 6, 5, BOUND.stroke_width(2)))?;
    }
    Ok(())
}
