//! Stoychitch's figures 2 and 5: the first steps.

use anyhow::Result;
use isostep_report::pictures::chart::{self, Axis, Chart, Curve, Scale};
use isostep_report::pictures::document::Picture;
use isostep_report::pictures::theme::CURVE;

use super::generators::{Generator, generators, law};
use super::motor::{SLOW_START_RAD_S, steps_per_rad};
use super::speed_error;

/// Number of steps shown.
const SHOWN: usize = 12;

/// Figure 2: steps at constant speed and while accelerating.
pub fn steps() -> Result<Picture> {
    let first_s = |edges: &[f64]| edges.iter().map(|edge_s| edge_s - edges[0]).collect::<Vec<_>>();
    let accelerating = first_s(&generators(SLOW_START_RAD_S)?[0].edges_s(&law(SLOW_START_RAD_S)?, SHOWN));
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
    let (all, law, alpha) = (generators(SLOW_START_RAD_S)?, law(SLOW_START_RAD_S)?, 1.0 / steps_per_rad());
    let stair = |(colour, generator): (usize, &Generator)| {
        let edges = generator.edges_s(&law, SHOWN + 1);
        let treads = edges.windows(2).map(|pair| (pair[0], pair[1], alpha / (pair[1] - pair[0])));
        let points = treads.flat_map(|(from_s, to_s, speed)| [(from_s, speed), (to_s, speed)]);
        Curve::line(CURVE[colour], points)
    };
    let mut curves: Vec<Curve> = all.iter().enumerate().map(stair).collect();
    let end_s = all[0].edges_s(&law, SHOWN + 1)[SHOWN];
    let line = (0..=100).map(|k| end_s * f64::from(k) / 100.0).map(|t_s| (t_s, law.speed_at(t_s) * alpha));
    curves.push(Curve::dashed(CURVE[6], line));
    let chart = Chart::new("time, s", "speed, rad/s", curves);
    Ok(Picture::new(
        "stoychitch-2018-figure-5",
        chart::picture(
            "Speed of the first steps of each generator",
            &[speed_error::key(), vec![(CURVE[6], "the linear law".to_owned())]].concat(),
            1,
            360,
            &[chart],
        ),
        "Figure 5: each stair is an interval, as high as its speed. Exact intervals cross the law in their middle. Time \
                  per step gives an interval the speed that the law has at its beginning, and so comes late by half a step; eq 14 \
                  makes the first five longer still. That helps where the recurrence runs ahead, nearly from rest as here; \
                  at the paper's own v_s = 0.5 rad/s it hardly errs, and the correction is all that is wrong.",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

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
