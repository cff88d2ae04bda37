//! The closeness with which the generators' speed follows the linear profile; and the first steps, figures 2 and 5 (Stoychitch
//! 2018).

use anyhow::Result;
use isostep_report::pictures::chart::{self, Axis, Chart, Curve, Scale};
use isostep_report::pictures::document::{Picture, Table};
use isostep_report::pictures::theme::{CURVE, Colour};

use super::generators::{
    Generator, NAMES, SLOW_START_RAD_S, START_RAD_S, STEPS_PER_REV, generators, linear_profile, steps_per_rad,
};
use crate::row::{Paper, Row, signed};

const STARTS: [(f64, &str); 2] = [(START_RAD_S, "v_s = 0.5 rad/s"), (SLOW_START_RAD_S, "v_s = 0.08 rad/s")];

/// Indices of generators in [`NAMES`].
const WITHOUT: usize = 1;
const WITH: usize = 2;
const STEPS_PER_TIME: usize = 3;

/// The largest error of each generator, %, in the order of [`NAMES`].
fn worst_errors(start_rad_s: f64) -> Result<Vec<f64>> {
    let linear_profile = linear_profile(start_rad_s, STEPS_PER_REV)?;
    Ok(generators(start_rad_s)?.iter().map(|generator| worst(&generator.errors_percent(&linear_profile))).collect())
}

fn worst(errors: &[f64]) -> f64 {
    errors.iter().fold(0.0, |worst: f64, error| worst.max(error.abs()))
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|error| error * error).sum::<f64>() / errors.len().max(1) as f64).sqrt()
}

/// The paper's statements about its correction, and each of its generators compared with ours.
pub fn rows() -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (start_rad_s, what) in STARTS {
        let errors = worst_errors(start_rad_s)?;
        rows.push(correction(&errors, what));
        for (index, place) in [(WITHOUT, "eqs 11-13"), (WITH, "eqs 11-14"), (STEPS_PER_TIME, "eq 17, 10 kHz")] {
            let quantity = format!("worst speed error, {}, {what}", NAMES[index]);
            rows.push(Paper::Linear.asks(place, quantity).number("%", 3).by_method(errors[index], errors[0]));
        }
    }
    Ok(rows)
}

fn correction(errors: &[f64], what: &str) -> Row {
    let (without, with) = (errors[WITHOUT], errors[WITH]);
    let helps = with < without;
    let verdict = if helps { "more exact" } else { "less exact" };
    let found = format!("{verdict}: worst error {with:.2} %, {without:.2} % without it");
    Paper::Linear.asks("3.1, eq 14", format!("the correction makes the speed, {what}")).says("more exact", found, helps)
}

/// The errors of every generator, from both start speeds.
pub fn table() -> Result<Table> {
    let mut rows = Vec::new();
    for (start_rad_s, what) in STARTS {
        let linear_profile = linear_profile(start_rad_s, STEPS_PER_REV)?;
        for generator in generators(start_rad_s)? {
            let errors = generator.errors_percent(&linear_profile);
            let late_ms = generator.late_s(&linear_profile) * 1e3;
            rows.push(vec![
                what.to_owned(),
                generator.name.to_owned(),
                format!("{:.3}", worst(&errors)),
                format!("{:.4}", rms(&errors)),
                signed(late_ms, 3),
            ]);
        }
    }
    let head = ["start", "generator", "worst speed error, %", "rms, %", "last step late, ms"];
    Ok(Table::new(&head, rows).captioned("Speed of each interval against the linear profile, one revolution"))
}

/// The error of every interval.
pub fn picture() -> Result<Picture> {
    let linear_profile = linear_profile(START_RAD_S, STEPS_PER_REV)?;
    let curves: Vec<Curve> = generators(START_RAD_S)?
        .iter()
        .enumerate()
        .rev()
        .map(|(colour, generator)| {
            let errors = generator.errors_percent(&linear_profile).into_iter().enumerate();
            Curve::line(CURVE[colour], errors.map(|(i, error)| (i as f64, error)))
        })
        .collect();
    let near = curves.iter().filter(|curve| curve.colour != CURVE[STEPS_PER_TIME]).cloned().collect();
    let error = "speed error, %";
    let panels = [Chart::new("step", error, curves), Chart::new("step", Axis::from(error).within(-0.3, 0.3), near)];
    Ok(Picture::new(
        "stoychitch-2018-speed-error",
        chart::picture("Speed error of each generator over the steps of a revolution", &key(), 1, 260, &panels),
        "One revolution of the paper's motor from v_s = 0.5 rad/s; below, the same seen closer. Steps per time can \
         only step on one of its 10,000 services a second: at 1,304 steps/s an interval is 7 or 8 of them, up to a \
         tenth wrong, though right on average. What is left of ours is the timer's microsecond. Time per step \
         goes from interval to interval by a recurrence that runs ahead a little everywhere, and keeps what it \
         has gained: at the end, where the motor is slow again, it shows.",
    ))
}

/// The key: each generator's colour and name.
pub fn key() -> Vec<(Colour, String)> {
    chart::key(NAMES)
}

