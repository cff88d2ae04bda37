//! Moves that follow each other without a stop: how fast each may begin and end, and the parts that are made of them.
//!
//! # Design
//! A chain is what is known of the path ahead: blocks, a move each, in order. It may always brake to rest within what it
//! knows, and is as fast as its limits allow then. Between two blocks it goes round the corner at a speed that both of
//! them, and the corner, allow.
//!
//! Speeds where blocks meet are kept squared, in whole units: over a block at constant acceleration a square gains or
//! loses 2 a d at most, which a block knows. So a pass over the chain is an addition and a comparison a block, and exact:
//! backwards from rest at the end, `entry = min(cap, exit + loss)`, and forwards from where it is, `exit = min(exit, entry +
//! gain)`. What a pass has found final, whatever comes, is not looked at again. Laws with curved ramps gain less; each
//! of their ramps lies within a block, and has no acceleration where blocks meet. How fast a stop is left depends on what
//! follows, too: where a start speed is high and a move short, the corner after it may not be reached so fast.
//!
//! A block may always end at its start speed, as there it may stop. So where what follows is not as fast as that, it does
//! stop there, and what follows begins at its own start speed; else a move more could make a speed too fast that was told.
//!
//! What is to be made next is told as [`Leg`]s, each a stretch of a [`SyncMove`] on the run's clock, no further ahead than
//! is asked for: what has been told is made, come what may. Whatever comes between (another block, a [`hold`](Chain::hold),
//! other [overrides](Chain::override_speed)) counts from there on. A plan goes on for as long as it is the right one; where it
//! is not, it is cut, and another part of the same path follows it at the same speed. Steps keep their numbers in the move.
//! A plan promises how fast its block ends: until it slows down, braking to that is possible from anywhere on it. So what
//! is left of a block can always be ended by what was promised, even where its gain, which is a bound, says less.
//!
//! A trapezoid is cut anywhere. Of a curved law, a ramp that slows down is made to its end; one that speeds up is left at
//! once, by the S-curve through the second half of a ramp that is all jerk.

mod block;
mod ring;

pub use self::block::FEED_SHARE_MAX;
use self::block::{Block, Scale, Square};
use self::ring::Ring;
use crate::law::{IntervalLaw, SpeedLaw};
use crate::limits::Limits;
use crate::profile::Profile;
use crate::sync::{PlanError, SyncMove};

/// A move that is to be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted<const N: usize> {
    /// Steps of each axis, signed by direction; not all 0.
    pub steps: [i32; N],
    /// Speed along the path, mm/s, above 0; `None` is as fast as the limits allow.
    pub feed_mm_s: Option<f64>,
    /// It ends at rest, whatever comes next.
    pub stops: bool,
    /// What it is called by whoever wants it.
    pub tag: u32,
}

/// How the moves of a chain are planned.
#[derive(Clone, Copy, Debug)]
pub struct Terms<const N: usize> {
    limits: [Limits; N],
    mm_per_step: [f64; N],
    corner_deviation_mm: f64,
    interval_law: IntervalLaw,
    speed_law: SpeedLaw,
    /// What an axis may do across a corner, mm/s².
    corner_accel_mm_s2: [f64; N],
    feed_share: f64,
    rapid_share: f64,
}

impl<const N: usize> Terms<N> {
    /// By which nothing can be planned.
    const NONE: Self = Self {
        limits: [Limits::NONE; N],
        mm_per_step: [0.0; N],
        corner_deviation_mm: 0.0,
        interval_law: IntervalLaw::Fastest,
        speed_law: SpeedLaw::Trapezoid,
        corner_accel_mm_s2: [0.0; N],
        feed_share: 1.0,
        rapid_share: 1.0,
    };

