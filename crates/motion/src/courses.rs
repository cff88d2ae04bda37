//! The courses of the chunks that are being compiled: what the axes of a plan have in common when compiled.

use isostep_profile::Course;
use isostep_profile::chain::Chunk;

use crate::axes::AXES;

/// The courses of the chunks that were asked for last. There is room for as many as there are axes, because each axis
/// streams one chunk at a time.
pub(crate) struct Courses {
    slots: [Slot; AXES],
}

struct Slot {
    /// The number of the chunk, and the tick rate, Hz.
    key: Option<(u32, u32)>,
    course: Course,
}

impl Courses {
    pub const fn new() -> Self {
        Self { slots: [const { Slot { key: None, course: Course::empty() } }; AXES] }
    }

    /// Forgets all courses, for another run.
    pub fn clear(&mut self) {
        self.slots.iter_mut().for_each(|slot| slot.key = None);
    }

    /// The course of `chunk`, whose number is `number`, at `tick_hz`.
    pub fn of(&mut self, number: u32, chunk: &Chunk<AXES>, tick_hz: u32) -> &mut Course {
        let key = Some((number, tick_hz));
        let known = self.slots.iter().position(|slot| slot.key == key);
        let index = known.unwrap_or_else(|| {
            // An empty slot if there is one; otherwise the slot of the earliest chunk.
            let oldest = (0..AXES).min_by_key(|index| self.slots[*index].key).unwrap_or(0);
            let slot = &mut self.slots[oldest];
            chunk.plan.lay(&mut slot.course, tick_hz);
            slot.key = key;
            oldest
        });
        &mut self.slots[index].course
    }
}
