//! Fonseca-Campos's figures 7, 10, 11 and 12, simulated with the paper's truncation and without it.

use crate::drawing::{Chart, Curve, Picture, Style, Table, charts};
use anyhow::Result;
use isostep_generators::FrequencyLaw;

use super::kinematics::{Kinematics, normalised, peak};
use super::parameters::{Parameters, TABLE_1, TABLE_2, TABLE_4};
use crate::row::{Paper, Row};

/// One law with the parameters of one table.
struct Simulated {
    law: FrequencyLaw,
    exact: Kinematics,
    truncated: Kinematics,
}

/// A column of [`Kinematics`].
type Quantity = fn(&Kinematics) -> &[f64];

fn simulate(table: &Parameters) -> Result<Vec<Simulated>> {
    let one = |law| {
        let exact = Kinematics::exact(&table.exact(law)?, table.step_deg());
        let truncated = Kinematics::truncated(&table.truncated(law)?, table.step_deg());
        Ok(Simulated { law, exact, truncated })
    };
    FrequencyLaw::ALL.into_iter().map(one).collect()
}

/// What the paper observes in its figures.
pub fn rows() -> Result<Vec<Row>> {
    let laws = simulate(&TABLE_1)?;
    let place = "VI.A, figure 7";
    let most = |quantity: Quantity| extreme(&laws, |law| peak(quantity(&law.truncated)));
    let smoothest = extreme(&laws, |law| -greatest_change(&law.truncated.accel));
    let ask = |quantity: &str| Paper::Frequency.asks(place, quantity);
    let says = |quantity: &str, says: FrequencyLaw, found: FrequencyLaw| {
        ask(quantity).says(says.name(), found.name(), says == found)
    };
    let first = laws.iter().map(|law| law.truncated.speed[0]);
    let (low, high) = first.fold((f64::MAX, f64::MIN), |(low, high), speed| (low.min(speed), high.max(speed)));
    let spread = format!("{low:.1} to {high:.1} deg/s, and all laws begin at 56.25");
    Ok(vec![
        says("greatest acceleration, Table 1", FrequencyLaw::Quadratic, most(|law| &law.accel)),
        says("greatest jerk, Table 1", FrequencyLaw::Quadratic, most(|law| &law.jerk)),
        says("smoothest acceleration (least change in a step), Table 1", FrequencyLaw::Sinusoidal, smoothest),
        ask("first speeds, by differences, Table 1").says("do not match", spread, high - low > 1.0),
        noise()?,
    ])
}

fn extreme(laws: &[Simulated], value: impl Fn(&Simulated) -> f64) -> FrequencyLaw {
    let greatest = laws.iter().max_by(|one, other| value(one).total_cmp(&value(other)));
    greatest.map_or(FrequencyLaw::Linear, |law| law.law)
}

/// The largest change from sample to sample, including standstill before the first and after the last.
fn greatest_change(values: &[f64]) -> f64 {
    let ends = [values.first(), values.last()].into_iter().flatten().map(|value| value.abs());
    values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).chain(ends).fold(0.0, f64::max)
}

/// "Low amplitude noise owing to the truncation": how far the truncated acceleration is from the exact one.
fn noise() -> Result<Row> {
    let laws = simulate(&TABLE_4)?;
    let shares = laws.iter().map(|law| {
        let squares = law.truncated.accel.iter().zip(&law.exact.accel).map(|(one, other)| (one - other).powi(2));
        (squares.sum::<f64>() / law.exact.accel.len() as f64).sqrt() / peak(&law.exact.accel)
    });
    let greatest = 100.0 * shares.fold(0.0, f64::max);
    let found = format!("rms up to {greatest:.0} % of the peak; none when exact");
    let ask = Paper::Frequency.asks("VI.E, figure 12", "noise of the acceleration by truncation, Table 4");
    Ok(ask.says("of low amplitude", found, greatest < 10.0))
}

/// The peak values of each law with Table 1.
pub fn table() -> Result<Table> {
    let rows = simulate(&TABLE_1)?.into_iter().map(|law| {
        let pair = |quantity: Quantity, decimals: usize| {
            [&law.exact, &law.truncated].map(|curve| format!("{:.decimals$}", peak(quantity(curve))))
        };
        let changes = [&law.exact, &law.truncated].map(|curve| format!("{:.0}", greatest_change(&curve.accel)));
        let values =
            [pair(|curve| &curve.speed, 1), pair(|curve| &curve.accel, 0), pair(|curve| &curve.jerk, 0), changes];
        [law.law.name().to_owned()].into_iter().chain(values.into_iter().flatten()).collect()
    });
    let head = [
        "law",
        "speed, deg/s",
        "as printed",
        "acceleration, deg/s²",
        "as printed",
        "jerk, deg/s³",
        "as printed",
        "change of acceleration in a step, deg/s²",
        "as printed",
    ];
    Ok(Table {
        caption: "Table 1, figure 7: highest magnitudes, by second-order differences, exact and as printed".to_owned(),
        head: head.map(str::to_owned).to_vec(),
        rows: rows.collect(),
    })
}

/// Figures 7, 10, 11 and 12.
pub fn pictures() -> Result<Vec<Picture>> {
    Ok(vec![figure_7()?, figure_10()?, figure_11()?, figure_12()?])
}

