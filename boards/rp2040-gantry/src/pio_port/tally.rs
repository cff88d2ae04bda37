//! How far an axis has come, by how many of its words or edges are gone.
//!
//! # Design
//! The state machine counts edges whatever their direction, and DMA and FIFO tell how many words are begun. So it is kept
//! here which of the words on their way are rests, and which of the edges go back: a bit each, for as many as can be on
//! their way. There is always room then, however often an axis turns, where a list of its turns could be full and would have
//! to wait until some have risen.
//!
//! Nothing here touches the chip: the tests take this very file.

/// Words that are written and not begun, at most.
pub const IN_FLIGHT_MAX: u32 = MARKS;

const MARKS: u32 = 1024;
const WORD_BITS: u32 = u32::BITS;

/// What has been written of a run. All counts are modulo 2^32.
pub struct Tally {
    /// Which words are rests.
    rests: Marks,
    /// Which edges go back.
    back: Marks,
    /// Where the last edge goes to, from where the run began.
    written_steps: i32,
    rests_written: u32,
}

impl Tally {
    /// Of a run of which nothing has been written.
    pub const fn new() -> Self {
        Self { rests: Marks::new(), back: Marks::new(), written_steps: 0, rests_written: 0 }
    }

    /// A word that is a rest has been written.
    pub fn write_rest(&mut self) {
        self.rests.push(true, 1);
        self.rests_written = self.rests_written.wrapping_add(1);
    }

    /// Words of so many steps have been written, of the same direction.
    pub fn write_steps(&mut self, back: bool, steps: u32) {
        self.rests.push(false, steps);
        self.back.push(back, steps);
        let moved = if back { 0_u32.wrapping_sub(steps) } else { steps };
        self.written_steps = self.written_steps.wrapping_add(moved as i32);
    }

    /// Edges that have been written.
    pub fn written_edges(&self) -> u32 {
        self.back.pushed
    }

    /// How many edges the first `words` words make.
    pub fn edges_of(&self, words: u32) -> u32 {
        let rests = self.rests_written.wrapping_sub(self.rests.count_from(words));
        words.wrapping_sub(rests)
    }

    /// Where the first `edges` edges lead, from where the run began.
    pub fn steps_after(&self, edges: u32) -> i32 {
        let to_come = self.back.pushed.wrapping_sub(edges);
        let back = self.back.count_from(edges);
        self.written_steps.wrapping_sub(to_come.wrapping_sub(2 * back) as i32)
    }
}

/// The last so many of a row of marks, set or not.
struct Marks {
    bits: [u32; (MARKS / WORD_BITS) as usize],
    /// How many there have been.
    pushed: u32,
    /// Whether the last is set, and how many in a row at the end are like it, the last included; [`MARKS`] at most. While an
    /// axis neither turns nor rests that says everything.
    last: bool,
    alike: u32,
}

impl Marks {
    const fn new() -> Self {
        Self { bits: [0; (MARKS / WORD_BITS) as usize], pushed: 0, last: false, alike: MARKS }
    }

    /// Appends `count` equal marks, as many as there is room for at most.
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

    /// How many are set, from the one with this number on.
    fn count_from(&self, first: u32) -> u32 {
        let count = self.pushed.wrapping_sub(first);
        if count <= self.alike {
            return if self.last { count } else { 0 };
        }
        pieces(first, count).map(|(index, mask)| (self.bits[index] & mask).count_ones()).sum()
    }
}

/// The marks from `first` on, word by word: its index, and which of its bits.
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
