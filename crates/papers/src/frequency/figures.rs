//! Fonseca-Campos's figures 7, 10, 11 and 12, simulated with the paper's truncation and without it.

use anyhow::Result;
use isostep_generators::FrequencyRamp;
use isostep_report::pictures::chart::{self, Axis, Chart, Curve, Style};
use isostep_report::pictures::document::{Picture, Table};
use isostep_report::pictures::profile;
use isostep_report::pictures::theme::{CURVE, Colour};
use isostep_report::speed_profiles::peak;

use super::parameters::{Parameters, TABLE_1, TABLE_2, TABLE_4};
use crate::row::{Paper, Row};

/// One profile with the parameters of one table.
struct Simulated {
    frequency_ramp: FrequencyRamp,
    exact: profile::Curve,
    truncated: profile::Curve,
}

/// A quantity over time.
type Quantity = fn(&profile::Curve) -> &[(f64, f64)];

fn simulate(table: &Parameters) -> Result<Vec<Simulated>> {
    let one = |frequency_ramp| {
        Ok(Simulated {
            frequency_ramp,
            exact: table.exact_curve(frequency_ramp)?,
            truncated: table.truncated_curve(frequency_ramp)?,
        })
    };
    FrequencyRamp::ALL.into_iter().map(one).collect()
}

/// The paper's observations in its figures.
pub fn rows() -> Result<Vec<Row>> {
    let frequency_ramps = simulate(&TABLE_1)?;
    let place = "VI.A, figure 7";
    let most =
        |quantity: Quantity| extreme(&frequency_ramps, |frequency_ramp| peak(quantity(&frequency_ramp.truncated)));
    let smoothest = extreme(&frequency_ramps, |frequency_ramp| -greatest_change(&frequency_ramp.truncated.accel));
    let ask = |quantity: &str| Paper::Frequency.asks(place, quantity);
    let says = |quantity: &str, says: FrequencyRamp, found: FrequencyRamp| {
        ask(quantity).says(says.name(), found.name(), says == found)
    };
    let first = frequency_ramps.iter().map(|frequency_ramp| frequency_ramp.truncated.speed[0].1);
    let (low, high) = first.fold((f64::MAX, f64::MIN), |(low, high), speed| (low.min(speed), high.max(speed)));
    let spread = format!("{low:.1} to {high:.1} deg/s, and all profiles begin at 56.25");
    Ok(vec![
        says("greatest acceleration, Table 1", FrequencyRamp::Quadratic, most(|frequency_ramp| &frequency_ramp.accel)),
        says("greatest jerk, Table 1", FrequencyRamp::Quadratic, most(|frequency_ramp| &frequency_ramp.jerk)),
        says("smoothest acceleration (least change in a step), Table 1", FrequencyRamp::Sinusoidal, smoothest),
        ask("first speeds, by differences, Table 1").says("do not match", spread, high - low > 1.0),
        noise()?,
    ])
}

fn extreme(frequency_ramps: &[Simulated], value: impl Fn(&Simulated) -> f64) -> FrequencyRamp {
    let greatest = frequency_ramps.iter().max_by(|one, other| value(one).total_cmp(&value(other)));
    greatest.map_or(FrequencyRamp::Linear, |frequency_ramp| frequency_ramp.frequency_ramp)
}

/// The largest change from sample to sample, including standstill before the first and after the last.
fn greatest_change(points: &[(f64, f64)]) -> f64 {
    let ends = [points.first(), points.last()].into_iter().flatten().map(|point| point.1.abs());
    points.windows(2).map(|pair| (pair[1].1 - pair[0].1).abs()).chain(ends).fold(0.0, f64::max)
}

/// "Low amplitude noise owing to the truncation": how far the truncated acceleration is from the exact one.
fn noise() -> Result<Row> {
    let frequency_ramps = simulate(&TABLE_4)?;
    let shares = frequency_ramps.iter().map(|frequency_ramp| {
        let squares = frequency_ramp
            .truncated
            .accel
            .iter()
            .zip(&frequency_ramp.exact.accel)
            .map(|(one, other)| (one.1 - other.1).powi(2));
        (squares.sum::<f64>() / frequency_ramp.exact.accel.len() as f64).sqrt() / peak(&frequency_ramp.exact.accel)
    });
    let greatest = 100.0 * shares.fold(0.0, f64::max);
    let found = format!("rms up to {greatest:.0} % of the peak; none when exact");
    let ask = Paper::Frequency.asks("VI.E, figure 12", "noise of the acceleration by truncation, Table 4");
    Ok(ask.says("of low amplitude", found, greatest < 10.0))
}

/// The peak values of each profile with Table 1.
pub fn table() -> Result<Table> {
    let rows = simulate(&TABLE_1)?.into_iter().map(|frequency_ramp| {
        let pair = |quantity: Quantity, decimals: usize| {
            [&frequency_ramp.exact, &frequency_ramp.truncated]
                .map(|curve| format!("{:.decimals$}", peak(quantity(curve))))
        };
        let changes = [&frequency_ramp.exact, &frequency_ramp.truncated]
            .map(|curve| format!("{:.0}", greatest_change(&curve.accel)));
        let values =
            [pair(|curve| &curve.speed, 1), pair(|curve| &curve.accel, 0), pair(|curve| &curve.jerk, 0), changes];
        [frequency_ramp.frequency_ramp.name().to_owned()].into_iter().chain(values.into_iter().flatten()).collect()
    });
    let head = [
        "profile",
        "speed, deg/s",
        "as printed",
        "acceleration, deg/s²",
        "as printed",
        "jerk, deg/s³",
        "as printed",
        "change of acceleration in a step, deg/s²",
        "as printed",
    ];
    let caption = "Table 1, figure 7: highest magnitudes, by second-order differences, exact and as printed";
    Ok(Table::new(&head, rows.collect()).captioned(caption))
}

