//! The meeting of a block with the one before it: how fast, by a corner or by a blend, or from rest.

use core::num::NonZero;

use super::blend::{self, BlendBounds, Room};
use super::block::ChainBlock;
use super::config::{ChainConfig, Square, is_as_low};
use super::corner::{self, UnitVector};
use crate::IntervalSplit;
use crate::fixed::is_zero;
use crate::limits::Limits;

/// The end of a block.
#[derive(Clone, Copy)]
pub(super) struct BlockEnd {
    stops: bool,
    /// The length of it that is for the blend at its end, mm.
    room_mm: f64,
    pace: Pace,
    fastest: Square,
}

/// The speeds of a block, squared.
#[derive(Clone, Copy)]
pub(super) struct Pace {
    nominal: Square,
    start: Square,
}

impl<const N: usize, T: Copy> ChainBlock<N, T> {
    /// Makes it follow `before`: computes how fast the corner between them may be taken. The directions are those of
    /// both, in order, and the limits those of its longest axis.
    pub(super) fn follow(
        &mut self,
        before: BlockEnd,
        directions: [&UnitVector<N>; 2],
        limits: &Limits,
        config: &ChainConfig<N>,
    ) {
        let stops = before.stops || config.interval_split != IntervalSplit::Fastest;
        self.blend = BlendBounds::NONE;
        let square = if stops {
            None
        } else if self.bends_after(&before, config) && !corner::is_straight(directions) {
            self.slow_down_to_bend(limits, config);
            let [own_mm, _] = self.rooms_mm(self.length_mm());
            let reach_mm = if own_mm < before.room_mm { own_mm } else { before.room_mm };
            let is_whole = self.reach_mm.to_bits() != 0;
            let fastest = self.fastest().max(before.fastest).max(before.pace.nominal);
            let room = Room { deviation_mm: self.deviation_mm, reach_mm, fastest, is_whole };
            blend::bounds(directions, &room, config).map(|(bounds, square)| {
                self.blend = bounds;
                square
            })
        } else if self.move_steps.offsets[0] == [0; N] || corner::is_straight(directions) {
            corner::square(directions, config)
        } else {
            // Steps next to a corner beside whole steps are too near to each other, except around a standstill.
            None
        };
        self.corner = square.and_then(NonZero::new);
        self.set_cap(before.pace);
    }

    /// True if the corner before it may be a blend: not where a block can jump from rest, as it does not begin slowly there.
    fn bends_after(&self, before: &BlockEnd, config: &ChainConfig<N>) -> bool {
        self.deviation_mm > 0.0 && config.can_blend() && (self.start, before.pace.start) == (0, 0)
    }

    /// Makes it begin, or go on, from rest.
    pub(super) fn stop(&mut self) {
        (self.corner, self.blend, self.flows) = (None, BlendBounds::NONE, false);
    }

    /// Begins after a blend, at the squared speed at which that leaves.
    pub(super) fn begin_bent(&mut self, exit: Square) {
        (self.flows, self.entry) = (exit > 0, exit);
        if !self.flows {
            self.stop();
        }
    }

    /// The square of the speed from which it can stop, whatever the overrides are.
    pub(super) fn stops_from(&self, limits: &Limits, config: &ChainConfig<N>) -> Square {
        // Most machines have a start speed of 0, which saves the work.
        let start_speed_steps_s = limits.start_speed_steps_s;
        if is_zero(start_speed_steps_s) { 0 } else { config.scale.of_speed(start_speed_steps_s * self.mm_per_step) }
    }

    /// Begins after a block that ends at the squared speed `exit`, and that can stop from `stops_from`. This block
    /// begins at that speed or from rest.
    pub(super) fn begin_after(&mut self, exit: Square, stops_from: Square) {
        if self.flows && is_as_low(exit, self.entry) {
            self.entry = exit;
            return;
        }
        // Otherwise the overrides have changed, and the block before could not brake to what is wanted now. If it can
        // stop from its end speed, it does, because what follows may not have room to brake from there. If it cannot,
        // this block was to begin at that speed or faster before the change, so that it may.
        if exit > stops_from && self.corner.is_some() {
            (self.flows, self.entry) = (true, exit);
        } else {
            (self.flows, self.entry) = (false, self.entry.min(self.start));
        }
    }

    /// True if its entry speed is as high as it can ever be.
    pub(super) fn has_final_entry(&self) -> bool {
        if self.flows { self.entry == self.cap } else { self.corner.is_none() && self.entry == self.start }
    }

    /// The highest squared speed at which it may begin if it ends at `exit`, and whether it begins without a stop after
    /// `before`.
    pub(super) fn fastest_entry(&self, exit: Square, before: Option<Pace>) -> (Square, bool) {
        let most = self.at_other_end(exit, self.decel_delta_v2);
        let flowing = self.cap.min(most);
        match (self.corner, before) {
            (Some(_), Some(before)) if self.arrival(flowing, before.nominal) >= before.start => (flowing, true),
            _ => (self.start.min(most), false),
        }
    }

    /// The facts of it that the next block needs, if it has begun up to `place_steps`. There is room for a blend if one is asked for.
    pub(super) fn end(&self, place_steps: f64, bends: bool) -> BlockEnd {
        let left_mm = || (self.distance_steps() - place_steps) * self.mm_per_step;
        let room_mm = if bends { self.rooms_mm(left_mm())[1] } else { 0.0 };
        BlockEnd { stops: self.stops(), room_mm, pace: self.pace(), fastest: self.fastest() }
    }

    fn length_mm(&self) -> f64 {
        self.distance_steps() * self.mm_per_step
    }

    /// The lengths that are for the blends at its beginning and at its end, mm, if so much of it is left.
    fn rooms_mm(&self, left_mm: f64) -> [f64; 2] {
        if self.reach_mm.to_bits() == 0 {
            return [0.5 * left_mm; 2];
        }
        let length_mm = self.length_mm();
        let reach_mm = length_mm.min(self.reach_mm.into());
        [reach_mm, left_mm.min(length_mm - reach_mm)]
    }

    /// The squared speed at which the block before it, of that nominal square, ends, if this one begins at `entry`.
    pub(super) fn arrival(&self, entry: Square, nominal: Square) -> Square {
        if self.blend.is_none() { entry } else { self.blend.entry_at(entry).min(self.corner_square()).min(nominal) }
    }

    /// The highest squared speed at which it begins, if the block before it ends at `arrival`.
    pub(super) fn departure(&self, arrival: Square) -> Square {
        if self.blend.is_none() { arrival } else { self.blend.exit_at(arrival) }
    }

    pub(super) fn corner_square(&self) -> Square {
        self.corner.map_or(0, NonZero::get)
    }

    /// The speeds on which the cap of the next block depends.
    pub(super) fn pace(&self) -> Pace {
        Pace { nominal: self.nominal, start: self.start }
    }

    /// Computes how fast it may begin without a stop after a block with this pace.
    pub(super) fn set_cap(&mut self, before: Pace) {
        if !self.blend.is_none() {
            // If it is slower than a stop would allow, it stops.
            let arrival = self.corner_square().min(before.nominal);
            self.cap = self.corner_square().min(self.nominal).min(self.blend.exit_at(arrival));
            return;
        }
        let fastest = self.corner_square().min(self.nominal).min(before.nominal);
        // The cap is not below the lower start speed, because even a stop would allow that.
        self.cap = fastest.max(self.start.min(before.start));
    }
}
