//! The drawing of a chart.

use plotters::chart::ChartContext;
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::super::theme::{self, Area, Drawn, FINE, GRID, INK};
use super::{Chart, Curve, Label, NAME, Place, Scale, Style, short};

/// The margins round the area of a chart whose x axis has a name, pixels.
pub const FRAME: Frame = Frame { left: MARGIN + 72, right: 16, above: MARGIN, below: MARGIN + NUMBERS + NAME };
const MARGIN: u32 = 8;
/// Height of the numbers of the x axis, and of a line of names there, pixels.
const NUMBERS: u32 = 24;
const LINE: u32 = 18;
/// Length of the tick marks on the axes, and the space between a text and its point, pixels.
const MARK: u32 = 5;
const SPACE: i32 = 3;
/// Size of texts and of names of axes, pixels.
const TEXT: u32 = 14;
const AXIS_TEXT: u32 = 15;
/// The largest number of columns in which the points of a line are told apart.
const COLUMNS: usize = 1_200;
/// A linear scale of this span or more has short numbers, such as 30k.
const LONG_SPAN: f64 = 1e4;

/// Widths and heights round an area, pixels.
pub struct Frame {
    /// To the left: the name of the y axis and its numbers.
    pub left: u32,
    /// To the right.
    pub right: u32,
    /// Above.
    pub above: u32,
    /// Below: the name of the x axis and its numbers.
    pub below: u32,
}

type On<'a, 'b, X, Y> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<X, Y>>;

impl Chart {
    /// Draws it into `area`.
    pub fn draw(&self, area: &Area) -> Drawn {
        let (x, y) = (self.x_range(), self.y_range());
        let mut frame = ChartBuilder::on(area);
        frame.margin(MARGIN * FINE).margin_right(FRAME.right * FINE);
        frame.x_label_area_size(self.below() * FINE).y_label_area_size((FRAME.left - MARGIN) * FINE);
        let (over, up) = (x.0..x.1, y.0..y.1);
        match (self.x.scale.is_logarithmic(), self.y.scale.is_logarithmic()) {
            (false, false) => self.fill(frame.build_cartesian_2d(over, up)?, x, y),
            (false, true) => self.fill(frame.build_cartesian_2d(over, up.log_scale())?, x, y),
            (true, false) => self.fill(frame.build_cartesian_2d(over.log_scale(), up)?, x, y),
            (true, true) => self.fill(frame.build_cartesian_2d(over.log_scale(), up.log_scale())?, x, y),
        }
    }

    /// Height of what stands below the area, without the margin.
    fn below(&self) -> u32 {
        let name = if self.x.name.is_empty() { 0 } else { NAME };
        match &self.x.scale {
            Scale::Groups(names) => 16 + LINE * names.iter().map(|name| name.lines().count()).max().unwrap_or(0) as u32,
            _ => NUMBERS + name,
        }
    }

    fn fill<X, Y>(&self, mut on: On<X, Y>, x: (f64, f64), y: (f64, f64)) -> Drawn
    where
        X: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let bands = self.bands.iter();
        on.draw_series(
            bands
                .map(|band| Rectangle::new([(band.from, y.0), (band.to, y.1)], band.colour.mix(band.opacity).filled())),
        )?;
        self.mesh(&mut on, x, y)?;
        for curve in &self.curves {
            draw_curve(&mut on, curve, shown(curve, x, y))?;
        }
        if let Scale::Groups(names) = &self.x.scale {
            for (number, name) in (0_u32..).zip(names) {
                draw_label(&mut on, &Label::new((f64::from(number) + 0.5, y.0), Place::Below, name))?;
            }
        }
        self.labels.iter().try_for_each(|label| draw_label(&mut on, label))
    }

    fn mesh<X, Y>(&self, on: &mut On<X, Y>, x: (f64, f64), y: (f64, f64)) -> Drawn
    where
        X: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let [x_number, y_number] = [(&self.x.scale, x), (&self.y.scale, y)]
            .map(|(scale, range)| move |value: &f64| number(scale, *value, range));
        let mut mesh = on.configure_mesh();
        mesh.light_line_style(TRANSPARENT).bold_line_style(GRID.stroke_width(FINE)).axis_style(INK.stroke_width(FINE));
        mesh.label_style(theme::font(TEXT * FINE)).axis_desc_style(theme::font(AXIS_TEXT * FINE));
        mesh.set_all_tick_mark_size(MARK * FINE).x_desc(&self.x.name).y_desc(&self.y.name);
        mesh.x_labels(8).y_labels(6).x_label_formatter(&x_number).y_label_formatter(&y_number);
        if matches!(self.x.scale, Scale::Groups(_)) {
            mesh.disable_x_mesh().x_labels(0);
        }
        mesh.draw()
    }
}

