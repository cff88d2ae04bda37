//! The distance of every step from its closed-form instant.

use isostep_motion::{AXES, Axis};

use super::chart::{self, Chart, Curve, axes_key};
use super::theme::{self, AXIS, BOUND};
use isostep_sim::Outcome;
use isostep_sim::verify::{self, shaped};

/// Columns of the picture. Each shows an axis's range of errors, from the earliest step to the latest.
const COLUMNS: usize = 240;

/// Draws the picture.
pub fn picture(outcome: &Outcome) -> String {
    let title = "Distance of each step from its closed-form instant";
    chart::picture(title, &axes_key(outcome, 0..AXES), 1, 340, &[chart(outcome)])
}

fn chart(outcome: &Outcome) -> Chart {
    let (from_s, to_s) = span_s(outcome);
    let columns = columns(outcome, from_s, to_s);
    let (low, high) = theme::range(columns.iter().flatten().flatten().flat_map(|&(low, high)| [low, high]));
    let tick_ns = outcome.config.port.tick_ns();
    let reach = low.abs().max(high.abs()).max(tick_ns) * 1.25;
    let bounds = [-tick_ns, tick_ns].map(|side_ns| Curve::dashed(BOUND, [(from_s, side_ns), (to_s, side_ns)]));
    let width_s = (to_s - from_s).max(1e-9) / COLUMNS as f64;
    // The height that makes a single step visible.
    let least_ns = tick_ns / 100.0;
    let bars = columns.iter().zip(AXIS).map(|(columns, colour)| {
        let spans = columns.iter().enumerate().filter_map(|(number, span)| Some((number, (*span)?)));
        let corners = spans.map(|(number, (low, high))| {
            let left_s = from_s + number as f64 * width_s;
            [(left_s, low - least_ns), (left_s + width_s, high + least_ns)]
        });
        Curve::bars(colour, corners).faint(0.55)
    });
    Chart::new(
        chart::Axis::from("time from power-up, s").within(from_s, to_s.max(from_s + 1e-3)),
        chart::Axis::from("late (+) or early (-), ns").within(-reach, reach),
        bounds.into_iter().chain(bars).collect(),
    )
}

/// From the beginning of the first move of the program to the end of the last one, s since power-up.
fn span_s(outcome: &Outcome) -> (f64, f64) {
    theme::range(
        outcome.program_moves().flat_map(|record| [record.begin_ns(), record.end_ns]).map(|ns| ns as f64 * 1e-9),
    )
}

/// For each axis and column, the least and the greatest error, ns; `None` without steps.
fn columns(outcome: &Outcome, from_s: f64, to_s: f64) -> [[Option<(f64, f64)>; COLUMNS]; AXES] {
    let mut columns = [[None; COLUMNS]; AXES];
    let per_s = COLUMNS as f64 / (to_s - from_s).max(1e-9);
    let mut take = |axis: usize, t_s: f64, error_ns: f64| {
        let span = &mut columns[axis][(((t_s - from_s) * per_s).max(0.0) as usize).min(COLUMNS - 1)];
        let (low, high) = span.unwrap_or((error_ns, error_ns));
        *span = Some((low.min(error_ns), high.max(error_ns)));
    };
    for (_, run) in outcome.runs() {
        if run[0].shaping.is_some() {
            for axis in Axis::ALL {
                let errors_ns = shaped::errors_ns(outcome, run, axis);
                errors_ns.into_iter().for_each(|(t_s, error_ns)| take(axis as usize, t_s, error_ns));
            }
            continue;
        }
        for record in run {
            let times_s = verify::axis_times_s(record, outcome.edges_of(record));
            let begin_s = record.begin_ns() as f64 * 1e-9;
            for (axis, times_s) in times_s.iter().enumerate() {
                verify::errors_ns(record, axis, times_s)
                    .for_each(|(t_s, error_ns)| take(axis, begin_s + t_s, error_ns));
            }
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use isostep_sim::{Config, run};

    /// The bars reach as far as the worst step, and there is none of an axis that rests.
    #[test]
    fn bars_span_the_errors_of_their_axis() {
        let outcome = run(b"G1 X20 Y10 F1200\n", &Config::default()).unwrap();
        let chart = chart(&outcome);
        let worst = verify::moves(&outcome).map(|check| check.error_max_ns()).fold(0.0, f64::max);
        let least_ns = outcome.config.port.tick_ns() / 100.0;
        let reach = |curve: &Curve| curve.points.iter().map(|point| point.1.abs()).fold(0.0, f64::max);
        assert_eq!(chart.curves[..2].iter().map(reach).collect::<Vec<_>>(), [8.0, 8.0], "one tick");
        let found = chart.curves[2..].iter().map(reach).fold(0.0, f64::max) - least_ns;
        assert!((found - worst).abs() < 1e-6, "{found} is not {worst}");
        assert!(!chart.curves[2].points.is_empty() && chart.curves[4].points.is_empty());
    }
}
