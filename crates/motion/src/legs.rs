//! The legs of a run: the parts of a move, and how far on the path each is made.

use core::cell::Cell;

use isostep_profile::SyncMove;
use isostep_profile::replan::PARTS;

use crate::axes::{AXES, Axis};

/// How many there may be: those of a change that has been fed up to the first of them, and those of the next.
const LEGS: usize = 2 * PARTS;

/// A part of a move, and how far on the path it is made.
#[derive(Clone, Copy)]
pub(crate) struct Leg {
    pub part: SyncMove<AXES>,
    /// Steps of the longest axis from the beginning of the whole move.
    pub until_steps: f64,
    /// When that is, s from the start of the run.
    pub until_s: f64,
}

impl Leg {
    /// The whole part.
    pub fn new(part: SyncMove<AXES>) -> Self {
        Self { part, until_steps: part.end_steps(), until_s: part.end_s() }
    }

    /// The last step of the axis in it, or before it.
    pub fn last_step(&self, axis: Axis) -> u32 {
        self.part.steps_before(axis as usize, self.until_steps)
    }
}

/// How far an axis's port has been fed in a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fed {
    /// Steps, of the whole move.
    pub steps: u32,
    /// Until when, us from the start of the run.
    pub until_us: u64,
}

/// The legs of a run, in order, from the first that an axis has still to be fed with.
pub(crate) struct Legs {
    all: heapless::Vec<Leg, LEGS>,
    /// How many of them are older than the last change.
    old: usize,
}

impl Legs {
    /// A run of one plan.
    pub fn new(plan: SyncMove<AXES>) -> Self {
        let mut legs = Self { all: heapless::Vec::new(), old: 0 };
        legs.push(plan);
        legs
    }

    pub fn all(&self) -> &[Leg] {
        &self.all
    }

    /// The leg with this index ends sooner, and is the last.
    pub fn cut(&mut self, index: usize, until_steps: f64, until_s: f64) {
        self.all.truncate(index + 1);
        if let Some(last) = self.all.last_mut() {
            (last.until_steps, last.until_s) = (until_steps, until_s);
        }
    }

    /// Forgets those that all axes have been fed with, the first ones: how many. What is pushed from now on is a change's.
    pub fn forget_fed(&mut self, fed: &[Cell<Fed>; AXES]) -> usize {
        let before = self.all.len();
        self.all.retain(|leg| !is_fed(leg, fed));
        self.old = self.all.len();
        before - self.old
    }

    /// Another leg, at the end. There is room, if the change before has been fed.
    pub fn push(&mut self, part: SyncMove<AXES>) {
        let _ = self.all.push(Leg::new(part));
    }

    /// Whether all axes have been fed up to the last change.
    pub fn are_old_fed(&self, fed: &[Cell<Fed>; AXES]) -> bool {
        self.all.iter().take(self.old).all(|leg| is_fed(leg, fed))
    }
}

/// Whether all axes have been fed with it.
fn is_fed(leg: &Leg, fed: &[Cell<Fed>; AXES]) -> bool {
    Axis::ALL.into_iter().all(|axis| fed[axis as usize].get().steps >= leg.last_step(axis))
}
