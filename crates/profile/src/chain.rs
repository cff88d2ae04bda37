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
//! gain)`. What a pass has found final, whatever comes, is not looked at again; and a pass is made only when something is asked
//! for that is not final yet. Laws with curved ramps gain less; each of their ramps lies within a block, and has no acceleration
//! where blocks meet. How fast a stop is left depends on what follows, too: where a start speed is high and a move short, the
//! corner after it may not be reached so fast.
//!
//! A block may always end at its start speed, as there it may stop. So where what follows is not as fast as that, it does
//! stop there, and what follows begins at its own start speed; else a move more could make a speed too fast that was told.
//!
//! What is to be made next is told as [`Chunk`]s, each a stretch of a [`SyncMove`] on the run's clock, no further ahead than
//! is asked for: what has been told is made, come what may. Whatever comes between (another block, a [`hold`](Chain::hold),
//! other [overrides](Chain::override_speed)) counts from there on. A plan goes on for as long as it is the right one; where it
//! is not, it is cut, and another part of the same path follows it at the same speed. Steps keep their numbers in the move.
//! A plan promises how fast its block ends: until it slows down, braking to that is possible from anywhere on it. So what
//! is left of a block can always be ended by what was promised, even where its gain, which is a bound, says less.
//!
//! A trapezoid is cut anywhere. Of a curved law, a ramp that slows down is made to its end; one that speeds up is left at
//! once, by the S-curve through the second half of a ramp that is all jerk.

mod block;
mod config;
mod corner;
mod passes;
mod plan;
mod ring;

use self::block::Block;
pub use self::config::ChainConfig;
use self::plan::Plan;
use self::ring::Ring;
use crate::sync::{PlanError, SyncMove};

/// The most that a feed is overridden by: what may be gained is reckoned for it.
pub const FEED_RATIO_MAX: f64 = 2.0;

/// A move that is to be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request<const N: usize> {
    /// Steps of each axis, signed by direction; not all 0.
    pub steps: [i32; N],
    /// Speed along the path, mm/s, above 0; `None` is as fast as the limits allow.
    pub feed_mm_s: Option<f64>,
    /// It ends at rest, whatever comes next.
    pub stops: bool,
    /// Whatever whoever wants it wants to know of it again; it changes nothing.
    pub tag: u64,
}

/// What is to be made next: a stretch of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chunk<const N: usize> {
    /// The plan.
    pub plan: SyncMove<N>,
    /// Where on the path the stretch ends, steps of the longest axis from the beginning of the move.
    pub until_steps: f64,
    /// When that is, s from the start of the run.
    pub until_s: f64,
    /// Path length of a step of the longest axis.
    pub mm_per_step: f64,
    /// The speed that was asked for the move, not overridden and not limited, of the longest axis.
    pub asked_steps_s: f64,
    /// Of the move.
    pub tag: u64,
    /// Where in its plan and its move it is.
    pub kind: ChunkKind,
}

/// How a chunk goes on from the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChunkKind {
    /// Another move begins, or goes on from rest after a hold.
    Move,
    /// The move goes on by another part.
    Replan,
    /// The part goes on.
    Continuation,
}

/// Moves that follow each other, at most `LEN` of them.
// Nothing of an empty one is anything but 0, so that a chip need not keep it where it keeps its program.
#[derive(Clone, Debug)]
pub struct Chain<const N: usize, const LEN: usize> {
    config: ChainConfig<N>,
    /// The first does not flow if it begins, or goes on, from rest.
    blocks: Ring<Block<N>, LEN>,
    /// So many blocks have been looked at by a pass. Those that came since have no entries yet.
    passed: usize,
    /// Of so many blocks the entries are final, unless the first one's is changed.
    settled: usize,
    /// Up to where the first block has been told, steps of its longest axis.
    place_steps: f64,
    /// When that is, s from the start of the run.
    at_s: f64,
    /// What the first block is made by there. None where a block begins, and at rest.
    plan: Plan<N>,
    /// It is braking to rest, or at rest until it is started.
    is_held: bool,
}

impl<const N: usize, const LEN: usize> Chain<N, LEN> {
    /// No moves, at rest, by these config.
    #[must_use]
    pub fn new(config: ChainConfig<N>) -> Self {
        Self { config, ..Self::empty() }
    }

    /// Has moves planned by these config. There are none yet.
    pub fn set_config(&mut self, config: ChainConfig<N>) {
        self.config = config;
    }

    /// Braking to rest, or held there.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.is_held
    }

    /// No moves, at rest, and no config to plan any by: see [`set_config`](Self::set_config).
    #[must_use]
    pub const fn empty() -> Self {
        Self {
            config: ChainConfig::NONE,
            blocks: Ring::new(Block::NONE),
            passed: 0,
            settled: 0,
            place_steps: 0.0,
            at_s: 0.0,
            plan: Plan::NONE,
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

    /// What has been told ends at rest.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        !self.plan.is_made && self.blocks.get(0).is_none_or(|first| !first.flows)
    }

    /// Puts a move behind the last.
    ///
    /// # Errors
    /// A move that cannot be planned, or for which there is no room, changes nothing.
    pub fn push(&mut self, request: Request<N>) -> Result<(), PlanError> {
        let mut block = Block::new(request, &self.config)?;
        if let Some(before) = self.blocks.last() {
            block.follow(before, &self.config);
        }
        if self.blocks.push(block) { Ok(()) } else { Err(PlanError::NoRoom) }
    }

    /// Forgets all moves, and is at rest on another clock. What has been told is not taken back; a hold is.
    pub fn clear(&mut self) {
        self.blocks.clear();
        (self.passed, self.settled) = (0, 0);
        (self.plan.is_made, self.place_steps) = (false, 0.0);
        (self.is_held, self.at_s) = (false, 0.0);
    }

    /// Brakes to rest from what has been told on, and stays there until [`start`](Self::start).
    pub fn hold(&mut self) {
        if !self.is_held {
            self.is_held = true;
            self.plan.is_stale = true;
        }
    }

    /// Begins from rest, on another clock; after a hold from where it is. What is left of a move is forgotten if no step is.
    /// While it moves it only takes a hold back: it goes on from what has been told, on the same clock.
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
            self.blocks.pop();
            self.place_steps = 0.0;
            self.rest();
        }
        self.reckon();
    }

    /// Has feeds, and rapids, be so large a fraction of what they are without: above 0, to [`FEED_RATIO_MAX`] and to 1. What
    /// is faster than it is to be brakes to that, if need be over more moves than one.
    pub fn override_speed(&mut self, feed_ratio: f64, rapid_ratio: f64) {
        self.config.set_ratios(feed_ratio, rapid_ratio);
        self.plan.is_stale = true;
        let mut before = None;
        for index in 0..self.blocks.len() {
            let Some(block) = self.blocks.get_mut(index) else { break };
            block.respeed(&self.config);
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

    /// What follows all that was told, of the first move, for `most_s` at most. `None` at rest: all moves have been told, or it
    /// is held.
    pub fn advance(&mut self, most_s: f64) -> Option<Chunk<N>> {
        while !(self.is_empty() || self.is_held && self.is_at_rest()) {
            self.look();
            match self.sound_until_s() {
                Some(sound_s) => {
                    let most_s = self.at_s + most_s;
                    return self.tell(if sound_s < most_s { sound_s } else { most_s });
                }
                None => self.replan(),
            }
        }
        None
    }
}
