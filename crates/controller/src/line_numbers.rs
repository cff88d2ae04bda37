//! Which line of the program the machine is at.

use isostep_motion::QUEUE_MOVES;

/// The motions that may be in the queue, and the one under way.
const MOTIONS: usize = QUEUE_MOVES + 1;

/// The line numbers of the motions last asked for.
pub(crate) struct LineNumbers {
    asked: usize,
    numbers: [u32; MOTIONS],
}

impl LineNumbers {
    pub const fn new() -> Self {
        Self { asked: 0, numbers: [0; MOTIONS] }
    }

    /// A motion of line `number`, 0 for none, has entered the queue.
    pub fn note(&mut self, number: u32) {
        self.numbers[self.asked % MOTIONS] = number;
        self.asked = self.asked.wrapping_add(1);
    }

    /// The number of the motion under way, if there is one, while the queue has room for `free` more.
    pub fn under_way(&self, free: usize) -> u32 {
        let waiting = QUEUE_MOVES - free;
        self.numbers[self.asked.wrapping_sub(waiting + 1) % MOTIONS]
    }
}
