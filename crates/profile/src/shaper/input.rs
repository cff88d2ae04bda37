//! The chunks of a chain as the phases of one axis.

use super::{Impulses, Shaped};
use crate::chain::{Chunk, ChunkKind, Plan};
use crate::fixed::is_zero;
use crate::phase::AxisPhase;
use crate::sync::SyncMove;

/// What is shaped, of the axes that a chain plans.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Combination {
    /// The axis with this index.
    Axis(usize),
    /// The sum of the first two: with crossed belts the carriage's way along X, in half steps.
    Sum,
    /// Their difference: its way along Y.
    Difference,
}

impl Combination {
    fn whole(self, of: impl Fn(usize) -> i32) -> i32 {
        match self {
            Self::Axis(axis) => of(axis),
            Self::Sum => of(0).wrapping_add(of(1)),
            Self::Difference => of(0).wrapping_sub(of(1)),
        }
    }

    fn place(self, of: impl Fn(usize) -> f64) -> f64 {
        match self {
            Self::Axis(axis) => of(axis),
            Self::Sum => of(0) + of(1),
            Self::Difference => of(0) - of(1),
        }
    }

    /// A phase of a plan, and when that ends.
    fn phase<const N: usize>(self, plan: &Plan<N>, index: usize) -> Option<(AxisPhase, f64)> {
        if let Self::Axis(axis) = self {
            return plan.phase(axis, index);
        }
        self.crossed_phase(plan, index)
    }

    #[cold]
    fn crossed_phase<const N: usize>(self, plan: &Plan<N>, index: usize) -> Option<(AxisPhase, f64)> {
        let ((one, end_s), (other, _)) = (plan.phase(0, index)?, plan.phase(1, index)?);
        let sign = if self == Self::Sum { 1.0 } else { -1.0 };
        let phase = AxisPhase {
            begin_s: one.begin_s,
            place_steps: one.place_steps + sign * other.place_steps,
            speed_steps_s: one.speed_steps_s + sign * other.speed_steps_s,
            accel_steps_s2: one.accel_steps_s2 + sign * other.accel_steps_s2,
        };
        Some((phase, end_s))
    }
}

/// Reads the chunks of a run, in order, for one axis.
#[derive(Clone, Copy, Debug)]
pub struct ShaperInput {
    source: Combination,
    /// The whole step next to where the move under way begins, counted from the beginning of the run.
    from_steps: i32,
    /// The phase of the chunk that comes next, and whether some of it has been read.
    index: usize,
    is_begun: bool,
}

impl ShaperInput {
    /// A reader of no run yet.
    #[must_use]
    pub const fn empty() -> Self {
        Self { source: Combination::Axis(0), from_steps: 0, index: 0, is_begun: false }
    }

    /// Begins a run of `source`, whose first chunk is this. Its top speed is `top_steps_s`.
    // Cold, as the end: they are needed once a run.
    #[cold]
    pub fn begin<const N: usize, const LEN: usize, T>(
        source: Combination,
        first: &Chunk<N, T>,
        shaped: &mut Shaped<LEN>,
        impulses: Impulses,
        top_steps_s: f64,
    ) -> Self {
        let (before, place_steps) = match &first.plan {
            Plan::Line(line) => {
                let begin_steps = line.begin_steps();
                (made(source, line, begin_steps), source.place(|axis| line.axis_place(axis, begin_steps)))
            }
            Plan::Blend(blend) => (
                source.whole(|axis| blend.ends_steps(axis)[0]),
                source.place(|axis| blend.place_at(axis, blend.begin_s())),
            ),
        };
        shaped.begin(impulses, top_steps_s, place_steps - f64::from(before));
        Self { source, from_steps: before.wrapping_neg(), index: 0, is_begun: false }
    }

    /// Reads one phase of the chunk, or what has become known of one. False if all that is known of it has been read, or there
    /// is no room.
    pub fn read<const N: usize, const LEN: usize, T>(&mut self, chunk: &Chunk<N, T>, shaped: &mut Shaped<LEN>) -> bool {
        let known_s = shaped.known_s();
        while known_s < chunk.until_s && (self.is_begun || shaped.has_room()) {
            let Some((phase, phase_end_s)) = self.source.phase(&chunk.plan, self.index) else { return false };
            let is_whole = phase_end_s <= chunk.until_s;
            let end_s = if is_whole { phase_end_s } else { chunk.until_s };
            let is_approach = self.index == 0 && chunk.plan.blend().is_some();
            if self.is_begun {
                shaped.extend(end_s.max(known_s), is_whole);
            } else if is_approach && shaped.can_do_without(&phase, end_s) {
                // The phase before it goes on.
            } else if !shaped.push(phase, self.from_steps, end_s, is_whole) && !is_whole {
                // Too little of it is known to begin it.
                return false;
            }
            (self.index, self.is_begun) = if is_whole { (self.index + 1, false) } else { (self.index, true) };
            if shaped.known_s() > known_s {
                return true;
            }
        }
        false
    }

    /// Goes on from one chunk, of which all has been read, to the next.
    pub fn go_on<const N: usize, T>(&mut self, from: &Chunk<N, T>, next: &Chunk<N, T>) {
        (self.index, self.is_begun) = (0, false);
        let is_move = match (&from.plan, &next.plan) {
            (_, Plan::Blend(_)) => true,
            // What is left of a move behind a blend or a hold begins at a place within it. A blend may have led to its end.
            (Plan::Blend(_), Plan::Line(line)) => begins(next, line.begin_steps()) && !is_zero(from.until_steps),
            (Plan::Line(_), Plan::Line(line)) => begins(next, line.begin_steps()),
        };
        if is_move {
            let steps = match &from.plan {
                Plan::Line(line) => &line.steps,
                Plan::Blend(blend) => &blend.steps,
            };
            let steps = self.source.whole(|axis| steps[axis]);
            self.from_steps = self.from_steps.wrapping_add(steps);
        }
    }

    /// The run ends with this chunk, of which all has been read; there is room for another phase.
    #[cold]
    pub fn finish<const N: usize, const LEN: usize, T>(&mut self, last: &Chunk<N, T>, shaped: &mut Shaped<LEN>) {
        let source = self.source;
        let (made, place_steps) = match &last.plan {
            Plan::Line(line) => {
                (made(source, line, last.until_steps), source.place(|axis| line.axis_place(axis, last.until_steps)))
            }
            Plan::Blend(blend) => (
                source.whole(|axis| blend.ends_steps(axis)[1]),
                source.place(|axis| blend.place_at(axis, blend.end_s())),
            ),
        };
        shaped.finish(place_steps, self.from_steps, self.from_steps.wrapping_add(made));
    }
}

/// True if a chunk with a line that begins at this place begins a move.
fn begins<const N: usize, T>(chunk: &Chunk<N, T>, begin_steps: f64) -> bool {
    chunk.kind == ChunkKind::Move && is_zero(begin_steps)
}

/// The steps that are made of a line up to a place, signed by direction.
fn made<const N: usize>(source: Combination, line: &SyncMove<N>, place_steps: f64) -> i32 {
    source.whole(|axis| {
        let steps = line.steps_before(axis, place_steps) as i32;
        if line.steps[axis] < 0 { -steps } else { steps }
    })
}
