//! The files that the verb writes: every step as CSV, and the curves as a picture or a page.

use std::io::{self, Write};
use std::path::Path;

use anyhow::{Result, bail};
use isostep_report::pictures::document::{Page, Picture, Section, Table};
use isostep_report::pictures::profile as picture;
use isostep_report::speed_profiles::{Curve, Row, rows};

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

/// The kind of drawing, chosen by the file's name: a picture, or a page with the table.
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
pub fn plot(
    kind: &PlotKind,
    speed_profiles: &[Curve],
    derivatives: Derivatives,
    summary: &str,
    command: &str,
) -> String {
    let title = "Position, speed, acceleration and jerk over time";
    let drawn: Vec<_> = speed_profiles.iter().map(|speed_profile| curves(speed_profile, derivatives)).collect();
    match kind {
        PlotKind::Picture => picture::file(title, &drawn),
        PlotKind::Page => {
            let section = section(speed_profiles, derivatives, picture::picture(title, &drawn));
            let names: Vec<&str> = speed_profiles.iter().map(|speed_profile| speed_profile.name.as_str()).collect();
            let title = format!("Speed profiles: {}", names.join(", "));
            let (lead, command) = (vec![summary.to_owned()], command.to_owned());
            Page { title, lead, command, sections: vec![section], ..Page::default() }.html()
        }
    }
}

fn section(speed_profiles: &[Curve], derivatives: Derivatives, svg: String) -> Section {
    let is_exact = |speed_profile: &Curve| speed_profile.exact.is_some() && derivatives == Derivatives::Exact;
    let caption = if speed_profiles.iter().all(is_exact) {
        "All in closed form. A jump of acceleration is a jerk without bound, which no line shows."
    } else if speed_profiles.iter().any(is_exact) {
        "In closed form where the speed profile has one, otherwise by second-order differences of the step instants, thrice."
    } else {
        "By second-order differences of the step instants, thrice: speed from position, acceleration from speed, jerk from acceleration."
    };
    let figures = rows(speed_profiles);
    let head: Vec<_> =
        [""].into_iter().chain(speed_profiles.iter().map(|speed_profile| speed_profile.name.as_str())).collect();
    let cells = |row: &Row| [vec![row.name.to_owned()], row.cells.clone()].concat();
    Section {
        heading: "Over time".to_owned(),
        text: vec!["Planned, not measured.".to_owned()],
        pictures: vec![Picture { name: "profile".to_owned(), svg, caption: caption.to_owned() }],
        tables: vec![Table::new(&head, figures.iter().map(cells).collect())],
    }
}
