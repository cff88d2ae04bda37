//! The chunks of a chain as the phases of one axis.

use super::{Impulses, Shaped};
use crate::chain::{Chunk, ChunkKind, Plan};
use crate::fixed::is_zero;

/// Reads the chunks of a run, in order, for one axis.
#[derive(Clone, Copy, Debug)]
pub struct ShaperInput {
    axis: usize,
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
        Self { axis: 0, from_steps: 0, index: 0, is_begun: false }
    }

    /// Begins a run of the axis with index `axis`, whose first chunk is this. Its top speed is `top_steps_s`.
    pub fn begin<const N: usize, const LEN: usize, T>(
        axis: usize,
        first: &Chunk<N, T>,
        shaped: &mut Shaped<LEN>,
        impulses: Impulses,
        top_steps_s: f64,
    ) -> Self {
        let (before, place_steps) = match &first.plan {
            Plan::Line(line) => {
                let begin_steps = line.begin_steps();
                (signed(line.steps[axis], line.steps_before(axis, begin_steps)), line.axis_place(axis, begin_steps))
            }
            Plan::Blend(blend) => (blend.ends_steps(axis)[0], blend.place_at(axis, blend.begin_s())),
        };
        shaped.begin(impulses, top_steps_s, place_steps - f64::from(before));
        Self { axis, from_steps: before.wrapping_neg(), index: 0, is_begun: false }
    }

    /// Reads one phase of the chunk, or what has become known of one. False if all that is known of it has been read, or there
    /// is no room.
    pub fn read<const N: usize, const LEN: usize, T>(&mut self, chunk: &Chunk<N, T>, shaped: &mut Shaped<LEN>) -> bool {
        let known_s = shaped.known_s();
        while known_s < chunk.until_s && (self.is_begun || shaped.has_room()) {
            let Some((phase, phase_end_s)) = chunk.plan.phase(self.axis, self.index) else { return false };
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
                Plan::Line(line) => line.steps[self.axis],
                Plan::Blend(blend) => blend.steps[self.axis],
            };
            self.from_steps = self.from_steps.wrapping_add(steps);
        }
    }

    /// The run ends with this chunk, of which all has been read; there is room for another phase.
    pub fn finish<const N: usize, const LEN: usize, T>(&mut self, last: &Chunk<N, T>, shaped: &mut Shaped<LEN>) {
        let axis = self.axis;
        let (made, place_steps) = match &last.plan {
            Plan::Line(line) => {
                let made = signed(line.steps[axis], line.steps_before(axis, last.until_steps));
                (made, line.axis_place(axis, last.until_steps))
            }
            Plan::Blend(blend) => (blend.ends_steps(axis)[1], blend.place_at(axis, blend.end_s())),
        };
        shaped.finish(place_steps, self.from_steps, self.from_steps.wrapping_add(made));
    }
}

/// True if a chunk with a line that begins at this place begins a move.
fn begins<const N: usize, T>(chunk: &Chunk<N, T>, begin_steps: f64) -> bool {
    chunk.kind == ChunkKind::Move && is_zero(begin_steps)
}

/// So many steps in the direction of a move of this many.
fn signed(of: i32, steps: u32) -> i32 {
    if of < 0 { -(steps as i32) } else { steps as i32 }
}
