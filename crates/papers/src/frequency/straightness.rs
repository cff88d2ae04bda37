//! The reason why the linear profile's speed over time is not a straight line (Fonseca-Campos 2023, section VI.A).

use anyhow::Result;
use isostep_generators::FrequencyRamp;
use isostep_report::pictures::chart::{self, Chart, Curve};
use isostep_report::pictures::document::Picture;
use isostep_report::pictures::theme::CURVE;

use super::parameters::{Parameters, TABLE_1};
use crate::row::{Paper, Row};

/// The acceleration phase of the linear profile.
struct Ramp {
    /// The middle of each period, s.
    t_s: Vec<f64>,
    /// f\[i\], i = 1 to p_N.
    hz: Vec<f64>,
}

impl Ramp {
    fn exact(table: &Parameters) -> Result<Self> {
        let profile = table.exact(FrequencyRamp::Linear)?;
        Ok(Self::new((1..=table.ramp_steps()).map(|i| profile.period_s(i))))
    }

    fn truncated(table: &Parameters) -> Result<Self> {
        let profile = table.truncated(FrequencyRamp::Linear)?;
        Ok(Self::new((1..=table.ramp_steps()).map(|i| f64::from(profile.period_us(i)) * 1e-6)))
    }

    fn new(periods_s: impl Iterator<Item = f64>) -> Self {
        let (mut t_s, mut hz, mut end_s) = (Vec::new(), Vec::new(), 0.0);
        for period_s in periods_s {
            t_s.push(end_s + period_s / 2.0);
            hz.push(1.0 / period_s);
            end_s += period_s;
        }
        Self { t_s, hz }
    }

    /// The largest distance of the speed from the chord between its ends, in % of the top frequency.
    fn bend_percent(&self, along: &[f64]) -> f64 {
        let last = along.len() - 1;
        let slope = (self.hz[last] - self.hz[0]) / (along[last] - along[0]);
        let distances = along.iter().zip(&self.hz).map(|(x, hz)| (hz - self.hz[0] - slope * (x - along[0])).abs());
        100.0 * distances.fold(0.0, f64::max) / self.hz[last]
    }

    fn steps(&self) -> Vec<f64> {
        (1..=self.hz.len()).map(|i| i as f64).collect()
    }

    fn over(&self, along: &[f64]) -> Vec<(f64, f64)> {
        along.iter().copied().zip(self.hz.iter().copied()).collect()
    }
}

/// The paper's statement, and the cause of the bend.
pub fn rows() -> Result<Vec<Row>> {
    let (exact, truncated) = (Ramp::exact(&TABLE_1)?, Ramp::truncated(&TABLE_1)?);
    let ask = |along: &str| {
        let quantity = format!("linear profile, Table 1: bend of its speed over {along}, of the top");
        Paper::Frequency.asks("VI.A, figure 7", quantity).number("%", 3)
    };
    let over_time = [truncated.bend_percent(&truncated.t_s), exact.bend_percent(&exact.t_s)];
    let over_steps = [truncated.bend_percent(&truncated.steps()), exact.bend_percent(&exact.steps())];
    let found = "the profile itself: straight over steps is exponential over time; truncation adds little";
    let cause = Paper::Frequency.asks("VI.A, figure 7", "what bends the linear profile's speed over time");
    Ok(vec![
        ask("time").by_method(over_time[0], over_time[1]),
        ask("steps").by_method(over_steps[0], over_steps[1]),
        cause.says("periods of whole microseconds", found, over_time[1] < over_steps[0]),
    ])
}

/// The ramp over time and over steps.
pub fn picture() -> Result<Picture> {
    let (exact, truncated) = (Ramp::exact(&TABLE_1)?, Ramp::truncated(&TABLE_1)?);
    let chart = |x_name: &str, exact_along: &[f64], truncated_along: &[f64]| {
        let line = exact.over(exact_along);
        let ends = [line[0], line[line.len() - 1]];
        let curves = vec![
            Curve::dashed(CURVE[6], ends),
            Curve::line(CURVE[0], line),
            Curve::dots(CURVE[1], truncated.over(truncated_along)),
        ];
        Chart::new(x_name, "frequency, Hz", curves)
    };
    let over_time = chart("time, s", &exact.t_s, &truncated.t_s);
    let over_steps = chart("step", &exact.steps(), &truncated.steps());
    let key = [(0, "exact"), (1, "as printed, even microseconds"), (6, "straight line")];
    let key = key.map(|(colour, name)| (CURVE[colour], name.to_owned()));
    Ok(Picture::new(
        "fonseca-campos-2023-linear-ramp",
        chart::picture(
            "Acceleration of the linear profile over time and over steps",
            &key,
            2,
            300,
            &[over_time, over_steps],
        ),
        "Table 1's linear profile while it accelerates. Its frequency rises by the same amount every step (right), and \
         steps come faster and faster, so over time it rises exponentially (left): f' = f df/di. So its acceleration \
         grows along the ramp, and is no step as a trapezoid's is. The paper lays the bend to periods of whole \
         microseconds; exact periods bend as much. Truncation moves a dot by less than its own size.",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: f = f_min e^(kt) from 250 to 666.7 Hz. With r = 8/3 the slope equals that of the chord, (r - 1)/ln r =
    /// 1.6992, at f = 1.6992 f_min. The chord is at 1 + 1.6992 ln 1.6992 = 1.9009 there: 0.2017 f_min above, which is
    /// 7.56 % of 8/3 f_min.
    #[test]
    fn the_exact_frequency_ramp_bends_over_time_as_an_exponential_does() {
        let exact = Ramp::exact(&TABLE_1).unwrap();
        assert!((exact.bend_percent(&exact.t_s) - 7.56).abs() < 0.1, "{}", exact.bend_percent(&exact.t_s));
        assert!(exact.bend_percent(&exact.steps()) < 1e-9);
    }

    #[test]
    fn truncation_bends_it_by_less_than_a_period_of_2_us() {
        let truncated = Ramp::truncated(&TABLE_1).unwrap();
        let bend = truncated.bend_percent(&truncated.steps());
        assert!((0.01..100.0 * 2.0 / 1_500.0).contains(&bend), "{bend}");
    }
}
