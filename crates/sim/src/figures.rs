//! The figures of a run as one value: what the command line prints, the report shows and `--json` writes.

use isostep_motion::{AXES, Event};
use serde::Serialize;

use crate::config::Port;
use crate::driver::Violation;
use crate::kinematics::{self, AxisFigures};
use crate::lines_of_moves;
use crate::measure::{Intervals, Measured};
use crate::outcome::Outcome;
use crate::pace::Pace;
use crate::record::Loss;
use crate::stream::Refusal;
use crate::verify::{self, MoveCheck, Verdict};

/// One move of the program.
#[derive(Clone, Debug, Serialize)]
pub struct MoveFigures {
    /// From 1, in the order made.
    pub number: usize,
    /// Its line of the program, from 1; null where that is not known.
    pub line: Option<usize>,
    /// When it began, ns since power-up.
    pub start_ns: u64,
    /// Where it began.
    pub from_mm: [f64; AXES],
    /// Where it ended.
    pub to_mm: [f64; AXES],
    /// Signed.
    pub steps: [i32; AXES],
    /// Of every axis, as planned.
    pub planned: Intervals,
    /// Per axis, from its edges alone; null for an axis at rest or with too few edges.
    pub measured: [Option<Measured>; AXES],
    /// The most that measured intervals of two axes differ, s.
    pub apart_s: Option<f64>,
    /// Per axis, the largest distance of an edge from its closed-form instant, ns.
    pub error_max_ns: [Option<f64>; AXES],
    /// 1 is the bound of half a step of either axis.
    pub path_deviation: Option<f64>,
    /// Whether all and only the planned steps left.
    pub exact: bool,
}

/// A run in figures.
#[derive(Clone, Debug, Serialize)]
pub struct Figures {
    /// What was run.
    pub program: String,
    /// The line that runs it again, to the byte.
    pub replay: String,
    /// Seed of everything random.
    pub seed: u64,
    /// What made the edges.
    pub port: Port,
    /// What it rounds instants to, ns.
    pub tick_ns: f64,
    /// Virtual time from power-up to rest, ns.
    pub duration_ns: u64,
    /// Of which homing, ns.
    pub homing_ns: u64,
    /// Steps of all axes, homing included.
    pub steps_total: usize,
    /// The controller's final position.
    pub position_steps: [i32; AXES],
    /// The same.
    pub position_mm: [f64; AXES],
    /// Where each carriage really is, mm from where its limit switch closes.
    pub carriage_mm: [f64; AXES],
    /// The moves of the program.
    pub moves: Vec<MoveFigures>,
    /// How fast each axis was, within moves and at corners.
    pub axes: [AxisFigures; AXES],
    /// How its time is spent, and what keeps it from being faster.
    pub pace: Pace,
    /// Every promise, and whether it was kept.
    pub verdicts: Vec<Verdict>,
    /// Every edge that a driver may misread.
    pub violations: Vec<Violation>,
    /// Every step that no carriage made.
    pub losses: Vec<Loss>,
    /// The lines that the controller refused.
    pub refusals: Vec<Refusal>,
    /// The number after `ALARM:`.
    pub alarm: Option<u8>,
}

impl Figures {
    /// The figures of `outcome`, the run of the program called `program`.
    pub fn new(program: &str, outcome: &Outcome) -> Self {
        let checks = verify::moves(outcome);
        let sources = lines_of_moves::of_moves(outcome);
        let lines: Vec<_> = sources.iter().map(|source| source.map(|source| source.line)).collect();
        Self {
            program: program.to_owned(),
            replay: outcome.config.replay(program),
            seed: outcome.config.seed,
            port: outcome.config.port,
            tick_ns: outcome.config.port.tick_ns(),
            duration_ns: outcome.duration_ns,
            homing_ns: homing_ns(outcome),
            steps_total: outcome.edges.len(),
            position_steps: outcome.position_steps,
            position_mm: outcome.position_mm,
            carriage_mm: outcome.mm(outcome.places_steps),
            verdicts: verify::verdicts(outcome, &checks),
            axes: kinematics::axes(outcome, &lines),
            pace: Pace::new(outcome, &sources),
            moves: checks
                .into_iter()
                .enumerate()
                .map(|(index, check)| move_figures(index + 1, lines[check.index], outcome, check))
                .collect(),
            violations: outcome.violations.clone(),
            losses: outcome.losses.clone(),
            refusals: outcome.refusals.clone(),
            alarm: outcome.alarm_code,
        }
    }

    /// The promises that were not kept.
    pub fn broken(&self) -> impl Iterator<Item = &Verdict> {
        self.verdicts.iter().filter(|verdict| !verdict.kept)
    }
}

fn move_figures(number: usize, line: Option<usize>, outcome: &Outcome, check: MoveCheck) -> MoveFigures {
    let record = &outcome.moves[check.index];
    MoveFigures {
        number,
        line,
        start_ns: record.begin_ns(),
        from_mm: outcome.mm(record.origin_steps),
        to_mm: outcome.mm(record.end_steps),
        steps: check.emitted_steps,
        planned: check.planned,
        apart_s: check.apart_s(),
        measured: check.measured,
        error_max_ns: check.error_max_ns,
        path_deviation: check.path_deviation,
        exact: check.exact,
    }
}

/// Time spent homing.
fn homing_ns(outcome: &Outcome) -> u64 {
    let mut began_ns = None;
    let mut total_ns = 0;
    for &(t_ns, event) in &outcome.events {
        match event {
            Event::State(isostep_motion::State::Home) => began_ns = Some(t_ns),
            Event::State(_) => total_ns += began_ns.take().map_or(0, |began_ns: u64| t_ns - began_ns),
            _ => {}
        }
    }
    total_ns
}
