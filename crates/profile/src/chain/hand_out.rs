//! The chunks that are handed out from the chain's plans, and how it goes on from block to block.

use super::block::ChainBlock;
use super::config::Square;
use super::plan::{Begun, Goal, is_no_faster, quotient};
use super::{Chain, Chunk, ChunkKind, Plan};
use crate::blend::{Blend, Side, Times};
use crate::fixed::is_zero;

impl<const N: usize, const LEN: usize, T: Copy> Chain<N, LEN, T> {
    /// Hands out the plan up to `until_s`, which commits it.
    pub(super) fn hand_out(&mut self, until_s: f64) -> Option<Chunk<N, T>> {
        let (block, plan) = (self.blocks.get(0)?, &mut self.plan);
        let is_end = until_s >= plan.end_s;
        let end_steps = plan.sync_move.end_steps();
        // Just before its end, rounding may take the place beyond it.
        let until_steps = if is_end { end_steps } else { plan.sync_move.place_at(until_s).min(end_steps) };
        let ChainBlock { mm_per_step, tag, .. } = *block;
        let asked_steps_s = block.asked_steps_s(&self.config);
        let exit_steps_s = plan.sync_move.profile.exit_speed_steps_s();
        let line = Plan::Line(plan.sync_move);
        let chunk = Chunk { plan: line, until_steps, until_s, mm_per_step, asked_steps_s, tag, kind: plan.kind };
        plan.kind = ChunkKind::Continuation;
        (self.at_s, self.place_steps) = (until_s, until_steps);
        if is_end && plan.ends_block && !plan.is_bent {
            self.end_block(self.plan.exit);
        } else if is_end && self.is_held && self.is_slow(exit_steps_s) {
            self.rest();
        } else if is_end && self.plan.ends_block {
            self.blend_on(&self.goal_onward(self.plan.exit, self.plan.onward), 0.0);
        }
        Some(chunk)
    }

    /// True if the first block may stop from this speed.
    fn is_slow(&self, speed_steps_s: f64) -> bool {
        self.blocks.get(0).is_some_and(|first| {
            let limits = first.limits_now(&self.config.shared_limits(&first.move_steps));
            is_no_faster(speed_steps_s, limits.start_speed_steps_s)
        })
    }

    /// Goes on to the next block by a blend, which is handed out next. It begins with an approach if the blend that is to
    /// follow begins later than at the current place.
    pub(super) fn blend_on(&mut self, goal: &Goal, approach_steps: f64) {
        let &Goal { exit, onward, speeds_steps_s, speeds_mm_s, .. } = goal;
        let ([from_steps_s, to_steps_s], [from_mm_s, to_mm_s]) = (speeds_steps_s, speeds_mm_s);
        let (Some(first), Some(next), config) = (self.blocks.get(0), self.blocks.get(1), &self.config) else { return };
        let (fast_mm_s, share) = if onward < exit { (from_mm_s, quotient(to_mm_s, from_mm_s)) } else { (to_mm_s, 1.0) };
        let reach_mm = next.blend.reach_mm;
        let place_steps = reach_mm * share * next.steps_per_mm();
        let times = Times {
            begin_s: self.at_s,
            approach_s: if is_zero(approach_steps) { 0.0 } else { approach_steps / from_steps_s },
            corner_s: 2.0 * reach_mm / fast_mm_s,
        };
        let before = Side {
            move_steps: &first.move_steps,
            shares: self.begun.map_or_else(|| first.shares(), |begun| begun.shares),
            counts: self.counts(first),
            corner_steps: first.distance_steps() - self.place_steps - approach_steps,
            speed_steps_s: from_steps_s,
        };
        let shares = next.shares();
        let counts = core::array::from_fn(|axis| {
            next.move_steps.steps_by(axis, place_steps, next.distance_steps(), || shares[axis])
        });
        let after =
            Side { move_steps: &next.move_steps, shares, counts, corner_steps: place_steps, speed_steps_s: to_steps_s };
        self.blend = Some(Blend::new(&before, &after, times, |axis| config.top_steps_s(axis)));
        let is_expected = next.entry == onward;
        self.pop();
        (self.place_steps, self.begun) = (place_steps, Some(Begun { shares, place_steps, counts }));
        if let Some(next) = self.blocks.get_mut(0) {
            next.begin_bent(onward);
            self.settled = self.settled.max(usize::from(next.flows));
        }
        if !is_expected {
            self.forward(0);
        }
    }

    /// The number of steps of each axis of the first block that are due before the current place.
    pub(super) fn counts(&self, first: &ChainBlock<N, T>) -> [u32; N] {
        match self.begun {
            Some(begun) if begun.place_steps == self.place_steps => begun.counts,
            _ => core::array::from_fn(|axis| {
                first.move_steps.steps_before(axis, self.place_steps, first.distance_steps())
            }),
        }
    }

    /// Hands out a blend, which commits it.
    pub(super) fn hand_out_blend(&mut self, blend: Blend<N>) -> Option<Chunk<N, T>> {
        let block = self.blocks.get(0)?;
        self.at_s = blend.end_s();
        Some(Chunk {
            plan: Plan::Blend(blend),
            until_steps: self.place_steps,
            until_s: self.at_s,
            mm_per_step: block.mm_per_step,
            asked_steps_s: block.asked_steps_s(&self.config),
            tag: block.tag,
            kind: ChunkKind::Move,
        })
    }

    /// Removes the first block, and keeps where it ends.
    pub(super) fn pop_block(&mut self) {
        if let Some(first) = self.blocks.get(0) {
            self.last_offsets = first.move_steps.offsets[1];
        }
        self.blocks.pop();
    }

    /// Goes on to the next block.
    fn pop(&mut self) {
        self.pop_block();
        (self.place_steps, self.plan.is_made, self.begun) = (0.0, false, None);
        self.passed = self.passed.saturating_sub(1);
        self.settled = self.settled.saturating_sub(1);
    }

    /// Comes to rest at the current place.
    pub(super) fn rest(&mut self) {
        self.plan.is_made = false;
        self.settled = 0;
        match self.blocks.get_mut(0) {
            Some(first) => first.stop(),
            None => self.place_steps = 0.0,
        }
    }

    /// Goes on to the next block, at the squared speed `exit`.
    pub(super) fn end_block(&mut self, exit: Square) {
        if self.bent().is_some() {
            // It came too late to be bent into.
            self.halt();
        }
        let is_expected = self.blocks.get(1).is_some_and(|next| next.flows && next.entry == exit);
        let stops_from = if is_expected {
            // Nothing depends on it.
            0
        } else {
            self.pass();
            self.blocks
                .get(0)
                .map_or(0, |first| first.stops_from(&self.config.shared_limits(&first.move_steps), &self.config))
        };
        self.pop();
        let Some(next) = self.blocks.get_mut(0) else { return };
        let expected = next.entry;
        next.begin_after(exit, stops_from);
        let is_expected = next.entry == expected;
        if next.flows {
            self.settled = self.settled.max(1);
        }
        if !is_expected {
            self.forward(0);
        }
    }
}
