//! What the axes of a run are compiled from, beside its chunks: timed plans, or shaped motion.

use isostep_profile::{SyncMove, TimedPlan};

use crate::axes::{AXES, Axis};
use crate::shaping::ShapedAxis;

/// A place for each axis. A run is shaped or not, so what shaped runs need and what others need share these.
///
/// In a shaped run an axis has its own. In another run they are the timed plans of the chunks that the axes compile, and there
/// are enough of them, because each axis compiles one chunk at a time. Axes that compile the same chunk share its timed plan.
pub(crate) struct Sources {
    slots: [Slot; AXES],
    /// The slot that each axis has used last.
    last: [usize; AXES],
}

struct Slot {
    /// The number of the chunk of the timed plan, and the tick rate, Hz.
    key: Option<(u32, u32)>,
    /// A bit for each axis that compiles this chunk.
    users: u8,
    source: Source,
}

// Without a niche, so that it begins as zeros, of which a chip needs no copy in flash.
#[repr(u8)]
#[expect(clippy::large_enum_variant, reason = "the largest one's size is what both share")]
enum Source {
    TimedPlan(TimedPlan),
    Shaped(ShapedAxis),
}

impl Slot {
    const EMPTY: Self = Self { key: None, users: 0, source: Source::TimedPlan(TimedPlan::empty()) };

    fn timed_plan(&mut self) -> Option<&mut TimedPlan> {
        match &mut self.source {
            Source::TimedPlan(timed_plan) => Some(timed_plan),
            Source::Shaped(_) => None,
        }
    }
}

impl Sources {
    pub const fn new() -> Self {
        Self { slots: [const { Slot::EMPTY }; AXES], last: [0; AXES] }
    }

    /// Forgets everything, for another run. Cold: it is needed once a run.
    #[cold]
    pub fn clear(&mut self, is_shaped: bool) {
        for slot in &mut self.slots {
            (slot.key, slot.users) = (None, 0);
            match &mut slot.source {
                Source::Shaped(shaped) if is_shaped => shaped.clear(),
                Source::TimedPlan(_) if !is_shaped => {}
                source if is_shaped => *source = Source::Shaped(ShapedAxis::new()),
                source => *source = Source::TimedPlan(TimedPlan::empty()),
            }
        }
    }

    /// The motion of an axis, if the run is shaped.
    pub fn shaped(&self, axis: Axis) -> Option<&ShapedAxis> {
        match &self.slots[axis as usize].source {
            Source::Shaped(shaped) => Some(shaped),
            Source::TimedPlan(_) => None,
        }
    }

    /// The same, to be read further.
    pub fn shaped_mut(&mut self, axis: Axis) -> Option<&mut ShapedAxis> {
        match &mut self.slots[axis as usize].source {
            Source::Shaped(shaped) => Some(shaped),
            Source::TimedPlan(_) => None,
        }
    }

    /// The timed plan with which `axis` has begun last; `None` if the run is shaped.
    pub fn begun(&mut self, axis: Axis) -> Option<&mut TimedPlan> {
        self.slots[self.last[axis as usize]].timed_plan()
    }

    /// The timed plan with which `axis` begins the line of the chunk with this number, at `tick_hz`; `None` if the run is
    /// shaped.
    pub fn begin(&mut self, axis: Axis, number: u32, line: &SyncMove<AXES>, tick_hz: u32) -> Option<&mut TimedPlan> {
        let (key, user) = (Some((number, tick_hz)), 1 << axis as u8);
        let known = self.slots.iter().position(|slot| slot.key == key);
        let index = known.unwrap_or_else(|| self.free(user));
        let slot = &mut self.slots[index];
        if slot.key != key {
            line.convert_to_ticks(slot.timed_plan()?, tick_hz);
            slot.key = key;
        }
        let last = core::mem::replace(&mut self.last[axis as usize], index);
        self.slots[last].users &= !user;
        self.slots[index].users |= user;
        self.slots[index].timed_plan()
    }

    /// The slot of the earliest chunk that no axis but `user` compiles. There is one, because each of the other axes
    /// compiles one chunk.
    fn free(&self, user: u8) -> usize {
        let free = (0..AXES).filter(|&index| self.slots[index].users & !user == 0);
        free.min_by_key(|&index| self.slots[index].key).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use isostep_profile::{IntervalSplit, Limits, SpeedProfile, SyncMove};

    use super::*;

    /// An axis that is ahead of the others does not take from them the timed plans that they still need.
    #[test]
    fn a_timed_plan_is_kept_while_an_axis_compiles_its_chunk() {
        let limits = Limits {
            start_speed_steps_s: 0.0,
            top_speed_steps_s: 1_000.0,
            accel_steps_s2: 1_000.0,
            decel_steps_s2: 1_000.0,
            jerk_steps_s3: f64::INFINITY,
        };
        let plan = SyncMove::plan([100, 0, 0], &[limits; AXES], IntervalSplit::Fastest, SpeedProfile::Trapezoid, None)
            .expect("a plan");
        let mut sources = Sources::new();
        let mut compiles = |axis, number| {
            sources.begin(axis, number, &plan, 1_000_000).expect("no shaped run");
            let mut kept: Vec<_> = sources.slots.iter().filter_map(|slot| slot.key).map(|(number, _)| number).collect();
            kept.sort_unstable();
            kept
        };
        assert_eq!(compiles(Axis::X, 0), [0]);
        assert_eq!(compiles(Axis::Y, 0), [0], "X and Y share it");
        for number in 1..8 {
            assert!(compiles(Axis::Z, number).contains(&0), "Z is ahead, at chunk {number}");
        }
        assert_eq!(compiles(Axis::X, 1), [0, 1, 7], "the place that nobody uses");
        assert_eq!(compiles(Axis::X, 2), [0, 2, 7], "Y is still at chunk 0");
        assert_eq!(compiles(Axis::Y, 2), [0, 2, 7], "already known");
        assert_eq!(compiles(Axis::Y, 3), [2, 3, 7]);
    }
}
