//! The data that the chain carries with each move, packed into a word.

use crate::tool::power::{Level, Power};

/// The marks that belong to a block: so many, from this place on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct MarksOf {
    pub first: u16,
    pub count: u8,
}

/// The data that the chain carries with each move: the program line that it comes from, its power, and the marks where lines
/// begin that are parts of the same move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tag {
    pub line: u32,
    pub power: Power,
    pub marks: MarksOf,
}

const CONSTANT: u32 = 1 << 16;
const BY_SPEED: u32 = 2 << 16;
const POWERS: u32 = 3 << 16;
const COUNT_SHIFT: u32 = 18;
const PLACE_SHIFT: u32 = COUNT_SHIFT + Tag::COUNT_BITS;

impl Tag {
    /// The bits of the number of its marks. Nine are left for the place of the first.
    pub const COUNT_BITS: u32 = 5;

    pub fn pack(self) -> u64 {
        let power = match self.power {
            Power::Off => 0,
            Power::Constant(level) => CONSTANT | u32::from(level.of_65535()),
            Power::BySpeed(level) => BY_SPEED | u32::from(level.of_65535()),
        };
        let marks = u32::from(self.marks.first) << PLACE_SHIFT | u32::from(self.marks.count) << COUNT_SHIFT;
        u64::from(power | marks) << 32 | u64::from(self.line)
    }

    pub fn unpack(tag: u64) -> Self {
        let (high, line) = ((tag >> 32) as u32, tag as u32);
        let level = Level::from_65535ths(high as u16);
        let power = match high & POWERS {
            CONSTANT => Power::Constant(level),
            BY_SPEED => Power::BySpeed(level),
            _ => Power::Off,
        };
        let count = (high >> COUNT_SHIFT) as u8 & ((1 << Self::COUNT_BITS) - 1);
        Self { line, power, marks: MarksOf { first: (high >> PLACE_SHIFT) as u16, count } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tag_is_what_it_was_before_it_was_packed() {
        let level = Level::from_65535ths(40_000);
        for power in [Power::Off, Power::Constant(level), Power::BySpeed(Level::FULL), Power::Constant(Level::ZERO)] {
            for marks in [MarksOf::default(), MarksOf { first: 511, count: 31 }, MarksOf { first: 1, count: 2 }] {
                let tag = Tag { line: 10_000_000, power, marks };
                assert_eq!(Tag::unpack(tag.pack()), tag);
            }
        }
    }
}
