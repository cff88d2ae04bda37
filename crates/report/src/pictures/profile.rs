//! Position, speed, acceleration and jerk of several profiles over time in one picture: plain data in, SVG out.

use super::chart::{self, Axis, Chart, over_one_x};
use super::theme::{self, CURVE};
pub use crate::speed_profiles::Derivatives as Curve;

/// A quantity over time.
type Quantity = fn(&Curve) -> &[(f64, f64)];

const QUANTITIES: [(&str, Quantity); 4] = [
    ("position, steps", |curve| &curve.position),
    ("speed, steps/s", |curve| &curve.speed),
    ("acceleration, steps/s²", |curve| &curve.accel),
    ("jerk, steps/s³", |curve| &curve.jerk),
];

/// Draws the picture: four charts over one time axis, and a key above them; the first curve is on top. Colours repeat if
/// there are more than seven curves.
#[must_use]
pub fn picture(title: &str, curves: &[Curve]) -> String {
    let names = curves.iter().map(|curve| curve.name.as_str());
    chart::picture(title, &chart::key(names), 1, 250, &charts(curves))
}

/// The picture as a separate file: SVG in light colours.
#[must_use]
pub fn file(title: &str, curves: &[Curve]) -> String {
    theme::standalone(&picture(title, curves))
}

fn colours() -> impl Iterator<Item = theme::Colour> {
    CURVE.into_iter().cycle()
}

fn charts(curves: &[Curve]) -> Vec<Chart> {
    let instants = QUANTITIES.iter().flat_map(|(_, of)| curves.iter().flat_map(of)).map(|point| point.0);
    let (from_s, to_s) = theme::range(instants.chain([0.0]));
    let chart = |(name, of): (&str, Quantity)| {
        let lines = curves.iter().zip(colours()).map(|(curve, colour)| chart::Curve::line(colour, of(curve).to_vec()));
        let (low, high) = extent(curves.iter().flat_map(of).map(|point| point.1));
        let x = Axis::from("time, s").within(from_s, to_s.max(from_s + 1e-9));
        let mut lines: Vec<_> = lines.collect();
        lines.reverse();
        Chart::new(x, Axis::from(name).within(low, high), lines)
    };
    over_one_x(QUANTITIES.into_iter().map(chart).collect())
}

/// A range with room for all values and for 0.
fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = theme::range(values.chain([0.0]));
    let room = if high > low { (high - low) * 0.06 } else { 1.0 };
    (if low < 0.0 { low - room } else { low }, high + room)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(name: &str, jerk: f64) -> Curve {
        let points = |power: i32| (0..50).map(|k| (f64::from(k) / 50.0, f64::from(k).powi(power))).collect();
        let jerk = vec![(0.0, jerk), (1.0, jerk)];
        Curve { name: name.to_owned(), position: points(3), speed: points(2), accel: points(1), jerk }
    }

    #[test]
    fn a_picture_has_a_line_of_each_curve_in_each_panel_and_a_key() {
        let curves = [curve("s-curve", 6.0), curve("sine", -6.0)];
        let picture = picture("Two speed profiles", &curves);
        assert!(picture.starts_with("<svg role=\"img\" aria-label=\"Two speed profiles\""));
        for colour in ["var(--x)", "var(--y)"] {
            assert!(picture.matches(colour).count() >= 5, "four lines and the key's");
        }
        for text in ["s-curve", "sine", "position, steps", "speed, steps/s", "jerk, steps/s³", "time, s"] {
            assert!(picture.contains(text), "{text}");
        }
        for (chart, (_, of)) in charts(&curves).iter().zip(QUANTITIES) {
            let drawn: Vec<_> = chart.curves.iter().map(|line| line.points.as_slice()).collect();
            assert_eq!(drawn, [of(&curves[1]), of(&curves[0])], "the first is on top");
            assert_eq!(chart.x.range, Some((0.0, 1.0)));
        }
        assert_eq!(charts(&curves)[3].y.range, Some((-6.72, 6.72)));
    }

    #[test]
    fn nothing_and_standstill_can_be_drawn() {
        assert!(picture("Nothing", &[]).contains("time, s"));
        let still = Curve { name: "still".to_owned(), position: vec![(0.0, 0.0)], ..Curve::default() };
        assert!(picture("Still", &[still]).contains("still"));
    }
}
