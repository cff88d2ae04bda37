//! Compares another machine's step trace with the plans of a simulated run: that of the emulated board, or of a logic
//! analyser.
//!
//! Homing ends at a switch, at a different instant on each machine, so only the moves after the last homing are
//! compared. Every step of these moves must be present, with its direction and position. On both sides, instants count
//! from the first step of the run. So a latency that is common to all steps does not show; what remains is jitter.

use std::io;

use isostep_motion::{AXES, Axis};
use isostep_profile::Profile;

use isostep_sim::MoveRecord;
use isostep_sim::Outcome;
use isostep_sim::config::Port;
use isostep_sim::measure;
use isostep_sim::verify::shaped;
use isostep_sim::world::Edge;

/// The reason why a trace does not match the run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Mismatch {
    /// The file cannot be read as a trace.
    #[error("not a step trace with the header t_ns,axis,direction,position_steps: {0}")]
    Csv(#[from] csv::Error),
    /// A row names an axis that does not exist.
    #[error("row {row}: there is no axis `{axis}`")]
    Axis {
        /// Number of the row after the header, from 1.
        row: usize,
        /// The name in the row.
        axis: String,
    },
    /// An axis made fewer or more steps than the program has.
    #[error("{axis}: {traced} steps in the trace, {planned} in the program")]
    Count {
        /// The axis.
        axis: Axis,
        /// Steps in the trace. If the program homes, this includes the steps of homing.
        traced: usize,
        /// Steps in the program after homing.
        planned: usize,
    },
    /// A step has another direction or position.
    #[error("move {number}, {axis} step {k}: direction {}, position {} in the trace, {} and {} in the program",
        .traced.direction, .traced.position_steps, .planned.0, .planned.1)]
    Step {
        /// Number of the move among those after homing, from 1.
        number: usize,
        /// The axis.
        axis: Axis,
        /// Number of the step in its move, from 1.
        k: u32,
        /// The step in the trace.
        traced: Edge,
        /// Direction and position in the program.
        planned: (i32, i32),
    },
}

/// Distances of the steps from their closed-form instants, ns, for one move or for all.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Jitter {
    /// Number of steps.
    pub steps: usize,
    /// The median distance.
    pub median_ns: f64,
    /// 99 of 100 distances are no larger.
    pub p99_ns: f64,
    /// The largest distance.
    pub max_ns: f64,
}

/// The comparison of one move.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct MoveComparison {
    /// Its steps, compared with their closed form.
    #[serde(flatten)]
    pub jitter: Jitter,
    /// The largest difference between axes in the duration of acceleration, cruise or deceleration, each measured from
    /// the axis's own edges, ns. `None` if the edges of fewer than two axes resolve 10 us, or if one deviates too far
    /// from its instant.
    pub apart_ns: Option<f64>,
    /// The time from the end of the previous plan to the start of this one, both computed from the first moves of their
    /// runs, ns. Negative if the previous move was cut short. `None` for the first move.
    pub pause_ns: Option<f64>,
}

/// The comparison of a trace that matches the run.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Comparison {
    /// The moves after the last homing.
    pub moves: Vec<MoveComparison>,
    /// All these moves together.
    pub all: Jitter,
}

/// Reads a step trace.
///
/// # Errors
/// [`Mismatch::Csv`], [`Mismatch::Axis`].
pub fn read(input: impl io::Read) -> Result<Vec<Edge>, Mismatch> {
    let mut rows = csv::Reader::from_reader(input);
    let rows = rows.deserialize::<(u64, String, i32, i32)>().enumerate();
    rows.map(|(index, row)| {
        let (t_ns, name, direction, position_steps) = row?;
        let axis = Axis::ALL.into_iter().position(|axis| axis.to_string() == name);
        let axis = axis.ok_or(Mismatch::Axis { row: index + 1, axis: name })?;
        Ok(Edge { t_ns, axis, direction, position_steps })
    })
    .collect()
}

