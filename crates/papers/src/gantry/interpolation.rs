//! Forero's figure 9: two axes at once, and how straight their path is.

use anyhow::Result;
use isostep_report::pictures::chart::{self, Chart, Curve};
use isostep_report::pictures::document::Picture;
use isostep_report::pictures::theme::CURVE;

use super::intervals::{ACROSS_STEPS, STEPS, ours, timed};
use crate::row::{Paper, Row};

/// Instants of the steps of both axes, s: the long axis, and the axis across it.
struct Edges {
    long_s: Vec<f64>,
    across_s: Vec<f64>,
}

impl Edges {
    fn theirs() -> Result<Self> {
        let of = |steps| -> Result<Vec<f64>> { Ok(timed(steps, 0)?.edges_s().collect()) };
        Ok(Self { long_s: of(STEPS)?, across_s: of(ACROSS_STEPS)? })
    }

    fn ours() -> Result<Self> {
        let plan = ours()?;
        let of = |axis: usize, steps: u32| (1..=steps).map(|k| plan.step_time_s(axis, k)).collect();
        Ok(Self { long_s: of(0, STEPS), across_s: of(1, ACROSS_STEPS) })
    }

    fn end_s(&self) -> f64 {
        let last = |edges: &[f64]| edges.last().copied().unwrap_or(0.0);
        last(&self.long_s).max(last(&self.across_s))
    }

    /// The position of both axes at `t_s`, steps.
    fn at(&self, t_s: f64) -> (f64, f64) {
        let made = |edges: &[f64]| edges.partition_point(|edge_s| *edge_s <= t_s) as f64;
        (made(&self.long_s), made(&self.across_s))
    }

    /// The lead of the axis across on the straight line, steps.
    fn error_steps(&self, t_s: f64) -> f64 {
        let (long, across) = self.at(t_s);
        across - long * f64::from(ACROSS_STEPS) / f64::from(STEPS)
    }

    /// The largest deviation from the straight line at any step.
    fn error_max_steps(&self) -> f64 {
        let instants = self.long_s.iter().chain(&self.across_s);
        instants.map(|t_s| self.error_steps(*t_s).abs()).fold(0.0, f64::max)
    }

    fn instants(&self) -> impl Iterator<Item = f64> + use<> {
        let end_s = self.end_s() * 1.01;
        (0..=POINTS).map(move |k| end_s * f64::from(k) / f64::from(POINTS))
    }
}

/// Points per curve.
const POINTS: u32 = 1_200;

/// Rows that compare how straight both paths are.
pub fn rows() -> Result<Vec<Row>> {
    let (theirs, ours) = (Edges::theirs()?, Edges::ours()?);
    let ask = |quantity: &str| Paper::Gantry.asks("section 4, figure 9", quantity);
    Ok(vec![
        ask("20,000 and 17,500 steps: farthest off the straight line (a model)")
            .number("steps", 1)
            .by_method(theirs.error_max_steps(), ours.error_max_steps()),
        ask("the same: first step to last (a model)")
            .number("s", 3)
            .by_method(theirs.end_s() - theirs.long_s[0], ours.end_s() - ours.long_s[0]),
    ])
}

/// Position over time, and the distance from the straight line.
pub fn picture() -> Result<Picture> {
    let (theirs, ours) = (Edges::theirs()?, Edges::ours()?);
    let curve = |edges: &Edges, colour: usize, value: &dyn Fn(f64) -> f64| {
        Curve::line(CURVE[colour], edges.instants().map(|t_s| (t_s, value(t_s))))
    };
    let positions = vec![
        curve(&theirs, 1, &|t_s| theirs.at(t_s).0),
        curve(&theirs, 2, &|t_s| theirs.at(t_s).1),
        curve(&ours, 0, &|t_s| ours.at(t_s).0),
        curve(&ours, 3, &|t_s| ours.at(t_s).1),
    ];
    let position = Chart::new("time, s", "position, steps", positions);
    let error = Chart::new(
        "time, s",
        "off the line, steps",
        vec![curve(&theirs, 1, &|t_s| theirs.error_steps(t_s)), curve(&ours, 0, &|t_s| ours.error_steps(t_s))],
    );
    let key = [
        (1, "paper, 20,000 steps"),
        (2, "paper, 17,500 steps"),
        (0, "Isostep, 20,000 steps"),
        (3, "Isostep, 17,500 steps"),
    ];
    let key = key.map(|(colour, name)| (CURVE[colour], name.to_owned()));
    Ok(Picture::new(
        "forero-2023-figure-9",
        chart::picture(
            "Two axes: position, and distance from the straight line, over time",
            &key,
            1,
            300,
            &[position, error],
        ),
        "Figure 9: both axes of a diagonal. The paper prints no steps; these cross its workspace of 40 x 35 cm. In the \
         staircase on timers (a model of truncation alone) each axis loses its own steps and gets them back, slowly, \
         at its own end: until then the carriage is off the straight line (below). With one profile for both axes \
         it never strays by more than a step.",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ours_stays_within_a_step_of_the_line_and_the_timers_do_not() {
        assert!(Edges::ours().unwrap().error_max_steps() <= 1.0);
        assert!(Edges::theirs().unwrap().error_max_steps() > 5.0);
    }

    #[test]
    fn every_step_is_made() {
        for edges in [Edges::ours().unwrap(), Edges::theirs().unwrap()] {
            assert_eq!(edges.at(edges.end_s()), (20_000.0, 17_500.0));
            assert_eq!(edges.error_steps(edges.end_s()), 0.0);
        }
    }
}
