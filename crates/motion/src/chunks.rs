//! The chunks of a run that have been handed out and are still needed.

use heapless::Deque;
use isostep_profile::chain::ChunkKind;
use isostep_profile::shaper::{Combination, Crossed, NextPart};
use isostep_profile::{CountedPhase, TimedPlan};

use crate::axes::Axis;
use crate::config::Config;
use crate::kinematics::Kinematics;
use crate::shaping::{ShapedAxis, ShapedFrom, Shaping};
use crate::sources::Sources;
use crate::tag::Chunk;

/// The number of chunks that are kept at once: with moves of a millisecond, more than is queued ahead.
const CHUNKS: usize = if cfg!(feature = "short-look-ahead") { 48 } else { 62 };
/// The number of these places that are kept free for chunks that are still to be streamed.
const CHUNKS_TO_STREAM: usize = CHUNKS - 16;

/// The chunks of a run, in order. Each keeps its number, which counts from the beginning of the run.
pub(crate) struct Chunks {
    known: Deque<Chunk, CHUNKS>,
    /// The number of the first chunk that is still kept.
    first: u32,
    /// The number of the chunk that was under way at the last call of [`newly_under_way`](Self::newly_under_way).
    under_way: Option<u32>,
    /// No chunk follows those that are known.
    is_closed: bool,
    /// The shaping of the run, if it is shaped.
    shaping: Option<Shaping>,
    sources: Sources,
    kinematics: Kinematics,
    /// The motors that crossed belts lead to, in a shaped run.
    crossed: Crossed,
}

impl Chunks {
    pub const fn new() -> Self {
        Self {
            known: Deque::new(),
            first: 0,
            under_way: None,
            is_closed: false,
            shaping: None,
            sources: Sources::new(),
            kinematics: Kinematics::Cartesian,
            crossed: Crossed::empty(),
        }
    }

    /// Forgets all chunks, for another run, which is shaped like this. `config` is that of the motors.
    pub fn clear(&mut self, shaping: Option<Shaping>, config: &Config) {
        self.kinematics = config.kinematics;
        self.crossed.begin([config.limits[0], config.limits[1]].map(|limits| limits.top_speed_steps_s));
        self.sources.clear(shaping.is_some());
        self.shaping = shaping;
        self.known.clear();
        (self.first, self.under_way, self.is_closed) = (0, None, false);
    }

    /// The chunk with this number, if it is known.
    pub fn get(&self, number: u32) -> Option<&Chunk> {
        self.known.get(number.checked_sub(self.first)? as usize)
    }

    /// The same, with what it is compiled from.
    pub fn get_with_sources(&mut self, number: u32) -> Option<(&Chunk, &mut Sources)> {
        let chunk = self.known.get(number.checked_sub(self.first)? as usize)?;
        Some((chunk, &mut self.sources))
    }

    /// The timed plan with which an axis has begun last, if the run is not shaped.
    pub fn begun(&mut self, axis: Axis) -> Option<&mut TimedPlan> {
        self.sources.begun(axis)
    }

    /// The shaping of the run, if it is shaped.
    pub fn shaping(&self) -> Option<&Shaping> {
        self.shaping.as_ref()
    }

    /// By how much the axes are late on the path, s.
    pub fn delay_s(&self) -> f64 {
        self.shaping.as_ref().map_or(0.0, |shaping| shaping.delay_s)
    }

    /// The instant at which the run is over, s from its start, if no chunk follows.
    pub fn over_s(&self) -> f64 {
        self.shaping.as_ref().map_or_else(|| self.end_s(), |shaping| self.end_s() + shaping.lasts_s)
    }

    /// Up to when the shaped motion of a motor has been taken, s from the start of the run, and whether that is all; `None` if the run is
    /// not shaped.
    pub fn shaped_until(&self, motor: Axis) -> Option<(f64, bool)> {
        let shaped = self.sources.shaped(motor)?;
        if !self.is_crossed(motor) {
            return Some((shaped.taken_s(), shaped.is_over()));
        }
        let motor = motor as usize;
        Some((self.crossed.taken_s(motor), self.crossed.is_over(motor)))
    }

