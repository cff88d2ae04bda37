//! Speed and acceleration of each axis over time: planned values as lines, values measured from the edges as dots.

use plotters::prelude::*;

use super::theme::{self, AXIS, Area, Drawn, GRID, INK, INTERVAL};
use crate::moves::MoveRecord;
use crate::outcome::Outcome;
use isostep_motion::AXES;

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
        planned: |axis, t_s| axis.mm_per_master_step * axis.plan.speed_at(t_s),
        measured: |axis| &axis.speeds,
        upper: true,
    };
    const ACCELERATION: Self = Self {
        name: "acceleration, mm/s²",
        planned: |axis, t_s| axis.mm_per_master_step * axis.plan.accel_at(t_s),
        measured: |axis| &axis.accelerations,
        upper: false,
    };
}

/// An axis that moves.
struct MovingAxis {
    index: usize,
    plan: isostep_profile::Profile,
    /// Signed distance of this axis per step of the master axis.
    mm_per_master_step: f64,
    /// Instants, s, and speeds, mm/s.
    speeds: Vec<(f64, f64)>,
    /// Instants, s, and accelerations, mm/s².
    accelerations: Vec<(f64, f64)>,
}

fn moving(outcome: &Outcome, record: &MoveRecord) -> Vec<MovingAxis> {
    let plan = record.profile().unwrap_or(record.plan.profile);
    let axes = (0..AXES).filter(|&axis| record.plan.steps[axis] != 0);
    axes.map(|index| {
        let steps_per_mm = outcome.steps_per_mm[index];
        let speeds = slopes(&spread(&places(outcome, record, index)));
        MovingAxis {
            index,
            plan,
            mm_per_master_step: record.plan.axis_steps(index) / record.plan.distance_steps() / steps_per_mm,
            accelerations: slopes(&speeds),
            speeds,
        }
    })
    .collect()
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
    let duration_s = record.profile().unwrap_or(record.plan.profile).duration_s();
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
    let (accel_s, decel_s) = (axis.plan.t_accel_s(), duration_s - axis.plan.t_decel_s());
    let aside_s = duration_s * 1e-6;
    let corners_s =
        [0.0, accel_s - aside_s, accel_s + aside_s, decel_s - aside_s, decel_s + aside_s, duration_s - aside_s];
    let between_s = (1..CURVE_POINTS).map(|i| duration_s * f64::from(i) / f64::from(CURVE_POINTS));
    let mut instants_s: Vec<_> = corners_s.into_iter().chain(between_s).collect();
    instants_s.sort_by(f64::total_cmp);
    instants_s.into_iter().map(|t_s| (t_s, value(axis, t_s))).collect()
}

/// Start and end of each interval, s.
fn spans(record: &MoveRecord) -> [(f64, f64); 3] {
    let profile = record.profile().unwrap_or(record.plan.profile);
    let (accel_s, decel_s) = (profile.t_accel_s(), profile.duration_s() - profile.t_decel_s());
    [(0.0, accel_s), (accel_s, decel_s), (decel_s, profile.duration_s())]
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
