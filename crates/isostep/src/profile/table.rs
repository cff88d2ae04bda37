//! A table on the screen that compares speed profiles.

use std::fmt::Write as _;

use isostep_report::speed_profiles::{Curve, Step, rows};

/// Steps shown at each end of a single speed profile.
const ENDS: usize = 5;
const LABEL: usize = 46;
const COLUMN_MIN: usize = 14;

/// The table, and for a single speed profile its first and last steps.
pub fn table(curves: &[Curve]) -> String {
    let mut text = String::new();
    let rows = rows(curves);
    let widths: Vec<usize> = (0..curves.len())
        .map(|column| {
            let cells = rows.iter().map(|row| row.cells[column].len());
            cells.chain([curves[column].name.len(), COLUMN_MIN]).max().unwrap_or(COLUMN_MIN) + 2
        })
        .collect();
    let names: Vec<String> = curves.iter().map(|curve| curve.name.clone()).collect();
    line(&mut text, "", &names, &widths);
    for row in &rows {
        line(&mut text, row.name, &row.cells, &widths);
    }
    if let [curve] = curves {
        text.push_str(&ends(&curve.steps));
    }
    text
}

fn line(text: &mut String, name: &str, cells: &[String], widths: &[usize]) {
    let _ = write!(text, "{name:<LABEL$}");
    for (cell, width) in cells.iter().zip(widths) {
        let _ = write!(text, "{cell:>width$}");
    }
    text.push('\n');
}

/// The first and the last steps.
fn ends(steps: &[Step]) -> String {
    let mut text = format!("\n{:>10} {:>18} {:>16} {:>16}\n", "step", "t_us", "period_us", "frequency_hz");
    for (index, step) in steps.iter().enumerate() {
        if index == ENDS && steps.len() > 2 * ENDS {
            text.push_str("       ...\n");
        }
        if index < ENDS || index + ENDS >= steps.len() {
            let cell = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.3}"));
            let (period, frequency) = (cell(step.period_us), cell(step.frequency_hz));
            let _ = writeln!(text, "{:>10} {:>18.3} {period:>16} {frequency:>16}", index + 1, step.t_us);
        }
    }
    text
}