    /// The number of the first chunk that is still needed for the shaped motion of a motor.
    pub fn shaped_chunk(&self, motor: Axis) -> Option<u32> {
        if self.is_crossed(motor) { self.crossed_chunk() } else { self.chunk_of(motor) }
    }

    #[cold]
    fn crossed_chunk(&self) -> Option<u32> {
        self.chunk_of(Axis::X).min(self.chunk_of(Axis::Y))
    }

    fn chunk_of(&self, axis: Axis) -> Option<u32> {
        self.sources.shaped(axis).map(ShapedAxis::chunk)
    }

    /// The next motion of a motor in a shaped run; `None` if that is not known yet, or if it is over. Its top speed is `top_steps_s`.
    pub fn shaped_phase(&mut self, motor: Axis, top_steps_s: f64) -> Option<CountedPhase> {
        if self.is_crossed(motor) {
            return self.crossed_phase(motor);
        }
        let Self { known, first, shaping, sources, is_closed, .. } = self;
        let chunk = |number: u32| known.get(number.wrapping_sub(*first) as usize);
        let impulses = &shaping.as_ref()?.impulses[motor as usize];
        let source = Kinematics::Cartesian.shaped(motor);
        sources.shaped_mut(motor)?.next_phase(&ShapedFrom {
            source,
            impulses,
            top_steps_s,
            chunk,
            is_closed: *is_closed,
        })
    }

    #[cold]
    fn crossed_phase(&mut self, motor: Axis) -> Option<CountedPhase> {
        let Self { known, first, shaping, sources, is_closed, kinematics, crossed, .. } = self;
        let shaping = shaping.as_ref()?;
        crossed.next_phase(motor as usize, |index| {
            let (axis, chunk) = (Axis::ALL[index], |number: u32| known.get(number.wrapping_sub(*first) as usize));
            let (source, impulses) = (shaped_of(*kinematics, axis), &shaping.impulses[index]);
            let from = ShapedFrom { source, impulses, top_steps_s: 0.0, chunk, is_closed: *is_closed };
            sources.shaped_mut(axis).map_or(NextPart::Unknown, |shaped| shaped.next_part(&from))
        })
    }

    /// True if two motors take their motion in turns: each waits until the other has taken its own.
    pub fn take_turns(&self) -> bool {
        self.shaping.is_some() && self.is_crossed(Axis::X)
    }

    fn is_crossed(&self, motor: Axis) -> bool {
        self.kinematics == Kinematics::CoreXy && motor <= Axis::Y
    }

    /// The first chunk that is still kept.
    pub fn oldest(&self) -> Option<&Chunk> {
        self.known.front()
    }

    /// The chunk that was under way at the last call of [`newly_under_way`](Self::newly_under_way).
    pub fn under_way(&self) -> Option<&Chunk> {
        self.get(self.under_way?)
    }

    pub fn last(&self) -> Option<&Chunk> {
        self.known.back()
    }

    /// True if another chunk follows the one with this number.
    pub fn has_next(&self, number: u32) -> bool {
        number.wrapping_sub(self.first) + 1 < self.known.len() as u32
    }

    pub fn has_room(&self) -> bool {
        !self.known.is_full()
    }

    /// Adds a chunk, for which there is room. A continuation extends the last chunk.
    pub fn push(&mut self, chunk: &Chunk) {
        if chunk.kind == ChunkKind::Continuation
            && let Some(last) = self.known.back_mut()
        {
            (last.until_steps, last.until_s) = (chunk.until_steps, chunk.until_s);
        } else if self.has_room() {
            // It is copied once if there is room for certain.
            let _ = self.known.push_back(*chunk);
        }
    }