/// Number of steps shown.
const SHOWN: usize = 12;

/// Figure 2: steps at constant speed and while accelerating.
pub fn steps() -> Result<Picture> {
    let first_s = |edges: &[f64]| edges.iter().map(|edge_s| edge_s - edges[0]).collect::<Vec<_>>();
    let accelerating =
        first_s(&generators(SLOW_START_RAD_S)?[0].edges_s(&linear_profile(SLOW_START_RAD_S, STEPS_PER_REV)?, SHOWN));
    let last_s = accelerating[SHOWN - 1];
    let constant: Vec<f64> = (0..SHOWN).map(|k| last_s * k as f64 / (SHOWN - 1) as f64).collect();
    let curve = |colour, edges: &[f64], low| Curve::line(colour, pulses(edges, low, last_s * 0.012));
    let chart = Chart::new(
        "time, s",
        Axis::scaled("STEP", Scale::Levels).within(-0.3, 2.6),
        vec![curve(CURVE[1], &constant, 1.4), curve(CURVE[0], &accelerating, 0.0)],
    );
    Ok(Picture::new(
        "stoychitch-2018-figure-2",
        chart::picture(
            "Steps at constant speed and while accelerating",
            &[(CURVE[1], "constant speed".to_owned()), (CURVE[0], "accelerating".to_owned())],
            1,
            220,
            &[chart],
        ),
        "Figure 2: twelve steps in the same time. Speed that rises in a straight line means intervals that shrink, \
         and not in a straight line: that is the whole problem of a step generator. (The paper's motor from 0.08 \
         rad/s, where it shows.)",
    ))
}

/// The level of STEP over time, from the instants of the rising edges.
fn pulses(edges_s: &[f64], low: f64, width_s: f64) -> Vec<(f64, f64)> {
    let pulse = |&edge_s: &f64| {
        let fall_s = edge_s + width_s;
        [(edge_s, low), (edge_s, low + 0.8), (fall_s, low + 0.8), (fall_s, low)]
    };
    edges_s.iter().flat_map(pulse).collect()
}

/// Figure 5: the speed in each interval.
pub fn stairs() -> Result<Picture> {
    let (all, linear_profile, alpha) =
        (generators(SLOW_START_RAD_S)?, linear_profile(SLOW_START_RAD_S, STEPS_PER_REV)?, 1.0 / steps_per_rad());
    let stair = |(colour, generator): (usize, &Generator)| {
        let edges = generator.edges_s(&linear_profile, SHOWN + 1);
        let treads = edges.windows(2).map(|pair| (pair[0], pair[1], alpha / (pair[1] - pair[0])));
        let points = treads.flat_map(|(from_s, to_s, speed)| [(from_s, speed), (to_s, speed)]);
        Curve::line(CURVE[colour], points)
    };
    let mut curves: Vec<Curve> = all.iter().enumerate().map(stair).collect();
    let end_s = all[0].edges_s(&linear_profile, SHOWN + 1)[SHOWN];
    let line = (0..=100).map(|k| end_s * f64::from(k) / 100.0).map(|t_s| (t_s, linear_profile.speed_at(t_s) * alpha));
    curves.push(Curve::dashed(CURVE[6], line));
    let chart = Chart::new("time, s", "speed, rad/s", curves);
    Ok(Picture::new(
        "stoychitch-2018-figure-5",
        chart::picture(
            "Speed of the first steps of each generator",
            &[key(), vec![(CURVE[6], "the linear profile".to_owned())]].concat(),
            1,
            360,
            &[chart],
        ),
        "Figure 5: each stair is an interval, as high as its speed. Exact intervals cross the profile in their middle. Time \
         per step gives an interval the speed that the profile has at its beginning, and so comes late by half a step; eq 14 \
         makes the first five longer still. That helps where the recurrence runs ahead, nearly from rest as here; \
         at the paper's own v_s = 0.5 rad/s it hardly errs, and the correction is all that is wrong.",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_segments_are_the_truest_from_either_start() {
        for (start_rad_s, what) in STARTS {
            let errors = worst_errors(start_rad_s).unwrap();
            assert!(errors[1..].iter().all(|error| errors[0] < *error), "{what}: {errors:?}");
        }
    }

    #[test]
    fn the_correction_helps_from_rest_and_harms_at_speed() {
        let (at_speed, from_rest) = (worst_errors(START_RAD_S).unwrap(), worst_errors(SLOW_START_RAD_S).unwrap());
        assert!(at_speed[WITH] > at_speed[WITHOUT] && from_rest[WITH] < from_rest[WITHOUT]);
    }

    #[test]
    fn pulses_rise_and_fall() {
        assert_eq!(pulses(&[1.0], 0.5, 0.25), [(1.0, 0.5), (1.0, 1.3), (1.25, 1.3), (1.25, 0.5)]);
    }

    #[test]
    fn figures_are_drawn() {
        for picture in [steps().unwrap(), stairs().unwrap()] {
            assert!(picture.svg.contains("<polyline"), "{}", picture.name);
        }
    }
}
