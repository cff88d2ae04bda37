//! `isostep papers`: the figures that the three papers print, compared with ours.
//!
//! # Design
//! ```text
//! frequency, linear, gantry: a paper each --> rows: the paper's figure, ours, the difference
//!                                         \-> sections: pictures and tables
//!                        rows --> screen: a table;  JSON
//! choice: the machine's seven laws --> a section
//!             rows + sections --> page: HTML
//! ```

mod choice;
mod frequency;
mod gantry;
mod linear;
mod page;
mod row;
mod screen;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use isostep_report::pictures::papers::{self, Section, Table};
use serde::Serialize;

use self::row::{Paper, Row};
use crate::files::Files;
use crate::name::as_called;
use crate::project;

/// Reproduce what the three papers print, side by side with ours
#[derive(clap::Args)]
#[command(after_help = "\
What can be reproduced without the papers' hardware, a row each: the paper's figure, ours, and the difference. A paper's
figure is printed there, or comes from its method, run here. The papers' pictures are drawn anew on the page.
Everything is computed or simulated, and what is a model says so. Equal builds give equal figures.

Examples:
  isostep papers                          the table
  isostep papers --report report/papers   a page of pictures too: open report/papers/index.html
  isostep papers --json papers.json       the rows and tables in full precision")]
pub struct Args {
    /// Write the page of pictures and tables into this folder
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Write the rows and tables as JSON
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

/// The results for one paper.
pub struct Part {
    paper: Paper,
    rows: Vec<Row>,
    sections: Vec<Section>,
}

/// The results for all papers, and the comparison of the machine's laws.
struct Report {
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
/// Where all figures come from.
const BASIS: &str = "All figures are computed or simulated on a computer; nothing here is measured on hardware.";

/// Runs the verb.
pub fn run(args: Args) -> Result<()> {
    Files::default().page("--report", &args.report).written("--json", &args.json).check()?;
    let report = report()?;
    print!("{}", screen::table(&report));
    match &args.report {
        Some(folder) => write_page(folder, &report)?,
        None => println!("\n{}", as_called("pictures: isostep papers --report papers")),
    }
    args.json.map_or(Ok(()), |path| write(&path, &json(&report)?))
}

fn report() -> Result<Report> {
    Ok(Report { parts: vec![frequency::part()?, linear::part()?, gantry::part()?], choice: choice::section()? })
}

impl Report {
    fn rows(&self) -> impl Iterator<Item = &Row> {
        self.parts.iter().flat_map(|part| &part.rows)
    }

    fn sections(&self) -> impl Iterator<Item = &Section> {
        self.parts.iter().flat_map(|part| &part.sections).chain([&self.choice])
    }
}

fn json(report: &Report) -> Result<String> {
    let rows = report.rows().collect();
    let tables = report.sections().flat_map(|section| &section.tables).collect();
    Ok(serde_json::to_string_pretty(&Figures { command: COMMAND, basis: BASIS, rows, tables })? + "\n")
}

fn write_page(folder: &Path, report: &Report) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let page = page::page(report);
    for (name, picture) in papers::files(&page) {
        let path = folder.join(name);
        fs::write(&path, picture).with_context(|| format!("cannot write {}", path.display()))?;
    }
    write(&folder.join("index.html"), &papers::page(&page))
}

fn write(path: &Path, text: &str) -> Result<()> {
    fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))?;
    println!("wrote {}", project::shown(path));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_has_the_papers_side_ours_and_the_difference() {
        let report = report().unwrap();
        let papers: Vec<Paper> = report.parts.iter().map(|part| part.paper).collect();
        assert_eq!(papers, [Paper::Frequency, Paper::Linear, Paper::Gantry]);
        for row in report.rows() {
            let texts = [row.theirs_text(), row.ours_text(), row.difference_text()];
            assert!(texts.iter().all(|text| !text.is_empty() && !text.contains("NaN")), "{row:?}");
        }
    }

    #[test]
    fn the_page_has_every_row_and_picture() {
        let report = report().unwrap();
        let html = papers::page(&page::page(&report));
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
        let report = report().unwrap();
        let json: serde_json::Value = serde_json::from_str(&json(&report).unwrap()).unwrap();
        let rows = json["rows"].as_array().unwrap();
        assert_eq!(rows.len(), report.rows().count());
        assert!(rows.iter().all(|row| row["ours"] != serde_json::Value::Null && row["paper"].is_string()));
    }
}
