//! Checks the promises edge by edge: exact counts, instants by the closed form, straight paths, equal intervals.
//!
//! A move of a shaped run is not judged by itself: see [`shaped`].

mod gathered;
pub mod shaped;
mod together;

pub use self::gathered::{Gathered, HomingTime};
pub use self::together::Together;

use isostep_motion::{AXES, Axis, State};
use isostep_profile::Profile;

use crate::config::Port;
use crate::driver::Violation;
use crate::losses::LossFigures;
use crate::measure::{self, Intervals, Measured};
use crate::moves::MoveRecord;
use crate::outcome::Outcome;
use crate::record::Edge;

/// The results for one move.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MoveCheck {
    /// Index in [`Outcome::moves`].
    pub index: usize,
    /// Steps that were made, signed; in a shaped run as they were planned.
    pub emitted_steps: [i32; AXES],
    /// True if exactly the planned steps were made; `None` in a shaped run, and so is all that is measured.
    pub exact: Option<bool>,
    /// For each axis, the largest distance of an edge from its closed-form instant, ns; `None` for an axis at rest.
    pub error_max_ns: [Option<f64>; AXES],
    /// The largest distance of two axes from the straight line, in units of half a step of each: 1 is the bound |x/nx -
    /// y/ny| <= 1/2 (1/nx + 1/ny). `None` if fewer than two axes move.
    pub path_deviation: Option<f64>,
    /// Planned intervals. There is one profile, so they are the same for every axis.
    pub planned: Intervals,
    /// For each axis, intervals of its line measured from its own edges ([`measure`]); `None` for an axis at rest or with too
    /// few edges.
    pub measured: [Option<Measured>; AXES],
    /// How far it is from where the moves that it is made for were to end.
    pub together: Together,
    /// The amount that the tolerance of the instants can add to `path_deviation`.
    path_slack: f64,
}

impl MoveCheck {
    /// The largest error of any axis, ns.
    pub fn error_max_ns(&self) -> f64 {
        self.error_max_ns.iter().flatten().copied().fold(0.0, f64::max)
    }

    /// True if the path stayed within half a step of both axes.
    pub fn is_straight(&self) -> bool {
        self.path_deviation.is_none_or(|deviation| deviation <= 1.0 + self.path_slack)
    }

    /// The largest difference between measured intervals of two axes, s; `None` if fewer than two were measured.
    pub fn apart_s(&self) -> Option<f64> {
        let measured: Vec<_> = self.measured.iter().flatten().collect();
        let (first, rest) = measured.split_first()?;
        rest.iter().map(|other| first.intervals.apart_s(&other.intervals)).reduce(f64::max)
    }

    /// The coarsest resolution of what [`apart_s`](Self::apart_s) compares, s.
    fn resolution_s(&self) -> Option<f64> {
        self.apart_s()?;
        self.measured.iter().flatten().map(|measured| measured.resolution_s).reduce(f64::max)
    }

    /// True if the measured intervals of all axes are equal, within the resolution of their edges.
    pub fn is_equal(&self) -> bool {
        let measured: Vec<_> = self.measured.iter().flatten().collect();
        measured.iter().enumerate().all(|(index, one)| measured[index + 1..].iter().all(|other| one.agrees(other)))
    }
}

/// Checks every move of the program. Moves of homing are left out because they end at a switch.
pub fn moves(outcome: &Outcome) -> impl Iterator<Item = MoveCheck> {
    let indices = 0..outcome.moves.len();
    indices.filter(|&index| !outcome.moves[index].homing).map(|index| check(outcome, index))
}

