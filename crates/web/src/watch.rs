//! Looks at the pieces of a run, and keeps what a page has not taken yet.

use isostep_sim::tool::ToolChange;
use isostep_sim::verify::Gathered;
use isostep_sim::world::Wave;
use isostep_sim::{Outcome, trace, vcd};

use crate::Kept;
use crate::lines::Lines;
use crate::motion::Motion;

/// The observations of a run.
#[derive(Default)]
pub(crate) struct Watch {
    pub gathered: Gathered,
    kept: Kept,
    motion: Motion,
    pub lines: Lines,
    rows: Vec<u8>,
    waves: (Vec<Wave>, Vec<ToolChange>),
}

impl Watch {
    /// Nothing yet.
    pub fn new(kept: Kept) -> Self {
        Self { kept, ..Self::default() }
    }

    /// Looks at the next piece.
    pub fn add(&mut self, piece: &Outcome) {
        let is_first = self.gathered.edges() == 0;
        self.gathered.add(piece);
        self.motion.add(piece);
        match self.kept {
            Kept::Lines | Kept::Plan => self.lines.add(piece),
            Kept::Trace => self.add_trace(piece, is_first),
            Kept::Waves => {
                self.waves.0.extend_from_slice(&piece.waves);
                self.waves.1.extend_from_slice(&piece.tool);
            }
            Kept::Nothing => {}
        }
    }

    fn add_trace(&mut self, piece: &Outcome, is_first: bool) {
        if piece.edges.is_empty() {
            return;
        }
        let mut csv = Vec::new();
        trace::write(&piece.edges, &mut csv).expect("memory takes all that is written");
        // The names of the columns stand once, above all pieces.
        let names = csv.iter().position(|&byte| byte == b'\n').map_or(0, |end| end + 1);
        self.rows.extend_from_slice(if is_first { &csv } else { &csv[names..] });
    }

    /// The motion of the axes since this was asked last.
    pub fn take_motion(&mut self) -> Motion {
        self.motion.take()
    }

    /// The next whole piece of it, if there is one.
    pub fn take_piece(&mut self) -> Option<Motion> {
        self.motion.take_piece()
    }

    /// The text since this was asked last.
    pub fn take_rows(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.rows)
    }

    /// Looks at the last piece, and writes what can be written at the end only.
    pub fn end(&mut self, end: &Outcome) -> Lines {
        self.add(end);
        if self.kept == Kept::Waves {
            let (waves, tool) = std::mem::take(&mut self.waves);
            vcd::write(&waves, &tool, end.limits_high_at_start, &mut self.rows)
                .expect("memory takes all that is written");
        }
        std::mem::take(&mut self.lines)
    }
}
