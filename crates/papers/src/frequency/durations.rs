//! The duration of each profile, exact and truncated as in the paper, and how much time the logarithmic one saves.

use anyhow::Result;
use isostep_generators::FrequencyRamp;
use isostep_report::pictures::document::Table;

use super::parameters::{Parameters, TABLE_1, TABLE_2, TABLES};
use crate::row::{Paper, Row};

/// Durations of one profile with the parameters of one table, s.
#[derive(Clone, Copy, Debug)]
pub struct Durations {
    /// The sum of 1/f\[i\].
    pub exact_s: f64,
    /// The sum of the truncated periods, which are even numbers of us.
    pub truncated_s: f64,
}

/// The durations of `frequency_ramp` with the parameters of `table`.
pub fn durations(table: &Parameters, frequency_ramp: FrequencyRamp) -> Result<Durations> {
    let truncated_s = table.truncated(frequency_ramp)?.duration_us() as f64 * 1e-6;
    Ok(Durations { exact_s: table.exact(frequency_ramp)?.duration_s(), truncated_s })
}

/// The paper's statements about durations.
pub fn rows() -> Result<Vec<Row>> {
    let mut rows = vec![
        order("VI.A, figures 7 and 10", &TABLE_1, "logarithmic < linear < sinusoidal < quadratic")?,
        extremes("VI.D, figure 11", &TABLE_2)?,
    ];
    for (frequency_ramp, printed) in
        [(FrequencyRamp::Linear, 10.0), (FrequencyRamp::Sinusoidal, 12.0), (FrequencyRamp::Quadratic, 18.0)]
    {
        rows.extend(saved(frequency_ramp, printed)?);
    }
    Ok(rows)
}

/// The profiles from the shortest to the longest duration.
fn ordered(table: &Parameters) -> Result<Vec<FrequencyRamp>> {
    let mut frequency_ramps = Vec::new();
    for frequency_ramp in FrequencyRamp::ALL {
        frequency_ramps.push((durations(table, frequency_ramp)?.truncated_s, frequency_ramp));
    }
    frequency_ramps.sort_by(|one, other| one.0.total_cmp(&other.0));
    Ok(frequency_ramps.into_iter().map(|(_, frequency_ramp)| frequency_ramp).collect())
}

fn order(place: &'static str, table: &Parameters, says: &str) -> Result<Row> {
    let found = ordered(table)?.iter().map(|frequency_ramp| frequency_ramp.name()).collect::<Vec<_>>().join(" < ");
    Ok(Paper::Frequency.asks(place, format!("durations, {}", table.name)).says(says, &found, found == says))
}

fn extremes(place: &'static str, table: &Parameters) -> Result<Row> {
    let frequency_ramps = ordered(table)?;
    let found = format!("{} fastest, {} slowest", frequency_ramps[0], frequency_ramps[3]);
    let says = "logarithmic fastest, quadratic slowest";
    Ok(Paper::Frequency.asks(place, format!("durations, {}", table.name)).says(says, &found, found == says))
}

/// The paper does not say what its percentage refers to: the slower profile's time or the logarithmic one's.
fn saved(than: FrequencyRamp, printed: f64) -> Result<[Row; 2]> {
    let ours = |of: fn(Durations, Durations) -> f64| -> Result<f64> {
        Ok(100.0 * of(durations(&TABLE_1, FrequencyRamp::Logarithmic)?, durations(&TABLE_1, than)?))
    };
    let ask = |of: FrequencyRamp| {
        let quantity = format!("logarithmic against {than}, Table 1: saved of the {of} time");
        Paper::Frequency.asks("VI.A, VI.G", quantity).number("%", 2)
    };
    Ok([
        ask(than).printed(printed, ours(|fast, slow| 1.0 - fast.exact_s / slow.exact_s)?),
        ask(FrequencyRamp::Logarithmic).printed(printed, ours(|fast, slow| slow.exact_s / fast.exact_s - 1.0)?),
    ])
}

/// The durations of all profiles with all tables.
pub fn table() -> Result<Table> {
    let mut rows = Vec::new();
    for table in &TABLES {
        for frequency_ramp in FrequencyRamp::ALL {
            let Durations { exact_s, truncated_s } = durations(table, frequency_ramp)?;
            let short_us = (exact_s - truncated_s) * 1e6;
            rows.push(vec![
                table.name.to_owned(),
                table.steps().to_string(),
                table.ramp_steps().to_string(),
                frequency_ramp.name().to_owned(),
                format!("{exact_s:.6}"),
                format!("{truncated_s:.6}"),
                format!("{short_us:.1}"),
            ]);
        }
    }
    let head = ["parameters", "N", "p_N", "profile", "exact, s", "as printed, s", "runs ahead, us"];
    let caption = "Durations: the sum of all N periods, exact and cut down to even microseconds";
    Ok(Table::new(&head, rows).captioned(caption))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::Cell;

    #[test]
    fn the_papers_percentages_are_of_the_slower_time() {
        let rows = rows().unwrap();
        let difference = |index: usize| match rows[index].difference {
            Cell::Number(value) => value.abs(),
            ref other => panic!("{other:?}"),
        };
        for (of_slower, of_faster) in [(2, 3), (4, 5), (6, 7)] {
            assert!(difference(of_slower) < 0.5 && difference(of_faster) > 1.0, "{}", rows[of_slower].quantity);
        }
    }

    #[test]
    fn the_order_of_the_frequency_ramps_is_the_papers() {
        assert!(rows().unwrap()[..2].iter().all(|row| row.difference == Cell::Words("none".to_owned())));
    }

    /// The sums of Table 1 were computed independently, in NumPy.
    #[test]
    fn durations_of_table_1() {
        let wanted = [
            (0.222_678_167, 0.222_632),
            (0.243_700_268, 0.243_660),
            (0.227_126_018, 0.227_080),
            (0.200_609_771, 0.200_564),
        ];
        for (frequency_ramp, (exact_s, truncated_s)) in FrequencyRamp::ALL.into_iter().zip(wanted) {
            let found = durations(&TABLE_1, frequency_ramp).unwrap();
            assert!(
                (found.exact_s - exact_s).abs() < 1e-9 && (found.truncated_s - truncated_s).abs() < 1e-12,
                "{frequency_ramp}"
            );
        }
    }
}
