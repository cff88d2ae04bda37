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
//! of their ramps lies within a block, and has no acceleration where blocks meet.
//!
//! What is to be made next is told as [`Leg`]s, each a stretch of a [`SyncMove`] on the run's clock, no further ahead than
//! is asked for: what has been told is made, come what may. Whatever comes between (another block, a [`hold`](Chain::hold),
//! other [overrides](Chain::override_speed)) counts from there on. A plan goes on for as long as it is the right one; where it
//! is not, it is cut, and another part of the same path follows it at the same speed. Steps keep their numbers in the move.

mod block;
mod ring;

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
    corner_accel_mm_s2: [f32; N],
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
            (accel_steps_s2.min(decel_steps_s2) * mm_per_step[axis]) as f32
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
    blocks: Ring<Block<N>, LEN>,
    /// The entries up to the block with this index are final.
    settled: usize,
    /// Up to where the first block has been told, steps of its longest axis.
    place_steps: f64,
    /// When that is, s from the start of the run.
    at_s: f64,
    /// What the first block is made by there.
    plan: Option<Plan<N>>,
    /// The next plan begins a move, or begins from rest.
    is_fresh: bool,
    /// It is braking to rest.
    is_held: bool,
    /// It has come to rest in the midst of a block.
    is_at_rest: bool,
    /// How often all has been reckoned anew.
    revision: u32,
}

/// A plan under way.
#[derive(Clone, Copy, Debug)]
struct Plan<const N: usize> {
    part: SyncMove<N>,
    /// How fast it ends.
    exit: Square,
    /// It ends where the block does.
    ends_block: bool,
    /// From when on it slows down, s from the start of the run.
    slows_s: f64,
    revision: u32,
    kind: LegKind,
}

