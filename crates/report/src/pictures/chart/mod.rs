//! Charts: plain data in, SVG out. Every picture with axes is made of them, and plotters is named nowhere else.

mod draw;
mod legend;

pub use draw::FRAME;

use super::theme::{self, AXIS, CURVE, Colour, FINE, INK};
use crate::digits::significant;
use isostep_sim::Outcome;

/// Width of a picture, pixels.
const WIDTH: u32 = 860;
/// The height that the name of the x axis takes, pixels.
const NAME: u32 = 22;
/// An x axis begins at 0 if its first value is less than this fraction of its last.
const NEAR: f64 = 0.06;
/// The fraction of the values' range that is left free above and below them.
const ROOM: f64 = 0.06;

/// A chart: what it shows over which axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    /// The axis to the right.
    pub x: Axis,
    /// The axis upwards.
    pub y: Axis,
    /// Ranges of x that are shaded, behind everything else.
    pub bands: Vec<Band>,
    /// The curves in the order drawn; later ones are on top.
    pub curves: Vec<Curve>,
    /// Texts, on top of the curves.
    pub labels: Vec<Label>,
}

/// An axis: its name, its scale and what is shown of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// Its name, with its unit.
    pub name: String,
    /// The scale by which values are placed and reported.
    pub scale: Scale,
    /// The least and the greatest value shown; if `None`, those of the curves.
    pub range: Option<(f64, f64)>,
}

/// A scale by which values are placed along an axis and reported.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// Equal distances are equal differences.
    #[default]
    Linear,
    /// Equal distances are equal factors; values are above 0.
    Logarithmic,
    /// Linear without numbers, because the values have no meaning.
    Levels,
    /// Groups, each as wide as 1, with names that may have several lines.
    Groups(Vec<String>),
}

/// Points and how they are drawn. What is outside the chart is drawn at its edge, and a dot there is left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// The style.
    pub style: Style,
    /// The colour.
    pub colour: Colour,
    /// From 0, invisible, to 1.
    pub opacity: f64,
    /// (x, y), in the order in which they are connected.
    pub points: Vec<(f64, f64)>,
}

/// The style of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// A line.
    Line,
    /// A line of half the width.
    Thin,
    /// A dashed line.
    Dashed,
    /// A dot at each point, with its radius in pixels.
    Dots(u32),
    /// The area that the points go round.
    Area,
    /// Rectangles: each two points are opposite corners of one.
    Bars,
}

/// A shaded range of x.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// The place where it begins.
    pub from: f64,
    /// The place where it ends.
    pub to: f64,
    /// The colour.
    pub colour: Colour,
    /// From 0, invisible, to 1.
    pub opacity: f64,
}

/// A text in a chart; it may have several lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// The point that it belongs to.
    pub at: (f64, f64),
    /// The text.
    pub text: String,
    /// Its side of that point.
    pub place: Place,
    /// The colour.
    pub colour: Colour,
}

/// The side of its point on which a text is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Its middle is there.
    Centre,
    /// Above it.
    Above,
    /// Below it.
    Below,
    /// Below it to the right: the text begins there.
    Right,
    /// Below it to the left: the text ends there.
    Left,
}

impl Chart {
    /// A chart of these curves.
    pub fn new(x: impl Into<Axis>, y: impl Into<Axis>, curves: Vec<Curve>) -> Self {
        Self { x: x.into(), y: y.into(), curves, ..Self::default() }
    }

    fn values(&self, of: fn(&(f64, f64)) -> f64) -> impl Iterator<Item = f64> {
        self.curves.iter().flat_map(|curve| &curve.points).map(of)
    }

    /// The range shown of x: from the first to the last value, or from 0 if the first is close to it.
    fn x_range(&self) -> (f64, f64) {
        self.x.range.unwrap_or_else(|| {
            let (from, to) = self.x.scale.extent(self.values(|point| point.0), 0.0);
            let is_near = !self.x.scale.is_logarithmic() && from > 0.0 && from < to * NEAR;
            if is_near { (0.0, to) } else { (from, to) }
        })
    }

    /// The range shown of y: room for all values.
    fn y_range(&self) -> (f64, f64) {
        self.y.range.unwrap_or_else(|| self.y.scale.extent(self.values(|point| point.1), ROOM))
    }
}

