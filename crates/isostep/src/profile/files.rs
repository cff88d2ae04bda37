//! The files that the verb writes: every step as CSV, and the curves as a picture or a page.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use anyhow::{Context, Result, bail};
use isostep_report::laws::{Curve, Row, rows};
use isostep_report::pictures::bench::{Picture, Section, Table, page};
use isostep_report::pictures::profile as picture;

use super::kinematics::{Derivatives, curves};

/// Writes `step,t_us,period_us,frequency_hz`. Numbers are as short as possible without losing a bit.
pub fn write_csv(curve: &Curve, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "step,t_us,period_us,frequency_hz")?;
    let cell = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    for (step, number) in curve.steps.iter().zip(1_u32..) {
        writeln!(out, "{number},{},{},{}", step.t_us, cell(step.period_us), cell(step.frequency_hz))?;
    }
    Ok(())
}

/// What to draw, chosen by the file's name: a picture, or a page with the table.
pub enum PlotKind {
    /// `.svg`
    Picture,
    /// `.html`
    Page,
}

impl PlotKind {
    /// The kind for the extension of `path`.
    pub fn of(path: &Path) -> Result<Self> {
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("svg") => Ok(Self::Picture),
            Some("html" | "htm") => Ok(Self::Page),
            _ => {
                bail!("--plot {}: name a picture, such as profile.svg, or a page, such as profile.html", path.display())
            }
        }
    }
}

/// The text of the picture or the page.
pub fn plot(kind: &PlotKind, laws: &[Curve], derivatives: Derivatives, summary: &str, command: &str) -> String {
    let title = "Position, speed, acceleration and jerk over time";
    let drawn: Vec<_> = laws.iter().map(|law| curves(law, derivatives)).collect();
    match kind {
        PlotKind::Picture => picture::file(title, &drawn),
        PlotKind::Page => {
            let section = section(laws, derivatives, picture::picture(title, &drawn));
            let names: Vec<&str> = laws.iter().map(|law| law.name.as_str()).collect();
            page(&format!("Speed profiles: {}", names.join(", ")), summary, command, &[section])
        }
    }
}

fn section(laws: &[Curve], derivatives: Derivatives, svg: String) -> Section {
    let is_exact = |law: &Curve| law.exact.is_some() && derivatives == Derivatives::Exact;
    let caption = if laws.iter().all(is_exact) {
        "All in closed form. A jump of acceleration is a jerk without bound, which no line shows."
    } else if laws.iter().any(is_exact) {
        "In closed form where the law has one, otherwise by second-order differences of the step instants, thrice."
    } else {
        "By second-order differences of the step instants, thrice: speed from position, acceleration from speed, jerk from acceleration."
    };
    let figures = rows(laws);
    let head = [String::new()].into_iter().chain(laws.iter().map(|law| law.name.clone())).collect();
    let cells = |row: &Row| [vec![row.name.to_owned()], row.cells.clone()].concat();
    Section {
        heading: "Over time".to_owned(),
        text: "Planned, not measured.".to_owned(),
        pictures: vec![Picture { name: "profile".to_owned(), svg, key: Vec::new(), caption: caption.to_owned() }],
        table: Some(Table { head, rows: figures.iter().map(cells).collect() }),
    }
}

/// Writes a whole file and reports it on the screen.
pub fn write(path: &Path, text: &[u8]) -> Result<()> {
    fs::write(path, text).with_context(|| format!("{} cannot be written", path.display()))?;
    println!("wrote {}", path.display());
    Ok(())
}
