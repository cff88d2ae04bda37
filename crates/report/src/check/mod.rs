//! The fate of a program on a machine: its survey, and how long it takes and why, from a run without edges.

mod words;

use isostep_console::Settings;
use isostep_sim::plate::Plate;
use isostep_sim::program::Program;
use isostep_sim::{AXES, Config, lines_of_moves};
use serde::Serialize;

use crate::pace::Pace;
use crate::shaping::ShapingFigures;
use crate::survey::{Fit, Survey};
use crate::{remarks, timing};

pub use self::words::{Row, fate, rows, without_dust};

/// The results of a program on one machine.
#[derive(Serialize)]
pub struct Check {
    /// The initial position of the carriages, mm from their switches.
    pub start_mm: [f64; AXES],
    /// The survey of it.
    pub survey: Survey,
    /// Time from the start of the first move to the end of the last, with the waits before and after, without homing and
    /// without refused lines, s.
    pub time_s: Option<f64>,
    /// Time for homing, s.
    pub homing_s: Option<f64>,
    /// Time for dwells and spin-ups before the first move and after the last one, s.
    pub waits_s: Option<[f64; 2]>,
    /// The results of the first probing moves.
    pub probes: Vec<String>,
    /// The time by what it is spent on.
    pub pace: Option<Pace>,
    /// The cost of shaping, if anything is shaped.
    pub shaping: Option<ShapingFigures>,
    /// The reason why the program does not reach its end.
    pub trouble: Option<String>,
}

/// The places where the carriages stand, and a plate for the probe.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stand {
    /// mm from the switches; where the program fits, if it is not given.
    pub start_mm: Option<[f64; AXES]>,
    /// The plate that the probe touches.
    pub plate: Option<Plate>,
}

/// The results of the run of a program.
struct Made {
    homing_s: f64,
    waits_s: [f64; 2],
    probes: Vec<String>,
    pace: Pace,
    shaping: Option<ShapingFigures>,
}

impl Check {
    /// Checks the lines of a program, and does not run it, for a reason that is told in place of its time.
    pub fn unrun(program: &Program, settings: &Settings, stand: Stand, why: &str) -> Self {
        let (start_mm, survey) = survey(program, settings, stand.start_mm);
        Self::new(start_mm, survey, Err(why.to_owned()))
    }

    /// Checks a program on a machine with these settings. Calls `watch` now and then with how many more lines are done.
    pub fn of(program: &Program, settings: &Settings, stand: Stand, watch: &mut dyn FnMut(usize)) -> Self {
        let (start_mm, survey) = survey(program, settings, stand.start_mm);
        let stand = Stand { start_mm: Some(start_mm), ..stand };
        let made = made(program, settings, stand, &survey, watch);
        Self::new(start_mm, survey, made)
    }

    fn new(start_mm: [f64; AXES], survey: Survey, made: Result<Made, String>) -> Self {
        let (trouble, made) = made.map_or_else(|trouble| (Some(trouble), None), |made| (None, Some(made)));
        Self {
            start_mm,
            survey,
            time_s: made.as_ref().map(|made| made.waits_s[0] + made.pace.total_s() + made.waits_s[1]),
            homing_s: made.as_ref().map(|made| made.homing_s),
            waits_s: made.as_ref().map(|made| made.waits_s),
            probes: made.as_ref().map_or_else(Vec::new, |made| made.probes.clone()),
            shaping: made.as_ref().and_then(|made| made.shaping.clone()),
            pace: made.map(|made| made.pace),
            trouble,
        }
    }

    /// True if the program would run unchanged.
    pub fn is_good(&self) -> bool {
        self.survey.refused_total == 0 && self.survey.outside.is_none() && self.trouble.is_none()
    }
}

/// Surveys the program from the requested start. Without one, the start is the middle of the travel; if the program
/// does not fit from there, a start from which it fits.
fn survey(program: &Program, settings: &Settings, start_mm: Option<[f64; AXES]>) -> ([f64; AXES], Survey) {
    let first_mm = start_mm.unwrap_or_else(|| timing::middle_mm(settings));
    let survey = Survey::of(program, settings, first_mm);
    match survey.outside.as_ref().map(|outside| outside.fit) {
        Some(Fit::StartAt(fitting_mm)) if start_mm.is_none() => (fitting_mm, Survey::of(program, settings, fitting_mm)),
        _ => (first_mm, survey),
    }
}

/// Runs the program; the error says why it does not reach its end. A machine that homes or probes needs simulated edges,
/// because they move the carriages to the switches and to the plate.
fn made(
    program: &Program,
    settings: &Settings,
    stand: Stand,
    survey: &Survey,
    watch: &mut dyn FnMut(usize),
) -> Result<Made, String> {
    let Stand { start_mm, plate } = stand;
    let start_mm = start_mm.unwrap_or_else(|| timing::middle_mm(settings));
    let (program, only_time) = (survey.accepted(program), !survey.homes && plate.is_none());
    // Who begins a program without $H has homed the machine before, and M6 asks for that. Its wait takes no time.
    let settings = if survey.homes { *settings } else { Settings { tool_change_mode: 0, ..*settings } };
    let config = Config { settings, start_mm, plate, only_time, keep_waves: false, ..Config::default() };
    let mut shown = 0;
    let outcome = timing::made_watched(program.clone(), &config, &mut |answered| {
        watch(answered - shown);
        shown = answered;
    });
    watch(program.len() - shown);
    let outcome = outcome.map_err(|trouble| match plate {
        None if trouble.starts_with("ALARM:5") => format!("{trouble} (--probe-plate puts a plate there)"),
        _ => trouble,
    })?;
    let [before_s, after_s] = outcome.waits_s();
    let sources = lines_of_moves::of_moves(&outcome);
    Ok(Made {
        homing_s: outcome.homing_ns() as f64 * 1e-9,
        waits_s: [before_s, (after_s - freed_s(&survey.settings)).max(0.0)],
        probes: remarks::probes(&outcome),
        pace: Pace::new(&outcome, &sources),
        shaping: ShapingFigures::of(&outcome, &sources),
    })
}

/// The time after the last motion at which the motors are freed (`$1`), which nobody waits for, s.
fn freed_s(settings: &Settings) -> f64 {
    match settings.idle_delay_ms {
        255 => 0.0,
        ms => f64::from(ms) * 1e-3,
    }
}
