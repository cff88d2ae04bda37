//! Speed and acceleration of each axis over time: planned values as lines, values measured from the edges as dots. A blend
//! at the beginning is drawn with the move.

use plotters::prelude::*;

use super::theme::{self, AXIS, Area, Drawn, GRID, INK, INTERVAL};
use isostep_motion::AXES;
use isostep_profile::{Blend, Profile};
use isostep_sim::MoveRecord;
use isostep_sim::Outcome;

/// Dots per axis and move.
const DOTS: usize = 80;
/// Segments of a planned line: about as many as it has pixels.
const CURVE_POINTS: u32 = 400;

/// The picture of one move: speed above, acceleration below, with the three intervals shaded.
pub fn of_move(outcome: &Outcome, record: &MoveRecord) -> String {
    let axes = moving(outcome, record);
    theme::svg((860, 560), "Speed and acceleration of each axis over time", |area| {
        let (upper, lower) = area.split_vertically(296);
        panel(&upper, record, &axes, &Quantity::SPEED)?;
        panel(&lower, record, &axes, &Quantity::ACCELERATION)
    })
}

/// The quantity that a panel shows.
struct Quantity {
    name: &'static str,
    planned: fn(&MovingAxis, f64) -> f64,
    measured: fn(&MovingAxis) -> &[(f64, f64)],
    /// Whether it is the upper panel, which names the intervals. The lower one names the time axis.
    upper: bool,
}

impl Quantity {
    const SPEED: Self = Self {
        name: "speed, mm/s",
        planned: |axis, t_s| axis.speed_mm_s(t_s),
        measured: |axis| &axis.speeds,
        upper: true,
    };
    const ACCELERATION: Self = Self {
        name: "acceleration, mm/s²",
        planned: |axis, t_s| axis.accel_mm_s2(t_s),
        measured: |axis| &axis.accelerations,
        upper: false,
    };
}

/// An axis that moves.
struct MovingAxis {
    index: usize,
    steps_per_mm: f64,
    blend: Option<Blend<AXES>>,
    /// Its line, and when that begins, s from the beginning of the move.
    line: Profile,
    line_begins_s: f64,
    /// Signed distance of this axis per step of the master axis.
    mm_per_master_step: f64,
    /// Instants, s, and speeds, mm/s.
    speeds: Vec<(f64, f64)>,
    /// Instants, s, and accelerations, mm/s².
    accelerations: Vec<(f64, f64)>,
}

impl MovingAxis {
    fn speed_mm_s(&self, t_s: f64) -> f64 {
        match self.blend_at(t_s) {
            Some(blend) => blend.speed_at(self.index, blend.begin_s() + t_s) / self.steps_per_mm,
            None => self.mm_per_master_step * self.line.speed_at(t_s - self.line_begins_s),
        }
    }

    fn accel_mm_s2(&self, t_s: f64) -> f64 {
        match self.blend_at(t_s) {
            Some(blend) => blend.accel_steps_s2(self.index) / self.steps_per_mm,
            None => self.mm_per_master_step * self.line.accel_at(t_s - self.line_begins_s),
        }
    }

    fn blend_at(&self, t_s: f64) -> Option<&Blend<AXES>> {
        self.blend.as_ref().filter(|_| t_s < self.line_begins_s)
    }
}

fn moving(outcome: &Outcome, record: &MoveRecord) -> Vec<MovingAxis> {
    let axes = (0..AXES).filter(|&axis| record.plan.steps[axis] != 0 || record.blend_steps(axis) > 0);
    axes.map(|index| {
        let steps_per_mm = outcome.steps_per_mm[index];
        let speeds = slopes(&spread(&places(outcome, record, index)));
        MovingAxis {
            index,
            steps_per_mm,
            blend: record.blend,
            line: line(record),
            line_begins_s: record.line_begins_s(),
            mm_per_master_step: record.plan.axis_steps(index) / record.plan.distance_steps() / steps_per_mm,
            accelerations: slopes(&speeds),
            speeds,
        }
    })
    .collect()
}

fn line(record: &MoveRecord) -> Profile {
    record.profile().unwrap_or(record.plan.profile)
}

/// The time from the beginning of the move to the end of its line, s.
fn duration_s(record: &MoveRecord) -> f64 {
    record.line_begins_s() + line(record).duration_s()
}

/// The instants of an axis's edges, s from the beginning of the move, and its positions there, mm from the first.
fn places(outcome: &Outcome, record: &MoveRecord, axis: usize) -> Vec<(f64, f64)> {
    let edges = outcome.edges[record.edges.clone()].iter().filter(|edge| edge.axis == axis);
    let mut made = 0;
    let places = edges.map(|edge| {
        made += edge.direction;
        (record.passed_s(edge.t_ns), f64::from(made) / outcome.steps_per_mm[axis])
    });
    places.collect()
}

