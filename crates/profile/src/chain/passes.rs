//! The passes over the chain, which compute how fast its blocks may begin and end.

use super::Chain;
use super::block::ChainBlock;
use super::config::{Square, is_as_low};

impl<const N: usize, const LEN: usize, T: Copy> Chain<N, LEN, T> {
    /// Makes sure that the end speed of the first block is known, as far as it can be.
    pub(super) fn look(&mut self) {
        // A pass changes nothing that is final. Usually it can wait until many blocks have come.
        if self.settled < 2 {
            self.pass();
        }
    }

    /// Computes what the blocks change that came since the last pass.
    pub(super) fn pass(&mut self) {
        if self.passed < self.len() {
            let from = self.backward();
            self.forward(from);
        }
    }

    /// The squared speed at which the first block is to end. In a hold it is the lowest that is possible.
    pub(super) fn exit(&self) -> Square {
        let Some(first) = self.blocks.get(0) else { return 0 };
        let (highest, lowest) = first.reach();
        // The start speed may be higher than the block can reach, or, after an override, lower than it can brake to.
        let exit = self.exit_of(0, first).min(highest).max(lowest);
        // What rounding leaves of a speed would last for days in a blend.
        let slowest = if is_as_low(first.entry, first.entry - lowest) { 0 } else { lowest };
        if self.is_held { slowest.max(first.start).min(exit) } else { exit }
    }

    /// The squared speed at which the block with this index ends.
    pub(super) fn exit_of(&self, index: usize, block: &ChainBlock<N, T>) -> Square {
        match self.blocks.get(index + 1) {
            Some(next) if next.flows => next.arrival(next.entry, block.nominal),
            _ => block.start,
        }
    }

    /// The block after the first one, if a blend leads into it.
    pub(super) fn bent(&self) -> Option<&ChainBlock<N, T>> {
        self.blocks.get(1).filter(|next| next.flows && !next.blend.is_none())
    }

    /// The squared speed at which the second block begins, if the first one ends at `exit`. In a hold it is the lowest
    /// that is possible.
    pub(super) fn onward(&self, exit: Square) -> Square {
        self.bent().map_or(exit, |next| {
            let onward = next.blend.exit_near(next.entry, exit);
            if self.is_held { onward.min(next.blend.lowest_exit_at(exit)) } else { onward }
        })
    }

    /// Computes all entry speeds again, except that of a first block under way. How far its plan has come is taken into
    /// account when the plan is replaced: until then, the range of its end speeds is computed from where the plan
    /// began.
    pub(super) fn compute_entries(&mut self) {
        if self.is_at_rest() {
            self.set_left();
        }
        self.settled = self.bound_entries();
        self.passed = 0;
        self.backward();
        self.forward(self.settled.saturating_sub(1));
    }

    /// The number of entries that can be no others, whatever comes.
    pub(super) fn bound_entries(&self) -> usize {
        if self.is_at_rest() { 0 } else { 1 + usize::from(self.is_bound_to_bend()) }
    }

    /// The backward pass. It begins at the last block and ends at the blocks whose entries are final, or at a block
    /// that an earlier pass has looked at and whose entry does not change. Returns the index of the block before the
    /// last one it looked at.
    fn backward(&mut self) -> usize {
        let mut index = self.blocks.len();
        while index > self.settled {
            index -= 1;
            let Some(block) = self.blocks.get(index) else { break };
            let before = index.checked_sub(1).and_then(|index| self.blocks.get(index)).map(ChainBlock::pace);
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

    /// The forward pass: no block begins faster than the block before it can end. If a block cannot brake to the entry
    /// speed of the next one, that is handled when the block ends.
    ///
    /// An entry at its cap is final, and so are all entries before it. An entry that is as high as the block before can
    /// reach is final if the entry of that block is.
    pub(super) fn forward(&mut self, from: usize) {
        let mut index = from;
        if index == 0 && self.blocks.get(0).is_some_and(ChainBlock::has_final_entry) {
            self.settled = self.settled.max(1);
        }
        while let Some(block) = self.blocks.get(index) {
            let ((highest, _), nominal) = (block.reach(), block.nominal);
            index += 1;
            // What came since the last pass has no entry yet.
            let Some(next) = self.blocks.get_mut(index).filter(|_| index < self.passed) else { break };
            let mut is_highest = false;
            if next.flows {
                let arrival = next.arrival(next.entry, nominal);
                let most = next.departure(arrival.min(highest));
                is_highest = highest <= arrival && most <= next.entry && self.settled >= index;
                next.entry = next.entry.min(most);
            }
            if is_highest || next.has_final_entry() {
                self.settled = self.settled.max(index + 1);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Chain;
    use crate::chain::{ChainConfig, Request};
    use crate::{IntervalSplit, Limits, SpeedProfile};

    /// A pass looks at no block again whose entry is final. Otherwise the time for a move would grow with the moves
    /// that wait before it.
    #[test]
    fn what_accelerates_all_the_way_is_settled() {
        let limits = Limits {
            start_speed_steps_s: 0.0,
            top_speed_steps_s: 1e5,
            accel_steps_s2: 1e4,
            decel_steps_s2: 1e4,
            jerk_steps_s3: f64::INFINITY,
        };
        let config = ChainConfig::new([limits], [0.01], 0.01, IntervalSplit::Fastest, SpeedProfile::Trapezoid);
        let mut chain = Chain::<1, 8>::new(config);
        // Seven short moves, and a long one in which all of their speed can be lost.
        for steps in [10, 10, 10, 10, 10, 10, 10, 10_000] {
            chain.push(Request::new([steps])).unwrap();
        }
        chain.pass();
        assert_eq!(chain.settled, 8);
    }
}
