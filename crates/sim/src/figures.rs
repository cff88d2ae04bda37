//! The figures of a run as one value: what the command line prints, the report shows and `--json` writes.

use isostep_motion::AXES;
use serde::Serialize;

use crate::config::Port;
use crate::driver::Violation;
use crate::kinematics::{self, AxisFigures};
use crate::lines_of_moves;
use crate::measure::{Intervals, Measured};
use crate::outcome::Outcome;
use crate::pace::Pace;
use crate::record::Loss;
use crate::stream::{Pause, Refusal};
use crate::tool::figures::ToolFigures;
use crate::verify::{self, Findings, MoveCheck, Verdict};

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

impl MoveFigures {
    /// How long it lasts, as planned, s.
    pub fn duration_s(&self) -> f64 {
        self.planned.accel_s + self.planned.cruise_s + self.planned.decel_s
    }

    /// The most that a step of any axis is off its closed-form instant, ns.
    pub fn error_max_ns(&self) -> f64 {
        self.error_max_ns.iter().flatten().copied().fold(0.0, f64::max)
    }
}

/// Which of a program's moves are listed one by one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Listed {
    /// All of them.
    All,
    /// All of a short program. Of a long one the first 1,000, the 500 that last longest and the 500 whose steps are farthest
    /// from their instants, so that a file of figures stays below 5 MB.
    Some,
}

/// Of so many moves all are listed.
const MOVES_MAX: usize = 2_000;
const FIRST_MOVES: usize = 1_000;
const MOST_MOVES: usize = 500;
/// Of steps lost and of edges that a driver may misread no more are listed, since many are alike.
const TROUBLES_MAX: usize = 1_000;

/// How long the moves of a program are, straight from where each begins to where it ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Lengths {
    /// The shortest.
    pub least_mm: f64,
    /// As many are shorter as are longer.
    pub median_mm: f64,
    /// The longest.
    pub most_mm: f64,
    /// All together.
    pub total_mm: f64,
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
    /// How many moves the program has.
    pub moves_total: usize,
    /// How long they are.
    pub lengths: Lengths,
    /// Its moves, those that are [`Listed`].
    pub moves: Vec<MoveFigures>,
    /// How fast each axis was, within moves and at corners.
    pub axes: [AxisFigures; AXES],
    /// How its time is spent, and what keeps it from being faster.
    pub pace: Pace,
    /// What the tool did; not there if it was not used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tool: Option<ToolFigures>,
    /// Every promise, and whether it was kept.
    pub verdicts: Vec<Verdict>,
    /// How many edges a driver may misread.
    pub violations_total: usize,
    /// They, up to 1,000.
    pub violations: Vec<Violation>,
    /// How often steps were lost.
    pub losses_total: usize,
    /// Steps that no carriage made, up to 1,000 times.
    pub losses: Vec<Loss>,
    /// The lines that the controller refused.
    pub refusals: Vec<Refusal>,
    /// The lines that waited for a person, and were resumed at once.
    pub pauses: Vec<Pause>,
    /// The number after `ALARM:`.
    pub alarm: Option<u8>,
}

impl Figures {
    /// The figures of `outcome`, the run of the program called `program`, with [`Listed::Some`] of its moves.
    pub fn new(program: &str, outcome: &Outcome) -> Self {
        Self::listing(program, outcome, Listed::Some)
    }

    /// The same with the moves that are `listed`.
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
            carriage_mm: outcome.mm(outcome.places_steps),
            verdicts: verify::verdicts(outcome, &findings),
            axes: kinematics::axes(outcome, &lines),
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
            losses: outcome.losses.iter().take(TROUBLES_MAX).copied().collect(),
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
                let (from, to) = (outcome.mm(record.origin_steps), outcome.mm(record.end_steps));
                from.iter().zip(to).map(|(from, to)| (to - from).powi(2)).sum::<f64>().sqrt()
            })
            .collect();
        lengths_mm.sort_by(f64::total_cmp);
        let (Some(&least_mm), Some(&most_mm)) = (lengths_mm.first(), lengths_mm.last()) else { return Self::default() };
        Self { least_mm, median_mm: lengths_mm[lengths_mm.len() / 2], most_mm, total_mm: lengths_mm.iter().sum() }
    }
}

/// Checks every move; and the moves that are listed, each as its number from 1 and its index in [`Outcome::moves`].
fn look_at(outcome: &Outcome, listed: Listed) -> (Findings, Vec<(usize, usize)>) {
    let mut findings = Findings::default();
    // Duration and error of each move, which has a number and an index.
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
