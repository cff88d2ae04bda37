//! Moves that follow each other without a stop: how fast each may begin and end, and the plans that they are made by.
//!
//! # Design
//! A chain holds the moves that are known ahead, in order, as one block each. It can always brake to rest within what
//! it knows; on this condition it is as fast as its limits allow. From one block to the next it takes the corner at a
//! speed that both blocks and the corner allow.
//!
//! The speeds where blocks meet are kept squared, in whole units. Over a block of length d at a constant acceleration
//! a, the squared speed changes by 2 a d at most. Each block stores this delta v². So a pass over the chain costs an
//! addition and a comparison a block, and is exact. It goes backwards from rest at the end,
//! `entry = min(cap, exit + decel delta v²)`, and forwards from the current place,
//! `exit = min(exit, entry + accel delta v²)`. A speed that no later move can change is final, and no pass looks at it
//! again. A pass is made only when a speed is needed that is not final yet.
//!
//! Speed profiles with curved ramps have a smaller delta v². Each of their ramps lies within a block, and the acceleration is
//! zero where blocks meet.
//!
//! A caller needs time to compile a move, most of it for curved ramps. No block is planned to be over sooner than that
//! ([`Effort`]). So a block has a squared speed above which it only cruises: it may begin faster than that if it also ends
//! so. Then the most that it can have at one end is `max(other, min(other + delta v², ramps to))`, still exact. As each
//! block lasts as long as it takes to compile, so do any number of them, and the machine slows down evenly to what its
//! processor carries.
//!
//! The speed at the beginning of a block after a stop depends on what follows, too: if the start speed is high and the
//! block short, the block might not be able to brake to the speed of the next corner.
//!
//! A block may always end at its start speed, because it may stop from that speed. If the next block cannot begin that
//! fast, the block does stop there, and the next block begins at its own start speed. Otherwise one more move could
//! make a speed too fast that is already committed.
//!
//! The chain hands out [`Chunk`]s. Each is a part of a [`SyncMove`] on the run's clock, no longer than the caller
//! asks for, because a chunk is committed: it will be made. A change (another block, a [`hold`](Chain::hold), other
//! [overrides](Chain::override_speed)) takes effect after the last chunk. A plan is used for as long as it is right.
//! When it is not, it is cut, and a replan of the same block follows it at the same speed. Steps keep their numbers in
//! the move.
//!
//! A plan promises how fast its block ends: until the plan slows down, it can brake to that speed from anywhere. So
//! what is left of a block can always end at the promised speed, even where its delta v², which is only a bound, is too
//! small for that.
//!
//! A trapezoid can be cut anywhere. A curved ramp that slows down is made to its end. A curved ramp that speeds up is
//! left at once; the S-curve leaves it by the second half of a ramp of jerk alone, which brings the acceleration to
//! zero.
//!
//! # An example
//! At 50 mm/s² and 30 mm/s (its square is 900), with `$11=0.01`, four moves of 5 mm follow each other: A and B along X, C and D
//! along Y. In each of them a squared speed changes by 2 a d = 500 at most.
//!
//! - **push.** A alone ends at rest. When B comes, a pass goes backwards from rest at the end: B may begin at 0 + 500. A pass
//!   forwards finds that A can reach that. So the path goes from A to B at 500, 22.4 mm/s. The corner from B to C is a right
//!   angle, which `$11` allows at a square of 1.7; so B brakes from 500 nearly all its length. Whatever comes after, A cannot
//!   end faster than 500: that speed is final.
//! - **advance** hands out a chunk of A, planned from rest to 500. Whatever comes meanwhile counts from its end on. If a later
//!   move makes a plan too slow, the plan is kept up to the place where it begins to slow down, because until there it is as fast
//!   as it can be. There it is cut.
//! - **hold**, when 3 mm of A have been handed out: the square is 300 there, and over the 2 mm that are left it loses 200. So A
//!   goes on by a plan that brakes, and ends at 100; B goes on braking and comes to rest after 1 mm. `start` begins there, on the
//!   clock of another run.
//! - **override_speed** to 50 % at the same place: feeds are 15 mm/s then (225), and the corners are computed again. A goes on by
//!   a plan that brakes from 300 to 225, and then by one to its end. What is too fast for the room that is left in a block brakes
//!   over more blocks than one.

