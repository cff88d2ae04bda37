//! Speed and acceleration of each axis over time: planned values as lines, values measured from the edges as dots. A blend
//! at the beginning is drawn with the move.

use super::chart::{self, Axis, Chart, Curve, Label, Place, axes_key, over_one_x, picture};
use super::theme::{self, AXIS};
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
    let key = axes_key(outcome, axes.iter().map(|axis| axis.index));
    picture("Speed and acceleration of each axis over time", &key, 1, 290, &charts(record, &axes))
}

fn charts(record: &MoveRecord, axes: &[MovingAxis]) -> Vec<Chart> {
    let mut speed = chart_of(record, axes, "speed, mm/s", MovingAxis::speed_mm_s, |axis| &axis.speeds);
    let acceleration =
        chart_of(record, axes, "acceleration, mm/s²", MovingAxis::accel_mm_s2, |axis| &axis.accelerations);
    speed.labels = names(record, speed.y.range.unwrap_or_default());
    over_one_x(vec![speed, acceleration])
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
        let steps_per_mm = outcome.axis_steps_per_mm[index];
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
    let edges = outcome.edges_of(record).iter().filter(|edge| edge.axis == axis);
    let mut made = 0;
    let places = edges.map(|edge| {
        made += edge.direction;
        (record.passed_s(edge.t_ns), f64::from(made) / outcome.axis_steps_per_mm[axis])
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

/// A quantity of all axes over time: planned as lines, measured as dots.
fn chart_of(
    record: &MoveRecord,
    axes: &[MovingAxis],
    name: &str,
    planned_at: fn(&MovingAxis, f64) -> f64,
    measured: fn(&MovingAxis) -> &[(f64, f64)],
) -> Chart {
    let duration_s = duration_s(record);
    let lines: Vec<_> = axes.iter().map(|axis| planned(axis, duration_s, planned_at)).collect();
    let (low, high) = extent(lines.iter().flatten().map(|point| point.1));
    let curves = axes.iter().zip(lines).flat_map(|(axis, line)| {
        let colour = AXIS[axis.index];
        [Curve::line(colour, line), Curve::dots(colour, measured(axis).iter().copied())]
    });
    let x = Axis::from("time from the start of the move, s").within(0.0, duration_s);
    let chart = Chart::new(x, Axis::from(name).within(low, high), curves.collect());
    Chart { bands: chart::intervals(spans(record)), ..chart }
}

/// The names of the intervals that are wide enough for them.
fn names(record: &MoveRecord, (low, high): (f64, f64)) -> Vec<Label> {
    let names = ["accelerate", "cruise", "decelerate"].into_iter().zip(spans(record));
    let wide = names.filter(|(_, (from_s, to_s))| to_s - from_s > duration_s(record) * 0.12);
    let label = |(name, (from_s, to_s)): (&str, (f64, f64))| {
        Label::new(((from_s + to_s) / 2.0, high - 0.05 * (high - low)), Place::Centre, name)
    };
    wide.map(label).collect()
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

/// A range with room for all values, and for the names above.
fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = theme::range(values.chain([0.0]));
    let room = (high - low).max(1e-6) * 0.14;
    (low - room, high + room)
}

#[cfg(test)]
mod tests {
    use super::chart::Style;
    use super::*;
    use isostep_sim::{Config, run};

    /// By hand: X goes 20 mm from and to rest at 50 mm/s2, so it reaches sqrt(50 x 20) mm/s in the middle, and Y half of it.
    #[test]
    fn lines_are_the_plan_and_dots_the_edges() {
        let outcome = run(b"G1 X20 Y10 F2400\n", &Config::default()).unwrap();
        let record = &outcome.moves[0];
        let charts = charts(record, &moving(&outcome, record));
        let duration_s = record.plan_s;
        for (chart, peaks) in charts.iter().zip([[31.623, 15.811], [50.0, 25.0]]) {
            assert_eq!(chart.x.range.map(|range| (range.1 - duration_s).abs() < 1e-9), Some(true));
            assert_eq!(chart.bands.len(), 3);
            assert!((chart.bands[2].to - duration_s).abs() < 1e-9);
            for (curves, peak) in chart.curves.chunks(2).zip(peaks) {
                let [line, dots] = curves else { panic!("{curves:?}") };
                let highest = line.points.iter().map(|point| point.1).fold(0.0, f64::max);
                assert!((highest / peak - 1.0).abs() < 1e-3, "{highest} is not {peak}");
                assert!((dots.style, dots.points.len() > 40) == (Style::Dots(2), true));
            }
        }
        let [line, dots] = &charts[0].curves[..2] else { panic!() };
        for &(t_s, speed) in &dots.points[1..dots.points.len() - 1] {
            let at = line.points.partition_point(|point| point.0 < t_s);
            assert!((line.points[at].1 - speed).abs() < 0.5, "at {t_s} s: {speed}, not {}", line.points[at].1);
        }
        assert_eq!(
            charts[0].labels.iter().map(|label| label.text.as_str()).collect::<Vec<_>>(),
            ["accelerate", "decelerate"]
        );
    }
}