    /// For axes of these limits and resolutions. `corner_deviation_mm`, 0 or more, says how fast corners are taken: as
    /// fast as a circle that strays from the corner by so much.
    #[must_use]
    pub fn new(
        limits: [Limits; N],
        mm_per_step: [f64; N],
        corner_deviation_mm: f64,
        interval_law: IntervalLaw,
        speed_law: SpeedLaw,
    ) -> Self {
        let corner_accel_mm_s2 = core::array::from_fn(|axis| {
            let Limits { accel_steps_s2, decel_steps_s2, .. } = limits[axis];
            accel_steps_s2.min(decel_steps_s2) * mm_per_step[axis]
        });
        Self {
            limits,
            mm_per_step,
            corner_deviation_mm,
            interval_law,
            speed_law,
            corner_accel_mm_s2,
            feed_share: 1.0,
            rapid_share: 1.0,
        }
    }
}

/// What is to be made next: a stretch of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg<const N: usize> {
    /// The plan.
    pub part: SyncMove<N>,
    /// Where on the path the stretch ends, steps of the longest axis from the beginning of the move.
    pub until_steps: f64,
    /// When that is, s from the start of the run.
    pub until_s: f64,
    /// Path length of a step of the longest axis.
    pub mm_per_step: f64,
    /// Of the move.
    pub tag: u32,
    /// Where in its plan and its move it is.
    pub kind: LegKind,
}

/// How a leg goes on from the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LegKind {
    /// Another move begins, or goes on from rest after a hold.
    Move,
    /// The move goes on by another part.
    Part,
    /// The part goes on.
    Further,
}

/// Moves that follow each other, at most `LEN` of them.
#[derive(Clone, Debug)]
pub struct Chain<const N: usize, const LEN: usize> {
    terms: Terms<N>,
    scale: Scale,
    /// The first does not flow if it begins, or goes on, from rest.
    blocks: Ring<Block<N>, LEN>,
    /// Of so many blocks the entries are final, unless the first one's is changed.
    settled: usize,
    /// Up to where the first block has been told, steps of its longest axis.
    place_steps: f64,
    /// When that is, s from the start of the run.
    at_s: f64,
    /// What the first block is made by there. `None` where a block begins, and at rest.
    plan: Option<Plan<N>>,
    /// It is braking to rest, or at rest until it is started.
    is_held: bool,
}

/// A plan under way.
#[derive(Clone, Copy, Debug)]
struct Plan<const N: usize> {
    part: SyncMove<N>,
    /// How fast the block ends by it, or can end after it.
    exit: Square,
    /// It ends where the block does.
    ends_block: bool,
    /// From when on it slows down, s from the start of the run.
    slows_s: f64,
    /// What it was made for has changed.
    is_stale: bool,
    /// Of the next leg by it.
    kind: LegKind,
}

/// Nothing is left of a move, steps; and as a share of its way, where rounding is more than that.
const NOTHING_STEPS: f64 = 1e-6;
const NOTHING_SHARE: f64 = 1e-14;

/// But for rounding.
fn is_no_faster(speed_steps_s: f64, than_steps_s: f64) -> bool {
    speed_steps_s <= than_steps_s * (1.0 + 1e-9)
}

impl<const N: usize, const LEN: usize> Chain<N, LEN> {
    /// No moves, at rest, by these terms.
    #[must_use]
    pub fn new(terms: Terms<N>) -> Self {
        let mut chain = Self::empty();
        chain.set_terms(terms);
        chain
    }

    /// Has moves planned by these terms. There are none yet.
    pub fn set_terms(&mut self, terms: Terms<N>) {
        (self.terms, self.scale) = (terms, Scale::of(&terms));
    }

