//! The motion of a load from edge to edge.

use isostep_motion::{AXES, Axis};

use isostep_sim::Outcome;
use isostep_sim::analysis::{Oscillator, Ringing};

/// A time between two edges of an axis, in which its load swings on its own.
#[derive(Clone, Copy, Debug)]
pub struct Swing {
    /// When it begins: at an edge, s since power-up.
    pub begin_s: f64,
    /// When it ends: at the next edge, or with the run.
    pub end_s: f64,
    /// Index in [`Outcome::moves`] of the move that the edge at its beginning belongs to.
    pub index: usize,
    oscillator: Oscillator,
    /// The load right after that edge, mm from where the edge has put the axis.
    load: Ringing,
    /// The steps at its beginning and its end, mm, signed.
    steps_mm: [f64; 2],
}

/// The swings of a load on `axis`, in order: one for each edge.
pub fn swings(outcome: &Outcome, axis: Axis, oscillator: Oscillator) -> impl Iterator<Item = Swing> {
    let mut edges = edges(outcome, axis as usize).peekable();
    let mut load = Ringing::default();
    let rest_s = rest_s(outcome);
    std::iter::from_fn(move || {
        let edge = edges.next()?;
        let next = edges.peek();
        load = oscillator.shift(load, edge.step_mm);
        let swing = Swing {
            begin_s: edge.t_ns as f64 * 1e-9,
            end_s: next.map_or(rest_s, |next| next.t_ns as f64 * 1e-9),
            index: edge.index,
            oscillator,
            load,
            steps_mm: [edge.step_mm, next.map_or(0.0, |next| next.step_mm)],
        };
        load = next
            .map_or(load, |next| oscillator.advance(load, next.t_ns.saturating_sub(edge.t_ns) as f64 * 1e-9, 0.0, 0.0));
        Some(swing)
    })
}

/// When all is at rest: the end of the run, or of its last plan, which may be a little later.
fn rest_s(outcome: &Outcome) -> f64 {
    let plan_s = outcome.moves.last().map_or(0.0, |last| last.start_ns as f64 * 1e-9 + last.plan_s);
    plan_s.max(outcome.duration_ns as f64 * 1e-9)
}

/// One step of an axis.
#[derive(Clone, Copy)]
struct Step {
    t_ns: u64,
    step_mm: f64,
    index: usize,
}

/// The edges of all moves that move an axis, each a step of the resolution that its move was planned with.
fn edges(outcome: &Outcome, axis: usize) -> impl Iterator<Item = Step> {
    let moves = outcome.kinematics.moves(Axis::ALL[axis]);
    outcome.moves.iter().enumerate().flat_map(move |(index, record)| {
        let step_mm = |motor: usize| {
            let mut steps = [0.0; AXES];
            steps[motor] = 1.0;
            outcome.mm_of_move(record, steps)[axis]
        };
        let steps_mm: [f64; AXES] = std::array::from_fn(step_mm);
        let own = outcome.edges_of(record).iter().filter(move |edge| moves[edge.axis]);
        own.map(move |edge| {
            let step_mm = f64::from(edge.direction) * steps_mm[edge.axis];
            Step { t_ns: edge.t_ns, step_mm, index }
        })
    })
}

impl Swing {
    /// The load at an instant of the swing, mm from where its edge has put the axis.
    fn at(&self, t_s: f64) -> Ringing {
        self.oscillator.advance(self.load, t_s - self.begin_s, 0.0, 0.0)
    }

    /// The deviation of the load from its axis at an instant of the swing, mm; at an edge from the middle of its step.
    pub fn deviation(&self, t_s: f64) -> f64 {
        let at_edge = match t_s {
            _ if t_s <= self.begin_s => self.steps_mm[0] / 2.0,
            _ if t_s >= self.end_s => -self.steps_mm[1] / 2.0,
            _ => 0.0,
        };
        self.at(t_s).displacement + at_edge
    }

    /// The amplitude with which the load would go on swinging if no edge came after an instant of the swing, mm.
    pub fn amplitude(&self, t_s: f64) -> f64 {
        self.oscillator.amplitude(self.at(t_s))
    }

    /// The least and the greatest deviation from one instant of the swing to another, mm.
    pub fn range(&self, from_s: f64, to_s: f64) -> (f64, f64) {
        let turns = self.oscillator.turns(self.at(from_s), to_s - from_s);
        let first = self.deviation(from_s);
        turns.chain([self.deviation(to_s)]).fold((first, first), |(low, high), mm| (low.min(mm), high.max(mm)))
    }

    /// The largest deviation from one instant of the swing to another, mm.
    pub fn largest(&self, from_s: f64, to_s: f64) -> f64 {
        let (low, high) = self.range(from_s, to_s);
        high.max(-low)
    }
}