/// Checks the move with this index in [`Outcome::moves`].
pub fn check(outcome: &Outcome, index: usize) -> MoveCheck {
    let record = &outcome.moves[index];
    let whole = record.profile();
    let profile = whole.unwrap_or(record.plan.profile);
    let unjudged = MoveCheck {
        index,
        emitted_steps: record.planned_steps(),
        exact: None,
        error_max_ns: [None; AXES],
        path_deviation: None,
        planned: Intervals {
            accel_s: profile.t_accel_s(),
            cruise_s: profile.t_cruise_s(),
            decel_s: profile.t_decel_s(),
        },
        measured: [None; AXES],
        together: Together::of(record, &outcome.config_of(record).steps_per_mm),
        path_slack: 0.0,
    };
    if record.shaping.is_some() { unjudged } else { judged(outcome, record, whole, unjudged) }
}

/// The results for a move that is judged by itself. `whole` is the single profile of its line, if it has one.
fn judged(outcome: &Outcome, record: &MoveRecord, whole: Option<Profile>, unjudged: MoveCheck) -> MoveCheck {
    let (edges, port) = (outcome.edges_of(record), outcome.config.port);
    let times_s = axis_times_s(record, edges);
    let emitted_steps = std::array::from_fn(|axis| {
        edges.iter().filter(|edge| edge.axis == axis).map(|edge| edge.direction).sum::<i32>()
    });
    let is_exact = emitted_steps == unjudged.emitted_steps && edges.len() as u64 == record.planned_edges();
    let (path_deviation, path_slack) = path(record, edges, port);
    MoveCheck {
        emitted_steps,
        exact: Some(is_exact),
        error_max_ns: std::array::from_fn(|axis| {
            errors_ns(record, axis, &times_s[axis]).map(|(_, error_ns)| error_ns.abs()).reduce(f64::max)
        }),
        path_deviation,
        path_slack,
        measured: std::array::from_fn(|axis| {
            let on_line = times_s[axis].get(record.blend_steps(axis) as usize..)?;
            measure::intervals_of(&whole?, &record.way(axis), on_line, port)
        }),
        ..unjudged
    }
}

/// Instants of each axis's edges from the beginning of the move, s.
pub fn axis_times_s(record: &MoveRecord, edges: &[Edge]) -> [Vec<f64>; AXES] {
    let mut times_s = [const { Vec::new() }; AXES];
    for edge in edges {
        times_s[edge.axis].push(record.passed_s(edge.t_ns));
    }
    times_s
}

/// For each edge, its instant from the beginning of the move, s, and how much later than the closed form it was, ns.
pub fn errors_ns(record: &MoveRecord, axis: usize, times_s: &[f64]) -> impl Iterator<Item = (f64, f64)> {
    let begin_s = record.begin_s();
    times_s.iter().zip(record.due_s(axis)).map(move |(&t_s, (due_s, _))| (t_s, (t_s - (due_s - begin_s)) * 1e9))
}

/// The largest difference between two axes' fractions of their distances, and how much the tolerance of the instants
/// may add to it.
fn path(record: &MoveRecord, edges: &[Edge], port: Port) -> (Option<f64>, f64) {
    // Lengths and places in the direction of the move.
    let n: [f64; AXES] = std::array::from_fn(|axis| record.plan.axis_steps(axis).abs());
    let begins: [f64; AXES] =
        std::array::from_fn(|axis| record.plan.axis_place(axis, 0.0) * record.plan.axis_steps(axis).signum());
    let pairs = (0..AXES.min(3)).flat_map(|j| (0..j).map(move |i| (i, j)));
    let pairs: Vec<_> = pairs.filter(|&(i, j)| n[i] > 0.0 && n[j] > 0.0).collect();
    // A move that was held continues where it was held.
    let mut made: [f64; AXES] = std::array::from_fn(|axis| f64::from(record.plan.step_numbers(axis).start - 1));
    let mut deviation = 0.0_f64;
    // Edges at the same instant belong together.
    let mut bent: [u32; AXES] = std::array::from_fn(|axis| record.blend_steps(axis));
    let is_on_line = |edge: &Edge| {
        let left = &mut bent[edge.axis];
        *left == 0 || {
            *left -= 1;
            false
        }
    };
    let edges: Vec<Edge> = edges.iter().copied().filter(is_on_line).collect();
    for together in edges.chunk_by(|one, next| one.t_ns == next.t_ns) {
        for edge in together {
            made[edge.axis] += 1.0;
        }
        for &(i, j) in &pairs {
            let bound = 0.5 / n[i] + 0.5 / n[j];
            let [one, other] = [i, j].map(|axis| (made[axis] - begins[axis]) / n[axis]);
            deviation = deviation.max((one - other).abs() / bound);
        }
    }
    let profile = record.plan.profile;
    // One axis may be early while the other is late.
    let apart_s = 2.0 * port.tolerance_ns() * 1e-9;
    let ratio = profile.cruise_speed_steps_s() * apart_s / profile.distance_steps();
    let slack = pairs.iter().map(|&(i, j)| ratio / (0.5 / n[i] + 0.5 / n[j])).fold(0.0, f64::max);
    ((!pairs.is_empty()).then_some(deviation), slack)
}

