//! The times as text for people.

use super::ratios::{ColumnTimes, Machine, Ratios, Report, Times};
use isostep_sim::AXES;

/// A table for each column, and a summary of all.
pub fn text(report: &Report) -> String {
    let columns: String = report.columns.iter().map(|column| table(column, report.bounds.each)).collect();
    columns + &summary("all", report.all)
}

fn table(column: &ColumnTimes, each_max: f64) -> String {
    let feeds = if column.is_max_feed { "every feed F12000" } else { "the programs' own feeds" };
    let mut text = format!("\n{}: {}, {feeds}\n", column.name, machine(&column.machine));
    text += &format!(
        "  {:<40} {:>12} {:>12} {:>8} {:>12} {:>8} {:>20}\n",
        "program", "Isostep, s", "Grbl, s", "ratio", "blends, s", "ratio", "corner's jump, mm/s"
    );
    text += &column.programs.iter().map(|times| row(times, each_max)).collect::<String>();
    text + &summary(&column.name, column.ratios) + &summary(&format!("{}, blends", column.name), column.blends)
}

fn row(times: &Times, each_max: f64) -> String {
    let Times { program, grbl_s, .. } = times;
    match (times.isostep_s.zip(times.ratio), times.blends_s.zip(times.blends_ratio), times.jump_mm_s) {
        (Some((isostep_s, ratio)), Some((blends_s, blends_ratio)), Some(jump_mm_s)) => {
            let mark = if ratio > each_max { " *" } else { "" };
            format!(
                "  {program:<40} {isostep_s:>12.3} {grbl_s:>12.3} {ratio:>8.3} {blends_s:>12.3} {blends_ratio:>8.3} {jump_mm_s:>20.2}{mark}\n"
            )
        }
        _ => {
            format!("  {program:<40} {:>12} {grbl_s:>12.3} {:>8} {}\n", "-", "-", times.failed.as_deref().unwrap_or(""))
        }
    }
}

fn summary(name: &str, ratios: Option<Ratios>) -> String {
    ratios.map_or(format!("  {name}: no program came to its end\n"), |Ratios { median, worst }| {
        format!("  {:<40} {:>12} {median:>12.3}   worst {worst:>8.3}\n", name, "median")
    })
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
