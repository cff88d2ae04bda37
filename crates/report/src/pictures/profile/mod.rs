//! Position, speed, acceleration and jerk of several profiles over time in one picture: plain data in, SVG out.

mod panel;
pub(super) mod thin;

use super::theme::{self, Area, CURVE, Drawn};
use panel::Panel;
use plotters::prelude::*;

/// The curves of a profile over time, s. A curve without points is not drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Its name in the key.
    pub name: String,
    /// Instants, s, and positions, steps.
    pub position: Vec<(f64, f64)>,
    /// Instants, s, and speeds, steps/s.
    pub speed: Vec<(f64, f64)>,
    /// Instants, s, and accelerations, steps/s².
    pub accel: Vec<(f64, f64)>,
    /// Instants, s, and jerks, steps/s³.
    pub jerk: Vec<(f64, f64)>,
}

/// Coordinates of a drawing are whole numbers: with four per pixel, a slow curve has no visible steps.
const FINE: u32 = 4;
const WIDTH: u32 = 860 * FINE;
const KEY_HEIGHT: u32 = 34 * FINE;
const PANEL_HEIGHT: u32 = 232 * FINE;
/// Height for the name of the time axis.
const FOOT: u32 = 26 * FINE;

/// Draws the picture: four panels over one time axis, and a key above them; the first curve is on top. If several
/// points fall into one column of the picture, the first, the lowest, the highest and the last are drawn, so no peak is
/// lost.
#[must_use]
pub fn picture(title: &str, curves: &[Curve]) -> String {
    let panels = Panel::ALL;
    let height = KEY_HEIGHT + PANEL_HEIGHT * panels.len() as u32 + FOOT;
    theme::svg((WIDTH, height), title, |area| {
        let (top, mut rest) = area.split_vertically(KEY_HEIGHT);
        key(&top, curves)?;
        for panel in panels {
            let (this, below) = rest.split_vertically(PANEL_HEIGHT + if panel.is_last() { FOOT } else { 0 });
            panel.draw(&this, curves)?;
            rest = below;
        }
        Ok(())
    })
}

/// The picture as a separate file: SVG in light colours.
#[must_use]
pub fn file(title: &str, curves: &[Curve]) -> String {
    theme::standalone(&picture(title, curves))
}

/// The colour of the curve with this index. Colours repeat if there are more than seven curves.
fn colour(index: usize) -> RGBColor {
    CURVE[index % CURVE.len()]
}

/// The key: a line of each colour and its name, side by side.
fn key(area: &Area, curves: &[Curve]) -> Drawn {
    let fine = |pixels: usize| pixels as i32 * FINE as i32;
    let share = (WIDTH as i32 - fine(80)) / curves.len().max(1) as i32;
    let mut x = fine(72);
    for (index, curve) in curves.iter().enumerate() {
        let ends = vec![(x, fine(19)), (x + fine(20), fine(19))];
        area.draw(&PathElement::new(ends, colour(index).stroke_width(3 * FINE)))?;
        area.draw(&Text::new(curve.name.clone(), (x + fine(27), fine(11)), theme::font(15 * FINE)))?;
        x += share.min(fine(60 + 8 * curve.name.len()));
    }
    Ok(())
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
        let picture = picture("Two laws", &[curve("s-curve", 6.0), curve("sine", -6.0)]);
        assert!(picture.starts_with("<svg role=\"img\" aria-label=\"Two laws\""));
        for colour in ["var(--x)", "var(--y)"] {
            assert!(picture.matches(colour).count() >= 5, "four lines and the key's");
        }
        for text in ["s-curve", "sine", "position, steps", "speed, steps/s", "jerk, steps/s³", "time, s"] {
            assert!(picture.contains(text), "{text}");
        }
    }

    #[test]
    fn nothing_and_standstill_can_be_drawn() {
        assert!(picture("Nothing", &[]).contains("time, s"));
        let still = Curve { name: "still".to_owned(), position: vec![(0.0, 0.0)], ..Curve::default() };
        assert!(picture("Still", &[still]).contains("still"));
    }
}
