//! What the axes of a leg have in common when they are compiled, for the legs that are being compiled.

use isostep_profile::Course;
use isostep_profile::chain::Leg;

use crate::axes::AXES;

/// The courses of the last legs that were asked for: as many as there are axes, each of which is fed with one leg at a time.
pub(crate) struct Courses {
    places: [Place; AXES],
}

struct Place {
    /// The number of the leg, and the rate.
    key: Option<(u32, u32)>,
    course: Course,
}

impl Courses {
    pub const fn new() -> Self {
        Self { places: [const { Place { key: None, course: Course::empty() } }; AXES] }
    }

    /// Of another run.
    pub fn clear(&mut self) {
        self.places.iter_mut().for_each(|place| place.key = None);
    }

    /// That of `leg`, whose number is `number`, at `tick_hz`.
    pub fn of(&mut self, number: u32, leg: &Leg<AXES>, tick_hz: u32) -> &mut Course {
        let key = Some((number, tick_hz));
        let known = self.places.iter().position(|place| place.key == key);
        let index = known.unwrap_or_else(|| {
            // An empty place, or else that of the earliest leg.
            let oldest = (0..AXES).min_by_key(|index| self.places[*index].key).unwrap_or(0);
            let place = &mut self.places[oldest];
            leg.part.lay(&mut place.course, tick_hz);
            place.key = key;
            oldest
        });
        &mut self.places[index].course
    }
}
