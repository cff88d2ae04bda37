//! The figures that compare speed profiles.

use serde::Serialize;

use super::{Curve, Derivatives, Exact, differences, peak, peak_mean};
use crate::digits::significant;

/// A row's name and its text for each speed profile.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The quantity and its unit.
    pub name: &'static str,
    /// One text per speed profile, in the order of the speed profiles.
    pub cells: Vec<String>,
}

/// Every figure of every speed profile.
pub fn rows(curves: &[Curve]) -> Vec<Row> {
    // Step generators end with their last step. If one is in the table, all durations are compared up to the last step.
    let have_totals = curves.iter().all(|curve| curve.duration_s.is_some());
    let length_s = |curve: &Curve| curve.duration_s.filter(|_| have_totals).unwrap_or(curve.first_to_last_s());
    let fastest_s = curves.iter().map(length_s).fold(f64::INFINITY, f64::min);
    let row = |name, cell: &dyn Fn(&Curve) -> String| Row { name, cells: curves.iter().map(cell).collect() };
    let mut rows = vec![
        row("steps: accelerate + cruise + decelerate", &|curve| {
            format!("{} + {} + {}", curve.counts.accel, curve.counts.cruise, curve.counts.decel)
        }),
        row("accelerating, s", &|curve| seconds(curve.phases_s[0])),
        row("cruising, s", &|curve| seconds(curve.phases_s[1])),
        row("decelerating, s", &|curve| seconds(curve.phases_s[2])),
        row("total, s", &|curve| curve.duration_s.map_or("-".to_owned(), seconds)),
        row("first step to last, s", &|curve| seconds(curve.first_to_last_s())),
        row("top speed, steps/s", &|curve| digits(curve.top_hz)),
    ];
    if curves.len() > 1 {
        let saved = |curve: &Curve| format!("{:.1} %", 100.0 * (1.0 - fastest_s / length_s(curve)));
        rows.insert(if have_totals { 5 } else { 6 }, row("  the fastest saves", &saved));
    }
    rows.extend(peaks(curves));
    rows
}

/// Peak acceleration and jerk. With a closed form, the rows are its peaks and the peaks of the mean over a few steps;
/// the speed profile's limits hold for both. If no speed profile has a closed form, the rows are the peaks by differences, as in
/// the papers.
fn peaks(curves: &[Curve]) -> Vec<Row> {
    let row = |name, value: &dyn Fn(&Curve) -> Option<f64>| Row {
        name,
        cells: curves.iter().map(|curve| value(curve).map_or("-".to_owned(), digits)).collect(),
    };
    if curves.iter().all(|curve| curve.exact.is_none()) {
        let slopes = |curve: &Curve, points: fn(&Derivatives) -> &[(f64, f64)]| Some(peak(points(&differences(curve))));
        return vec![
            row("peak acceleration by differences, steps/s2", &|curve| slopes(curve, |slopes| &slopes.accel)),
            row("peak jerk by differences, steps/s3", &|curve| slopes(curve, |slopes| &slopes.jerk)),
        ];
    }
    let exact = |curve: &Curve, value: fn(&Exact) -> f64| curve.exact.as_ref().map(value);
    vec![
        row("peak acceleration, steps/s2", &|curve| exact(curve, Exact::peak_accel)),
        row("  mean over 3 steps, at most", &|curve| Some(peak_mean::<3>(curve))),
        row("peak jerk, steps/s3", &|curve| exact(curve, Exact::peak_jerk)),
        row("  mean over 4 steps, at most", &|curve| Some(peak_mean::<4>(curve))),
    ]
}

fn seconds(s: f64) -> String {
    format!("{s:.6}")
}

/// A number with six significant digits and without trailing zeros.
fn digits(value: f64) -> String {
    if value.is_infinite() {
        return "unbounded".to_owned();
    }
    significant(value, 6.0)
}
