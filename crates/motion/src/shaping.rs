//! Shaped runs: each axis makes the weighted sum of its motion at several instants.
//!
//! # Design
//! The shapers of the axes have different lengths, and each is late by its mean. So that the axes stay on the path at
//! constant speed, all are made as late as the latest of them; an axis without a shaper is only late. A run lasts longer by
//! the time until the last impulse of all axes has passed, and is over then. What belongs to a place on the path, a
//! laser's level and the reports, is late by the same mean.
//!
//! Homing and probing are not shaped: a switch, or a contact, ends them at once.

use isostep_profile::CountedPhase;
use isostep_profile::shaper::{Combination, Impulses, NextPart, Shaped, ShaperInput};

use crate::axes::{AXES, Axis};
use crate::config::Config;
use crate::tag::Chunk;

/// The number of phases that are kept of each axis.
pub(crate) const PHASES: usize = if cfg!(feature = "short-look-ahead") { 24 } else { 64 };

/// The shaping of the axes of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Shaping {
    /// The impulses of each axis, by which it is late by [`delay_s`](Self::delay_s) in the mean.
    pub impulses: [Impulses; AXES],
    /// By how much the axes are late on the path, s.
    pub delay_s: f64,
    /// The time by which a run lasts longer, s.
    pub lasts_s: f64,
}

impl Config {
    /// The shaping of runs of programs and jogs; `None` if no axis has a shaper. Not inlined, so that a chip may have it in
    /// slow memory: it is needed once a run.
    #[must_use]
    #[cold]
    pub fn shaping(&self) -> Option<Shaping> {
        let impulses = self.shapers.map(|shaper| shaper.impulses());
        if impulses.iter().all(|impulses| *impulses == Impulses::ONE) {
            return None;
        }
        let delay_s = impulses.iter().map(Impulses::mean_s).fold(0.0, f64::max);
        let impulses = impulses.map(|impulses| impulses.later(delay_s - impulses.mean_s()));
        let lasts_s = impulses.iter().map(Impulses::last_s).fold(0.0, f64::max);
        Some(Shaping { impulses, delay_s, lasts_s })
    }
}

/// What an axis is shaped from.
pub(crate) struct ShapedFrom<'a, F> {
    /// The axis, of what the chain plans.
    pub source: Combination,
    pub impulses: &'a Impulses,
    /// Its top speed, if it has a motor of its own.
    pub top_steps_s: f64,
    /// The chunk with a number, if it is known.
    pub chunk: F,
    /// No other chunk follows.
    pub is_closed: bool,
}

impl Shaping {
    /// True if X and Y are not shaped alike.
    pub(crate) fn is_unlike(&self) -> bool {
        self.impulses[Axis::X as usize] != self.impulses[Axis::Y as usize]
    }
}

/// The shaped motion of an axis in a run, as far as it has been read from the chunks.
pub(crate) struct ShapedAxis {
    shaped: Shaped<PHASES>,
    /// The reader of the chunks, and whether it has begun, with the first of them.
    input: ShaperInput,
    is_begun: bool,
    /// The number of the chunk that it reads.
    chunk: u32,
    is_finished: bool,
}

impl ShapedAxis {
    pub const fn new() -> Self {
        Self { shaped: Shaped::empty(), input: ShaperInput::empty(), is_begun: false, chunk: 0, is_finished: false }
    }

    /// Forgets everything, for another run.
    pub fn clear(&mut self) {
        (self.is_begun, self.chunk, self.is_finished) = (false, 0, false);
    }

    /// The number of the chunk that it reads.
    pub fn chunk(&self) -> u32 {
        self.chunk
    }

    /// Up to when shaped phases have been taken, s from the start of the run.
    pub fn taken_s(&self) -> f64 {
        if self.is_begun { self.shaped.taken_s() } else { 0.0 }
    }

    /// True if the axis has come to the end of the run.
    pub fn is_over(&self) -> bool {
        self.is_finished && self.shaped.is_over()
    }

    /// The next motion of an axis with a motor of its own; `None` if that is not known yet, or if it is over.
    pub fn next_phase<'a>(&mut self, from: &ShapedFrom<'_, impl Fn(u32) -> Option<&'a Chunk>>) -> Option<CountedPhase> {
        self.next(from, Shaped::next_phase)
    }

    /// The next motion of an axis that crossed belts move.
    #[cold]
    pub fn next_part<'a>(&mut self, from: &ShapedFrom<'_, impl Fn(u32) -> Option<&'a Chunk>>) -> NextPart {
        match self.next(from, Shaped::next_part) {
            Some(part) => NextPart::Part(part),
            None if self.is_over() => NextPart::Over(self.shaped.end_steps()),
            None => NextPart::Unknown,
        }
    }

    #[inline(always)]
    fn next<'a, T>(
        &mut self,
        from: &ShapedFrom<'_, impl Fn(u32) -> Option<&'a Chunk>>,
        next_shaped: fn(&mut Shaped<PHASES>) -> Option<T>,
    ) -> Option<T> {
        let ShapedFrom { source, impulses, top_steps_s, chunk, is_closed } = from;
        loop {
            if self.is_begun
                && let Some(next) = next_shaped(&mut self.shaped)
            {
                return Some(next);
            }
            let now = chunk(self.chunk)?;
            if !self.is_begun {
                self.input = ShaperInput::begin(*source, now, &mut self.shaped, **impulses, *top_steps_s);
                self.is_begun = true;
            }
            let input = &mut self.input;
            if input.read(now, &mut self.shaped) {
                continue;
            }
            if let Some(next) = chunk(self.chunk + 1) {
                if !self.shaped.has_room() {
                    return None;
                }
                input.go_on(now, next);
                self.chunk += 1;
            } else if *is_closed && !self.is_finished && self.shaped.has_room() {
                input.finish(now, &mut self.shaped);
                self.is_finished = true;
            } else {
                return None;
            }
        }
    }
}
