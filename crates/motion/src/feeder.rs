//! Feeds one axis's port with the steps of a part of a move, as far ahead as is of use.
//!
//! # Design
//! What a port has been given is made, come what may. So that a hold, or another speed, takes effect soon, a port is
//! given no more than [`AHEAD`] of motion, in pieces of [`PIECE`] at most: long segments are split, and a long wait for a
//! step is told as rests. That is far more than compiling ever lags behind.

use core::future::poll_fn;

use embassy_futures::yield_now;
use embassy_time::{Duration, Instant, Timer};
use isostep_profile::{Segment, Segments, SyncMove};

use crate::axes::{AXES, Axis};
use crate::machine::Machine;
use crate::port::Feed;

/// How much motion a port is given ahead of time, at least.
pub(crate) const AHEAD: Duration = Duration::from_millis(40);
/// A piece of motion lasts no longer, unless it is a single step.
const PIECE: Duration = Duration::from_millis(10);

/// How far an axis's port has been fed in a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fed {
    /// Steps, of the whole move.
    pub steps: u32,
    /// Until when, ticks from the start of the run.
    pub until_ticks: u64,
}

/// Feeds one axis with its steps of one part of a move.
pub(crate) struct Feeder<'a> {
    machine: &'a Machine,
    axis: Axis,
    tick_hz: u32,
    segments: Segments<'a>,
    /// Compiled and not given yet.
    hand: Option<Segment>,
    fed: Fed,
    /// The last step to give.
    end: u32,
    /// While others go on the port rests up to this, or a little before, ticks.
    rest_until_ticks: u64,
    /// The last step of the whole move: with it the port's run ends.
    last: u32,
}

impl<'a> Feeder<'a> {
    /// `fed` is how far the axis has come.
    pub fn new(machine: &'a Machine, axis: Axis, part: &'a SyncMove<AXES>, fed: Fed) -> Self {
        let (index, tick_hz) = (axis as usize, machine.tick_hz(axis));
        let (segments, last) = (part.segments(index, tick_hz), part.steps[index].unsigned_abs());
        Self { machine, axis, tick_hz, segments, hand: None, fed, end: last, rest_until_ticks: 0, last }
    }

    pub fn fed(&self) -> Fed {
        self.fed
    }

    /// Ends with the step `end`, if that is not behind it, and rests until `until_s` from the start of the run.
    pub fn end_with(&mut self, end: u32, until_s: f64) {
        self.end = end.max(self.fed.steps);
        self.rest_until_ticks = (until_s * f64::from(self.tick_hz)) as u64;
    }

    /// Compiles and gives as much as the queue takes, until the port is fed for `time`. Before the run starts.
    pub fn prepare(&mut self, time: Duration) {
        let until_ticks = self.ticks(time);
        let queue = &self.machine.link(self.axis).segments;
        while self.fed.until_ticks < until_ticks && !queue.is_full() {
            let Some(feed) = self.next() else { return };
            self.give(feed);
        }
    }

    /// Gives all there is to give of a run that began at `start`, each piece in its time. One a poll: the axes take turns, and so do the other tasks of
    /// this priority.
    ///
    /// # Cancellation
    /// Safe: what has not been given is still to be given.
    pub async fn feed(&mut self, start: Instant) {
        while self.has_more() {
            let fed_until = start + Duration::from_micros(self.fed_until_us());
            Timer::at(fed_until.checked_sub(AHEAD).unwrap_or(Instant::MIN)).await;
            let queue = &self.machine.link(self.axis).segments;
            poll_fn(|context| queue.poll_ready_to_send(context)).await;
            let Some(feed) = self.next() else { return };
            self.give(feed);
            yield_now().await;
        }
    }

    /// Until when its port has been fed, from the start of the run, us.
    pub fn fed_until_us(&self) -> u64 {
        self.fed.until_ticks * 1_000_000 / u64::from(self.tick_hz)
    }

    fn ticks(&self, time: Duration) -> u64 {
        time.as_micros() * u64::from(self.tick_hz) / 1_000_000
    }

    fn has_more(&self) -> bool {
        self.fed.steps < self.end || self.fed.steps < self.last && self.is_long_before(self.rest_until_ticks)
    }

    /// Whether the port has to rest before then.
    fn is_long_before(&self, ticks: u64) -> bool {
        ticks > self.fed.until_ticks + 2 * self.ticks(PIECE)
    }

    /// What to give next, if there is any.
    fn next(&mut self) -> Option<Feed> {
        if !self.has_more() {
            return None;
        }
        let piece_ticks = self.ticks(PIECE);
        let rest = Some(Feed::Rest { until_ticks: self.fed.until_ticks + piece_ticks });
        let left = self.end - self.fed.steps;
        if left == 0 {
            return rest;
        }
        let segment = self.hand.take().or_else(|| self.segments.next())?;
        if self.is_long_before(segment.first_ticks()) {
            self.hand = Some(segment);
            return rest;
        }
        let lasts_ticks = segment.last_ticks() - segment.first_ticks();
        let fitting = if lasts_ticks > piece_ticks {
            // Less than the steps there are; what a ramp makes of it need not be exact.
            ((u64::from(segment.steps()) * piece_ticks / lasts_ticks) as u32).max(1)
        } else {
            segment.steps()
        };
        let steps = fitting.min(left);
        let piece = if steps < segment.steps() {
            let (piece, others) = segment.split(steps);
            self.hand = Some(others);
            piece
        } else {
            segment
        };
        Some(Feed::Steps(piece))
    }

    /// There is room, and this task is the only sender.
    fn give(&mut self, feed: Feed) {
        match feed {
            Feed::Steps(segment) => {
                self.fed.steps += segment.steps();
                self.fed.until_ticks = segment.last_ticks();
            }
            Feed::Rest { until_ticks } => self.fed.until_ticks = until_ticks,
            Feed::End => {}
        }
        let _ = self.machine.link(self.axis).segments.try_send(feed);
    }
}
