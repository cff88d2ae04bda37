//! `isostep papers`: the figures that the three papers print, compared with ours.

use std::path::PathBuf;

use anyhow::Result;
use isostep_papers::Report;

use crate::files::{self, Files};
use crate::name::as_called;

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

/// Runs the verb.
pub fn run(args: Args) -> Result<()> {
    Files::default().page("--report", &args.report).written("--json", &args.json).check()?;
    let report = Report::new()?;
    print!("{}", report.table());
    match &args.report {
        Some(folder) => files::write_page(folder, &report.page())?,
        None => println!("\n{}", as_called("pictures: isostep papers --report papers")),
    }
    args.json.map_or(Ok(()), |path| files::write(&path, report.json()?.as_bytes()))
}
