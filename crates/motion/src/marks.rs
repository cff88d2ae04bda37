//! Marks: where within a block of the chain a program line ends and the next begins, with another power.
//!
//! # Design
//! A raster has a line for each of its pixels. Those that go straight on at one feed become one block, so that the chain
//! plans, hands out and compiles one move for many lines. What is different from line to line is kept here, in the
//! order of the path. The tag of a block says which marks are its own. So whoever has a chunk finds its marks, also
//! after a hold, and nothing has to be counted along with the chain. Short moves that are taken together
//! ([`group`](crate::group)) are one block with marks, too.
//!
//! If a block has as many marks as it may have, the line becomes another. While there is no room at all, no line is taken.
//! Blocks are lengthened with a trapezoid only, because the instant of a mark on a curved ramp takes far longer to compute, and
//! only where hardware makes the steps, because with `TimerPort` each line has a time of its own (`Effort`).

use crate::tag::{MarksOf, Tag};
use crate::tool::power::{Level, Power};

/// The number of marks that there is room for: those of the path ahead and of the block under way. One place is always empty.
const PLACES: usize = 341;
/// The number of marks that a block has at most. Its room is free again only when it is over, and planning it costs little for
/// each of so many lines.
const MARKS_OF_BLOCK: u8 = 31;

/// There are many of them, so each is stored as what it adds to the one before in its block.
#[derive(Clone, Copy)]
struct Stored {
    /// The number of steps of the longest axis after it.
    steps: u16,
    lines: u16,
    level: Level,
}

/// A place within a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Mark {
    /// The place where it is, steps of the longest axis from the beginning of the block.
    pub place_steps: u32,
    /// The line that begins here.
    pub line: u32,
    /// Its level.
    pub level: Level,
}

/// The marks of all blocks that are not over, in order.
pub(crate) struct Marks {
    ring: [Stored; PLACES],
    first: u16,
    /// The place after the last one.
    end: u16,
    /// The last mark, if the last block has one.
    last: Mark,
}

impl Marks {
    pub const fn new() -> Self {
        let last = Mark { place_steps: 0, line: 0, level: Level::ZERO };
        Self { ring: [Stored { steps: 0, lines: 0, level: Level::ZERO }; PLACES], first: 0, end: 0, last }
    }

    /// True if there is no room for another.
    pub fn is_full(&self) -> bool {
        after(self.end) == self.first
    }

    /// The number of marks of the block with this tag and of those behind it.
    pub fn count_from(&self, tag: &Tag) -> usize {
        let (first, end) = (usize::from(tag.marks().first), usize::from(self.end));
        if end < first { end + PLACES - first } else { end - first }
    }

    /// Those of a block that is pushed now, which has none yet.
    pub fn none(&self) -> MarksOf {
        MarksOf { first: self.end, count: 0 }
    }

    /// Joins a move with `next`, which goes straight on from `place_steps`, the end of the last block, whose tag is
    /// `tag`. Returns the tag for both; `None` if they are to be two blocks, because not only the level is another, or
    /// there is no room.
    pub fn join(&mut self, tag: Tag, place_steps: u32, next: &Tag) -> Option<Tag> {
        let level = match next.power() {
            Power::Constant(level) | Power::BySpeed(level) => level,
            Power::Off => Level::ZERO,
        };
        let mut own = tag.marks();
        if tag.power().with_level(level) != next.power() || own.count == MARKS_OF_BLOCK || self.is_full() {
            return None;
        }
        let from = if own.count == 0 { (0, tag.line) } else { (self.last.place_steps, self.last.line) };
        let steps = u16::try_from(place_steps.checked_sub(from.0)?).ok()?;
        let lines = u16::try_from(next.line.checked_sub(from.1)?).ok().filter(|_| (next.line == 0) == (from.1 == 0))?;
        self.ring[usize::from(self.end)] = Stored { steps, lines, level };
        (self.end, self.last) = (after(self.end), Mark { place_steps, line: next.line, level });
        own.count += 1;
        Some(tag.with_marks(own))
    }

    /// Stretches the places of a block's marks by a ratio, because its longest axis is another than the one they count in.
    pub fn stretch(&mut self, tag: &Tag, [by, from]: [u32; 2]) {
        let MarksOf { mut first, count } = tag.marks();
        let (mut place, mut before) = (0, 0);
        for _ in 0..count {
            let Some(mark) = self.ring.get_mut(usize::from(first)) else { return };
            place += u32::from(mark.steps);
            let stretched = (place * by).checked_div(from).map_or(by, |place| place.min(by));
            mark.steps = stretched.saturating_sub(before) as u16;
            (before, first) = (stretched, after(first));
        }
    }