/// Figures 7, 10, 11 and 12.
pub fn pictures() -> Result<Vec<Picture>> {
    Ok(vec![figure_7()?, figure_10()?, figure_11()?, figure_12()?])
}

/// The key: each profile's colour and name.
pub fn key() -> Vec<(Colour, String)> {
    chart::key(FrequencyRamp::ALL.map(|frequency_ramp| frequency_ramp.name()))
}

fn figure_7() -> Result<Picture> {
    let frequency_ramps = simulate(&TABLE_1)?;
    let chart = |name: &str, quantity: Quantity| {
        let curves = frequency_ramps.iter().enumerate().flat_map(|(colour, frequency_ramp)| {
            let points = |curve| quantity(curve).iter().copied();
            [
                Curve::line(CURVE[colour], points(&frequency_ramp.exact)),
                Curve::dots(CURVE[colour], points(&frequency_ramp.truncated)),
            ]
        });
        Chart::new("time, s", name, curves.collect())
    };
    let panels = [
        chart("position, deg", |curve| &curve.position),
        chart("speed, deg/s", |curve| &curve.speed),
        chart("acceleration, deg/s²", |curve| &curve.accel),
        chart("jerk, deg/s³", |curve| &curve.jerk),
    ];
    Ok(Picture::new(
        "fonseca-campos-2023-figure-7",
        chart::picture(
            "Position, speed, acceleration and jerk of the four profiles of Table 1",
            &key(),
            2,
            300,
            &panels,
        ),
        "Figure 7: Table 1, a ramp of 24 of 120 steps. Lines: exact periods; dots: the program's even \
         microseconds. All four profiles rise over the same number of steps, not over the same time: whoever is fast early \
         is through early, so the logarithmic profile is there first, and pays with a jolt at the very start and end. \
         The quadratic profile is slow over most of the ramp and hurries at its top. Only the sinusoidal profile's \
         acceleration begins and ends without a jump.",
    ))
}

fn figure_10() -> Result<Picture> {
    let frequency_ramps = simulate(&TABLE_1)?;
    let charts_of = frequency_ramps.iter().enumerate().map(|(colour, frequency_ramp)| {
        let line = Curve::line(CURVE[colour], frequency_ramp.truncated.position.iter().copied());
        Chart::new("time, s", format!("{}, deg", frequency_ramp.frequency_ramp.name()), vec![line])
    });
    Ok(Picture::new(
        "fonseca-campos-2023-figure-10",
        chart::picture(
            "Position over time of the four profiles of Table 1",
            &[],
            2,
            220,
            &charts_of.collect::<Vec<_>>(),
        ),
        "Figure 10: position over time by Table 1, the paper's simulated curves. Its measured dots need its \
         encoder; the paper finds them \"very similar\", later with MicroPython than with the compiled program.",
    ))
}

fn figure_11() -> Result<Picture> {
    let frequency_ramps = simulate(&TABLE_2)?;
    let curves = frequency_ramps.iter().enumerate().map(|(colour, frequency_ramp)| {
        let highest = peak(&frequency_ramp.exact.speed).max(f64::MIN_POSITIVE);
        Curve::line(CURVE[colour], frequency_ramp.exact.speed.iter().map(|&(t_s, speed)| (t_s, speed / highest)))
    });
    let chart = Chart::new("time, s", "speed, share of the highest", curves.collect());
    Ok(Picture::new(
        "fonseca-campos-2023-figure-11",
        chart::picture("Normalised speed of the four profiles of Table 2", &key(), 1, 320, &[chart]),
        "Figure 11: speed by Table 2, normalised as the paper does, over each other instead of side by side. A move \
         does not start from rest: the first period is tau_max, so the speed jumps to a tenth of its top at once, \
         which the paper's gyroscope cannot follow either.",
    ))
}

fn figure_12() -> Result<Picture> {
    let frequency_ramps = simulate(&TABLE_4)?;
    let charts_of = frequency_ramps.iter().enumerate().map(|(colour, frequency_ramp)| {
        let scale = 1.0 / peak(&frequency_ramp.exact.accel).max(f64::MIN_POSITIVE);
        let scaled =
            |curve: &profile::Curve| curve.accel.iter().map(|&(t_s, accel)| (t_s, accel * scale)).collect::<Vec<_>>();
        let curves = vec![
            Curve::new(Style::Thin, CURVE[4], scaled(&frequency_ramp.truncated)),
            Curve::line(CURVE[colour], scaled(&frequency_ramp.exact)),
        ];
        Chart::new("time, s", Axis::from(frequency_ramp.frequency_ramp.name()).within(-1.8, 1.8), curves)
    });
    Ok(Picture::new(
        "fonseca-campos-2023-figure-12",
        chart::picture(
            "Normalised acceleration of the four profiles of Table 4",
            &[key(), vec![(CURVE[4], "as printed, even microseconds".to_owned())]].concat(),
            2,
            260,
            &charts_of.collect::<Vec<_>>(),
        ),
        "Figure 12: acceleration by Table 4, in shares of the exact profile's highest. At 300 us a microsecond more or \
         less is a third of a percent of the speed, from one step to the next: the derivative turns it into noise. \
         Exact instants (coloured) have none.",
    ))
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