    /// Braking to rest, or held there.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.is_held
    }

    /// No moves, at rest, and no terms to plan any by: see [`set_terms`](Self::set_terms).
    #[must_use]
    pub const fn empty() -> Self {
        Self {
            terms: Terms::NONE,
            scale: Scale::NONE,
            blocks: Ring::new(),
            settled: 0,
            place_steps: 0.0,
            at_s: 0.0,
            plan: None,
            is_held: false,
        }
    }

    /// How many moves have not been told to their end.
    #[must_use]
    pub fn len(&self) -> usize {
        self.blocks.len()
    }

    /// No move is left.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// No other move fits.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.blocks.is_full()
    }

    /// Some of the first move has been told.
    #[must_use]
    pub fn is_under_way(&self) -> bool {
        self.plan.is_some() || self.place_steps > 0.0
    }

    /// What has been told ends at rest.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.plan.is_none() && self.blocks.get(0).is_none_or(|first| !first.flows)
    }

    /// Puts a move behind the last.
    ///
    /// # Errors
    /// A move that cannot be planned, or for which there is no room, changes nothing.
    pub fn push(&mut self, wanted: Wanted<N>) -> Result<(), PlanError> {
        let mut block = Block::new(wanted, &self.terms, self.scale)?;
        if let Some(before) = self.len().checked_sub(1).and_then(|last| self.blocks.get(last)) {
            block.follow(before, &self.terms, self.scale);
        }
        self.blocks.push(block).map_err(|_| PlanError::NoRoom)?;
        self.pass();
        Ok(())
    }

    /// Forgets all moves, and is at rest on another clock. What has been told is not taken back; a hold is.
    pub fn clear(&mut self) {
        while self.blocks.pop().is_some() {}
        (self.plan, self.place_steps, self.settled) = (None, 0.0, 0);
        (self.is_held, self.at_s) = (false, 0.0);
    }

    /// Brakes to rest from what has been told on, and stays there until [`start`](Self::start).
    pub fn hold(&mut self) {
        if !self.is_held {
            self.is_held = true;
            self.make_stale();
        }
    }

    /// Begins from rest, on another clock; after a hold from where it is. What is left of a move is forgotten if no step is.
    /// While it moves it only takes a hold back: it goes on from what has been told, on the same clock.
    pub fn start(&mut self) {
        if !self.is_at_rest() {
            if self.is_held {
                self.is_held = false;
                self.make_stale();
            }
            return;
        }
        (self.is_held, self.at_s) = (false, 0.0);
        if self.blocks.get(0).is_some_and(|first| first.has_no_step_after(self.place_steps)) {
            let _ = self.blocks.pop();
            self.place_steps = 0.0;
            self.rest();
        }
        self.reckon();
    }

    /// Has feeds, and rapids, be so large a share of what they are without: above 0, to [`FEED_SHARE_MAX`] and to 1. What
    /// is faster than it is to be brakes to that, if need be over more moves than one.
    pub fn override_speed(&mut self, feed_share: f64, rapid_share: f64) {
        self.terms.feed_share = feed_share.min(FEED_SHARE_MAX);
        self.terms.rapid_share = rapid_share.min(1.0);
        self.make_stale();
        let mut before = None;
        for index in 0..self.blocks.len() {
            let Some(block) = self.blocks.get_mut(index) else { break };
            block.respeed(&self.terms, self.scale);
            before.into_iter().for_each(|before| block.set_cap(before));
            before = Some(block.pace());
        }
        self.reckon();
    }

    /// When what has been told ends, s from the start of the run.
    #[must_use]
    pub fn at_s(&self) -> f64 {
        self.at_s
    }

    /// Where the first block has been told up to, steps of its longest axis.
    #[must_use]
    pub fn place_steps(&self) -> f64 {
        self.place_steps
    }

    /// What follows all that was told, of the first move, for `most_s` at most. `None` at rest: all moves have been told, or it
    /// is held.
    pub fn advance(&mut self, most_s: f64) -> Option<Leg<N>> {
        while !(self.is_empty() || self.is_held && self.is_at_rest()) {
            match self.sound_until_s() {
                Some(sound_s) => return self.tell(sound_s.min(self.at_s + most_s)),
                None => self.replan(),
            }
        }
        None
    }

    /// Until when the plan is what the first block is made by. `None` if there has to be another one from here on.
    fn sound_until_s(&self) -> Option<f64> {
        let plan = self.plan.as_ref()?;
        let end_s = plan.part.end_s();
        if self.at_s >= end_s && plan.kind == LegKind::Further {
            return None;
        }
        let slows = self.at_s > plan.slows_s;
        let is_right = !plan.is_stale && (!plan.ends_block || plan.exit == self.exit());
        let is_bound =
            slows && self.terms.speed_law != SpeedLaw::Trapezoid || plan.ends_block && self.has_nothing_left();
        if is_right || is_bound {
            return Some(end_s);
        }
        // Up to there it is as fast as it can be.
        (!plan.is_stale && self.at_s < plan.slows_s).then_some(plan.slows_s)
    }

    /// Tells the plan until then.
    fn tell(&mut self, until_s: f64) -> Option<Leg<N>> {
        let (block, plan) = (self.blocks.get(0)?, self.plan.as_mut()?);
        let part = plan.part;
        let is_end = until_s >= part.end_s();
        let until_steps = if is_end { part.end_steps() } else { part.place_at(until_s) };
        let (mm_per_step, tag) = (block.mm_per_step, block.wanted.tag);
        let leg = Leg { part, until_steps, until_s, mm_per_step, tag, kind: plan.kind };
        plan.kind = LegKind::Further;
        let (exit, ends_block) = (plan.exit, plan.ends_block);
        (self.at_s, self.place_steps) = (until_s, until_steps);
        if is_end && ends_block {
            self.end_block(exit);
        } else if is_end && self.is_held {
            let start_steps_s = block.limits_now().start_speed_steps_s;
            if is_no_faster(part.profile.exit_speed_steps_s(), start_steps_s) {
                self.rest();
            }
        }
        Some(leg)
    }

    /// At rest where it is.
    fn rest(&mut self) {
        self.plan = None;
        self.settled = 0;
        match self.blocks.get_mut(0) {
            Some(first) => first.stop(),
            None => self.place_steps = 0.0,
        }
    }

    /// Goes over to the next block, with the speed of `exit`.
    fn end_block(&mut self, exit: Square) {
        let Some(before) = self.blocks.pop() else { return };
        (self.place_steps, self.plan) = (0.0, None);
        self.settled = self.settled.saturating_sub(1);
        let Some(next) = self.blocks.get_mut(0) else { return };
        let expected = next.entry;
        next.begin_after(exit, before.start);
        let is_expected = next.entry == expected;
        if next.flows {
            self.settled = self.settled.max(1);
        }
        if !is_expected {
            self.forward(0);
        }
    }

    /// What was planned is no longer what is wanted.
    fn make_stale(&mut self) {
        if let Some(plan) = &mut self.plan {
            plan.is_stale = true;
        }
    }

    /// Plans what is left of the first block from where it is on, or a part of that; or finds that nothing is left, or
    /// that it rests, held.
    fn replan(&mut self) {
        let Some(block) = self.blocks.get(0) else { return };
        let (speed_steps_s, accel_steps_s2) = self.motion(block);
        let left_steps = block.way_steps - self.place_steps;
        if self.has_nothing_left() {
            let exit = self.square_of(speed_steps_s, block);
            return self.end_block(exit);
        }
        let limits = block.limits_now();
        if self.terms.speed_law == SpeedLaw::SCurve && accel_steps_s2 > 0.0 && limits.jerk_steps_s3.is_finite() {
            return self.ease(speed_steps_s, accel_steps_s2, limits.jerk_steps_s3);
        }
        if self.is_held && is_no_faster(speed_steps_s, limits.start_speed_steps_s) {
            return self.rest();
        }
        self.cut(speed_steps_s, left_steps);
        if !self.slow_down(speed_steps_s, left_steps, &limits) {
            self.end(speed_steps_s, left_steps, &limits);
        }
    }

    /// Nothing of the first block is left that could be planned.
    fn has_nothing_left(&self) -> bool {
        let way_steps = self.blocks.get(0).map_or(0.0, |first| first.way_steps);
        way_steps - self.place_steps <= NOTHING_STEPS.max(NOTHING_SHARE * way_steps)
    }

    /// Slows down to the start speed, held, or to the top speed, if it is faster and there is room. True if it does.
    fn slow_down(&mut self, speed_steps_s: f64, left_steps: f64, limits: &Limits) -> bool {
        let slow_steps_s = if self.is_held { limits.start_speed_steps_s } else { limits.top_speed_steps_s };
        if is_no_faster(speed_steps_s, slow_steps_s) {
            return false;
        }
        let braking = |fast, slow| Profile::braking(fast, slow, limits, self.terms.speed_law);
        let slower = braking(speed_steps_s, slow_steps_s);
        let mut needed_steps = slower.distance_steps() + NOTHING_STEPS;
        let exit_steps_s = self.exit_steps_s();
        if !self.is_held && exit_steps_s < slow_steps_s {
            needed_steps += braking(slow_steps_s, exit_steps_s).distance_steps();
        }
        let has_room = needed_steps < left_steps;
        if has_room {
            self.begin(slower, false);
        }
        has_room
    }

    /// Goes on to the end of the block.
    fn end(&mut self, speed_steps_s: f64, left_steps: f64, limits: &Limits) {
        let exit_steps_s = self.exit_steps_s();
        let top_steps_s = if self.is_held { 0.0 } else { limits.top_speed_steps_s };
        let limits = Limits { top_speed_steps_s: top_steps_s.max(speed_steps_s).max(exit_steps_s), ..*limits };
        let interval_law = if self.is_at_rest() { self.terms.interval_law } else { IntervalLaw::Fastest };
        let law = self.terms.speed_law;
        self.begin(Profile::between(left_steps, speed_steps_s, exit_steps_s, &limits, interval_law, law), true);
    }

    /// How it moves where it is, steps/s and steps/s² of the longest axis.
    fn motion(&self, block: &Block<N>) -> (f64, f64) {
        match &self.plan {
            None => (block.speed_steps_s(block.entry, self.scale), 0.0),
            Some(plan) if self.at_s >= plan.part.end_s() => (plan.part.profile.exit_speed_steps_s(), 0.0),
            Some(plan) => plan.part.motion_at(self.at_s),
        }
    }

    fn square_of(&self, speed_steps_s: f64, block: &Block<N>) -> Square {
        let mm_s = speed_steps_s * block.mm_per_step;
        self.scale.square(mm_s * mm_s)
    }

    /// The first block is from now on what its plan has left of it.
    fn cut(&mut self, speed_steps_s: f64, left_steps: f64) {
        let Some(promised) = self.plan.as_ref().map(|plan| plan.exit) else { return };
        let Some(first) = self.blocks.get_mut(0) else { return };
        let mm_s = speed_steps_s * first.mm_per_step;
        first.entry = self.scale.square(mm_s * mm_s);
        first.set_gains(left_steps, &self.terms, self.scale);
        self.keep_promise(promised, speed_steps_s, left_steps);
        self.forward(0);
    }

    /// Where the first block is to end slower than its gain allows, it can if there is room, and if that is what was
    /// `promised`. Else it does what was promised, if that is slower than by its gain: with a limited jerk it takes longer
    /// to brake to a little more.
    fn keep_promise(&mut self, promised: Square, speed_steps_s: f64, left_steps: f64) {
        let Some(first) = self.blocks.get(0) else { return };
        let (wanted, lowest) = (self.exit_of(0, first), first.reach().1);
        if wanted >= lowest {
            return;
        }
        let has_room = wanted == promised || {
            let wanted_steps_s = first.speed_steps_s(wanted, self.scale);
            let limits = first.limits_now();
            let braking = Profile::braking(speed_steps_s, wanted_steps_s, &limits, self.terms.speed_law);
            braking.distance_steps() <= left_steps
        };
        let exit = if has_room { wanted } else { promised };
        if exit >= lowest {
            return;
        }
        match self.blocks.get_mut(1) {
            Some(next) if next.flows => next.entry = next.entry.min(exit),
            _ => self.blocks.get_mut(0).into_iter().for_each(|first| first.start = first.start.min(exit)),
        }
        if let Some(first) = self.blocks.get_mut(0) {
            first.decel_gain = first.entry - exit;
        }
    }

    /// Goes on by the second half of a ramp that is all jerk, which brings the acceleration to nothing.
    fn ease(&mut self, speed_steps_s: f64, accel_steps_s2: f64, jerk_steps_s3: f64) {
        let Some(plan) = &mut self.plan else { return };
        let profile = Profile::easing(speed_steps_s, accel_steps_s2, jerk_steps_s3);
        let half_s = profile.duration_s() / 2.0;
        let part = SyncMove {
            profile,
            steps: plan.part.steps,
            from_steps: self.place_steps,
            origin_steps: self.place_steps - profile.position_at(half_s),
            origin_s: self.at_s - half_s,
        };
        // Nothing changes it; and it is no faster, and no further on, than the plan would be that it leaves.
        let (slows_s, kind) = (f64::NEG_INFINITY, LegKind::Part);
        *plan = Plan { part, ends_block: false, slows_s, is_stale: false, kind, ..*plan };
    }

    /// Goes on by `profile` from where it is.
    fn begin(&mut self, profile: Profile, ends_block: bool) {
        let Some(block) = self.blocks.get(0) else { return };
        let (place_steps, exit) = (self.place_steps, self.exit());
        let (steps, origin_s) = (block.wanted.steps, self.at_s);
        let part = SyncMove { profile, steps, from_steps: place_steps, origin_steps: place_steps, origin_s };
        let slows_s = part.end_s() - profile.t_decel_s();
        let kind = if self.plan.is_none() { LegKind::Move } else { LegKind::Part };
        self.settled = self.settled.max(1);
        self.plan = Some(Plan { part, exit, ends_block, slows_s, is_stale: false, kind });
    }

    /// How fast the first block is to end; held, as slow as it can.
    fn exit(&self) -> Square {
        let Some(first) = self.blocks.get(0) else { return 0 };
        let (highest, lowest) = first.reach();
        // A start speed may be more than it comes to; or, at another speed, less.
        let exit = self.exit_of(0, first).min(highest).max(lowest);
        if self.is_held { lowest.max(first.start).min(exit) } else { exit }
    }

    /// The same in steps/s of its longest axis.
    fn exit_steps_s(&self) -> f64 {
        self.blocks.get(0).map_or(0.0, |first| first.speed_steps_s(self.exit(), self.scale))
    }

    /// How fast the block with this index ends.
    fn exit_of(&self, index: usize, block: &Block<N>) -> Square {
        match self.blocks.get(index + 1) {
            Some(next) if next.flows => next.entry,
            _ => block.start,
        }
    }

    /// Reckons all entries anew, but that of a first block under way. How far its plan has come is seen to when it is
    /// replaced: until then it may end as slow, and as fast, as it might have where it began.
    fn reckon(&mut self) {
        if self.is_at_rest()
            && self.place_steps > 0.0
            && let Some(first) = self.blocks.get_mut(0)
        {
            first.set_gains(first.way_steps - self.place_steps, &self.terms, self.scale);
        }
        self.settled = if self.is_at_rest() { 0 } else { 1 };
        self.backward(None);
        self.forward(0);
    }

    /// Looks at what a block more changes.
    fn pass(&mut self) {
        let from = self.backward(self.len().checked_sub(1));
        self.forward(from);
    }

    /// From the last block on, up to those whose entries are final, or to one whose entry does not change: the block before
    /// the last one looked at. `new` has no entry yet.
    fn backward(&mut self, new: Option<usize>) -> usize {
        let mut index = self.blocks.len();
        while index > self.settled {
            index -= 1;
            let Some(block) = self.blocks.get(index) else { break };
            let before = index.checked_sub(1).and_then(|index| self.blocks.get(index)).map(Block::pace);
            let (entry, flows) = block.fastest_entry(self.exit_of(index, block), before);
            if entry == block.entry && flows == block.flows && new.is_some_and(|new| new != index) {
                break;
            }
            if let Some(block) = self.blocks.get_mut(index) {
                (block.entry, block.flows) = (entry, flows);
            }
        }
        index.saturating_sub(1)
    }

    /// No block begins faster than the one before it can end. Where that is too fast to brake, it is seen to when it ends.
    ///
    /// An entry at its cap is final, and so are all before it; one that is as high as the one before it allows, if that is.
    fn forward(&mut self, from: usize) {
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