/// One promise, and whether it was kept.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Verdict {
    /// The promise.
    pub promise: &'static str,
    /// True if it was kept.
    pub kept: bool,
    /// Figures on how it was kept or broken.
    pub detail: String,
}

/// The results for many moves.
#[derive(Clone, Copy, Debug, Default)]
pub struct Findings {
    moves: usize,
    /// Number of moves of shaped runs, which are not judged by themselves.
    shaped: usize,
    exact: usize,
    error_max_ns: f64,
    /// Number of moves of several axes, their largest deviation from the straight line, and how many exceed the bound.
    paths: usize,
    path_deviation: f64,
    bent: usize,
    /// Number of moves whose intervals were measured on several axes, their largest difference, and its resolution.
    measured: usize,
    apart_s: f64,
    resolution_s: f64,
    unequal: usize,
    together: Together,
}

impl Findings {
    /// Moves that were made together.
    pub fn together(&self) -> Together {
        self.together
    }

    /// Number of moves checked.
    pub fn moves(&self) -> usize {
        self.moves
    }

    /// The reason why there is nothing to tell of moves: `words`, unless all of them are shaped.
    fn nothing(&self, words: &str) -> String {
        let all_shaped = self.shaped > 0 && self.shaped == self.moves;
        if all_shaped { "shaped runs are not judged by this" } else { words }.to_owned()
    }

    /// Adds the results for one move.
    pub fn add(&mut self, check: &MoveCheck) {
        self.moves += 1;
        self.shaped += usize::from(check.exact.is_none());
        self.exact += usize::from(check.exact == Some(true));
        self.error_max_ns = self.error_max_ns.max(check.error_max_ns());
        self.together = self.together.and(check.together);
        if let Some(deviation) = check.path_deviation {
            self.paths += 1;
            self.path_deviation = self.path_deviation.max(deviation);
            self.bent += usize::from(!check.is_straight());
        }
        if let (Some(apart_s), Some(resolution_s)) = (check.apart_s(), check.resolution_s()) {
            self.measured += 1;
            self.apart_s = self.apart_s.max(apart_s);
            self.resolution_s = self.resolution_s.max(resolution_s);
            self.unequal += usize::from(!check.is_equal());
        }
    }
}

impl FromIterator<MoveCheck> for Findings {
    fn from_iter<I: IntoIterator<Item = MoveCheck>>(checks: I) -> Self {
        let mut findings = Self::default();
        checks.into_iter().for_each(|check| findings.add(&check));
        findings
    }
}

/// All promises of a run, with their results.
pub fn verdicts(outcome: &Outcome, findings: &Findings) -> Vec<Verdict> {
    Gathered::whole(outcome, *findings).verdicts(outcome)
}

fn program(outcome: &Outcome) -> Verdict {
    let kept = outcome.refusals.is_empty() && outcome.alarm_code.is_none() && outcome.state == State::Idle;
    let detail = match (outcome.refusals.first(), outcome.alarm()) {
        (Some(refusal), _) => format!("line {} refused with error:{}", refusal.line, refusal.code),
        (None, Some(alarm)) => format!("ended in alarm: {alarm}"),
        (None, None) => format!("{} lines sent", outcome.lines_sent),
    };
    Verdict { promise: "every line accepted, machine idle", kept, detail }
}

