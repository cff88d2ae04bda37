//! Speed along the path over time, compared with the speed asked for.

use plotters::prelude::*;

use super::theme::{self, AXIS, Area, BOUND, CURVE, Drawn, GRID, INK};
use crate::pace::{Sample, Second, samples};
use isostep_sim::Outcome;
use isostep_sim::lines_of_moves::Source;

/// Number of time spans, each with its lowest and its highest speed.
const SPANS: usize = 760;
/// plotters rounds points to whole pixels. Drawn at this scale, the error is not visible.
const FINE: u32 = 4;
/// The speed asked for is shown up to this multiple of the highest speed.
const ASKED_MAX: f64 = 1.5;
/// The mark of a second is at least this fraction of the picture wide.
const SEEN: f64 = 0.004;

/// Draws the picture; `sources` are those of all moves, `seconds` are the slowest and the busiest.
pub fn picture(outcome: &Outcome, sources: &[Option<Source>], seconds: [Option<Second>; 2]) -> String {
    let samples = samples(outcome, sources, SPANS);
    theme::svg((860 * FINE, 340 * FINE), "Speed along the path over time", |area| draw(area, &samples, seconds))
}

fn draw(area: &Area, samples: &[Sample], extremes: [Option<Second>; 2]) -> Drawn {
    let end_s = samples.last().map_or(1.0, |sample| sample.end_s);
    let highest_mm_s = samples.iter().map(|sample| sample.highest_mm_s).fold(1e-3, f64::max);
    let asked_mm_s = samples.iter().map(|sample| sample.asked_mm_s).fold(0.0, f64::max);
    let top_mm_s = 1.12 * highest_mm_s.max(asked_mm_s.min(ASKED_MAX * highest_mm_s));
    let [seconds, decimals] = [end_s, top_mm_s].map(theme::decimals_of);
    let mut chart = ChartBuilder::on(area)
        .margin(8 * FINE)
        .margin_right(16 * FINE)
        .x_label_area_size(46 * FINE)
        .y_label_area_size(68 * FINE)
        .build_cartesian_2d(0.0..end_s, 0.0..top_mm_s)?;
    for (_, from_s, colour) in marks(extremes) {
        let corners = [(from_s, 0.0), (mark_end_s(from_s, end_s), top_mm_s)];
        chart.draw_series([Rectangle::new(corners, colour.filled())])?;
    }
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(TRANSPARENT).bold_line_style(GRID.stroke_width(FINE)).axis_style(INK.stroke_width(FINE));
    mesh.label_style(theme::font(14 * FINE)).axis_desc_style(theme::font(15 * FINE));
    mesh.set_all_tick_mark_size(5 * FINE).x_desc("time from the start of the first move, s").y_desc("speed, mm/s");
    let [x_label, y_label] = [seconds, decimals].map(|decimals| move |value: &f64| format!("{value:.decimals$}"));
    mesh.x_label_formatter(&x_label).y_label_formatter(&y_label).y_labels(7).draw()?;
    let asked = samples.iter().flat_map(|sample| {
        let mm_s = sample.asked_mm_s.min(top_mm_s);
        [(sample.begin_s, mm_s), (sample.end_s, mm_s)]
    });
    let asked: Vec<_> = [(0.0, 0.0)].into_iter().chain(asked).chain([(end_s, 0.0)]).collect();
    chart.draw_series([Polygon::new(asked, BOUND.mix(0.3))])?;
    let middle = |sample: &Sample| (sample.begin_s + sample.end_s) / 2.0;
    let above = samples.iter().map(|sample| (middle(sample), sample.highest_mm_s));
    let below = samples.iter().rev().map(|sample| (middle(sample), sample.lowest_mm_s));
    let band = Polygon::new(above.chain(below).collect::<Vec<_>>(), AXIS[0].mix(0.35));
    chart.draw_series([band])?;
    let mean = samples.iter().map(|sample| (middle(sample), sample.mean_mm_s));
    chart.draw_series(LineSeries::new(mean, AXIS[0].stroke_width(FINE * 3 / 2)))?;
    for (rank, (name, from_s, _)) in marks(extremes).into_iter().enumerate() {
        let left = from_s < 0.8 * end_s;
        let (at_s, aside) = if left { (mark_end_s(from_s, end_s), 12) } else { (from_s, -12) };
        let style = theme::font(13 * FINE).pos(theme::beside(left));
        let label = EmptyElement::at((at_s, top_mm_s)) + Text::new(name, (aside, 8 + 64 * rank as i32), style);
        chart.draw_series([label])?;
    }
    Ok(())
}

/// Where the mark of a second ends, so that it is wide enough to be visible.
fn mark_end_s(from_s: f64, end_s: f64) -> f64 {
    (from_s + (SEEN * end_s).max(1.0)).min(end_s)
}

/// The seconds that are marked: names, starts and colours.
fn marks([slowest, busiest]: [Option<Second>; 2]) -> Vec<(&'static str, f64, RGBAColor)> {
    let slowest = slowest.map(|second| ("slowest second", second.start_s, CURVE[4].mix(0.25)));
    let busiest = busiest.map(|second| ("busiest second", second.start_s, AXIS[2].mix(0.25)));
    [busiest, slowest].into_iter().flatten().collect()
}
