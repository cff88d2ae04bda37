//! Values that the firmware reads of the chip in several accesses, while it changes between any two of them.

use std::cell::Cell;
use std::collections::VecDeque;
use std::sync::atomic::AtomicU32;

#[path = "../../boards/pico-gantry/src/guard/edges.rs"]
mod edges;
#[path = "../../boards/pico-gantry/src/two_words.rs"]
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

/// A state machine that watches inputs of which some change before certain accesses of the handler.
struct Changing {
    levels: u32,
    /// The levels after each change, which the handler has not taken yet.
    queue: VecDeque<u32>,
    accesses: usize,
    /// The inputs that change before each access.
    changes: Vec<u32>,
}

impl Changing {
    fn access(&mut self) {
        let changed = self.changes.get(self.accesses).copied().unwrap_or(0);
        self.levels ^= changed;
        if changed != 0 {
            self.queue.push_back(self.levels);
        }
        self.accesses += 1;
    }
}

impl edges::Changes for Changing {
    fn are_there(&mut self) -> bool {
        self.access();
        !self.queue.is_empty()
    }

    fn take(&mut self) -> u32 {
        self.access();
        self.queue.pop_front().expect("an entry")
    }
}

/// Two inputs change, or do not, before each of six accesses. Then the handler has reported every change of either, with the
/// level after it, and in order.
#[test]
fn no_edge_of_an_input_is_lost_between_two_accesses_of_the_handler() {
    for pattern in 0..4_usize.pow(6) {
        let changes: Vec<_> = (0..6).map(|access| (pattern >> (2 * access) & 3) as u32).collect();
        let mut wanted = [vec![], vec![]];
        let mut levels = 0;
        for &changed in &changes {
            levels ^= changed;
            (0..2).filter(|input| changed >> input & 1 != 0).for_each(|input| wanted[input].push(levels >> input & 1));
        }
        let mut inputs = Changing { levels: 0, queue: VecDeque::new(), accesses: 0, changes };
        let (last, mut reported) = (AtomicU32::new(0), [vec![], vec![]]);
        // The interrupt comes again for as long as there are changes, or will be.
        while inputs.accesses < inputs.changes.len() || !inputs.queue.is_empty() {
            let Some((changed, levels)) = edges::take(&mut inputs, &last) else { continue };
            (0..2)
                .filter(|input| changed >> input & 1 != 0)
                .for_each(|input| reported[input].push(levels >> input & 1));
        }
        assert_eq!(reported, wanted, "{:?}", inputs.changes);
    }
}