mod blend;
mod block;
mod bound;
mod config;
mod corner;
mod hand_out;
mod meeting;
mod passes;
mod plan;
pub(crate) mod ring;

use self::block::ChainBlock;
pub use self::config::{ChainConfig, Effort, SHAPED_STEPS_MAX};
use self::corner::UnitVector;
use self::plan::{Begun, UnderWay};
use self::ring::Ring;
use crate::blend::Blend;
use crate::phase::AxisPhase;
use crate::sync::{PlanError, SyncMove};

/// The highest override of feeds, as a ratio. The delta v² of a block holds for feeds up to this.
pub const FEED_RATIO_MAX: f64 = 2.0;

/// The request of a move. `T` is what the caller keeps with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request<const N: usize, T = u64> {
    /// Steps of each axis, signed by direction; not all 0.
    pub steps: [i32; N],
    /// The distance of the place that is meant from these whole steps, in [`OFFSET_PARTS`](crate::OFFSET_PARTS) of a step, less
    /// than half of one. If the move is one of those that blends follow, the path goes there.
    pub offsets: [i8; N],
    /// Speed along the path, mm/s, above 0; `None`, or an infinite speed, is as fast as the limits allow.
    pub feed_mm_s: Option<f64>,
    /// True if it ends at rest even if another move follows.
    pub stops: bool,
    /// The distance by which the path may leave the corner at which the move begins, mm. If it is above 0, a blend of this
    /// deviation at most goes round the corner. If it is 0, or the speed profile has curved ramps, the path goes to the corner
    /// exactly, where axes change their speed at once.
    pub deviation_mm: f32,
    /// The length of it, less than all, that is for that blend, mm, which then reaches as far as it may, however slow it is; what
    /// is left is for the blend at the end. 0 if each has half of the move, and reaches as far as its speed needs.
    pub reach_mm: f32,
    /// The time that it lasts at least at constant speed, s, if the caller knows better than [`Effort`] what it takes; 0 if not.
    pub least_s: f32,
    /// A value for the caller, which every chunk of the move returns. The chain does not use it.
    pub tag: T,
}

impl<const N: usize, T: Default> Request<N, T> {
    /// As fast as the limits allow, to the corner exactly, and on without a stop; with the default tag.
    #[must_use]
    pub fn new(steps: [i32; N]) -> Self {
        Self {
            steps,
            offsets: [0; N],
            feed_mm_s: None,
            stops: false,
            deviation_mm: 0.0,
            reach_mm: 0.0,
            least_s: 0.0,
            tag: T::default(),
        }
    }
}

/// A part of a plan that the chain has handed out: it will be made next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chunk<const N: usize, T = u64> {
    /// The plan.
    pub plan: Plan<N>,
    /// The place on the path where the part ends, steps of the longest axis from the beginning of the move.
    pub until_steps: f64,
    /// The instant at which the part ends, s from the start of the run.
    pub until_s: f64,
    /// Path length of a step of the longest axis.
    pub mm_per_step: f64,
    /// The requested speed of the longest axis, steps/s, without overrides and limits.
    pub asked_steps_s: f64,
    /// The tag of the move's request.
    pub tag: T,
    /// The way in which it follows: it begins a move, begins a plan or goes on.
    pub kind: ChunkKind,
}

/// A plan of a chain: of a line, or of the corner before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Plan<const N: usize> {
    /// Straight on, for a move or a part of it.
    Line(SyncMove<N>),
    /// Round the corner at which the move begins.
    Blend(Blend<N>),
}

impl<const N: usize> Plan<N> {
    /// The plan of a line; `None` if it is that of a blend.
    #[must_use]
    pub fn line(&self) -> Option<&SyncMove<N>> {
        match self {
            Self::Line(line) => Some(line),
            Self::Blend(_) => None,
        }
    }

