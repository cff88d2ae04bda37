//! The rows, pictures and tables: a page of HTML, and a table on the screen.

use isostep_report::pictures::document::{Page, Section, Table};

use crate::row::Row;
use crate::{BASIS, COMMAND, Part, Report};

/// The whole page, one paper after the other. Each paper begins with its rows.
pub fn page(report: &Report) -> Page {
    let sections = report.parts.iter().flat_map(|part| [vec![side_by_side(part)], part.sections.clone()].concat());
    Page {
        title: "The papers reproduced".to_owned(),
        lead: vec![
            "Three papers on moving stepper motors, and what comes out when their equations are run here, beside what they \
             print. \"Printed\" stands in the paper; \"its method\" is the paper's own procedure, run here; where the paper has \
             only a picture there is no number to compare."
                .to_owned(),
            BASIS.to_owned(),
        ],
        command: COMMAND.to_owned(),
        sections: sections.chain([report.choice.clone(), absent()]).collect(),
        ..Page::default()
    }
}

fn side_by_side(part: &Part) -> Section {
    let table = Table::new(&["figure", "paper", "ours", "difference"], part.rows.iter().map(comparison).collect());
    Section::new(part.paper.title()).with_tables([table])
}

/// A figure and where it is in the paper, the paper's value and how it came to it, ours, and the difference.
fn comparison(row: &Row) -> Vec<String> {
    vec![
        format!("{}\n{}", row.quantity, row.place),
        format!("{}\n{}", row.theirs_text(), row.basis.name()),
        row.ours_text(),
        row.difference_text(),
    ]
}

fn absent() -> Section {
    Section::new("Not reproduced").with_text(
        "Fonseca-Campos 2023: figures 8 and 9 (motors without load against frequency, and steps in excess at 300 us), the measured \
         dots of figures 10 to 13, and the averages of Table 7, which are gravity. Stoychitch 2018: its section 4 names a motor and \
         prints no measurement. Forero 2023: figures 7, 8 and 10 (the prototype, its drawing, the memory it takes). All need \
         the papers' hardware.",
    )
}

/// All rows, one paper after the other.
pub fn table(report: &Report) -> String {
    let parts = report.parts.iter().map(|part| {
        let rows = part.rows.iter().map(|row| if row.is_words() { words(row) } else { numbers(row) });
        format!("\n{}\n{}{}", part.paper.title(), head(), rows.collect::<String>())
    });
    let choice = report.choice.tables.iter().map(columns).collect::<Vec<_>>().join("\n");
    format!("{BASIS}\n{}\n{}\n{choice}\n", parts.collect::<String>(), report.choice.heading)
}

/// A table whose columns are as wide as their longest cells.
fn columns(table: &Table) -> String {
    let lines = || [&table.head].into_iter().chain(&table.rows);
    let width = |column: usize| lines().map(|cells| cells[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..table.head.len()).map(width).collect();
    let line = |cells: &Vec<String>| {
        let cells = cells.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}"));
        format!("  {}\n", cells.collect::<Vec<_>>().join("  ").trim_end())
    };
    lines().map(line).collect()
}

fn head() -> String {
    line(["", "paper", "", "ours", "difference", ""])
}

fn numbers(row: &Row) -> String {
    let (theirs, ours, difference) = (row.theirs_text(), row.ours_text(), row.difference_text());
    line([&row.quantity, &theirs, row.basis.name(), &ours, &difference, row.place])
}

/// Statements in words are longer than a column, so they get lines of their own.
fn words(row: &Row) -> String {
    let (theirs, ours) = (row.theirs_text(), row.ours_text());
    let head = line([&row.quantity, "", "", "", &row.difference_text(), row.place]);
    format!("{head}      paper: {theirs}\n      ours:  {ours}\n")
}

fn line([quantity, theirs, basis, ours, difference, place]: [&str; 6]) -> String {
    let text = format!("  {quantity:<70} {theirs:>12} {basis:<10} {ours:>12} {difference:>13}  {place}");
    text.trim_end().to_owned() + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::Paper;

    #[test]
    fn columns_are_as_wide_as_their_longest_cells() {
        let cells = |cells: [&str; 2]| cells.map(str::to_owned).to_vec();
        let table = Table { head: cells(["ramp", "s"]), rows: vec![cells(["s-curve", "4.9"])], ..Table::default() };
        assert_eq!(columns(&table), "  ramp     s\n  s-curve  4.9\n");
    }

    #[test]
    fn numbers_stand_in_columns_and_words_below() {
        let row = Paper::Gantry.asks("Table 1", "deceleration").number("s", 3).printed(6.8, 4.5);
        let text = numbers(&row);
        assert!(
            text.starts_with("  deceleration ")
                && text.ends_with("6.8 s printed         4.500 s      -2.300 s  Table 1\n")
        );
        let text = words(&Paper::Gantry.asks("section 4", "lost").says("some", "73", true));
        assert!(text.contains("none  section 4\n      paper: some\n      ours:  73\n"), "{text}");
    }
}
