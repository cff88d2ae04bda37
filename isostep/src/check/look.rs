//! A program on each of some machines.

use std::path::Path;

use isostep_console::Settings;
use isostep_sim::Config;
use isostep_sim::pace::Pace;
use isostep_sim::stream::Program;
use isostep_sim::survey::{Fit, Survey};
use serde::Serialize;

use crate::{project, sim, timing};

/// A machine that programs are checked for.
pub struct Machine {
    pub name: String,
    pub settings: Settings,
}

/// A program and what would become of it.
#[derive(Serialize)]
pub struct Checked {
    pub program: String,
    /// Why it is no program.
    pub unreadable: Option<String>,
    /// On each machine.
    pub on: Vec<On>,
}

/// A program on a machine.
#[derive(Serialize)]
pub struct On {
    pub machine: String,
    /// Where the carriages stand at first, mm from their switches.
    pub start_mm: [f64; 3],
    pub survey: Survey,
    /// From the start of the first move to the end of the last, without homing and what is refused, s.
    pub time_s: Option<f64>,
    /// Homing, s.
    pub homing_s: Option<f64>,
    pub pace: Option<Pace>,
    /// Why it does not come to its end.
    pub trouble: Option<String>,
}

impl Checked {
    /// Whether it would run as it is, on each machine.
    pub fn is_good(&self) -> bool {
        self.unreadable.is_none() && self.on.iter().all(On::is_good)
    }
}

impl On {
    fn is_good(&self) -> bool {
        self.survey.refused_total == 0 && self.survey.outside.is_none() && self.trouble.is_none()
    }
}

/// Checks a program; one that cannot be read is one that would not run.
pub fn check(path: &Path, machines: &[Machine], start_mm: Option<[f64; 3]>) -> Checked {
    let program = project::shown(path);
    match sim::lines(path) {
        Ok(lines) => {
            let on = machines.iter().map(|machine| on(&lines, machine, start_mm)).collect();
            Checked { program, unreadable: None, on }
        }
        Err(error) => Checked { program, unreadable: Some(error.root_cause().to_string()), on: Vec::new() },
    }
}

fn on(program: &Program, machine: &Machine, start_mm: Option<[f64; 3]>) -> On {
    let (start_mm, survey) = survey(program, &machine.settings, start_mm);
    let made = made(&survey.accepted(program), &machine.settings, start_mm, survey.homes);
    let (trouble, made) = made.map_or_else(|trouble| (Some(trouble), None), |made| (None, Some(made)));
    On {
        machine: machine.name.clone(),
        start_mm,
        survey,
        time_s: made.as_ref().map(|(_, pace)| pace.total_s()),
        homing_s: made.as_ref().map(|(homing_s, _)| *homing_s),
        pace: made.map(|(_, pace)| pace),
        trouble,
    }
}

/// From where it is asked to begin; else from the middle of the travel, or from where it fits if it does not from there.
fn survey(program: &Program, settings: &Settings, start_mm: Option<[f64; 3]>) -> ([f64; 3], Survey) {
    let first_mm = start_mm.unwrap_or_else(|| timing::middle_mm(settings));
    let survey = Survey::of(program, settings, first_mm);
    match survey.outside.as_ref().map(|outside| outside.fit) {
        Some(Fit::StartAt(fitting_mm)) if start_mm.is_none() => (fitting_mm, Survey::of(program, settings, fitting_mm)),
        _ => (first_mm, survey),
    }
}

/// How long homing takes, and what keeps the rest from going faster; or why it does not come to its end. A machine that homes
/// needs edges, since its switches close where they take it.
fn made(program: &Program, settings: &Settings, start_mm: [f64; 3], homes: bool) -> Result<(f64, Pace), String> {
    let config = Config { settings: *settings, start_mm, only_time: !homes, keep_waves: false, ..Config::default() };
    let outcome = timing::made(program.clone(), &config)?;
    Ok((outcome.homing_ns() as f64 * 1e-9, Pace::of(&outcome)))
}
