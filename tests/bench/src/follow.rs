//! Compares every edge with the closed form of its move.

use std::io;

use isostep_profile::SyncMove;

use super::edges::{Edge, NS_PER_CYCLE};
use super::statistics::{Drift, DriftFigures, ErrorFigures, Errors};
use super::trial::AXES;

/// Why the edges do not match the moves.
#[derive(Debug)]
pub enum Astray {
    /// The file cannot be read.
    Read(io::Error),
    /// An axis made a wrong number of steps, or moved in the wrong direction.
    Steps { axis: usize, made: u64, planned: u64 },
    /// A step came while its axis should rest or move in the other direction.
    Stray { axis: usize, cycle: u64 },
}

/// The errors of all edges.
#[derive(Clone, Debug)]
pub struct Followed {
    pub errors: Errors,
    /// The drift in the first move.
    pub drift: DriftFigures,
}

impl Followed {
    pub fn figures(&self) -> ErrorFigures {
        self.errors.figures()
    }
}

/// Compares `edges` with `plans`.
///
/// The firmware chooses the instant at which a move starts. So in each move both the measured and the planned instants
/// count from its first edge, and a latency common to all edges does not show.
pub fn follow(edges: impl Iterator<Item = io::Result<Edge>>, plans: &[SyncMove<AXES>]) -> Result<Followed, Astray> {
    let mut edges = edges.peekable();
    let mut errors = Errors::default();
    let mut drifts = Vec::new();
    for plan in plans {
        let mut moved = Move::new(plan);
        while moved.left > 0 {
            let edge = edges.next().ok_or_else(|| moved.cut_short())?.map_err(Astray::Read)?;
            errors.add(moved.error_ns(edge)?);
        }
        drifts.push(moved.drift.figures());
    }
    match edges.next() {
        None => Ok(Followed { errors, drift: drifts[0] }),
        Some(Ok(Edge { axis, cycle, .. })) => Err(Astray::Stray { axis, cycle }),
        Some(Err(error)) => Err(Astray::Read(error)),
    }
}

/// A move whose edges are being read.
struct Move<'a> {
    plan: &'a SyncMove<AXES>,
    /// Steps that each axis has made.
    made: [u32; AXES],
    /// Number of edges still to come.
    left: u64,
    /// The board's time at instant 0 of the plan, ns. It is known from the first edge on.
    start_ns: Option<f64>,
    drift: Drift,
}

impl<'a> Move<'a> {
    fn new(plan: &'a SyncMove<AXES>) -> Self {
        let left = plan.steps.iter().map(|n| u64::from(n.unsigned_abs())).sum();
        Self { plan, made: [0; AXES], left, start_ns: None, drift: Drift::new(left) }
    }

    fn error_ns(&mut self, Edge { cycle, axis, direction }: Edge) -> Result<f64, Astray> {
        let steps = self.plan.steps[axis];
        if self.made[axis] == steps.unsigned_abs() || direction != steps.signum() {
            return Err(Astray::Stray { axis, cycle });
        }
        self.made[axis] += 1;
        self.left -= 1;
        let due_s = self.plan.step_time_s(axis, self.made[axis]);
        let t_ns = cycle as f64 * NS_PER_CYCLE;
        let start_ns = *self.start_ns.get_or_insert(t_ns - due_s * 1e9);
        let error_ns = t_ns - start_ns - due_s * 1e9;
        self.drift.add(due_s, error_ns);
        Ok(error_ns)
    }

    fn cut_short(&self) -> Astray {
        let short = (0..AXES).find(|&axis| self.made[axis] < self.plan.steps[axis].unsigned_abs());
        let axis = short.unwrap_or(0);
        Astray::Steps { axis, made: self.made[axis].into(), planned: self.plan.steps[axis].unsigned_abs().into() }
    }
}

impl std::fmt::Display for Astray {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = |axis: usize| ["X", "Y", "Z"][axis];
        match *self {
            Self::Read(ref error) => write!(f, "the edges cannot be read: {error}"),
            Self::Steps { axis, made, planned } => write!(f, "{} made {made} of {planned} steps", name(axis)),
            Self::Stray { axis, cycle } => {
                write!(f, "{} made a step that is in no plan, {:.6} s after power-up", name(axis), cycle as f64 * 8e-9)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::trial::{Machine, Trial};
    use super::*;

    /// A short move there and back, with edges that are exact to the cycle.
    fn ideal() -> (Vec<SyncMove<AXES>>, Vec<Edge>) {
        let machine = Machine::new(10_000, 0.01);
        let plans = Trial::new(machine, 2, 250, true).plans().unwrap();
        let start = [1_000_000, 90_000_000];
        let mut edges = Vec::new();
        for (plan, start) in plans.iter().zip(start) {
            for k in 1..=250 {
                for axis in 0..2 {
                    let cycle = start + (plan.step_time_s(axis, k) * 125e6).round() as u64;
                    edges.push(Edge { cycle, axis, direction: plan.steps[axis].signum() });
                }
            }
        }
        (plans, edges)
    }

    fn judge(plans: &[SyncMove<AXES>], edges: &[Edge]) -> Result<Followed, Astray> {
        follow(edges.iter().copied().map(Ok), plans)
    }

    #[test]
    fn edges_to_the_cycle_have_no_error_but_rounding() {
        let (plans, edges) = ideal();
        let followed = judge(&plans, &edges).unwrap();
        assert_eq!(followed.figures().edges, 1_000);
        assert!(followed.figures().max_ns <= 8.0, "half a cycle on either side: {:?}", followed.figures());
    }

    #[test]
    fn a_late_edge_is_seen_with_its_lateness() {
        let (plans, mut edges) = ideal();
        edges[100].cycle += 125;
        let figures = judge(&plans, &edges).unwrap().figures();
        assert!((figures.latest_ns - 1_000.0).abs() <= 8.0 && figures.p99_ns <= 8.0, "{figures:?}");
    }

    #[test]
    fn lost_added_and_turned_edges_are_named() {
        let (plans, edges) = ideal();
        let lost = judge(&plans, &edges[..edges.len() - 1]).unwrap_err();
        assert_eq!(lost.to_string(), "Y made 249 of 250 steps");
        let added = [edges.as_slice(), &edges[edges.len() - 1..]].concat();
        assert!(matches!(judge(&plans, &added), Err(Astray::Stray { axis: 1, .. })));
        let mut turned = edges.clone();
        turned[7].direction = -1;
        assert!(matches!(judge(&plans, &turned), Err(Astray::Stray { axis: 1, .. })));
    }
}
