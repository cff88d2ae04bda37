//! Computes the position of an axis from the number of words or edges that are done.
//!
//! # Design
//! The state machine counts edges in either direction, and DMA and FIFO only show how many words are begun. So this
//! keeps two bits for each word on its way: whether it is a rest, and whether its edge goes back. There is always room,
//! however often an axis turns. A list of turns could be full and would have to wait until some edges have risen.
//!
//! Nothing here accesses the chip: the tests use this file directly.

/// The most words that can be written but not begun.
pub const IN_FLIGHT_MAX: u32 = MARKS;

const MARKS: u32 = 1024;
const WORD_BITS: u32 = u32::BITS;

/// The record of a run's words. All counts are modulo 2^32.
pub struct Tally {
    /// The words that are rests.
    rests: MarkHistory,
    /// The edges that go back.
    back: MarkHistory,
    /// Position after the last written edge, relative to the start of the run.
    written_steps: i32,
    rests_written: u32,
}

impl Tally {
    /// The tally of a run for which nothing has been written.
    pub const fn new() -> Self {
        Self { rests: MarkHistory::new(), back: MarkHistory::new(), written_steps: 0, rests_written: 0 }
    }

    /// Notes a written word that is a rest.
    pub fn write_rest(&mut self) {
        self.rests.push(true, 1);
        self.rests_written = self.rests_written.wrapping_add(1);
    }

    /// Notes written words of `steps` steps in one direction.
    pub fn write_steps(&mut self, back: bool, steps: u32) {
        self.rests.push(false, steps);
        self.back.push(back, steps);
        let moved = if back { 0_u32.wrapping_sub(steps) } else { steps };
        self.written_steps = self.written_steps.wrapping_add(moved as i32);
    }

    /// Number of edges that have been written.
    pub fn written_edges(&self) -> u32 {
        self.back.pushed
    }

    /// The number of edges that the first `words` words make.
    pub fn edges_of(&self, words: u32) -> u32 {
        let rests = self.rests_written.wrapping_sub(self.rests.count_from(words));
        words.wrapping_sub(rests)
    }

    /// Position after the first `edges` edges, relative to the start of the run.
    pub fn steps_after(&self, edges: u32) -> i32 {
        let to_come = self.back.pushed.wrapping_sub(edges);
        let back = self.back.count_from(edges);
        self.written_steps.wrapping_sub(to_come.wrapping_sub(2 * back) as i32)
    }
}

/// The last `MARKS` marks of a sequence; each is set or not.
struct MarkHistory {
    bits: [u32; (MARKS / WORD_BITS) as usize],
    /// The number of marks that have been appended.
    pushed: u32,
    /// The last mark, and the number of marks at the end that equal it, including itself; at most [`MARKS`]. While
    /// an axis neither turns nor rests, these two say everything, and the bits are not written.
    last: bool,
    alike: u32,
}

impl MarkHistory {
    const fn new() -> Self {
        Self { bits: [0; (MARKS / WORD_BITS) as usize], pushed: 0, last: false, alike: MARKS }
    }

    /// Appends `count` equal marks, at most as many as there is room for.
    fn push(&mut self, is_set: bool, count: u32) {
        if is_set != self.last {
            (self.last, self.alike) = (is_set, 0);
        }
        if self.alike < MARKS {
            self.write(is_set, count);
            self.alike = self.alike.saturating_add(count).min(MARKS);
        }
        self.pushed = self.pushed.wrapping_add(count);
    }

    fn write(&mut self, is_set: bool, count: u32) {
        for (index, mask) in pieces(self.pushed, count) {
            let bits = &mut self.bits[index];
            *bits = if is_set { *bits | mask } else { *bits & !mask };
        }
    }

    /// The number of marks that are set, from number `first` to the last.
    fn count_from(&self, first: u32) -> u32 {
        let count = self.pushed.wrapping_sub(first);
        if count <= self.alike {
            return if self.last { count } else { 0 };
        }
        pieces(first, count).map(|(index, mask)| (self.bits[index] & mask).count_ones()).sum()
    }
}

/// The bits of `count` marks from number `first`, word by word: the word's index and a mask of its bits.
fn pieces(first: u32, count: u32) -> impl Iterator<Item = (usize, u32)> {
    let (mut at, mut left) = (first % MARKS, count);
    core::iter::from_fn(move || {
        if left == 0 {
            return None;
        }
        let (index, low) = (at / WORD_BITS, at % WORD_BITS);
        let bits = left.min(WORD_BITS - low);
        let mask = (u32::MAX >> (WORD_BITS - bits)) << low;
        (at, left) = ((at + bits) % MARKS, left - bits);
        Some((index as usize, mask))
    })
}