    /// The plan of a blend; `None` if it is that of a line.
    #[must_use]
    pub fn blend(&self) -> Option<&Blend<N>> {
        match self {
            Self::Line(_) => None,
            Self::Blend(blend) => Some(blend),
        }
    }

    /// The instant at which it begins, s from the start of the run.
    #[must_use]
    pub fn begin_s(&self) -> f64 {
        match self {
            Self::Line(line) => line.begin_s(),
            Self::Blend(blend) => blend.begin_s(),
        }
    }

    /// The instant at which it ends, s from the start of the run.
    #[must_use]
    pub fn end_s(&self) -> f64 {
        match self {
            Self::Line(line) => line.end_s(),
            Self::Blend(blend) => blend.end_s(),
        }
    }

    /// The phase with this index that the axis with index `axis` has in this plan, and when that ends, s from the start of the
    /// run; `None` beyond the last. A phase that lasts no time has any place. Its place counts from the whole step next to where the
    /// move begins, signed by direction.
    #[must_use]
    pub fn phase(&self, axis: usize, index: usize) -> Option<(AxisPhase, f64)> {
        match self {
            Self::Line(line) => line.phase(axis, index),
            Self::Blend(blend) => blend.counted_phase(axis, index).map(|counted| (counted.phase, counted.end_s)),
        }
    }
}

/// The way in which a chunk follows the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChunkKind {
    /// Another move begins, or a move goes on from rest after a hold.
    Move,
    /// The same move goes on by another plan.
    Replan,
    /// The same plan goes on.
    Continuation,
}

/// Moves that follow each other, at most `LEN` of them.
// An empty chain is all zeros in memory, so that a chip needs no copy of it in flash.
#[derive(Clone, Debug)]
pub struct Chain<const N: usize, const LEN: usize, T = u64> {
    config: ChainConfig<N>,
    /// The first block does not flow if it begins, or goes on, from rest.
    blocks: Ring<ChainBlock<N, T>, LEN>,
    /// The direction of the last block, and over which length that has its delta v², mm.
    last_direction: UnitVector<N>,
    last_line_mm: f64,
    /// The place where the block that was made last ends beside its whole steps: a block that comes at rest begins there.
    last_offsets: [i8; N],
    /// The number of blocks that a pass has looked at. Those that came later have no entry speeds yet.
    passed: usize,
    /// The number of blocks that have final entry speeds, unless the first block's entry is changed.
    settled: usize,
    /// Up to where the first block is committed, steps of its longest axis.
    place_steps: f64,
    /// The instant at which that place is reached, s from the start of the run.
    at_s: f64,
    /// The plan of the first block at that place. There is none where a block begins, and at rest.
    plan: UnderWay<N>,
    /// The blend into the first block, if that comes next.
    blend: Option<Blend<N>>,
    /// The beginning of the first block, if it was by a blend.
    begun: Option<Begun<N>>,
    /// True if a hold is in force: the chain brakes to rest, or rests until it is started.
    is_held: bool,
}

impl<const N: usize, const LEN: usize, T: Copy + Default> Chain<N, LEN, T> {
    /// A chain without moves, at rest, with this configuration.
    #[must_use]
    pub fn new(config: ChainConfig<N>) -> Self {
        Self { config, ..Self::empty(T::default()) }
    }
}

impl<const N: usize, const LEN: usize, T: Copy> Chain<N, LEN, T> {
    /// Sets the configuration by which moves are planned. The chain must not have any moves yet.
    pub fn set_config(&mut self, config: ChainConfig<N>) {
        self.config = config;
    }

