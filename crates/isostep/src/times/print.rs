//! The times as text for people.

use super::ratios::{ColumnTimes, Machine, Ratios, Report, Times};
use isostep_sim::AXES;

/// A table for each column, and a summary of all.
pub fn text(report: &Report) -> String {
    let columns: String = report.columns.iter().map(|column| table(column, report.bounds.each)).collect();
    let Report { all, all_of_one_by_one, all_of_fastest, .. } = report;
    columns + "\nall columns\n" + &summary(&[(EXACT, all), (ONE_BY_ONE, all_of_one_by_one), (FASTEST, all_of_fastest)])
}

/// The ratios, as a summary names them.
const EXACT: &str = "exact/Grbl";
const BLENDS: &str = "blends/Grbl";
const ONE_BY_ONE: &str = "blends/one by one";
const FASTEST: &str = "blends/fastest";

fn table(column: &ColumnTimes, each_max: f64) -> String {
    let feeds = if column.is_max_feed { "every feed F12000" } else { "the programs' own feeds" };
    let mut text = format!("\n{}: {}, {feeds}\n", column.name, machine(&column.machine));
    text += &format!(
        "  {:<36} {:>9} {:>9} {EXACT:>10} {:>10} {:>13} {:>9} {BLENDS:>11} {:>10} {FASTEST:>14} {:>15} {:>10}\n",
        "program",
        "Grbl, s",
        "exact, s",
        "jump, mm/s",
        "one by one, s",
        "blends, s",
        "fastest, s",
        "together",
        "beside, mm"
    );
    text += &column.programs.iter().map(|times| row(times, each_max)).collect::<String>();
    let ColumnTimes { ratios, blends, of_one_by_one, of_fastest, .. } = column;
    text + &summary(&[(EXACT, ratios), (BLENDS, blends), (ONE_BY_ONE, of_one_by_one), (FASTEST, of_fastest)])
}

fn row(times: &Times, each_max: f64) -> String {
    let number =
        |value: Option<f64>, decimals: usize| value.map_or("-".to_owned(), |value| format!("{value:.decimals$}"));
    let together = times.moves.zip(times.together);
    let together = together.map_or("-".to_owned(), |(moves, together)| format!("{together} of {moves}"));
    let mark = if times.ratio > Some(each_max) { " *" } else { times.failed.as_deref().unwrap_or("") };
    format!(
        "  {:<36} {:>9.3} {:>9} {:>10} {:>10} {:>13} {:>9} {:>11} {:>10} {:>14} {together:>15} {:>10}{mark}\n",
        times.program,
        times.grbl_s,
        number(times.isostep_s, 3),
        number(times.ratio, 3),
        number(times.jump_mm_s, 2),
        number(times.one_by_one_s, 3),
        number(times.blends_s, 3),
        number(times.blends_ratio, 3),
        number(times.fastest_s, 3),
        number(times.of_fastest, 3),
        number(times.beside_mm, 4),
    )
}

fn summary(ratios: &[(&str, &Option<Ratios>)]) -> String {
    let line = |(name, ratios): &(&str, &Option<Ratios>)| match ratios {
        Some(Ratios { median, worst }) => format!("  {name:<18} median {median:.3}, at most {worst:.3}\n"),
        None => format!("  {name:<18} no program has both times\n"),
    };
    ratios.iter().map(line).collect()
}

/// The machine's figures. A figure that is the same for all axes is given once.
fn machine(machine: &Machine) -> String {
    let each = |values: [f32; AXES]| {
        let is_same = values.iter().all(|value| *value == values[0]);
        if is_same { values[0].to_string() } else { values.map(|value| value.to_string()).join("/") }
    };
    let (steps, top, accel) = (each(machine.steps_per_mm), each(machine.top_speed_mm_min), each(machine.accel_mm_s2));
    format!("{steps} steps/mm, {top} mm/min, {accel} mm/s2")
}
