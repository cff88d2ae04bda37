//! Stoychitch 2018, section 2: trajectory planning, following the paper's flow chart step by step.

use anyhow::Result;
use isostep_profile::Profile;
use isostep_report::pictures::chart::{self, Chart, Curve};
use isostep_report::pictures::document::Picture;
use isostep_report::pictures::theme::CURVE;

use super::generators::{ACCEL_RAD_S2, RATIO, START_RAD_S, STEPS_PER_REV, TOP_RAD_S, linear_profile, steps_per_rad};
use crate::row::{Paper, Row};

/// The results of section 2: times, s, and steps of the phases.
struct Planned {
    accel_s: f64,
    cruise_s: f64,
    decel_s: f64,
    total_s: f64,
    steps: [f64; 3],
}

/// Eqs 1 to 8, in the paper's units.
fn by_the_paper(steps: u32) -> Planned {
    let (vs, vm, a, m) = (START_RAD_S, TOP_RAD_S, ACCEL_RAD_S2, RATIO);
    let (n, alpha) = (f64::from(steps), 1.0 / steps_per_rad());
    let s = n * alpha;
    let k = vs * (1.0 + m) / a;
    let total_s = -k + (k * k + 2.0 * s * (1.0 + m) / a).sqrt();
    let accel_s = total_s / (1.0 + m);
    if vs + a * accel_s <= vm {
        let accel = (n / (1.0 + m)).round();
        return Planned { accel_s, cruise_s: 0.0, decel_s: total_s - accel_s, total_s, steps: [accel, 0.0, n - accel] };
    }
    let accel_s = (vm - vs) / a;
    let ramps_s = accel_s * (1.0 + m);
    let ramps_rad = vs * ramps_s + a * ramps_s * ramps_s / (2.0 * (1.0 + m));
    let cruise_s = (s - ramps_rad) / vm;
    // Eq 8 gives a fractional N_ad; the appendix rounds it to a whole number.
    let ramps = (ramps_rad / alpha).floor();
    let accel = (ramps / (1.0 + m)).round();
    let steps = [accel, n - ramps, ramps - accel];
    Planned { accel_s, cruise_s, decel_s: ramps_s - accel_s, total_s: ramps_s + cruise_s, steps }
}

/// Half a radian, whose profile is a triangle.
const TRIANGLE_STEPS: u32 = 326;

/// Every result of section 2, for a revolution (a trapezoid) and for half a radian (a triangle).
pub fn rows() -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (steps, what) in [(STEPS_PER_REV, "one revolution"), (TRIANGLE_STEPS, "326 steps")] {
        let (theirs, ours) = (by_the_paper(steps), linear_profile(START_RAD_S, steps)?);
        let counts = ours.step_counts();
        let times = [
            ("T", theirs.total_s, ours.duration_s()),
            ("t_a", theirs.accel_s, ours.t_accel_s()),
            ("t_v", theirs.cruise_s, ours.t_cruise_s()),
            ("t_d", theirs.decel_s, ours.t_decel_s()),
        ];
        let ask = |name: &str| Paper::Linear.asks("section 2, appendix", format!("{name}, {what}"));
        rows.extend(times.map(|(name, theirs, ours)| ask(name).number("s", 6).by_method(theirs, ours)));
        let ours = [counts.accel, counts.cruise, counts.decel].map(f64::from);
        for (name, (theirs, ours)) in ["N_a", "N_v", "N_d"].into_iter().zip(theirs.steps.into_iter().zip(ours)) {
            rows.push(ask(name).number("steps", 0).by_method(theirs, ours));
        }
    }
    Ok(rows)
}

/// Figures 1 and 3.
pub fn picture() -> Result<Picture> {
    let [triangle, trapezoid] = [TRIANGLE_STEPS, STEPS_PER_REV].map(|steps| linear_profile(START_RAD_S, steps));
    let panels = quantities(&triangle?).into_iter().zip(quantities(&trapezoid?));
    let rows: Vec<Chart> = panels.flat_map(|(one, other)| [one, other]).collect();
    Ok(Picture::new(
        "stoychitch-2018-figures-1-and-3",
        chart::picture("Position, speed and acceleration of a triangle and a trapezoid", &[], 2, 230, &rows),
        "Figures 1 and 3: the paper's motor over half a radian (left, a triangle: the top speed is not reached) and over \
         one revolution (right, a trapezoid). Acceleration is twice the deceleration, m = 2, so the motor takes \
         twice as long to stop as to start; it begins and ends at v_s = 0.5 rad/s. Shaded: accelerating, \
         cruising, decelerating.",
    ))
}

/// Points per curve.
const POINTS: u32 = 600;

fn quantities(plan: &Profile) -> [Chart; 3] {
    let (alpha, total_s) = (1.0 / steps_per_rad(), plan.duration_s());
    let accel_s = plan.t_accel_s();
    let cruise_end_s = total_s - plan.t_decel_s();
    let chart = |name: &str, value: &dyn Fn(f64) -> f64| {
        let instants = (0..=POINTS).map(|k| total_s * f64::from(k) / f64::from(POINTS));
        let points = instants.map(|t_s| (t_s, value(t_s) * alpha));
        Chart {
            bands: chart::intervals([(0.0, accel_s), (accel_s, cruise_end_s), (cruise_end_s, total_s)]),
            ..Chart::new("time, s", name, vec![Curve::line(CURVE[0], points)])
        }
    };
    [
        chart("position, rad", &|t_s| plan.position_at(t_s)),
        chart("speed, rad/s", &|t_s| plan.speed_at(t_s)),
        chart("acceleration, rad/s²", &|t_s| plan.accel_at(t_s)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::Cell;

    /// By hand; the derivation is in the tests of the papers in the profile crate.
    #[test]
    fn a_revolution_by_the_papers_equations() {
        let planned = by_the_paper(STEPS_PER_REV);
        assert!((planned.total_s - 3.985_342_653_6).abs() < 1e-9);
        assert_eq!(planned.steps, [611.0, 2_263.0, 1_222.0]);
    }

    #[test]
    fn the_plan_is_the_papers() {
        for row in rows().unwrap() {
            let Cell::Number(difference) = row.difference else { panic!("{row:?}") };
            assert!(difference.abs() < 1e-9, "{row:?}");
        }
    }
}
