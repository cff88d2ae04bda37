//! What the firmware reads of the chip in several accesses, while it changes between any two of them.

use std::cell::Cell;

#[path = "../../boards/rp2040-gantry/src/edges.rs"]
mod edges;
#[path = "../../boards/rp2040-gantry/src/two_words.rs"]
mod two_words;

/// The lower word comes round every 71 minutes. An interrupt between any two reads may take any time.
#[test]
fn a_time_is_one_between_the_first_read_and_the_last() {
    const ROUND: u64 = 1 << 32;
    let waits = [0, 1, 2, 5, 1_000, ROUND - 1, ROUND, ROUND + 3];
    for begin in [0, ROUND - 1_001, ROUND - 3, ROUND - 2, ROUND - 1, ROUND, 3 * ROUND - 1] {
        for pattern in 0..waits.len().pow(4) {
            let (now, reads) = (Cell::new(begin), Cell::new(0_u32));
            let pass = || {
                let wait = waits.get(pattern / waits.len().pow(reads.get().min(9)) % waits.len());
                now.set(now.get() + wait.filter(|_| reads.get() < 4).unwrap_or(&1));
                reads.set(reads.get() + 1);
                now.get()
            };
            let read = two_words::read(|| (pass() >> 32) as u32, || pass() as u32);
            assert!((begin..=now.get()).contains(&read), "{read:#x} of {begin:#x} to {:#x}, {pattern}", now.get());
        }
    }
}

/// Inputs of which some change before certain accesses.
struct Changing {
    levels: u8,
    flags: u8,
    accesses: usize,
    /// The inputs that change before each access.
    changes: Vec<u8>,
}

impl Changing {
    fn access(&mut self) {
        let changed = self.changes.get(self.accesses).copied().unwrap_or(0);
        self.levels ^= changed;
        self.flags |= changed;
        self.accesses += 1;
    }
}

impl edges::Inputs for Changing {
    fn flags(&mut self) -> u8 {
        self.access();
        self.flags
    }

    fn clear(&mut self, flags: u8) {
        self.access();
        self.flags &= !flags;
    }

    fn levels(&mut self) -> u32 {
        self.access();
        self.levels.into()
    }
}

/// Two inputs change, or do not, before each of six accesses: two passes of the handler. Then the handler has told the
/// levels that they have, and has told of each input that has changed.
#[test]
fn no_edge_of_an_input_is_lost_between_two_accesses_of_the_handler() {
    for pattern in 0..4_usize.pow(6) {
        let changes: Vec<_> = (0..6).map(|access| (pattern >> (2 * access) & 3) as u8).collect();
        let mut inputs = Changing { levels: 0, flags: 0, accesses: 0, changes };
        let (mut told, mut noticed) = (0, 0);
        // The interrupt comes again for as long as a flag is set, or one will be.
        while inputs.accesses < inputs.changes.len() || inputs.flags != 0 {
            let (changed, levels) = edges::take(&mut inputs);
            noticed |= changed;
            told = told & !changed | levels as u8 & changed;
        }
        assert_eq!(told, inputs.levels, "{:?}", inputs.changes);
        assert_eq!(noticed, inputs.changes.iter().fold(0, |all, one| all | one), "{:?}", inputs.changes);
    }
}
