//! Strokes: for how long a laser shines, and how strongly.

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::Instant;

use super::power::Asked;

/// The power of a laser for some time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stroke {
    pub begin: Instant,
    pub end: Instant,
    pub asked: Asked,
}

/// Strokes queued: enough for 30 ms of a thousand short moves a second, each of which may have two.
const QUEUE_STROKES: usize = 64;

/// The queue of a laser's strokes for the tool's task.
pub(crate) type StrokeQueue = Channel<CriticalSectionRawMutex, Stroke, QUEUE_STROKES>;

impl Stroke {
    /// True if what it asks for lasts until then, by what is queued behind it. A chunk may end soon after a line has
    /// begun; then the next stroke goes on with the same.
    pub fn lasts_until(&self, least: Instant, queue: &StrokeQueue) -> bool {
        let goes_on = |next: Self| next.begin == self.end && next.asked == self.asked && next.end >= least;
        self.end >= least || self.asked.is_even() && queue.try_peek().is_ok_and(goes_on)
    }

    /// The request from one instant to another.
    pub fn asked_in(&self, between: [Instant; 2]) -> Asked {
        let passed_us = |at: Instant| (at - self.begin).as_micros() as u32;
        self.asked.part(between.map(passed_us), passed_us(self.end))
    }
}