    /// No chunk follows any more: the run ends with the last one.
    pub fn close(&mut self) {
        self.is_closed = true;
    }

    pub fn is_closed(&self) -> bool {
        self.is_closed
    }

    /// The instant at which the last chunk ends, s from the start of the run.
    pub fn end_s(&self) -> f64 {
        self.last().map_or(0.0, |chunk| chunk.until_s)
    }

    /// The chunk that is under way at `t_s`, or the last one if all have ended.
    pub fn under_way_at(&self, t_s: f64) -> Option<&Chunk> {
        self.known.iter().find(|chunk| chunk.until_s > t_s).or(self.known.back())
    }

    /// The chunk that is under way at `now_s`, if it is not the same as at the last call.
    pub fn newly_under_way(&mut self, now_s: f64) -> Option<&Chunk> {
        let mut number = self.under_way.map_or(self.first, |number| number.max(self.first));
        while self.has_next(number) && self.get(number).is_some_and(|chunk| chunk.until_s <= now_s) {
            number += 1;
        }
        if self.under_way == Some(number) {
            return None;
        }
        self.under_way = self.get(number).map(|_| number);
        self.get(number)
    }

    /// Forgets the chunks before number `oldest` that have ended by `now_s`, or take up too much room.
    pub fn forget(&mut self, oldest: u32, now_s: f64) {
        while self.first < oldest
            && self.known.front().is_some_and(|chunk| {
                chunk.until_s < now_s || (oldest - self.first) as usize > CHUNKS - CHUNKS_TO_STREAM
            })
        {
            let _ = self.known.pop_front();
            self.first += 1;
        }
    }
}

/// What is shaped with crossed belts. That it is cold leads a closure that calls it to flash.
#[cold]
#[inline(never)]
fn shaped_of(kinematics: Kinematics, axis: Axis) -> Combination {
    kinematics.shaped(axis)
}

#[cfg(test)]
mod tests {
    use isostep_profile::chain::Plan;
    use isostep_profile::{IntervalSplit, Limits, SpeedProfile, SyncMove};

    use super::*;
    use crate::axes::AXES;
    use crate::tag::Tag;

    /// Chunks that end one second after the other, as many as there is room for.
    fn full() -> Chunks {
        let limits = Limits {
            start_speed_steps_s: 0.0,
            top_speed_steps_s: 1_000.0,
            accel_steps_s2: 1_000.0,
            decel_steps_s2: 1_000.0,
            jerk_steps_s3: f64::INFINITY,
        };
        let plan = SyncMove::plan([100, 0, 0], &[limits; AXES], IntervalSplit::Fastest, SpeedProfile::Trapezoid, None)
            .expect("a plan");
        let plan = Plan::Line(plan);
        let mut chunks = Chunks::new();
        while chunks.has_room() {
            let until_s = chunks.end_s() + 1.0;
            let kind = ChunkKind::Move;
            chunks.push(&Chunk {
                plan,
                until_steps: 0.0,
                until_s,
                mm_per_step: 1.0,
                asked_steps_s: 1.0,
                tag: Tag::NONE,
                kind,
            });
        }
        chunks
    }

    /// A chunk is kept while an axis needs it and until it is over, as long as enough places are left.
    #[test]
    fn room_is_kept_for_chunks_that_are_to_be_streamed() {
        let kept = |oldest, now_s| {
            let mut chunks = full();
            chunks.forget(oldest, now_s);
            (chunks.first, chunks.known.len())
        };
        let spare = (CHUNKS - CHUNKS_TO_STREAM) as u32;
        assert_eq!(kept(0, 100.0), (0, CHUNKS), "all are needed");
        assert_eq!(kept(spare, 0.5), (0, CHUNKS), "none is over, and enough places are left");
        assert_eq!(kept(spare, 2.5), (2, CHUNKS - 2), "two are over");
        assert_eq!(kept(40, 0.5), (40 - spare, CHUNKS - (40 - spare as usize)), "no place is left");
    }
}
