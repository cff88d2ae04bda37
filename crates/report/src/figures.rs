//! The figures of a run as one value, for the output of the command line, the report and `--json`.

use isostep_motion::AXES;
use serde::Serialize;

use crate::kinematics::{self, AxisFigures, BeltFigures};
use crate::pace::Pace;
use crate::ringing::{self, RingingFigures};
use crate::shaping::ShapingFigures;
use crate::tool::ToolFigures;
use isostep_sim::Outcome;
use isostep_sim::config::Port;
use isostep_sim::driver::Violation;
use isostep_sim::lines_of_moves;
use isostep_sim::losses::{self, LossFigures};
use isostep_sim::measure::{Intervals, Measured};
use isostep_sim::stream::{Pause, Refusal};
use isostep_sim::verify::{self, Findings, MoveCheck, Verdict};

/// One move of the program.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct MoveFigures {
    /// Number of the move, from 1, in the order made.
    pub number: usize,
    /// Its line of the program, from 1; null if unknown.
    pub line: Option<usize>,
    /// The duration of the blend in which it begins, s; 0 without one.
    pub blend_s: f64,
    /// When it began, ns since power-up.
    pub start_ns: u64,
    /// The place where it begins; the corner, if a blend goes round it.
    pub from_mm: [f64; AXES],
    /// The place where it ends; the corner, if a blend goes round it.
    pub to_mm: [f64; AXES],
    /// Steps of each axis, signed: those of the blend in which it begins, and of its line.
    pub steps: [i32; AXES],
    /// Planned intervals of its line, the same for every axis.
    pub planned: Intervals,
    /// Intervals of each axis, measured from its edges alone; null for an axis at rest or with too few edges.
    pub measured: [Option<Measured>; AXES],
    /// Largest difference between the measured intervals of two axes, s.
    pub apart_s: Option<f64>,
    /// Per axis, the largest distance of an edge from its closed-form instant, ns.
    pub error_max_ns: [Option<f64>; AXES],
    /// Deviation from the straight path; 1 is the bound of half a step of both axes.
    pub path_deviation: Option<f64>,
    /// True if exactly the planned steps were made; null in a shaped run, whose moves are not judged by themselves.
    pub exact: Option<bool>,
}

impl MoveFigures {
    /// Planned duration, s.
    pub fn duration_s(&self) -> f64 {
        self.blend_s + self.planned.accel_s + self.planned.cruise_s + self.planned.decel_s
    }

    /// The largest distance of a step of any axis from its closed-form instant, ns.
    pub fn error_max_ns(&self) -> f64 {
        self.error_max_ns.iter().flatten().copied().fold(0.0, f64::max)
    }
}

/// The moves of a program that are listed one by one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Listed {
    /// All of them.
    All,
    /// All of a short program. Of a long one the first 1,000, the 500 of the longest duration, and the 500 with the
    /// largest errors of their steps, so that a file of figures stays below 5 MB.
    Some,
}

/// Up to this number, all moves are listed.
const MOVES_MAX: usize = 2_000;
const FIRST_MOVES: usize = 1_000;
const MOST_MOVES: usize = 500;
/// Largest number of listed losses, and of listed edges that a driver may misread, since many are alike.
const TROUBLES_MAX: usize = 1_000;

/// Lengths of the moves of a program, each straight from its start to its end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Lengths {
    /// The shortest.
    pub least_mm: f64,
    /// The median.
    pub median_mm: f64,
    /// The longest.
    pub most_mm: f64,
    /// The sum.
    pub total_mm: f64,
}

/// The figures of a run.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Figures {
    /// Name of the program.
    pub program: String,
    /// The command line that repeats the run, to the byte.
    pub replay: String,
    /// Seed of everything random.
    pub seed: u64,
    /// The port that made the edges.
    pub port: Port,
    /// Its tick length, to which instants are rounded, ns.
    pub tick_ns: f64,
    /// Virtual time from power-up to rest, ns.
    pub duration_ns: u64,
    /// The part of it that was homing, ns.
    pub homing_ns: u64,
    /// Steps of all axes, homing included.
    pub steps_total: usize,
    /// The controller's final position.
    pub position_steps: [i32; AXES],
    /// The same in mm.
    pub position_mm: [f64; AXES],
    /// True position of each carriage, mm from where its limit switch closes.
    pub carriage_mm: [f64; AXES],
    /// Number of moves of the program.
    pub moves_total: usize,
    /// Lengths of the moves.
    pub lengths: Lengths,
    /// The moves that are [`Listed`].
    pub moves: Vec<MoveFigures>,
    /// Speed and acceleration of each axis, within moves and at corners.
    pub axes: [AxisFigures; AXES],
    /// What crossed belts make of the axes; left out if each axis has its own motor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub belts: Option<BeltFigures>,
    /// The cost of shaping; left out if no run is shaped.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shaping: Option<ShapingFigures>,
    /// The swinging of the loads on springs; left out if there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ringing: Vec<RingingFigures>,
    /// The same without shapers, if whoever asks for the figures has run the program so
    /// ([`unshaped`](crate::again::unshaped)); left out otherwise.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ringing_unshaped: Vec<RingingFigures>,
    /// The time by what limits the speed.
    pub pace: Pace,
    /// The tool's work; left out if it was not used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tool: Option<ToolFigures>,
    /// Every promise, and whether it was kept.
    pub verdicts: Vec<Verdict>,
    /// Number of edges that a driver may misread.
    pub violations_total: usize,
    /// The first 1,000 of them.
    pub violations: Vec<Violation>,
    /// Number of times that steps were lost.
    pub losses_total: usize,
    /// The first 1,000 of these losses.
    pub losses: Vec<LossFigures>,
    /// The lines that the controller refused.
    pub refusals: Vec<Refusal>,
    /// The lines that waited for the operator. They were resumed at once.
    pub pauses: Vec<Pause>,
    /// The number after `ALARM:`.
    pub alarm: Option<u8>,
}

