//! The HTML page.

use isostep_report::pictures::document::{Page, Section, Table};

use super::row::Row;
use super::{BASIS, COMMAND, Part, Report};

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
    Section { heading: part.paper.title().to_owned(), tables: vec![table], ..Section::default() }
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
    Section {
        heading: "Not reproduced".to_owned(),
        text: vec![
            "Fonseca-Campos 2023: figures 8 and 9 (motors without load against frequency, and steps in excess at 300 us), the measured \
             dots of figures 10 to 13, and the averages of Table 7, which are gravity. Stoychitch 2018: its section 4 names a motor and \
             prints no measurement. Forero 2023: figures 7, 8 and 10 (the prototype, its drawing, the memory it takes). All need \
             the papers' hardware."
                .to_owned(),
        ],
        ..Section::default()
    }
}