/// Nothing is left of a move, steps.
const NOTHING_STEPS: f64 = 1e-6;

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
            is_fresh: true,
            is_held: false,
            is_at_rest: true,
            revision: 0,
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

    /// Where the moves of which nothing has been told yet begin, counted from the first.
    #[must_use]
    pub fn is_under_way(&self) -> bool {
        self.plan.is_some() || self.place_steps > 0.0
    }

    /// Puts a move behind the last.
    ///
    /// # Errors
    /// A move that cannot be planned, or for which there is no room, changes nothing.
    pub fn push(&mut self, wanted: Wanted<N>) -> Result<(), PlanError> {
        let mut block = Block::new(wanted, &self.terms, self.scale)?;
        match self.blocks.len().checked_sub(1).and_then(|last| self.blocks.get(last)) {
            Some(before) => block.follow(before, &self.terms, self.scale),
            None => {
                block.cap = block.start;
                block.entry = block.start;
            }
        }
        self.blocks.push(block).map_err(|_| PlanError::NoRoom)?;
        self.pass();
        Ok(())
    }

    /// Forgets all moves. What has been told is not taken back.
    pub fn clear(&mut self) {
        while self.blocks.pop().is_some() {}
        self.rest();
        self.at_s = 0.0;
    }

    /// Brakes to rest from what has been told on, and stays there until [`start`](Self::start).
    pub fn hold(&mut self) {
        if !self.is_held {
            self.is_held = true;
            self.revision = self.revision.wrapping_add(1);
        }
    }

    /// Begins from rest, on another clock; after a hold from where it is. What is left of a move is forgotten if no step is.
    pub fn start(&mut self) {
        self.rest();
        (self.is_held, self.at_s) = (false, 0.0);
        self.revision = self.revision.wrapping_add(1);
        if self.blocks.get(0).is_some_and(|block| block.has_no_step_after(self.place_steps)) {
            let _ = self.blocks.pop();
            self.place_steps = 0.0;
        }
        self.reckon();
    }

    /// Has feeds, and rapids, be so large a share of what they are without: above 0, a rapid's 1 at most.
    pub fn override_speed(&mut self, feed_share: f64, rapid_share: f64) {
        (self.terms.feed_share, self.terms.rapid_share) = (feed_share, rapid_share);
        self.revision = self.revision.wrapping_add(1);
        let (terms, scale) = (self.terms, self.scale);
        for index in 0..self.blocks.len() {
            if let Some(block) = self.blocks.get_mut(index) {
                block.respeed(&terms, scale);
            }
            self.set_cap(index);
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
        loop {
            let block = *self.blocks.get(0)?;
            if self.is_at_rest && self.is_held {
                return None;
            }
            if let Some(plan) = self.plan {
                let sound_s = self.sound_until_s(&plan);
                if self.at_s < sound_s {
                    return Some(self.tell(plan, &block, sound_s.min(self.at_s + most_s)));
                }
            }
            if !self.replan(&block) {
                return None;
            }
        }
    }

    /// Until when `plan` is what the first block is to be made by.
    fn sound_until_s(&self, plan: &Plan<N>) -> f64 {
        let end_s = plan.part.end_s();
        let may_be_cut = self.terms.speed_law == SpeedLaw::Trapezoid;
        let slows = self.at_s >= plan.slows_s;
        if plan.revision != self.revision {
            return if slows && !may_be_cut { end_s } else { self.at_s };
        }
        match plan.ends_block && plan.exit != self.exit() {
            false => end_s,
            // Up to there it is as fast as it can be.
            true if !slows => plan.slows_s,
            true if may_be_cut => self.at_s,
            true => end_s,
        }
    }

    /// Tells `plan` until then.
    fn tell(&mut self, plan: Plan<N>, block: &Block<N>, until_s: f64) -> Leg<N> {
        let part = plan.part;
        let is_end = until_s >= part.end_s();
        let until_steps = if is_end { part.end_steps() } else { part.place_at(until_s) };
        let (mm_per_step, tag) = (block.mm_per_step, block.wanted.tag);
        let leg = Leg { part, until_steps, until_s, mm_per_step, tag, kind: plan.kind };
        (self.at_s, self.place_steps) = (until_s, until_steps);
        self.plan = Some(Plan { kind: LegKind::Further, ..plan });
        self.is_fresh = false;
        if is_end && plan.ends_block {
            self.end_block(plan.exit);
        } else if is_end && self.is_held && plan.exit <= block.start {
            self.rest();
        }
        leg
    }

    /// At rest where it is.
    fn rest(&mut self) {
        (self.plan, self.is_fresh, self.is_at_rest) = (None, true, true);
        if self.blocks.len() == 0 {
            self.place_steps = 0.0;
        }
    }

    /// Goes over to the next block, with the speed of `exit`.
    fn end_block(&mut self, exit: Square) {
        let _ = self.blocks.pop();
        (self.place_steps, self.plan, self.is_fresh) = (0.0, None, true);
        self.settled = self.settled.saturating_sub(1);
        let Some(next) = self.blocks.get_mut(0) else {
            self.is_at_rest = true;
            return;
        };
        if next.corner.is_none() {
            next.entry = next.start;
            self.is_at_rest = true;
        } else if next.entry != exit {
            next.entry = exit;
            self.forward(0);
        }
    }

    /// Plans what is left of `block`, the first, from where it is on. False if it is at rest, held.
    fn replan(&mut self, block: &Block<N>) -> bool {
        let (speed_steps_s, accel_steps_s2) = self.motion(block);
        let left_steps = block.way_steps - self.place_steps;
        if left_steps <= NOTHING_STEPS {
            self.end_block(self.square_of(speed_steps_s, block));
            return true;
        }
        let eases = self.terms.speed_law == SpeedLaw::SCurve && accel_steps_s2 > 0.0;
        let jerk_steps_s3 = block.limits_now().jerk_steps_s3;
        if eases && jerk_steps_s3.is_finite() && self.plan.is_some() {
            self.ease(block, speed_steps_s, accel_steps_s2, jerk_steps_s3);
            return true;
        }
        if self.place_steps > 0.0 {
            self.cut(block, speed_steps_s, left_steps);
        }
        let Some(block) = self.blocks.get(0).copied() else { return true };
        let exit = self.exit();
        let exit_steps_s = block.speed_steps_s(exit, self.scale);
        let limits = block.limits_now();
        let slow_steps_s = if self.is_held { limits.start_speed_steps_s } else { limits.top_speed_steps_s };
        let law = self.terms.speed_law;
        if speed_steps_s > slow_steps_s {
            let braking = |fast, slow| Profile::braking(fast, slow, &limits, law);
            let slower = braking(speed_steps_s, slow_steps_s);
            let mut needed_steps = slower.distance_steps() + NOTHING_STEPS;
            if !self.is_held && exit_steps_s < slow_steps_s {
                needed_steps += braking(slow_steps_s, exit_steps_s).distance_steps();
            }
            if needed_steps < left_steps {
                let exit = if self.is_held { block.start } else { self.square_of(slow_steps_s, &block) };
                self.begin(slower, exit, false);
                return true;
            }
        } else if self.is_held {
            self.rest();
            return false;
        }
        let is_whole = self.is_at_rest && speed_steps_s <= limits.start_speed_steps_s;
        let interval_law = if is_whole { self.terms.interval_law } else { IntervalLaw::Fastest };
        let top_steps_s = if self.is_held { 0.0 } else { limits.top_speed_steps_s };
        let limits = Limits { top_speed_steps_s: top_steps_s.max(speed_steps_s), ..limits };
        let profile = Profile::between(left_steps, speed_steps_s, exit_steps_s, &limits, interval_law, law);
        self.begin(profile, exit, true);
        true
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

    /// The first block is from now on what is left of it.
    fn cut(&mut self, block: &Block<N>, speed_steps_s: f64, left_steps: f64) {
        let entry = self.square_of(speed_steps_s, block);
        let exit_before = self.plan.filter(|plan| plan.ends_block).map_or(entry, |plan| plan.exit);
        let (terms, scale) = (self.terms, self.scale);
        if let Some(first) = self.blocks.get_mut(0) {
            first.entry = entry;
            first.set_gains(left_steps, &terms, scale);
            // What it was to brake to, it can.
            first.decel_gain = first.decel_gain.max(entry.saturating_sub(exit_before));
        }
        self.forward(0);
    }

    /// Goes on by the second half of a ramp that is all jerk, which brings the acceleration to nothing.
    fn ease(&mut self, block: &Block<N>, speed_steps_s: f64, accel_steps_s2: f64, jerk_steps_s3: f64) {
        let profile = Profile::easing(speed_steps_s, accel_steps_s2, jerk_steps_s3);
        let half_s = profile.duration_s() / 2.0;
        let part = SyncMove {
            profile,
            steps: block.wanted.steps,
            from_steps: self.place_steps,
            origin_steps: self.place_steps - profile.position_at(half_s),
            origin_s: self.at_s - half_s,
        };
        let exit = self.square_of(profile.exit_speed_steps_s(), block);
        let (revision, kind) = (self.revision, LegKind::Part);
        // Nothing changes it.
        self.plan = Some(Plan { part, exit, ends_block: false, slows_s: f64::NEG_INFINITY, revision, kind });
    }

    /// Goes on by `profile` from where it is.
    fn begin(&mut self, profile: Profile, exit: Square, ends_block: bool) {
        let Some(block) = self.blocks.get(0) else { return };
        let place_steps = self.place_steps;
        let (steps, origin_s) = (block.wanted.steps, self.at_s);
        let part = SyncMove { profile, steps, from_steps: place_steps, origin_steps: place_steps, origin_s };
        let slows_s = part.end_s() - profile.t_decel_s();
        let kind = if self.is_fresh { LegKind::Move } else { LegKind::Part };
        self.is_at_rest = false;
        self.plan = Some(Plan { part, exit, ends_block, slows_s, revision: self.revision, kind });
    }

    /// How fast the first block is to end.
    fn exit(&self) -> Square {
        let Some(first) = self.blocks.get(0) else { return 0 };
        let exit = self.exit_of(0, first);
        if self.is_held { first.entry.saturating_sub(first.decel_gain).max(first.start).min(exit) } else { exit }
    }

    /// How fast the block with this index ends.
    fn exit_of(&self, index: usize, block: &Block<N>) -> Square {
        match self.blocks.get(index + 1) {
            Some(next) if next.corner.is_some() => next.entry,
            _ => block.start,
        }
    }

    fn set_cap(&mut self, index: usize) {
        let Some(before) = index.checked_sub(1).and_then(|index| self.blocks.get(index)).copied() else { return };
        if let Some(block) = self.blocks.get_mut(index) {
            block.set_cap(&before);
        }
    }

    /// Reckons all entries but the first's anew.
    fn reckon(&mut self) {
        let Some(first) = self.blocks.get(0).copied() else { return };
        let (speed_steps_s, _) = self.motion(&first);
        if self.is_at_rest {
            self.blocks.get_mut(0).map(|first| first.entry = first.start);
        }
        self.settled = 0;
        self.backward(None);
        if self.place_steps > 0.0 {
            let speed_steps_s = if self.is_at_rest { 0.0 } else { speed_steps_s };
            self.cut(&first, speed_steps_s, first.way_steps - self.place_steps);
        } else {
            self.forward(0);
        }
    }

    /// Looks at what a block more changes.
    fn pass(&mut self) {
        let from = self.backward(self.blocks.len().checked_sub(1));
        self.forward(from.max(self.settled));
    }

    /// From the last block on, up to the one behind those that are settled, or to one that does not change: the one before
    /// that. `new` has no entry yet.
    fn backward(&mut self, new: Option<usize>) -> usize {
        let mut index = self.blocks.len();
        while index > self.settled + 1 {
            index -= 1;
            let Some(block) = self.blocks.get(index) else { break };
            let entry = block.cap.min(self.exit_of(index, block) + block.decel_gain);
            if entry == block.entry && new.is_some_and(|new| new != index) {
                break;
            }
            if let Some(block) = self.blocks.get_mut(index) {
                block.entry = entry;
            }
        }
        index.saturating_sub(1)
    }

    /// No block begins faster than the one before it can end; nor slower, where that is too fast to brake.
    fn forward(&mut self, from: usize) {
        let mut index = from;
        while let Some(block) = self.blocks.get(index) {
            let (highest, lowest) = (block.entry + block.accel_gain, block.entry.saturating_sub(block.decel_gain));
            index += 1;
            let Some(next) = self.blocks.get_mut(index) else { break };
            if next.corner.is_none() {
                self.settled = index;
                continue;
            }
            if highest <= next.entry {
                next.entry = highest;
                self.settled = index;
            } else if next.entry == next.cap {
                self.settled = index;
            }
            next.entry = next.entry.max(lowest);
        }
    }
}
