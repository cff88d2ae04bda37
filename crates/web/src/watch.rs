//! Looks at the pieces of a run, and keeps what a page has not taken yet.

use isostep_sim::verify::Gathered;
use isostep_sim::{Outcome, trace};

use crate::motion::Motion;

/// What was seen of a run.
pub(crate) struct Watch {
    pub gathered: Gathered,
    motion: Motion,
    /// Rows of the trace; `None` if nobody wants it.
    trace: Option<Vec<u8>>,
}

impl Watch {
    /// Nothing yet. The trace takes memory until it is taken, so it is kept only if it is wanted.
    pub fn new(with_trace: bool) -> Self {
        Self { gathered: Gathered::default(), motion: Motion::default(), trace: with_trace.then(Vec::new) }
    }

    /// Looks at the next piece.
    pub fn add(&mut self, piece: &Outcome) {
        let is_first = self.gathered.edges() == 0;
        self.gathered.add(piece);
        self.motion.add(piece);
        if let Some(rows) = &mut self.trace
            && !piece.edges.is_empty()
        {
            let mut csv = Vec::new();
            trace::write(&piece.edges, &mut csv).expect("memory takes all that is written");
            // The names of the columns stand once, above all pieces.
            let names = csv.iter().position(|&byte| byte == b'\n').map_or(0, |end| end + 1);
            rows.extend_from_slice(if is_first { &csv } else { &csv[names..] });
        }
    }

    /// How the axes moved since this was asked last.
    pub fn take_motion(&mut self) -> Motion {
        std::mem::take(&mut self.motion)
    }

    /// The rows of the trace since this was asked last, as `isostep sim --trace` writes them.
    pub fn take_trace(&mut self) -> Vec<u8> {
        self.trace.as_mut().map(std::mem::take).unwrap_or_default()
    }
}