    /// True if a hold is in force: the chain brakes to rest, or rests until it is started.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.is_held
    }

    /// A chain without moves, at rest, and without a configuration to plan any: see [`set_config`](Self::set_config).
    /// `tag` fills the places of moves that are still to come.
    #[must_use]
    pub const fn empty(tag: T) -> Self {
        Self {
            config: ChainConfig::none(),
            blocks: Ring::new(ChainBlock::none(tag)),
            last_direction: [0; N],
            last_line_mm: 0.0,
            last_offsets: [0; N],
            passed: 0,
            settled: 0,
            place_steps: 0.0,
            at_s: 0.0,
            plan: UnderWay::NONE,
            blend: None,
            begun: None,
            is_held: false,
        }
    }

    /// The number of moves that are not committed to their end.
    #[must_use]
    pub fn len(&self) -> usize {
        self.blocks.len()
    }

    /// The tag of the first move that is not committed to its end.
    #[must_use]
    pub fn first_tag(&self) -> Option<&T> {
        self.blocks.get(0).map(|first| &first.tag)
    }

    /// True if no move is left.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// True if there is no room for another move.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.blocks.is_full()
    }

    /// True if everything that is committed ends at rest.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        !self.plan.is_made && self.blend.is_none() && self.blocks.get(0).is_none_or(|first| !first.flows)
    }

    /// Appends a move.
    ///
    /// # Errors
    /// If the move cannot be planned, or if there is no room for it, nothing is changed.
    pub fn push(&mut self, request: Request<N, T>) -> Result<(), PlanError> {
        let is_begun = self.blocks.len() == 1;
        let is_late = is_begun && !self.is_at_rest();
        let (place_steps, bends) = (if is_begun { self.place_steps } else { 0.0 }, request.deviation_mm > 0.0);
        let before = self.blocks.last().map(|last| last.end(place_steps, bends));
        let begin = self.blocks.last().map_or(self.last_offsets, |last| last.move_steps.offsets[1]);
        // It is made in its place: a block is large.
        let block = self.blocks.next_place().ok_or(PlanError::NoRoom)?;
        let (direction, limits) = block.begin(request, begin, &self.config)?;
        if let Some(before) = before {
            block.follow(before, [&self.last_direction, &direction], &limits, &self.config);
        }
        block.is_late = is_late;
        let reach_mm = block.blend.reach_mm;
        let bent = !block.blend.is_none();
        let mut line_steps = block.distance_steps();
        if bent {
            line_steps -= reach_mm * block.steps_per_mm();
        }
        let line_mm = block.set_line(line_steps, &limits, &self.config);
        if bent {
            self.shorten_last(reach_mm);
        }
        self.blocks.extend();
        (self.last_direction, self.last_line_mm) = (direction, line_mm);
        Ok(())
    }

    /// Takes this length off the line of the last move, for a blend at its end. If the line that is left is too short to stop
    /// on it, its entry is not final any more, nor are those before.
    fn shorten_last(&mut self, mm: f64) {
        let Some(index) = self.blocks.len().checked_sub(1) else { return };
        let Some(last) = self.blocks.get_mut(index) else { return };
        last.shorten(self.last_line_mm, mm);
        if index < self.settled && last.entry > last.decel_delta_v2 {
            self.settled = self.settled.min(self.bound_entries());
        }
    }

    /// Lengthens the last move by one that goes straight on at the same feed, so that both are one move, if it has not
    /// begun yet. `join` is called with the tag of the last move and its length, steps of its longest axis; it returns
    /// the tag that the longer move is to have, or `None` if they are to remain two. Returns whether they are one.
    ///
    /// Each step keeps its place on the path, and no time is lost: no ramp of the longer move is shorter.
    pub fn lengthen(&mut self, request: &Request<N, T>, join: impl FnOnce(T, u32) -> Option<T>) -> bool {
        let begun = usize::from(self.has_begun());
        let len = self.blocks.len();
        let Some(last) = self.blocks.get_mut(len.wrapping_sub(1)).filter(|_| len > begun) else { return false };
        let Some(line_mm) = last.lengthen(request, join, &self.config) else { return false };
        self.last_line_mm = line_mm;
        // It counts as one that has just come. What is final remains so: a longer move may only be faster.
        self.passed = self.passed.min(len - 1);
        self.quicken_last();
        true
    }

    /// Lets the last move, which has become longer, go as fast as is asked of it, if it was too short for that.
    fn quicken_last(&mut self) {
        let last = self.blocks.len() - 1;
        // A blend that is as good as committed remains as it is, and so does what begins with it.
        if last == 1 && self.is_bound_to_bend() {
            return;
        }
        let is_settled = last < self.settled;
        let before = last.checked_sub(1).and_then(|before| self.blocks.get(before)).map(ChainBlock::pace);
        // After an override it may begin faster than it should, because there is no room to brake before it. That is promised.
        if let Some(block) = self.blocks.get_mut(last)
            && !(is_settled && block.entry > block.cap)
            && block.quicken(&self.config)
        {
            before.into_iter().for_each(|before| block.set_cap(before));
            // If it is the next to be made, it begins as fast as what is committed ends.
            self.settled = self.settled.min(last).max(self.bound_entries());
        }
    }

    /// Forgets all moves and ends a hold. The chain is then at rest, on a new clock. What is committed is not taken
    /// back.
    pub fn clear(&mut self) {
        self.blocks.clear();
        self.last_offsets = [0; N];
        (self.passed, self.settled) = (0, 0);
        (self.plan.is_made, self.blend, self.begun, self.place_steps) = (false, None, None, 0.0);
        (self.is_held, self.at_s) = (false, 0.0);
    }

    /// Brakes to rest, beginning after what is committed, and stays there until [`start`](Self::start).
    pub fn hold(&mut self) {
        if !self.is_held {
            self.is_held = true;
            self.plan.is_stale = true;
        }
    }

    /// Begins from rest on a new clock; after a hold, from the place where the chain rests. If no step is left of the
    /// first move, the rest of that move is forgotten. While the chain moves, this only ends a hold: it goes on after
    /// what is committed, on the same clock.
    pub fn start(&mut self) {
        if !self.is_at_rest() {
            if self.is_held {
                self.is_held = false;
                self.plan.is_stale = true;
            }
            return;
        }
        (self.is_held, self.at_s) = (false, 0.0);
        if self.blocks.get(0).is_some_and(|first| first.has_no_step_after(self.place_steps)) {
            self.pop_block();
            (self.place_steps, self.begun) = (0.0, None);
            self.rest();
        }
        self.compute_entries();
    }

    /// Overrides feeds and rapids by these ratios. Both are above 0; feeds go up to [`FEED_RATIO_MAX`], rapids up to 1.
    /// Moves that are then too fast brake to the new speed, over several moves if necessary.
    pub fn override_speed(&mut self, feed_ratio: f64, rapid_ratio: f64) {
        self.config.set_ratios(feed_ratio, rapid_ratio);
        self.plan.is_stale = true;
        let mut before = None;
        for index in 0..self.blocks.len() {
            let Some(block) = self.blocks.get_mut(index) else { break };
            let limits = self.config.shared_limits(&block.move_steps);
            block.respeed(block.feed_steps_s(), &limits, &self.config);
            before.into_iter().for_each(|before| block.set_cap(before));
            before = Some(block.pace());
        }
        self.compute_entries();
    }

    /// The instant at which what is committed ends, s from the start of the run.
    #[must_use]
    pub fn at_s(&self) -> f64 {
        self.at_s
    }

    /// True if some of the first move is committed, or planned.
    fn has_begun(&self) -> bool {
        self.plan.is_made || self.place_steps > 0.0
    }

    /// Commits what follows, and hands it out: a part of the first move that lasts `most_s` at most, or a whole blend.
    /// `None` at rest: all moves are committed to their ends, or the chain is held.
    pub fn advance(&mut self, most_s: f64) -> Option<Chunk<N, T>> {
        while !(self.is_empty() || self.is_held && self.is_at_rest()) {
            if let Some(blend) = self.blend.take() {
                return self.hand_out_blend(blend);
            }
            self.look();
            let sound_s = match self.sound_until_s() {
                Some(sound_s) => sound_s,
                None => {
                    self.replan();
                    if !self.plan.is_made {
                        continue;
                    }
                    // A plan that has just been made is right to its end.
                    self.plan.end_s
                }
            };
            let most_s = self.at_s + most_s;
            return self.hand_out(if sound_s < most_s { sound_s } else { most_s });
        }
        None
    }
}
