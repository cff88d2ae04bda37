//! The data that the chain carries with each move.

use isostep_profile::chain;

use crate::axes::AXES;
use crate::tool::power::Power;

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

/// The data that the chain carries with each move: the program line that it comes from, its power, and the marks where lines
/// begin that are parts of the same move. There are many of them, so it is small.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tag {
    pub line: u32,
    pub power: Power,
    pub marks: MarksOf,
}

impl Tag {
    /// Of no line, without a laser.
    pub const NONE: Self = Self { line: 0, power: Power::Off, marks: MarksOf { first: 0, count: 0 } };
}