impl Figures {
    /// The figures of `outcome`, the run of the program called `program`, with [`Listed::Some`] of its moves.
    pub fn new(program: &str, outcome: &Outcome) -> Self {
        Self::listing(program, outcome, Listed::Some)
    }

    /// As [`new`](Self::new), with the moves that are `listed`.
    pub fn listing(program: &str, outcome: &Outcome, listed: Listed) -> Self {
        let (findings, moves) = look_at(outcome, listed);
        let sources = lines_of_moves::of_moves(outcome);
        let lines: Vec<_> = sources.iter().map(|source| source.map(|source| source.line)).collect();
        Self {
            program: program.to_owned(),
            replay: outcome.config.replay(program),
            seed: outcome.config.seed,
            port: outcome.config.port,
            tick_ns: outcome.config.port.tick_ns(),
            duration_ns: outcome.duration_ns,
            homing_ns: outcome.homing_ns(),
            steps_total: outcome.edges.len(),
            position_steps: outcome.position_steps,
            position_mm: outcome.position_mm,
            carriage_mm: outcome.carriage_mm(),
            verdicts: verify::verdicts(outcome, &findings),
            axes: kinematics::axes(outcome, &lines),
            belts: kinematics::belts(outcome),
            shaping: ShapingFigures::of(outcome, &sources),
            ringing: ringing::figures(outcome, &sources),
            ringing_unshaped: Vec::new(),
            moves_total: findings.moves(),
            lengths: Lengths::of(outcome),
            pace: Pace::new(outcome, &sources),
            tool: ToolFigures::of(outcome, &sources),
            moves: moves
                .into_iter()
                .map(|(number, index)| move_figures(number, lines[index], outcome, verify::check(outcome, index)))
                .collect(),
            violations_total: outcome.violations.len(),
            violations: outcome.violations.iter().take(TROUBLES_MAX).copied().collect(),
            losses_total: outcome.losses.len(),
            losses: losses::explained(outcome, TROUBLES_MAX),
            refusals: outcome.refusals.clone(),
            pauses: outcome.pauses.clone(),
            alarm: outcome.alarm_code,
        }
    }

    /// The promises that were not kept.
    pub fn broken(&self) -> impl Iterator<Item = &Verdict> {
        self.verdicts.iter().filter(|verdict| !verdict.kept)
    }
}

impl Lengths {
    fn of(outcome: &Outcome) -> Self {
        let program = outcome.moves.iter().filter(|record| !record.homing);
        let mut lengths_mm: Vec<f64> = program
            .map(|record| {
                let (from, to) = (outcome.mm(record.corner_steps()), outcome.mm(record.next_corner_steps()));
                from.iter().zip(to).map(|(from, to)| (to - from).powi(2)).sum::<f64>().sqrt()
            })
            .collect();
        lengths_mm.sort_by(f64::total_cmp);
        let (Some(&least_mm), Some(&most_mm)) = (lengths_mm.first(), lengths_mm.last()) else { return Self::default() };
        Self { least_mm, median_mm: lengths_mm[lengths_mm.len() / 2], most_mm, total_mm: lengths_mm.iter().sum() }
    }
}

/// Checks every move. Also returns the listed moves, each as its number from 1 and its index in [`Outcome::moves`].
fn look_at(outcome: &Outcome, listed: Listed) -> (Findings, Vec<(usize, usize)>) {
    let mut findings = Findings::default();
    // For each move its duration, its error, and its number and index.
    let mut moves: Vec<(f64, f64, (usize, usize))> = Vec::new();
    for (number, check) in (1..).zip(verify::moves(outcome)) {
        findings.add(&check);
        moves.push((outcome.moves[check.index].duration_s(), check.error_max_ns(), (number, check.index)));
    }
    if listed == Listed::All || moves.len() <= MOVES_MAX {
        return (findings, moves.into_iter().map(|(.., place)| place).collect());
    }
    let mut picked: Vec<_> = moves.iter().take(FIRST_MOVES).map(|&(.., place)| place).collect();
    moves.sort_by(|one, other| other.0.total_cmp(&one.0));
    picked.extend(moves.iter().take(MOST_MOVES).map(|&(.., place)| place));
    moves.sort_by(|one, other| other.1.total_cmp(&one.1));
    picked.extend(moves.iter().take(MOST_MOVES).map(|&(.., place)| place));
    picked.sort_unstable();
    picked.dedup();
    (findings, picked)
}

fn move_figures(number: usize, line: Option<usize>, outcome: &Outcome, check: MoveCheck) -> MoveFigures {
    let record = &outcome.moves[check.index];
    MoveFigures {
        number,
        line,
        blend_s: record.line_begins_s(),
        start_ns: record.begin_ns(),
        from_mm: outcome.mm(record.corner_steps()),
        to_mm: outcome.mm(record.next_corner_steps()),
        steps: check.emitted_steps,
        planned: check.planned,
        apart_s: check.apart_s(),
        measured: check.measured,
        error_max_ns: check.error_max_ns,
        path_deviation: check.path_deviation,
        exact: check.exact,
    }
}