fn counts(findings: &Findings, runs: &shaped::Findings) -> Verdict {
    let (exact, judged) = (findings.exact, findings.moves - findings.shaped);
    let moves = (judged > 0 || runs.runs == 0).then(|| format!("{exact} of {judged} moves"));
    let detail: Vec<_> = moves.into_iter().chain(runs.words()).collect();
    let kept = exact == judged && runs.exact == runs.runs;
    Verdict { promise: "step counts exact", kept, detail: detail.join(", ") }
}

fn instants(worst_ns: f64, port: Port) -> Verdict {
    let tick_ns = port.tick_ns();
    let detail = format!("at most {worst_ns:.0} ns from the closed form, one tick is {tick_ns:.0} ns");
    Verdict { promise: "every step at its instant", kept: worst_ns <= port.tolerance_ns(), detail }
}

fn straight(findings: &Findings) -> Verdict {
    let Findings { paths, path_deviation, bent, .. } = *findings;
    let detail = match paths {
        0 => findings.nothing("no move of several axes"),
        _ => format!("|x/nx - y/ny| at most {path_deviation:.4} of half a step of both axes, in {paths} moves"),
    };
    Verdict { promise: "paths straight within half a step", kept: bent == 0, detail }
}

fn equal(findings: &Findings) -> Verdict {
    let Findings { measured, apart_s, resolution_s, unequal, .. } = *findings;
    let detail = match measured {
        0 => findings.nothing("no move of several axes with enough edges to measure"),
        _ => {
            let (apart_ns, resolution_ns) = (apart_s * 1e9, resolution_s * 1e9);
            format!(
                "at most {apart_ns:.0} ns apart in {measured} moves, from each axis's edges, which resolve {resolution_ns:.0} ns"
            )
        }
    };
    Verdict { promise: "equal intervals on every axis", kept: unequal == 0, detail }
}

/// The promise about the pauses between moves; `shortest_ns` is that of the shortest of them.
fn lasting(shortest_ns: Option<f64>, pauses: usize) -> Verdict {
    let detail = match shortest_ns {
        Some(ns) => {
            let us = ns / 1e3;
            format!("from the end of a plan to the next start at least {us:.2} us, over {} moves", pauses + 1)
        }
        None => "no move after another".to_owned(),
    };
    // The end of a plan is computed in floating point.
    Verdict { promise: "every move as long as its plan", kept: shortest_ns.is_none_or(|ns| ns > -1.0), detail }
}

fn timing(first: Option<&Violation>, violations: usize, edges: usize) -> Verdict {
    let detail = match first {
        Some(first) => format!("{violations} violations, the first: {first}"),
        None => format!("at each of {edges} edges"),
    };
    Verdict { promise: "driver timing kept", kept: first.is_none(), detail }
}

fn no_loss(first: Option<&LossFigures>, steps_lost: u32, edges: usize) -> Verdict {
    let detail = match first {
        Some(first) => format!("{steps_lost} lost, first at {first}"),
        None => format!("all {edges} made by the carriages"),
    };
    Verdict { promise: "no step lost", kept: first.is_none(), detail }
}

fn position(outcome: &Outcome) -> Verdict {
    let detail = match Axis::ALL.iter().find(|&&axis| outcome.drift_steps[axis as usize] != 0) {
        Some(&axis) => {
            format!("{axis} stands {} steps from where the controller believes", outcome.drift_steps[axis as usize])
        }
        None => "carriages stand where the controller says".to_owned(),
    };
    let kept = outcome.drift_steps == [0; AXES] && outcome.motor_steps == outcome.counted_steps;
    Verdict { promise: "final position exact", kept, detail }
}