/// About `DOTS` of these places, evenly distributed in time.
fn spread(places: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let (from_s, to_s) = theme::range(places.iter().map(|place| place.0));
    let slot = |t_s: f64| ((t_s - from_s) / (to_s - from_s).max(1e-9) * DOTS as f64) as usize;
    let mut last = None;
    places.iter().copied().filter(|&(t_s, _)| last.replace(slot(t_s)) != Some(slot(t_s))).collect()
}

/// Mean slopes between neighbours, each at the middle of the two.
fn slopes(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let pairs = points.windows(2).filter(|pair| pair[1].0 > pair[0].0);
    pairs.map(|pair| ((pair[0].0 + pair[1].0) / 2.0, (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0))).collect()
}

fn panel(area: &Area, record: &MoveRecord, axes: &[MovingAxis], quantity: &Quantity) -> Drawn {
    let duration_s = duration_s(record);
    let (low, high) = extent(axes, duration_s, quantity);
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .margin_right(16)
        .x_label_area_size(if quantity.upper { 24 } else { 46 })
        .y_label_area_size(68)
        .build_cartesian_2d(0.0..duration_s, low..high)?;
    chart.draw_series(intervals(record, low, high))?;
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(TRANSPARENT).bold_line_style(GRID).axis_style(INK);
    mesh.label_style(theme::font(14)).axis_desc_style(theme::font(15)).y_desc(quantity.name);
    let decimals = theme::decimals_of(high - low);
    let label = move |value: &f64| format!("{value:.decimals$}");
    mesh.y_label_formatter(&label).y_labels(7);
    let seconds = theme::decimals_of(duration_s);
    let x_label = move |value: &f64| format!("{value:.seconds$}");
    mesh.x_label_formatter(&x_label);
    if !quantity.upper {
        mesh.x_desc("time from the start of the move, s");
    }
    mesh.draw()?;
    for axis in axes {
        let colour = AXIS[axis.index];
        let line = planned(axis, duration_s, quantity.planned);
        chart.draw_series(LineSeries::new(line, colour.stroke_width(2)))?;
        let dots = (quantity.measured)(axis).iter().filter(|dot| (low..=high).contains(&dot.1));
        chart.draw_series(dots.map(|&dot| Circle::new(dot, 2, colour.filled())))?;
    }
    if quantity.upper {
        let names = ["accelerate", "cruise", "decelerate"].into_iter().zip(spans(record));
        let wide = names.filter(|(_, (from_s, to_s))| to_s - from_s > duration_s * 0.12);
        let names = wide.map(|(name, (from_s, to_s))| {
            Text::new(name, ((from_s + to_s) / 2.0, high - 0.05 * (high - low)), theme::centred(14))
        });
        chart.draw_series(names)?;
    }
    Ok(())
}

/// The planned line: at equidistant instants, and on both sides of the ends of each interval, where it has corners.
fn planned(axis: &MovingAxis, duration_s: f64, value: fn(&MovingAxis, f64) -> f64) -> Vec<(f64, f64)> {
    let accel_s = axis.line_begins_s + axis.line.t_accel_s();
    let decel_s = duration_s - axis.line.t_decel_s();
    let aside_s = duration_s * 1e-6;
    let beside = [axis.line_begins_s, accel_s, decel_s].into_iter().flat_map(|t_s| [t_s - aside_s, t_s + aside_s]);
    let corners_s = beside.chain([0.0, duration_s - aside_s]).filter(|t_s| *t_s >= 0.0);
    let between_s = (1..CURVE_POINTS).map(|i| duration_s * f64::from(i) / f64::from(CURVE_POINTS));
    let mut instants_s: Vec<_> = corners_s.chain(between_s).collect();
    instants_s.sort_by(f64::total_cmp);
    instants_s.into_iter().map(|t_s| (t_s, value(axis, t_s))).collect()
}

/// Start and end of each interval of the line, s from the beginning of the move.
fn spans(record: &MoveRecord) -> [(f64, f64); 3] {
    let (line, begin_s, end_s) = (line(record), record.line_begins_s(), duration_s(record));
    let (accel_s, decel_s) = (begin_s + line.t_accel_s(), end_s - line.t_decel_s());
    [(begin_s, accel_s), (accel_s, decel_s), (decel_s, end_s)]
}

fn intervals(record: &MoveRecord, low: f64, high: f64) -> impl Iterator<Item = Rectangle<(f64, f64)>> {
    let coloured = spans(record).into_iter().zip(INTERVAL);
    coloured.map(move |((from_s, to_s), colour)| Rectangle::new([(from_s, low), (to_s, high)], colour.filled()))
}

/// A range with room for all values, and for the names above.
fn extent(axes: &[MovingAxis], duration_s: f64, quantity: &Quantity) -> (f64, f64) {
    let values = axes.iter().flat_map(|axis| planned(axis, duration_s, quantity.planned)).map(|(_, value)| value);
    let (low, high) = theme::range(values.chain([0.0]));
    let room = (high - low).max(1e-6) * 0.14;
    (low - room, high + room)
}