impl<T: Into<String>> From<T> for Axis {
    fn from(name: T) -> Self {
        Self { name: name.into(), ..Self::default() }
    }
}

impl Axis {
    /// An axis with this scale.
    pub fn scaled(name: impl Into<String>, scale: Scale) -> Self {
        Self { scale, ..name.into().into() }
    }

    /// The same with what is shown of it.
    #[must_use]
    pub fn within(self, low: f64, high: f64) -> Self {
        Self { range: Some((low, high)), ..self }
    }
}

impl Scale {
    fn is_logarithmic(&self) -> bool {
        *self == Self::Logarithmic
    }

    /// A range of values with `room` beside them, never empty.
    fn extent(&self, values: impl Iterator<Item = f64>, room: f64) -> (f64, f64) {
        if self.is_logarithmic() {
            let (low, high) = theme::range(values.filter(|value| *value > 0.0).map(f64::ln));
            let room = ((high - low) * ROOM).max(0.1);
            return ((low - room).exp(), (high + room).exp());
        }
        let (low, high) = theme::range(values);
        let room = (high - low).max(1e-9) * room;
        if high > low { (low - room, high + room) } else { (low - 0.5, low + 0.5) }
    }
}

impl Curve {
    /// Points in this style.
    pub fn new(style: Style, colour: Colour, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self { style, colour, opacity: 1.0, points: points.into_iter().collect() }
    }

    /// A line.
    pub fn line(colour: Colour, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self::new(Style::Line, colour, points)
    }

    /// A dashed line.
    pub fn dashed(colour: Colour, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self::new(Style::Dashed, colour, points)
    }

    /// Small dots.
    pub fn dots(colour: Colour, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self::new(Style::Dots(2), colour, points)
    }

    /// Rectangles, each by two opposite corners.
    pub fn bars(colour: Colour, corners: impl IntoIterator<Item = [(f64, f64); 2]>) -> Self {
        Self::new(Style::Bars, colour, corners.into_iter().flatten())
    }

    /// The same, but seen through.
    #[must_use]
    pub fn faint(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }
}

impl Label {
    /// A text in the colour of texts.
    pub fn new(at: (f64, f64), place: Place, text: impl Into<String>) -> Self {
        Self { at, text: text.into(), place, colour: INK }
    }
}

/// The shading of the intervals of a move that accelerates, cruises and decelerates, from their ends.
pub fn intervals(spans: [(f64, f64); 3]) -> Vec<Band> {
    let coloured = spans.into_iter().zip(theme::INTERVAL);
    coloured.map(|((from, to), colour)| Band { from, to, colour, opacity: 1.0 }).collect()
}

/// Charts one below the other over one x axis, which only the last one names.
pub fn over_one_x(mut charts: Vec<Chart>) -> Vec<Chart> {
    let upper = charts.len().saturating_sub(1);
    charts[..upper].iter_mut().for_each(|chart| chart.x.name.clear());
    charts
}

/// A picture of `charts`, with `columns` charts in a row, each `height` pixels high, below a key of colours and their
/// meanings.
///
/// # Panics
/// If `columns` is 0.
pub fn picture(title: &str, key: &[(Colour, String)], columns: usize, height: u32, charts: &[Chart]) -> String {
    let rows: Vec<_> = charts.chunks(columns).collect();
    let is_named = |row: &[Chart]| row.iter().any(|chart| !chart.x.name.is_empty());
    let heights: Vec<_> = rows.iter().map(|row| height - if is_named(row) { 0 } else { NAME }).collect();
    let key = legend::Key::new(key);
    let high = key.height() + heights.iter().sum::<u32>();
    theme::svg((WIDTH * FINE, high * FINE), title, |area| {
        let (top, mut rest) = area.split_vertically(key.height() * FINE);
        key.draw(&top)?;
        for (row, height) in rows.iter().zip(heights) {
            let (own, below) = rest.split_vertically(height * FINE);
            let places = own.split_evenly((1, columns));
            row.iter().zip(&places).try_for_each(|(chart, place)| chart.draw(place))?;
            rest = below;
        }
        Ok(())
    })
}

/// The key of curves, in the order of their colours.
pub fn key<T: Into<String>>(names: impl IntoIterator<Item = T>) -> Vec<(Colour, String)> {
    CURVE.into_iter().cycle().zip(names.into_iter().map(Into::into)).collect()
}

