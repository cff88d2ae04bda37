//! Pictures of what was measured: bars in groups, points over a logarithmic scale, and histograms of errors.

use super::chart::{Axis, Chart, Curve, Label, Place, Scale, Style, picture, short};
use super::theme::{self, AXIS, BOUND, Colour};

/// The fraction of a group's width that its bars take, and of a bar's place that it fills.
const FILLED: f64 = 0.72;
const BAR: f64 = 0.94;
/// Height of a picture, pixels.
const HEIGHT: u32 = 340;

/// A series of values with one name and one colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Series<T> {
    /// Its name in the key.
    pub name: String,
    /// The values, in the order drawn.
    pub values: Vec<T>,
}

/// In each of `groups`, whose names may have several lines, one bar for every series with its value above it. Values that
/// are `None` or not above 0 are left out.
pub fn bars(title: &str, value_name: &str, groups: &[String], series: &[Series<Option<f64>>]) -> String {
    picture(title, &key(series), 1, HEIGHT, &[bars_chart(value_name, groups, series)])
}

fn bars_chart(value_name: &str, groups: &[String], series: &[Series<Option<f64>>]) -> Chart {
    let shown = |one: &Series<Option<f64>>| {
        let values: Vec<_> =
            (0_u32..).zip(&one.values).map(|(group, value)| Some((f64::from(group), (*value)?))).collect();
        values.into_iter().flatten().filter(|(_, value)| *value > 0.0)
    };
    let (low, high) = decades(series.iter().flat_map(|one| shown(one).map(|(_, value)| value)));
    let width = FILLED / series.len() as f64;
    let left = |index: usize, group: f64| group + (1.0 - FILLED) / 2.0 + index as f64 * width;
    let curves = series.iter().zip(colours()).enumerate().map(|(index, (one, colour))| {
        let corners = |(group, value)| [(left(index, group), low), (left(index, group) + width * BAR, value)];
        Curve::bars(colour, shown(one).map(corners))
    });
    let labels = series.iter().enumerate().flat_map(|(index, one)| {
        let middle = move |group| left(index, group) + width * BAR / 2.0;
        shown(one).map(move |(group, value)| Label::new((middle(group), value), Place::Above, short(value)))
    });
    let x = Axis::scaled("", Scale::Groups(groups.to_vec())).within(0.0, groups.len() as f64);
    // Leaves room for the number above the highest bar.
    let y = Axis::scaled(value_name, Scale::Logarithmic).within(low, high * 2.0);
    Chart { labels: labels.collect(), ..Chart::new(x, y, curves.collect()) }
}

/// A curve with a dot at each (x, y) of every series, over a logarithmic scale; x is above 0, y is 0 or more.
pub fn curves(title: &str, x_name: &str, y_name: &str, series: &[Series<(f64, f64)>]) -> String {
    let highest = series.iter().flat_map(|one| &one.values).map(|point| point.1).fold(1e-9, f64::max);
    let both = series.iter().zip(colours()).flat_map(|(one, colour)| {
        [Style::Line, Style::Dots(4)].map(|style| Curve::new(style, colour, one.values.iter().copied()))
    });
    let x = Axis::scaled(x_name, Scale::Logarithmic);
    let chart = Chart::new(x, Axis::from(y_name).within(0.0, highest * 1.15), both.collect());
    picture(title, &key(series), 1, HEIGHT, &[chart])
}

/// One bar for each of `bins`, which are the middle of the bin, ns, and its fraction of all errors. The scale is
/// logarithmic, so that rare errors are visible too. Dashed lines are at `bound_ns` on either side. `index` is that of the
/// colour.
pub fn histogram(title: &str, bins: &[(f64, f64)], bound_ns: f64, index: usize) -> String {
    picture(title, &[], 1, HEIGHT, &[histogram_chart(bins, bound_ns, index)])
}