/// Compares `trace` with the plans of `outcome`.
///
/// # Errors
/// The first step that differs.
pub fn compare(outcome: &Outcome, trace: &[Edge]) -> Result<Comparison, Mismatch> {
    let after_homing = outcome.moves.iter().rposition(|record| record.homing).map_or(0, |last| last + 1);
    let moves = &outcome.moves[after_homing..];
    let dues = dues(outcome, moves);
    let mut left = split(trace, &dues, after_homing > 0)?;
    let mut all_ns = Vec::new();
    let mut compared = Vec::new();
    let mut plan_end_ns = None;
    let mut under_way = None;
    for (index, record) in moves.iter().enumerate() {
        let instants = instants_of(index + 1, &dues[index], &mut left)?;
        // All moves of a run count from the same instant.
        let start_ns = match under_way {
            Some((run, start_ns)) if run == record.run => start_ns,
            _ => start_of(&instants),
        };
        under_way = Some((record.run, start_ns));
        let errors_ns = errors_of(&instants, start_ns);
        let pause_ns = plan_end_ns.map(|end_ns| start_ns + record.begin_s() * 1e9 - end_ns);
        plan_end_ns = Some(start_ns + record.plan_s * 1e9);
        all_ns.extend_from_slice(&errors_ns);
        let (jitter, port) = (Jitter::of(errors_ns), outcome.config.port);
        // If an edge is further off than this, its ramp cannot be measured.
        let is_measurable = jitter.max_ns <= measure::stray_max_ns(port);
        compared.push(MoveComparison {
            jitter,
            pause_ns,
            apart_ns: record
                .profile()
                .filter(|_| is_measurable)
                .and_then(|profile| apart_ns(&profile, record, &instants, port)),
        });
    }
    Ok(Comparison { moves: compared, all: Jitter::of(all_ns) })
}

/// An edge of a move in closed form.
struct Due {
    /// s from the start of the run.
    t_s: f64,
    direction: i32,
    position_steps: i32,
}

/// For each move, the edges of each axis.
fn dues(outcome: &Outcome, moves: &[MoveRecord]) -> Vec<[Vec<Due>; AXES]> {
    let runs = moves.chunk_by(|one, next| one.run == next.run);
    let of_run = |run: &[MoveRecord]| match run[0].shaping {
        Some(_) => shaped_dues(outcome, run),
        None => run.iter().map(|record| std::array::from_fn(|axis| planned_dues(record, axis))).collect(),
    };
    runs.flat_map(of_run).collect()
}

fn planned_dues(record: &MoveRecord, axis: usize) -> Vec<Due> {
    let mut position_steps = record.origin_steps[axis];
    let dues = record.due_s(axis).map(|(t_s, direction)| {
        position_steps += direction;
        Due { t_s, direction, position_steps }
    });
    dues.collect()
}

/// The same for the moves of a shaped run: the edges that the simulated machine has made, each where the closed form has it.
fn shaped_dues(outcome: &Outcome, run: &[MoveRecord]) -> Vec<[Vec<Due>; AXES]> {
    let errors_ns = Axis::ALL.map(|axis| shaped::errors_ns(outcome, run, axis));
    let mut errors_ns = errors_ns.map(Vec::into_iter);
    let mut at = run[0].origin_steps;
    let of_move = |record: &MoveRecord| {
        let mut dues: [Vec<Due>; AXES] = Default::default();
        for edge in outcome.edges_of(record) {
            at[edge.axis] += edge.direction;
            let late_ns = errors_ns[edge.axis].next().map_or(0.0, |(_, late_ns)| late_ns);
            let t_s = ((edge.t_ns as f64 - record.start_ns as f64) - late_ns) * 1e-9;
            dues[edge.axis].push(Due { t_s, direction: edge.direction, position_steps: at[edge.axis] });
        }
        dues
    };
    run.iter().map(of_move).collect()
}

/// The edges of each axis that belong to moves with these, which are the last ones. Returned in reverse order.
fn split<'a>(trace: &'a [Edge], dues: &[[Vec<Due>; AXES]], homed: bool) -> Result<[Vec<&'a Edge>; AXES], Mismatch> {
    let mut edges: [Vec<&Edge>; AXES] = Default::default();
    for edge in trace {
        edges[edge.axis].push(edge);
    }
    for axis in Axis::ALL {
        let edges = &mut edges[axis as usize];
        let planned = dues.iter().map(|dues| dues[axis as usize].len()).sum();
        let traced = edges.len();
        if traced < planned || (traced > planned && !homed) {
            return Err(Mismatch::Count { axis, traced, planned });
        }
        // Reversed, so that the next edge is taken from the end.
        edges.reverse();
        edges.truncate(planned);
    }
    Ok(edges)
}

/// For each axis, the instants of its edges in the trace and in closed form, ns.
type Instants = [Vec<(f64, f64)>; AXES];

fn instants_of(number: usize, dues: &[Vec<Due>; AXES], left: &mut [Vec<&Edge>; AXES]) -> Result<Instants, Mismatch> {
    let mut instants = Instants::default();
    for axis in Axis::ALL {
        for (k, due) in (1..).zip(&dues[axis as usize]) {
            let traced = *left[axis as usize].pop().expect("as many were kept as are planned");
            let planned = (due.direction, due.position_steps);
            if (traced.direction, traced.position_steps) != planned {
                return Err(Mismatch::Step { number, axis, k, traced, planned });
            }
            instants[axis as usize].push((traced.t_ns as f64, due.t_s * 1e9));
        }
    }
    Ok(instants)
}