fn draw_curve<X, Y>(on: &mut On<X, Y>, curve: &Curve, points: Vec<(f64, f64)>) -> Drawn
where
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    let colour = curve.colour.mix(curve.opacity);
    let wide = |pixels: u32| colour.stroke_width(pixels * FINE);
    match curve.style {
        Style::Line => on.draw_series(LineSeries::new(points, wide(2)))?,
        Style::Thin => on.draw_series(LineSeries::new(points, wide(1)))?,
        Style::Dashed => on.draw_series(DashedLineSeries::new(points, 6 * FINE, 5 * FINE, wide(2)))?,
        Style::Dots(radius) => {
            on.draw_series(points.into_iter().map(|point| Circle::new(point, radius * FINE, colour.filled())))?
        }
        Style::Area => on.draw_series([Polygon::new(points, colour)])?,
        Style::Bars => {
            on.draw_series(points.chunks_exact(2).map(|pair| Rectangle::new([pair[0], pair[1]], colour.filled())))?
        }
    };
    Ok(())
}

/// The points of a curve as drawn: as many as can be told apart, and none outside the chart.
fn shown(curve: &Curve, x: (f64, f64), y: (f64, f64)) -> Vec<(f64, f64)> {
    let points = curve.points.iter().copied();
    let inside = |point: (f64, f64)| (point.0, point.1.clamp(y.0, y.1));
    match curve.style {
        Style::Dots(_) => points.filter(|point| (y.0..=y.1).contains(&point.1)).collect(),
        Style::Area | Style::Bars => points.map(inside).collect(),
        Style::Line | Style::Thin | Style::Dashed => thin(&points.map(inside).collect::<Vec<_>>(), x.0, x.1, COLUMNS),
    }
}

fn draw_label<X, Y>(on: &mut On<X, Y>, label: &Label) -> Drawn
where
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    let (across, down, aside, below) = match label.place {
        Place::Centre => (HPos::Center, VPos::Center, 0, 0),
        Place::Above => (HPos::Center, VPos::Bottom, 0, -SPACE),
        Place::Below => (HPos::Center, VPos::Top, 0, 3 * SPACE),
        Place::Right => (HPos::Left, VPos::Top, SPACE, SPACE),
        Place::Left => (HPos::Right, VPos::Top, -SPACE, SPACE),
    };
    let style = theme::font(TEXT * FINE).color(&label.colour).pos(Pos::new(across, down));
    for (line, text) in (0..).zip(label.text.lines()) {
        let from = (aside, below + line * LINE as i32);
        let text = Text::new(text.to_owned(), (from.0 * FINE as i32, from.1 * FINE as i32), style.clone());
        on.draw_series([EmptyElement::at(label.at) + text])?;
    }
    Ok(())
}

/// The number beside a place of a scale; some places of a logarithmic one have none, because they are too close.
fn number(scale: &Scale, value: f64, (low, high): (f64, f64)) -> String {
    match scale {
        Scale::Linear if high - low >= LONG_SPAN => short(value),
        Scale::Linear => {
            let decimals = theme::decimals_of(high - low);
            let text = format!("{value:.decimals$}");
            if text.chars().any(|digit| ('1'..='9').contains(&digit)) { text } else { "0".to_owned() }
        }
        Scale::Logarithmic => {
            let power = value.log10().floor();
            let leading = value / 10_f64.powf(power);
            let is = |digit: f64| (leading - digit).abs() < 0.01;
            match power < -3.0 {
                true if is(1.0) => format!("1e{power}"),
                false if is(1.0) || is(2.0) || is(5.0) => short(value),
                _ => String::new(),
            }
        }
        Scale::Levels | Scale::Groups(_) => String::new(),
    }
}