fn histogram_chart(bins: &[(f64, f64)], bound_ns: f64, index: usize) -> Chart {
    let width_ns = bins.windows(2).next().map_or(1.0, |pair| pair[1].0 - pair[0].0);
    let (early_ns, late_ns) = theme::range(bins.iter().map(|bin| bin.0));
    let reach_ns = (early_ns.abs().max(late_ns.abs()) + width_ns).max(bound_ns * 1.1);
    let filled = || bins.iter().copied().filter(|bin| bin.1 > 0.0);
    let rarest = filled().map(|bin| bin.1).fold(1.0, f64::min);
    let floor = 100.0 * 10_f64.powf(rarest.log10().floor());
    let corners = filled()
        .map(|(middle_ns, share)| [(middle_ns - width_ns / 2.0, floor), (middle_ns + width_ns / 2.0, share * 100.0)]);
    let bar = Curve::bars(AXIS[index % AXIS.len()], corners);
    let bounds = [-bound_ns, bound_ns].map(|side_ns| Curve::dashed(BOUND, [(side_ns, floor), (side_ns, 200.0)]));
    Chart::new(
        Axis::from("late (+) or early (-), ns").within(-reach_ns, reach_ns),
        Axis::scaled("share of the edges, %", Scale::Logarithmic).within(floor, 200.0),
        [bar].into_iter().chain(bounds).collect(),
    )
}

/// The colours of series. They repeat if there are more series than axes.
fn colours() -> impl Iterator<Item = Colour> {
    AXIS.into_iter().cycle()
}

/// The key, if there is something to tell apart.
fn key<T>(series: &[Series<T>]) -> Vec<(Colour, String)> {
    let names = colours().zip(series).map(|(colour, one)| (colour, one.name.clone()));
    if series.len() > 1 { names.collect() } else { Vec::new() }
}

/// The powers of ten around positive `values`; the lower one is below all of them.
fn decades(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = theme::range(values.map(f64::log10));
    (10_f64.powf(low.ceil() - 1.0), 10_f64.powf(high.ceil()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series<T>(values: [Vec<T>; 2]) -> Vec<Series<T>> {
        ["one", "other"]
            .into_iter()
            .zip(values)
            .map(|(name, values)| Series { name: name.to_owned(), values })
            .collect()
    }

    #[test]
    fn bars_stand_in_their_groups_with_their_values_above() {
        let series = series([vec![Some(5e5), None], vec![Some(2e4), Some(0.0)]]);
        let groups = ["1 axis".to_owned(), "2 axes".to_owned()];
        let chart = bars_chart("steps/s", &groups, &series);
        assert_eq!((chart.x.range, chart.y.range), (Some((0.0, 2.0)), Some((1e4, 2e6))));
        let heights: Vec<Vec<_>> =
            chart.curves.iter().map(|bars| bars.points.iter().map(|point| point.1).collect()).collect();
        assert_eq!(heights, [vec![1e4, 5e5], vec![1e4, 2e4]]);
        let labels: Vec<_> = chart.labels.iter().map(|label| (label.text.as_str(), label.at.1)).collect();
        assert_eq!(labels, [("500k", 5e5), ("20k", 2e4)]);
        assert!(chart.labels[0].at.0 < 0.5 && chart.labels[1].at.0 > 0.5);
        let svg = bars("Rates", "steps/s", &groups, &series);
        assert!(svg.contains("2 axes") && svg.contains("other"));
    }

    #[test]
    fn a_histogram_has_its_shares_and_its_bounds() {
        let chart = histogram_chart(&[(-8.0, 0.25), (0.0, 0.745), (8.0, 0.005)], 50.0, 0);
        let ends: Vec<_> = chart.curves[0].points.chunks(2).map(|corners| (corners[0].0, corners[1])).collect();
        assert_eq!(ends, [(-12.0, (-4.0, 25.0)), (-4.0, (4.0, 74.5)), (4.0, (12.0, 0.5))]);
        let bounds: Vec<_> = chart.curves[1..].iter().map(|bound| bound.points[0].0).collect();
        assert_eq!(bounds, [-50.0, 50.0]);
        assert_eq!(chart.y.range.map(|(low, high)| ((low * 1e6).round(), high)), Some((1e5, 200.0)));
    }

    #[test]
    fn decades_hold_all_values() {
        assert_eq!(decades([3e4, 2.4e6].into_iter()), (1e4, 1e7));
        assert_eq!(decades([100.0].into_iter()), (10.0, 100.0));
    }

    #[test]
    fn points_are_connected_and_told_apart() {
        let svg = curves("Load", "steps/s", "%", &series([vec![(1e4, 1.0), (1e6, 50.0)], vec![(1e5, 2.0)]]));
        assert_eq!((svg.matches("<circle").count(), svg.contains("100k")), (3, true), "{svg}");
    }
}
