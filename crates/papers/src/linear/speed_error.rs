//! How closely the generators' speed follows the linear law.

use anyhow::Result;
use isostep_report::pictures::chart::{self, Axis, Chart, Curve};
use isostep_report::pictures::document::{Picture, Table};
use isostep_report::pictures::theme::{CURVE, Colour};

use super::generators::{NAMES, generators, law};
use super::motor::{SLOW_START_RAD_S, START_RAD_S};
use crate::row::{Paper, Row, signed};

const STARTS: [(f64, &str); 2] = [(START_RAD_S, "v_s = 0.5 rad/s"), (SLOW_START_RAD_S, "v_s = 0.08 rad/s")];

/// Indices of generators in [`NAMES`].
const WITHOUT: usize = 1;
const WITH: usize = 2;
const STEPS_PER_TIME: usize = 3;

/// The largest error of each generator, %, in the order of [`NAMES`].
fn worst_errors(start_rad_s: f64) -> Result<Vec<f64>> {
    let law = law(start_rad_s)?;
    Ok(generators(start_rad_s)?.iter().map(|generator| worst(&generator.errors_percent(&law))).collect())
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
        let law = law(start_rad_s)?;
        for generator in generators(start_rad_s)? {
            let errors = generator.errors_percent(&law);
            let late_ms = generator.late_s(&law) * 1e3;
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
    Ok(Table {
        caption: "Speed of each interval against the linear law, one revolution".to_owned(),
        ..Table::new(&head, rows)
    })
}

/// The error of every interval.
pub fn picture() -> Result<Picture> {
    let law = law(START_RAD_S)?;
    let curves: Vec<Curve> = generators(START_RAD_S)?
        .iter()
        .enumerate()
        .rev()
        .map(|(colour, generator)| {
            let errors = generator.errors_percent(&law).into_iter().enumerate();
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
}