/// The points needed to draw a line over `columns` columns: of each column the first, the lowest, the highest and the
/// last, in order of time.
fn thin(points: &[(f64, f64)], from: f64, to: f64, columns: usize) -> Vec<(f64, f64)> {
    let width = ((to - from) / columns as f64).max(f64::MIN_POSITIVE);
    let column = |point: &(f64, f64)| ((point.0 - from) / width).floor();
    points.chunk_by(|one, next| column(one) == column(next)).flat_map(extremes).collect()
}

fn extremes(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let by_value = |one: &usize, other: &usize| points[*one].1.total_cmp(&points[*other].1);
    let indices = || 0..points.len();
    let mut kept: Vec<usize> =
        [Some(0), indices().min_by(by_value), indices().max_by(by_value), points.len().checked_sub(1)]
            .into_iter()
            .flatten()
            .collect();
    kept.sort_unstable();
    kept.dedup();
    kept.into_iter().map(|index| points[index]).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Axis, picture};
    use super::*;
    use crate::pictures::theme::CURVE;

    const SIZE: (f64, f64) = (860.0, 300.0);
    /// plotters leaves the last row and column of an area free.
    const HALF_A_PIXEL: f64 = FINE as f64 / 2.0;

    /// The numbers of an attribute, in the order drawn.
    fn drawn(svg: &str, element: &str, attribute: &str) -> Vec<f64> {
        let begins = format!("<{element} ");
        let elements = svg.split(&begins).skip(1).map(|rest| rest.split("/>").next().unwrap());
        let of_curve = elements.filter(|rest| rest.contains("var(--curve-5)"));
        let values = of_curve.map(|rest| {
            rest.split(&format!(" {attribute}=\"")).nth(1).or(rest.strip_prefix(&format!("{attribute}=\""))).unwrap()
        });
        values
            .flat_map(|value| value.split('"').next().unwrap().split([' ', ',']).filter(|part| !part.is_empty()))
            .map(|number| number.parse().unwrap())
            .collect()
    }

    /// The place of a value between the ends of an axis, from 0 to 1.
    fn share(axis: &Axis, value: f64) -> f64 {
        let (low, high) = axis.range.unwrap();
        let [value, low, high] = [value, low, high].map(|at| if axis.scale.is_logarithmic() { at.ln() } else { at });
        (value - low) / (high - low)
    }

    /// The place where a point has to be drawn, by hand: the frame, and the share of the area within it.
    fn place(chart: &Chart, point: (f64, f64)) -> (f64, f64) {
        let [left, right, above, below] = [FRAME.left, FRAME.right, FRAME.above, FRAME.below].map(f64::from);
        let (wide, high) = (SIZE.0 - left - right, SIZE.1 - above - below);
        let (x, y) = (share(&chart.x, point.0), share(&chart.y, point.1));
        ((left + x * wide) * f64::from(FINE), (above + (1.0 - y) * high) * f64::from(FINE))
    }

    /// Every value that is drawn is where the axes say it is, under every scale and style.
    #[test]
    fn what_is_drawn_is_the_data() {
        let points = [(1.0, 3.0), (2.0, 0.5), (5.5, 80.0), (9.0, 17.0)];
        for scales in
            [[Scale::Linear, Scale::Linear], [Scale::Linear, Scale::Logarithmic], [Scale::Logarithmic, Scale::Linear]]
        {
            for (style, element) in [(Style::Line, "polyline"), (Style::Thin, "polyline"), (Style::Area, "polygon")] {
                let [x, y] = scales.clone();
                let (x, y) = (Axis::scaled("x", x).within(0.5, 10.0), Axis::scaled("y", y).within(0.2, 100.0));
                let chart = Chart::new(x, y, vec![Curve::new(style, CURVE[4], points)]);
                let svg = picture("One", &[], 1, SIZE.1 as u32, std::slice::from_ref(&chart));
                let numbers = drawn(&svg, element, "points");
                assert_eq!(numbers.len(), 2 * points.len(), "{svg}");
                for (point, at) in points.into_iter().zip(numbers.chunks(2)) {
                    let (x, y) = place(&chart, point);
                    assert!(
                        (at[0] - x).abs() <= HALF_A_PIXEL && (at[1] - y).abs() <= HALF_A_PIXEL,
                        "{point:?} is at {at:?}, not {x} {y}"
                    );
                }
            }
        }
    }

    #[test]
    fn bars_are_from_corner_to_corner_and_end_at_the_edge() {
        let (x, y) = (Axis::from("x").within(0.0, 10.0), Axis::from("y").within(0.0, 10.0));
        let chart =
            Chart::new(x, y, vec![Curve::bars(CURVE[4], [[(1.0, 0.0), (2.0, 4.0)], [(3.0, -5.0), (4.0, 99.0)]])]);
        let svg = picture("Bars", &[], 1, SIZE.1 as u32, std::slice::from_ref(&chart));
        let [x, y, wide, high] = ["x", "y", "width", "height"].map(|attribute| drawn(&svg, "rect", attribute));
        for (number, [low, high_at]) in [[(1.0, 0.0), (2.0, 4.0)], [(3.0, 0.0), (4.0, 10.0)]].into_iter().enumerate() {
            let ((left, bottom), (right, top)) = (place(&chart, low), place(&chart, high_at));
            let found = [x[number], y[number], x[number] + wide[number], y[number] + high[number]];
            for (found, wanted) in found.into_iter().zip([left, top, right, bottom]) {
                assert!((found - wanted).abs() <= HALF_A_PIXEL, "{found} is not {wanted}: {svg}");
            }
        }
    }

    #[test]
    fn dots_outside_are_left_out_and_lines_end_at_the_edge() {
        let chart = |style| {
            let curve = Curve::new(style, CURVE[4], [(0.0, 1.0), (0.5, 7.0), (1.0, 2.0)]);
            Chart::new(Axis::from("x").within(0.0, 1.0), Axis::from("y").within(0.0, 5.0), vec![curve])
        };
        assert_eq!(drawn(&picture("Dots", &[], 1, 300, &[chart(Style::Dots(2))]), "circle", "cx").len(), 2);
        let points = drawn(&picture("Line", &[], 1, 300, &[chart(Style::Line)]), "polyline", "points");
        assert_eq!((points.len(), points[3]), (6, f64::from(FRAME.above * FINE)));
    }

    #[test]
    fn few_places_of_a_logarithmic_scale_have_numbers() {
        let text = |value: f64| number(&Scale::Logarithmic, value, (1e-6, 1e6));
        assert_eq!([1e4, 2e4, 3e4, 0.05, 1e6, 1e-4, 2e-5].map(text), ["10k", "20k", "", "0.05", "1M", "1e-4", ""]);
    }

    #[test]
    fn numbers_of_a_linear_scale_resolve_a_tenth_of_it() {
        let text = |value: f64, high: f64| number(&Scale::Linear, value, (0.0, high));
        assert_eq!(
            [text(-0.0, 1.0), text(0.25, 2.0), text(48.0, 60.0), text(12_500.0, 3e4)],
            ["0", "0.2", "48", "12.5k"]
        );
    }

    #[test]
    fn groups_have_their_names_below_and_labels_their_lines() {
        let x =
            Axis::scaled("", Scale::Groups(vec!["1 axis".to_owned(), "2 axes\nat once".to_owned()])).within(0.0, 2.0);
        let label = Label::new((0.5, 0.5), Place::Above, "500k");
        let chart = Chart { labels: vec![label], ..Chart::new(x, Axis::from("y").within(0.0, 1.0), Vec::new()) };
        let svg = picture("Groups", &[], 1, 300, &[chart]);
        for text in ["1 axis", "2 axes", "at once", "500k"] {
            assert!(svg.contains(text), "{text}");
        }
    }

    #[test]
    fn first_lowest_highest_and_last_of_each_column_are_kept_in_order() {
        let points = [(0.0, 5.0), (0.1, 9.0), (0.2, 1.0), (0.3, 4.0), (0.4, 6.0), (1.0, 0.0), (1.5, 2.0)];
        let kept = thin(&points, 0.0, 2.0, 2);
        assert_eq!(kept, [(0.0, 5.0), (0.1, 9.0), (0.2, 1.0), (0.4, 6.0), (1.0, 0.0), (1.5, 2.0)]);
    }

    #[test]
    fn few_points_stay_as_they_are() {
        assert_eq!(thin(&[], 0.0, 1.0, 10), []);
        assert_eq!(thin(&[(0.0, 1.0)], 0.0, 0.0, 10), [(0.0, 1.0)]);
    }
}
