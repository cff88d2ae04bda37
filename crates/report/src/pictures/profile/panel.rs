//! The panel of one quantity of all profiles.

use plotters::prelude::*;

use super::super::bench::short;
use super::super::theme::{self, Area, Drawn, GRID, INK};
use super::thin::thin;
use super::{Curve, FINE, colour};

/// Number of columns: the pixels of the widest line.
const COLUMNS: usize = 760;
/// Length of the tick marks on the axes, pixels.
const MARK: u32 = 5;

/// The panel of one quantity.
#[derive(Clone, Copy)]
pub struct Panel {
    name: &'static str,
    points: fn(&Curve) -> &[(f64, f64)],
    /// Whether it is the lowest panel, which names the time axis.
    last: bool,
}

impl Panel {
    /// All panels, from position to jerk.
    pub const ALL: [Self; 4] = [
        Self { name: "position, steps", points: |curve| &curve.position, last: false },
        Self { name: "speed, steps/s", points: |curve| &curve.speed, last: false },
        Self { name: "acceleration, steps/s²", points: |curve| &curve.accel, last: false },
        Self { name: "jerk, steps/s³", points: |curve| &curve.jerk, last: true },
    ];

    /// Whether it is the lowest panel.
    pub fn is_last(self) -> bool {
        self.last
    }

    /// Draws it into `area`.
    pub fn draw(self, area: &Area, curves: &[Curve]) -> Drawn {
        let (from_s, to_s) = times(curves);
        let (low, high) = self.extent(curves);
        let mut chart = ChartBuilder::on(area)
            .margin(4 * FINE)
            .margin_right(18 * FINE)
            .x_label_area_size(FINE * if self.last { 46 } else { 22 })
            .y_label_area_size(76 * FINE)
            .build_cartesian_2d(from_s..to_s, low..high)?;
        let seconds = theme::decimals_of(to_s - from_s);
        let mut mesh = chart.configure_mesh();
        mesh.light_line_style(TRANSPARENT).bold_line_style(GRID.stroke_width(FINE)).axis_style(INK.stroke_width(FINE));
        mesh.x_labels(9).y_labels(6).set_all_tick_mark_size(MARK * FINE);
        mesh.label_style(theme::font(14 * FINE)).axis_desc_style(theme::font(15 * FINE)).y_desc(self.name);
        let x_label = move |s: &f64| format!("{s:.seconds$}");
        mesh.x_label_formatter(&x_label).y_label_formatter(&|value| short(*value));
        if self.last {
            mesh.x_desc("time, s");
        }
        mesh.draw()?;
        for (index, curve) in curves.iter().enumerate().rev() {
            let line = thin((self.points)(curve), from_s, to_s, COLUMNS);
            chart.draw_series(LineSeries::new(line, colour(index).stroke_width(2 * FINE)))?;
        }
        Ok(())
    }

    /// A range with room for all values and for 0.
    fn extent(self, curves: &[Curve]) -> (f64, f64) {
        let values = curves.iter().flat_map(|curve| (self.points)(curve)).map(|point| point.1);
        let (low, high) = theme::range(values.chain([0.0]));
        let room = if high > low { (high - low) * 0.06 } else { 1.0 };
        (if low < 0.0 { low - room } else { low }, high + room)
    }
}

/// From 0 to the last instant of all curves: all panels have the same time axis.
fn times(curves: &[Curve]) -> (f64, f64) {
    let lists = curves.iter().flat_map(|curve| [&curve.position, &curve.speed, &curve.accel, &curve.jerk]);
    let (from_s, to_s) = theme::range(lists.flatten().map(|point| point.0).chain([0.0]));
    (from_s, to_s.max(from_s + 1e-9))
}