/// The key of axes of the machine, by their numbers.
pub fn axes_key(outcome: &Outcome, axes: impl IntoIterator<Item = usize>) -> Vec<(Colour, String)> {
    axes.into_iter().map(|axis| (AXIS[axis], outcome.motor_name(axis))).collect()
}

/// `1.2M`, `30k`, `4.13`, `0.012`: three significant digits, without zeros at the end of decimals.
pub fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        1e6.. => format!("{}M", short(value * 1e-6)),
        1e3.. => format!("{}k", short(value * 1e-3)),
        _ => significant(value, 3.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STYLES: [Style; 6] = [Style::Line, Style::Thin, Style::Dashed, Style::Dots(3), Style::Area, Style::Bars];

    fn chart(points: &[(f64, f64)], scale: Scale) -> Chart {
        let curves = STYLES.map(|style| Curve::new(style, CURVE[4], points.to_vec())).to_vec();
        Chart::new("time, s", Axis::scaled("speed", scale), curves)
    }

    #[test]
    fn a_picture_has_its_key_and_its_charts_in_the_colours_of_the_page() {
        let chart = chart(&[(0.0, 1.0), (1.0, 1_000.0)], Scale::Linear);
        let key = [(CURVE[3], "a speed profile".to_owned())];
        let svg = picture("Curves", &key, 2, 200, &[chart.clone(), chart.clone(), chart]);
        assert!(svg.starts_with("<svg role=\"img\" aria-label=\"Curves\""));
        assert_eq!(svg.matches("time, s").count(), 3);
        for part in ["var(--curve-5)", "var(--ink)", "var(--rack)", "a speed profile"] {
            assert!(svg.contains(part), "{part}");
        }
        assert!(!svg.contains("#0100"));
    }

    #[test]
    fn nothing_and_a_single_value_can_be_drawn() {
        for points in [&[][..], &[(1.0, 5.0), (1.0, 5.0)]] {
            for scale in [Scale::Linear, Scale::Logarithmic, Scale::Levels] {
                assert!(picture("Few", &[], 1, 200, &[chart(points, scale)]).starts_with("<svg"));
            }
        }
        assert!(picture("Nothing", &[], 1, 200, &[]).starts_with("<svg"));
    }

    #[test]
    fn charts_over_one_x_name_it_once_and_are_equally_high() {
        let one = chart(&[(0.0, 1.0), (1.0, 2.0)], Scale::Linear);
        let svg = picture("Stack", &[], 1, 200, &over_one_x(vec![one.clone(), one.clone(), one]));
        assert_eq!(svg.matches("time, s").count(), 1);
        assert!(svg.contains(&format!("viewBox=\"0 0 {} {}\"", WIDTH * FINE, (3 * 200 - 2 * NAME) * FINE)), "{svg}");
    }

    #[test]
    fn an_axis_has_room_for_its_values() {
        let one = chart(&[(0.05, 1.0), (1.0, 11.0)], Scale::Linear);
        assert_eq!((one.x_range(), one.y_range()), ((0.0, 1.0), (0.4, 11.6)));
        let far = chart(&[(0.5, 3.0), (1.0, 3.0)], Scale::Linear);
        assert_eq!((far.x_range(), far.y_range()), ((0.5, 1.0), (2.5, 3.5)));
        let far_apart = Curve::line(CURVE[0], [(1e4, 3.0), (1e6, 60.0)]);
        let (from, to) = Chart::new(Axis::scaled("steps/s", Scale::Logarithmic), "%", vec![far_apart]).x_range();
        assert!((5e3..1e4).contains(&from) && (1e6..2e6).contains(&to), "no logarithm is at 0: {from} to {to}");
        let (low, high) = chart(&[(0.0, 0.0), (1.0, 1e-3), (2.0, 1e3)], Scale::Logarithmic).y_range();
        assert!(
            (1e-4..1e-3).contains(&low) && (1e3..1e4).contains(&high),
            "a value of 0 has no place: {low} to {high}"
        );
    }

    #[test]
    fn numbers_are_short() {
        let numbers =
            [(0.0, "0"), (1e6, "1M"), (2.4e6, "2.4M"), (30_000.0, "30k"), (0.012, "0.012"), (-4.126, "-4.13")];
        for (value, text) in numbers {
            assert_eq!(short(value), text);
        }
    }
}