fn key() -> Vec<(usize, String)> {
    FrequencyLaw::ALL.into_iter().enumerate().map(|(colour, law)| (colour, law.name().to_owned())).collect()
}

fn figure_7() -> Result<Picture> {
    let laws = simulate(&TABLE_1)?;
    let chart = |name: &str, quantity: Quantity| {
        let curves = laws.iter().enumerate().flat_map(|(colour, law)| {
            let line = Curve { colour, style: Style::Line, points: law.exact.over_time(quantity(&law.exact)) };
            let dots = law.truncated.over_time(quantity(&law.truncated));
            [line, Curve { colour, style: Style::Dots, points: dots }]
        });
        Chart { x_name: "time, s".to_owned(), y_name: name.to_owned(), curves: curves.collect(), ..Chart::default() }
    };
    let panels = [
        chart("position, deg", |curve| &curve.position),
        chart("speed, deg/s", |curve| &curve.speed),
        chart("acceleration, deg/s²", |curve| &curve.accel),
        chart("jerk, deg/s³", |curve| &curve.jerk),
    ];
    Ok(Picture {
        name: "fonseca-campos-2023-figure-7".to_owned(),
        svg: charts("Position, speed, acceleration and jerk of the four laws of Table 1", 2, 300, &panels),
        key: key(),
        caption: "Figure 7: Table 1, a ramp of 24 of 120 steps. Lines: exact periods; dots: the program's even \
                  microseconds. All four laws rise over the same number of steps, not over the same time: whoever is fast early \
                  is through early, so the logarithmic law is there first, and pays with a jolt at the very start and end. \
                  The quadratic law is slow over most of the ramp and hurries at its top. Only the sinusoidal law's \
                  acceleration begins and ends without a jump."
            .to_owned(),
    })
}

fn figure_10() -> Result<Picture> {
    let laws = simulate(&TABLE_1)?;
    let charts_of = laws.iter().enumerate().map(|(colour, law)| {
        let points = law.truncated.over_time(&law.truncated.position);
        Chart {
            x_name: "time, s".to_owned(),
            y_name: format!("{}, deg", law.law.name()),
            curves: vec![Curve { colour, style: Style::Line, points }],
            ..Chart::default()
        }
    });
    Ok(Picture {
        name: "fonseca-campos-2023-figure-10".to_owned(),
        svg: charts("Position over time of the four laws of Table 1", 2, 220, &charts_of.collect::<Vec<_>>()),
        key: Vec::new(),
        caption: "Figure 10: position over time by Table 1, the paper's simulated curves. Its measured dots need its \
                  encoder; the paper finds them \"very similar\", later with MicroPython than with the compiled program."
            .to_owned(),
    })
}

fn figure_11() -> Result<Picture> {
    let laws = simulate(&TABLE_2)?;
    let curves = laws.iter().enumerate().map(|(colour, law)| {
        let points = law.exact.over_time(&normalised(&law.exact.speed));
        Curve { colour, style: Style::Line, points }
    });
    let chart = Chart {
        x_name: "time, s".to_owned(),
        y_name: "speed, share of the highest".to_owned(),
        curves: curves.collect(),
        ..Chart::default()
    };
    Ok(Picture {
        name: "fonseca-campos-2023-figure-11".to_owned(),
        svg: charts("Normalised speed of the four laws of Table 2", 1, 320, &[chart]),
        key: key(),
        caption: "Figure 11: speed by Table 2, normalised as the paper does, over each other instead of side by side. A move \
                  does not start from rest: the first period is tau_max, so the speed jumps to a tenth of its top at once, \
                  which the paper's gyroscope cannot follow either."
            .to_owned(),
    })
}

fn figure_12() -> Result<Picture> {
    let laws = simulate(&TABLE_4)?;
    let charts_of = laws.iter().enumerate().map(|(colour, law)| {
        let scale = 1.0 / peak(&law.exact.accel).max(f64::MIN_POSITIVE);
        let scaled = |curve: &Kinematics| {
            curve.t_s.iter().zip(&curve.accel).map(|(&t_s, accel)| (t_s, accel * scale)).collect::<Vec<_>>()
        };
        Chart {
            x_name: "time, s".to_owned(),
            y_name: law.law.name().to_owned(),
            curves: vec![
                Curve { colour: 4, style: Style::Thin, points: scaled(&law.truncated) },
                Curve { colour, style: Style::Line, points: scaled(&law.exact) },
            ],
            range: Some((-1.8, 1.8)),
            ..Chart::default()
        }
    });
    Ok(Picture {
        name: "fonseca-campos-2023-figure-12".to_owned(),
        svg: charts("Normalised acceleration of the four laws of Table 4", 2, 260, &charts_of.collect::<Vec<_>>()),
        key: key().into_iter().chain([(4, "as printed, even microseconds".to_owned())]).collect(),
        caption: "Figure 12: acceleration by Table 4, in shares of the exact law's highest. At 300 us a microsecond more or \
                  less is a third of a percent of the speed, from one step to the next: the derivative turns it into noise. \
                  Exact instants (coloured) have none."
            .to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_figure_is_drawn() {
        for picture in pictures().unwrap() {
            assert!(picture.svg.contains("<polyline") && !picture.caption.is_empty(), "{}", picture.name);
        }
    }
}
