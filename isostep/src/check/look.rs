//! Checks a program on each of several machines.

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

/// A program and the results of its check.
#[derive(Serialize)]
pub struct Checked {
    pub program: String,
    /// Why the file is not a readable program.
    pub unreadable: Option<String>,
    /// The results on each machine.
    pub on: Vec<On>,
}

/// The results of a program on one machine.
#[derive(Serialize)]
pub struct On {
    pub machine: String,
    /// The initial position of the carriages, mm from their switches.
    pub start_mm: [f64; 3],
    pub survey: Survey,
    /// Time from the start of the first move to the end of the last, without homing and without refused lines, s.
    pub time_s: Option<f64>,
    /// Time for homing, s.
    pub homing_s: Option<f64>,
    pub pace: Option<Pace>,
    /// Why the program does not reach its end.
    pub trouble: Option<String>,
}

impl Checked {
    /// Whether the program would run unchanged on each machine.
    pub fn is_good(&self) -> bool {
        self.unreadable.is_none() && self.on.iter().all(On::is_good)
    }
}

impl On {
    fn is_good(&self) -> bool {
        self.survey.refused_total == 0 && self.survey.outside.is_none() && self.trouble.is_none()
    }
}

/// Checks a program. A file that cannot be read counts as a program that would not run.
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

/// Surveys the program from the requested start. Without one, the start is the middle of the travel; if the program
/// does not fit from there, a start from which it fits.
fn survey(program: &Program, settings: &Settings, start_mm: Option<[f64; 3]>) -> ([f64; 3], Survey) {
    let first_mm = start_mm.unwrap_or_else(|| timing::middle_mm(settings));
    let survey = Survey::of(program, settings, first_mm);
    match survey.outside.as_ref().map(|outside| outside.fit) {
        Some(Fit::StartAt(fitting_mm)) if start_mm.is_none() => (fitting_mm, Survey::of(program, settings, fitting_mm)),
        _ => (first_mm, survey),
    }
}

/// How long homing takes, and what keeps the other moves from going faster; the error says why the program does not
/// reach its end. A machine that homes needs simulated edges, because they move the carriages to the switches.
fn made(program: &Program, settings: &Settings, start_mm: [f64; 3], homes: bool) -> Result<(f64, Pace), String> {
    let config = Config { settings: *settings, start_mm, only_time: !homes, keep_waves: false, ..Config::default() };
    let outcome = timing::made(program.clone(), &config)?;
    Ok((outcome.homing_ns() as f64 * 1e-9, Pace::of(&outcome)))
}