/// The start of the run, as the edges of its first move say in the median, ns. One edge would not do: where tasks make
/// the steps the first may be microseconds later than most.
fn start_of(instants: &Instants) -> f64 {
    let mut starts: Vec<f64> = instants.iter().flatten().map(|(traced, exact)| traced - exact).collect();
    starts.sort_by(f64::total_cmp);
    starts.get(starts.len() / 2).copied().unwrap_or_default()
}

/// The lateness of each edge in a run that started at `start_ns`, ns.
fn errors_of(instants: &Instants, start_ns: f64) -> Vec<f64> {
    instants.iter().flatten().map(|(traced, exact)| (traced - start_ns) - exact).collect()
}

/// If intervals are not resolved at least this well, a comparison says nothing, s.
const RESOLUTION_MAX_S: f64 = 10e-6;

fn apart_ns(profile: &Profile, record: &MoveRecord, instants: &Instants, port: Port) -> Option<f64> {
    let measured = instants.iter().enumerate().filter_map(|(axis, edges)| {
        let edges = edges.get(record.blend_steps(axis) as usize..)?;
        // Counted from the first edge, so that no digits are lost to a large offset.
        let (first_ns, _) = *edges.first()?;
        let times_s: Vec<_> = edges.iter().map(|(traced_ns, _)| (traced_ns - first_ns) * 1e-9).collect();
        measure::intervals_of(profile, &record.way(axis), &times_s, port)
    });
    let resolved = measured.filter(|measured| measured.resolution_s <= RESOLUTION_MAX_S);
    let measured: Vec<_> = resolved.map(|measured| measured.intervals).collect();
    let (first, rest) = measured.split_first()?;
    rest.iter().map(|other| first.apart_s(other) * 1e9).reduce(f64::max)
}

impl Jitter {
    fn of(errors_ns: Vec<f64>) -> Self {
        let mut sorted: Vec<f64> = errors_ns.into_iter().map(f64::abs).collect();
        sorted.sort_by(f64::total_cmp);
        let quantile = |ratio: f64| sorted.get((sorted.len() as f64 * ratio) as usize).or(sorted.last());
        let at = |ratio: f64| quantile(ratio).copied().unwrap_or(0.0);
        Self { steps: sorted.len(), median_ns: at(0.5), p99_ns: at(0.99), max_ns: at(1.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use isostep_sim::{Config, run};

    const PROGRAM: &[u8] = b"$H\nG61 G0 X1 Y0.5\nG0 X0.5\n";

    fn traced() -> (Outcome, Vec<Edge>) {
        let outcome = run(PROGRAM, &Config::default()).unwrap();
        let edges = outcome.edges.clone();
        (outcome, edges)
    }

    #[test]
    fn a_run_compares_with_itself_to_the_tick() {
        let (outcome, edges) = traced();
        let comparison = compare(&outcome, &edges).unwrap();
        assert_eq!(comparison.moves.iter().map(|each| each.jitter.steps).collect::<Vec<_>>(), [75, 25]);
        let both_sides_ns = 2.0 * Config::default().port.tolerance_ns();
        assert!(comparison.all.max_ns < both_sides_ns, "half a tick and the fit, on both sides: {comparison:?}");
    }

    #[test]
    fn a_latency_of_all_steps_is_no_jitter_but_one_late_step_is() {
        let (outcome, mut edges) = traced();
        let on_time = compare(&outcome, &edges).unwrap();
        edges.iter_mut().for_each(|edge| edge.t_ns += 5_000_000);
        assert_eq!(compare(&outcome, &edges).unwrap(), on_time);
        edges.last_mut().unwrap().t_ns += 9_000;
        let max_ns = compare(&outcome, &edges).unwrap().all.max_ns;
        assert!((8_900.0..9_100.0).contains(&max_ns), "{max_ns}");
    }

    #[test]
    fn a_missing_step_or_a_wrong_direction_is_a_mismatch() {
        let (outcome, edges) = traced();
        let mut short = edges.clone();
        short.pop();
        assert!(matches!(compare(&outcome, &short), Err(Mismatch::Step { axis: Axis::X, .. })));
        assert!(matches!(compare(&outcome, &short[short.len() - 9..]), Err(Mismatch::Count { .. })));
        let mut turned = edges;
        turned.last_mut().unwrap().direction = 1;
        assert!(matches!(compare(&outcome, &turned), Err(Mismatch::Step { number: 2, k: 25, .. })));
    }

    #[test]
    fn what_is_no_trace_is_refused() {
        let bad = read(b"t_ns,axis,direction,position_steps\n5,Q,1,1\n".as_slice()).unwrap_err();
        assert_eq!(bad.to_string(), "row 1: there is no axis `Q`");
        assert!(matches!(read(b"t_ns,axis,direction,position_steps\nx,X,1,1\n".as_slice()), Err(Mismatch::Csv(_))));
    }
}