    /// The marks of a block, in order.
    pub fn of(&self, tag: &Tag) -> impl Iterator<Item = Mark> + use<'_> {
        let mut walk = Walk::along(tag);
        core::iter::from_fn(move || walk.next(self))
    }

    /// Forgets the marks of the blocks before the one with this tag.
    pub fn forget_before(&mut self, tag: &Tag) {
        self.first = tag.marks().first;
    }

    /// Forgets all marks.
    pub fn clear(&mut self) {
        self.first = self.end;
    }
}

/// The place after this one, without a division, because a Cortex-M0+ has no divider.
fn after(place: u16) -> u16 {
    if usize::from(place) + 1 < PLACES { place + 1 } else { 0 }
}

/// A walk along the marks of a block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Walk {
    ahead: MarksOf,
    place_steps: u32,
    line: u32,
}

impl Walk {
    /// From the beginning of the block with this tag.
    pub fn along(tag: &Tag) -> Self {
        Self { ahead: tag.marks(), place_steps: 0, line: tag.line }
    }

    /// The next mark.
    pub fn next(&mut self, marks: &Marks) -> Option<Mark> {
        self.ahead.count = self.ahead.count.checked_sub(1)?;
        let Stored { steps, lines, level } = *marks.ring.get(usize::from(self.ahead.first))?;
        self.ahead.first = after(self.ahead.first);
        self.place_steps += u32::from(steps);
        self.line += u32::from(lines);
        Some(Mark { place_steps: self.place_steps, line: self.line, level })
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use super::*;
    use crate::axes::AXES;
    use crate::machine::Move;

    fn level(percent: u32) -> Level {
        Level::of_ratio(percent as f32 / 100.0)
    }

    fn tag(power: Power, line: u32) -> Tag {
        Tag::new(0, &Move { power, line, ..Move::to([0; AXES]) }, MarksOf { first: 0, count: 0 })
    }

    fn pushed(marks: &Marks, line: u32, percent: u32) -> Tag {
        tag(Power::BySpeed(level(percent)), line).with_marks(marks.none())
    }

    /// A block of `lines`, each of eight steps and with 1 % more than the one before, as far as they are one block.
    fn block(marks: &mut Marks, first: u32, lines: u32) -> Tag {
        let mut tag = pushed(marks, first, 0);
        for line in 1..lines {
            let next = pushed(marks, first + line, line);
            match marks.join(tag, 8 * line, &next) {
                Some(joined) => tag = joined,
                None => break,
            }
        }
        tag
    }

    #[test]
    fn each_block_finds_its_own_marks_however_many_came_before() {
        let mut marks = Marks::new();
        let mut before = block(&mut marks, 1, 4);
        for first in (100..3_000).step_by(10) {
            let tag = block(&mut marks, first, 1 + first / 10 % 9);
            let found: Vec<_> = marks.of(&tag).collect();
            let expected = (1..1 + first / 10 % 9).map(|line| Mark {
                place_steps: 8 * line,
                line: first + line,
                level: level(line),
            });
            assert_eq!(found, expected.collect::<Vec<_>>());
            marks.forget_before(&before);
            before = tag;
        }
    }

    #[test]
    fn only_lines_of_one_mode_whose_numbers_rise_or_that_have_none_are_one_block() {
        let mut marks = Marks::new();
        let (constant, by_speed) = (Power::Constant(level(5)), Power::BySpeed(level(5)));
        let mut joins = |one: Tag, other: Tag| marks.join(one, 8, &other).is_some();
        assert!(joins(tag(constant, 0), tag(constant, 0)) && joins(tag(by_speed, 7), tag(by_speed, 9)));
        assert!(joins(tag(constant, 0), tag(Power::Constant(Level::ZERO), 0)));
        assert!(!joins(tag(constant, 0), tag(by_speed, 0)) && !joins(tag(constant, 0), tag(Power::Off, 0)));
        assert!(joins(tag(Power::Off, 0), tag(Power::Off, 0)), "without a laser");
        assert!(!joins(tag(constant, 7), tag(constant, 6)) && !joins(tag(constant, 7), tag(constant, 0)));
        assert!(!joins(tag(constant, 0), tag(constant, 7)) && !joins(tag(constant, 1), tag(constant, 70_000)));
    }

    #[test]
    fn where_there_is_no_room_a_line_is_a_block_of_its_own() {
        let mut marks = Marks::new();
        let first = block(&mut marks, 1, 100);
        assert_eq!(first.marks().count, MARKS_OF_BLOCK);
        let mut last = first;
        for _ in 1..11 {
            last = block(&mut marks, 1, 100);
        }
        assert_eq!(block(&mut marks, 1, 2).marks().count, 0, "340 are there");
        marks.forget_before(&first);
        assert_eq!(block(&mut marks, 1, 2).marks().count, 0, "the block under way keeps its own");
        marks.forget_before(&last);
        assert_eq!((block(&mut marks, 5, 2).marks().count, marks.of(&last).count()), (1, last.marks().count.into()));
        let far = marks.join(pushed(&marks, 0, 0), 70_000, &pushed(&marks, 0, 0));
        assert_eq!(far, None);
    }
}
