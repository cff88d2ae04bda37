//! The figures that the three papers print, compared with ours. Only the verb `isostep papers` needs them, which prints them and writes them
//! to files.
//!
//! # Design
//! ```text
//! frequency, linear, gantry: a paper each --> rows: the paper's figure, ours, the difference
//!                                         \-> sections: pictures and tables
//! choice: the machine's seven profiles --> a section
//!                       rows --> a table on the screen, JSON
//!            rows + sections --> a page of HTML
//! ```
#![forbid(unsafe_code)]

mod choice;
mod frequency;
mod gantry;
mod linear;
mod row;
mod show;
mod welch;

use anyhow::Result;
use isostep_profile::{IntervalSplit, Limits, Profile, SpeedProfile};
use serde::Serialize;

use self::row::{Paper, Row};
use isostep_report::pictures::document::{Page, Section, Table};

/// The results for one paper.
struct Part {
    paper: Paper,
    rows: Vec<Row>,
    sections: Vec<Section>,
}

/// The results for all papers, and the comparison of the machine's profiles.
pub struct Report {
    parts: Vec<Part>,
    choice: Section,
}

/// The content of the JSON file.
#[derive(Serialize)]
struct Figures<'a> {
    command: &'static str,
    basis: &'static str,
    rows: Vec<&'a Row>,
    tables: Vec<&'a Table>,
}

/// The command that prints this report.
const COMMAND: &str = "isostep papers";
/// The sources of all figures.
const BASIS: &str = "All figures are computed or simulated on a computer; nothing here is measured on hardware.";

impl Report {
    /// Computes all of it, which takes some seconds.
    ///
    /// # Errors
    /// A profile or a run that cannot be made: a defect.
    pub fn new() -> Result<Self> {
        Ok(Self { parts: vec![frequency::part()?, linear::part()?, gantry::part()?], choice: choice::section()? })
    }

    /// The rows as a table for a screen.
    #[must_use]
    pub fn table(&self) -> String {
        show::table(self)
    }

    /// The page of rows, pictures and tables.
    #[must_use]
    pub fn page(&self) -> Page {
        show::page(self)
    }

    /// The rows and tables in full precision.
    ///
    /// # Errors
    /// None in normal use.
    pub fn json(&self) -> Result<String> {
        let rows = self.rows().collect();
        let tables = self.sections().flat_map(|section| &section.tables).collect();
        Ok(serde_json::to_string_pretty(&Figures { command: COMMAND, basis: BASIS, rows, tables })? + "\n")
    }

    fn rows(&self) -> impl Iterator<Item = &Row> {
        self.parts.iter().flat_map(|part| &part.rows)
    }

    fn sections(&self) -> impl Iterator<Item = &Section> {
        self.parts.iter().flat_map(|part| &part.sections).chain([&self.choice])
    }
}

/// A move of so many steps, from the start speed and to it, as fast as the limits allow.
fn plan(steps: f64, limits: &Limits, speed_profile: SpeedProfile) -> Result<Profile> {
    let start = limits.start_speed_steps_s;
    Ok(Profile::plan(steps, start, start, limits, IntervalSplit::Fastest, speed_profile)?)
}

#[cfg(test)]
mod tests {
    use std::sync::LazyLock;

    use super::*;

    /// One report for all tests: it takes longer than they do.
    static REPORT: LazyLock<Report> = LazyLock::new(|| Report::new().unwrap());

    #[test]
    fn every_row_has_the_papers_side_ours_and_the_difference() {
        let report = &*REPORT;
        let papers: Vec<Paper> = report.parts.iter().map(|part| part.paper).collect();
        assert_eq!(papers, [Paper::Frequency, Paper::Linear, Paper::Gantry]);
        for row in report.rows() {
            let texts = [row.theirs_text(), row.ours_text(), row.difference_text()];
            assert!(texts.iter().all(|text| !text.is_empty() && !text.contains("NaN")), "{row:?}");
        }
    }

    #[test]
    fn the_page_has_every_row_and_picture() {
        let report = &*REPORT;
        let html = report.page().html();
        let pictures = report.sections().flat_map(|section| &section.pictures).count();
        assert_eq!(html.matches("<svg").count(), pictures);
        assert!(pictures > 10 && !html.contains("NaN") && !html.contains("inf"));
        assert_eq!(html.matches("<table").count(), html.matches("</table>").count());
        for row in report.rows() {
            assert!(html.contains(&format!("<td>{}</td>", row.difference_text())), "{row:?}");
        }
    }

    #[test]
    fn json_has_every_row() {
        let report = &*REPORT;
        let json: serde_json::Value = serde_json::from_str(&report.json().unwrap()).unwrap();
        let rows = json["rows"].as_array().unwrap();
        assert_eq!(rows.len(), report.rows().count());
        assert!(rows.iter().all(|row| row["ours"] != serde_json::Value::Null && row["paper"].is_string()));
    }
}
