//! The data that the chain carries with each move.

use isostep_profile::chain;

use crate::axes::AXES;
use crate::machine::Move;
use crate::tool::power::{Level, Power, PowerMode};

/// A move for the chain.
pub(crate) type Request = chain::Request<AXES, Tag>;
/// A part of a plan that the chain has handed out.
pub(crate) type Chunk = chain::Chunk<AXES, Tag>;

/// The marks that belong to a block: so many, from this place on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MarksOf {
    pub first: u16,
    pub count: u8,
}

/// The data that the chain carries with each move: its number, the line number of its block, its power, and the marks where
/// other moves begin that are parts of the same block. There are many of them, so it is small.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tag {
    pub line: u32,
    pub number: u16,
    mode: PowerMode,
    level: Level,
    first_mark: u16,
    mark_count: u8,
}

impl Tag {
    /// Of no move.
    pub const NONE: Self =
        Self { line: 0, number: 0, mode: PowerMode::Off, level: Level::ZERO, first_mark: 0, mark_count: 0 };

    /// Of the move with this number, whose marks are to be these.
    pub fn new(number: u16, of: &Move, marks: MarksOf) -> Self {
        let (mode, level) = of.power.parts();
        Self { line: of.line, number, mode, level, ..Self::NONE }.with_marks(marks)
    }

    pub fn power(&self) -> Power {
        Power::of(self.mode, self.level)
    }

    pub fn marks(&self) -> MarksOf {
        MarksOf { first: self.first_mark, count: self.mark_count }
    }

    pub fn with_marks(self, marks: MarksOf) -> Self {
        Self { first_mark: marks.first, mark_count: marks.count, ..self }
    }
}
