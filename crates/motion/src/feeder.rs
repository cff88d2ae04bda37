//! Feeds one axis's port with the steps of a run, as far ahead as is of use.
//!
//! # Design
//! What a port has been given is made, come what may. So that a hold, or another speed, takes effect soon, a port is
//! given [`AHEAD`] of motion and little more, in pieces of [`PIECE`] at most: long segments are split, and a long wait for
//! a step is told as rests. That is far more than compiling ever lags behind.

use core::cell::Cell;
use core::future::poll_fn;

use embassy_futures::yield_now;
use embassy_time::{Duration, Instant, Timer};
use isostep_profile::{Segment, Segments, SyncMove};

use crate::axes::{AXES, Axis};
use crate::machine::Machine;
use crate::port::Feed;

/// How much motion a port is given ahead of time, at least.
const AHEAD: Duration = Duration::from_millis(30);
/// A piece of motion lasts no longer, unless it is a single step. So often it is looked whether there is enough.
const PIECE: Duration = Duration::from_millis(15);

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
    /// Until when, ticks from the start of the run.
    pub until_ticks: u64,
}

impl Fed {
    /// Until when, us from the start of the run, of a port with `tick_hz`.
    pub fn until_us(self, tick_hz: u32) -> u64 {
        self.until_ticks * 1_000_000 / u64::from(tick_hz)
    }
}

/// Feeds one axis with its steps of all legs of a run, through whatever changes there are.
pub(crate) struct Feeder<'a> {
    machine: &'a Machine,
    axis: Axis,
    tick_hz: u32,
    piece_ticks: u64,
    /// Legs of the run's that have been begun: the last of them is under way.
    begun: usize,
    /// Of that; the last step to give, and what is compiled of it.
    end: u32,
    segments: Option<Segments>,
    /// Compiled and not given yet.
    hand: Option<Segment>,
    fed: &'a Cell<Fed>,
    /// What to give after the last leg.
    ending: Option<Feed>,
}

impl<'a> Feeder<'a> {
    /// `fed` is how far the axis has come, and is kept so.
    pub fn new(machine: &'a Machine, axis: Axis, fed: &'a Cell<Fed>) -> Self {
        let tick_hz = machine.tick_hz(axis);
        let piece_ticks = ticks(PIECE, tick_hz);
        Self { machine, axis, tick_hz, piece_ticks, begun: 0, end: 0, segments: None, hand: None, fed, ending: None }
    }

    /// The leg with this index, to whose end it has not been fed, ends sooner, and others follow it. What has been
    /// compiled of it is kept: beginning anew in its midst takes long.
    pub fn cut(&mut self, legs: &[Leg], index: usize) {
        if self.begun > index + 1 {
            // It had looked ahead.
            (self.begun, self.end, self.segments, self.hand) = (index, 0, None, None);
        } else if self.begun == index + 1 {
            self.end = legs[index].last_step(self.axis);
        }
    }

    /// The first `count` legs, to whose end it has been fed, are gone.
    pub fn forget(&mut self, count: usize) {
        self.begun = self.begun.saturating_sub(count);
    }

    /// What to give after all legs.
    pub fn end_with(&mut self, ending: Option<Feed>) {
        self.ending = ending;
    }

    /// Compiles and gives as much as the queue takes, until the port is fed for `time`. Before the run starts.
    pub fn prepare(&mut self, legs: &[Leg], time: Duration) {
        let until_ticks = ticks(time, self.tick_hz);
        let queue = &self.machine.link(self.axis).segments;
        while self.fed.get().until_ticks < until_ticks && !queue.is_full() {
            let Some(feed) = self.next(legs) else { return };
            self.give(feed);
        }
    }

    /// Gives all there is to give of a run that began at `start`, each piece in its time. One a poll: the axes take turns,
    /// and so do the other tasks of this priority.
    ///
    /// # Cancellation
    /// Safe: what has not been given is still to be given; the axis goes on to the end of what has been.
    pub async fn feed(&mut self, legs: &[Leg], start: Instant) {
        loop {
            let fed_until = start + Duration::from_micros(self.fed.get().until_us(self.tick_hz));
            if fed_until > Instant::now() + AHEAD + PIECE {
                // Not at an instant reckoned from a step's: it would be another step's, again and again.
                Timer::after(PIECE).await;
                continue;
            }
            let queue = &self.machine.link(self.axis).segments;
            poll_fn(|context| queue.poll_ready_to_send(context)).await;
            let Some(feed) = self.next(legs) else { return };
            self.give(feed);
            yield_now().await;
        }
    }

    /// What to give next, if there is any.
    fn next(&mut self, legs: &[Leg]) -> Option<Feed> {
        let Some(segment) = self.next_segment(legs) else { return self.ending.take() };
        let (fed, piece_ticks) = (self.fed.get(), self.piece_ticks);
        if segment.first_ticks() > fed.until_ticks + 2 * piece_ticks {
            self.hand = Some(segment);
            return Some(Feed::Rest { until_ticks: fed.until_ticks + piece_ticks });
        }
        let lasts_ticks = segment.last_ticks() - segment.first_ticks();
        let fitting = if lasts_ticks > piece_ticks {
            // Less than the steps there are; what a ramp makes of it need not be exact.
            ((u64::from(segment.steps()) * piece_ticks / lasts_ticks) as u32).max(1)
        } else {
            segment.steps()
        };
        let steps = fitting.min(self.end - fed.steps);
        if steps == segment.steps() {
            return Some(Feed::Steps(segment));
        }
        let (piece, others) = segment.split(steps);
        self.hand = Some(others);
        Some(Feed::Steps(piece))
    }

    /// The steps that follow those given, of the leg that they are in.
    fn next_segment(&mut self, legs: &[Leg]) -> Option<Segment> {
        let fed_steps = self.fed.get().steps;
        while fed_steps >= self.end {
            let leg = legs.get(self.begun)?;
            self.begun += 1;
            self.end = leg.last_step(self.axis);
            self.hand = None;
            self.segments =
                (fed_steps < self.end).then(|| leg.part.segments_from(self.axis as usize, fed_steps + 1, self.tick_hz));
        }
        self.hand.take().or_else(|| self.segments.as_mut()?.next())
    }

    /// There is room, and this task is the only sender.
    fn give(&mut self, feed: Feed) {
        let Fed { steps, .. } = self.fed.get();
        match feed {
            Feed::Steps(segment) => {
                self.fed.set(Fed { steps: steps + segment.steps(), until_ticks: segment.last_ticks() });
            }
            Feed::Rest { until_ticks } => self.fed.set(Fed { steps, until_ticks }),
            Feed::End => {}
        }
        let _ = self.machine.link(self.axis).segments.try_send(feed);
    }
}

fn ticks(time: Duration, tick_hz: u32) -> u64 {
    time.as_micros() * u64::from(tick_hz) / 1_000_000
}
