//! How fast the blocks of a chain may begin and end: the passes over them.

use super::Chain;
use super::block::Block;
use super::config::Square;

impl<const N: usize, const LEN: usize> Chain<N, LEN> {
    /// Sees to it that how fast the first block ends is known, as far as it can be.
    pub(super) fn look(&mut self) {
        // A pass changes nothing that is final, and most often it can wait until many blocks have come.
        if self.settled < 2 {
            self.pass();
        }
    }

    /// Looks at what the blocks change that came since it last did.
    pub(super) fn pass(&mut self) {
        if self.passed < self.len() {
            let from = self.backward();
            self.forward(from);
        }
    }

    /// How fast the first block is to end; held, as slow as it can.
    pub(super) fn exit(&self) -> Square {
        let Some(first) = self.blocks.get(0) else { return 0 };
        let (highest, lowest) = first.reach();
        // A start speed may be more than it comes to; or, at another speed, less.
        let exit = self.exit_of(0, first).min(highest).max(lowest);
        if self.is_held { lowest.max(first.start).min(exit) } else { exit }
    }

    /// How fast the block with this index ends.
    pub(super) fn exit_of(&self, index: usize, block: &Block<N>) -> Square {
        match self.blocks.get(index + 1) {
            Some(next) if next.flows => next.entry,
            _ => block.start,
        }
    }

    /// Reckons all entries anew, but that of a first block under way. How far its plan has come is seen to when it is
    /// replaced: until then it may end as slow, and as fast, as it might have where it began.
    pub(super) fn reckon(&mut self) {
        if self.is_at_rest()
            && self.place_steps > 0.0
            && let Some(first) = self.blocks.get_mut(0)
        {
            first.set_delta_v2(first.distance_steps - self.place_steps, &self.config);
        }
        self.settled = if self.is_at_rest() { 0 } else { 1 };
        self.passed = 0;
        self.backward();
        self.forward(0);
    }

    /// From the last block on, up to those whose entries are final, or to one that a pass had come by and whose entry does not
    /// change: the block before the last one looked at.
    fn backward(&mut self) -> usize {
        let mut index = self.blocks.len();
        while index > self.settled {
            index -= 1;
            let Some(block) = self.blocks.get(index) else { break };
            let before = index.checked_sub(1).and_then(|index| self.blocks.get(index)).map(Block::pace);
            let (entry, flows) = block.fastest_entry(self.exit_of(index, block), before);
            if entry == block.entry && flows == block.flows && index < self.passed {
                break;
            }
            if let Some(block) = self.blocks.get_mut(index) {
                (block.entry, block.flows) = (entry, flows);
            }
        }
        self.passed = self.blocks.len();
        index.saturating_sub(1)
    }

    /// No block begins faster than the one before it can end. Where that is too fast to brake, it is seen to when it ends.
    ///
    /// An entry at its cap is final, and so are all before it; one that is as high as the one before it allows, if that is.
    pub(super) fn forward(&mut self, from: usize) {
        let mut index = from;
        if index == 0 && self.blocks.get(0).is_some_and(Block::has_final_entry) {
            self.settled = self.settled.max(1);
        }
        while let Some(block) = self.blocks.get(index) {
            let (highest, _) = block.reach();
            index += 1;
            let Some(next) = self.blocks.get_mut(index) else { break };
            let mut is_highest = false;
            if next.flows {
                is_highest = highest <= next.entry && self.settled >= index;
                next.entry = next.entry.min(highest);
            }
            if is_highest || next.has_final_entry() {
                self.settled = self.settled.max(index + 1);
            }
        }
    }
}
