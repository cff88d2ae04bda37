//! Feeds one axis's port with the steps of a run, as far ahead as is of use.
//!
//! # Design
//! What a port has been given is made, come what may. So that a hold, or another speed, takes effect soon, a port is
//! given [`AHEAD`] of motion and little more, in pieces of [`PIECE`] at most: long segments are split, and a long wait for
//! a step is told as rests.
//!
//! Of a curved ramp near standstill a segment takes longer to compile than it lasts. So while no port wants anything, what
//! comes next is compiled and kept in [`HAND`]: in a cruise most of the ramp at its end. That may still be changed.

use core::cell::Cell;
use core::future::poll_fn;
use core::mem;
use core::task::Poll;

use embassy_futures::yield_now;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Instant, with_timeout};
use heapless::Deque;
use isostep_profile::{Segment, Segments};

use crate::axes::{AXES, Axis};
use crate::legs::{Fed, Leg};
use crate::machine::Machine;
use crate::port::{Direction, Feed, SegmentQueue};

/// How much motion a port is given ahead of time, at least.
pub(crate) const AHEAD: Duration = Duration::from_millis(30);
/// A piece of motion lasts no longer, unless it is a single step. So often it is looked whether there is enough.
const PIECE: Duration = Duration::from_millis(15);
/// Feeding goes on so long at a time, unless a piece takes longer. Waking up takes as long as to compile several pieces of a
/// trapezoid's.
const TURN: Duration = Duration::from_micros(500);
/// Segments that are compiled before a port wants them.
const HAND: usize = 32;

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
    /// The last step that has been compiled of it.
    compiled: u32,
    /// Compiled of it and not given yet.
    hand: Deque<Segment, HAND>,
    fed: &'a Cell<Fed>,
    /// Until when that is, ticks from the start of the run.
    fed_ticks: u64,
    /// The end has been given, after the last leg.
    has_ended: bool,
    /// All has been given.
    is_done: bool,
}

/// Tells whoever waits for it that an axis has been fed further.
pub(crate) type Progress = Signal<NoopRawMutex, ()>;

/// Gives all there is to give of a run that began at `start`, each piece in its time, to the axis first that has been fed
/// the least, and tells of its `progress`. The other tasks of this priority take their turns.
///
/// # Cancellation
/// Safe: what has not been given is still to be given; the axes go on to the end of what has been.
pub(crate) async fn feed(feeders: &mut [Feeder<'_>; AXES], legs: &[Leg], start: Instant, progress: &Progress) {
    while feeders.iter().any(|feeder| !feeder.is_done) {
        let now = Instant::now();
        let enough_us = (now + AHEAD + PIECE).saturating_duration_since(start).as_micros();
        let mut has_worked = false;
        while Instant::now() < now + TURN && work(feeders, legs, enough_us) {
            has_worked = true;
        }
        if has_worked {
            progress.signal(());
            yield_now().await;
            continue;
        }
        let has_room = poll_fn(|context| {
            let wanting = feeders.iter().filter(|feeder| feeder.is_wanting(enough_us));
            // Each is to wake this task.
            let rooms = wanting.filter(|feeder| feeder.queue().poll_ready_to_send(context).is_ready()).count();
            if rooms > 0 { Poll::Ready(()) } else { Poll::Pending }
        });
        // Not at an instant reckoned from a step's: it would be another step's, again and again.
        let _ = with_timeout(PIECE, has_room).await;
    }
}

/// Gives a piece to the axis that has been fed the least, of those that want one; or else compiles a segment ahead. False
/// if there is nothing to do.
fn work(feeders: &mut [Feeder<'_>; AXES], legs: &[Leg], enough_us: u64) -> bool {
    let wanting = feeders.iter_mut().filter(|feeder| feeder.is_wanting(enough_us) && !feeder.queue().is_full());
    if let Some(feeder) = wanting.min_by_key(|feeder| feeder.fed.get().until_us) {
        feeder.feed_one(legs);
        return true;
    }
    let able = feeders.iter_mut().filter(|feeder| feeder.can_compile());
    able.min_by_key(|feeder| feeder.hand.len()).map(Feeder::compile).is_some()
}

impl<'a> Feeder<'a> {
    /// `fed` is how far the axis has come, and is kept so.
    pub fn new(machine: &'a Machine, axis: Axis, fed: &'a Cell<Fed>) -> Self {
        let tick_hz = machine.tick_hz(axis);
        let piece_ticks = ticks(PIECE, tick_hz);
        let (begun, end, segments, hand) = (0, 0, None, Deque::new());
        let (compiled, fed_ticks, has_ended, is_done) = (0, 0, false, false);
        Self {
            machine,
            axis,
            tick_hz,
            piece_ticks,
            begun,
            end,
            segments,
            compiled,
            hand,
            fed,
            fed_ticks,
            has_ended,
            is_done,
        }
    }

    /// The leg with this index, to whose end it has not been fed, ends sooner, and others follow it. What has been
    /// compiled of it is kept: beginning anew in its midst takes long.
    pub fn cut(&mut self, legs: &[Leg], index: usize) {
        self.is_done = false;
        if self.begun > index + 1 {
            // It had looked ahead.
            (self.begun, self.end, self.segments) = (index, 0, None);
            self.hand.clear();
        } else if self.begun == index + 1 {
            self.end = legs[index].last_step(self.axis);
        }
    }

    /// The first `count` legs, to whose end it has been fed, are gone.
    pub fn forget(&mut self, count: usize) {
        self.begun = self.begun.saturating_sub(count);
    }

    /// Compiles as much of the first leg as there is room for, `time` at most, and gives what the queue takes. Before the run
    /// starts.
    pub fn prepare(&mut self, legs: &[Leg], time: Duration) {
        let until_ticks = ticks(time, self.tick_hz);
        while self.fed_ticks < until_ticks && !self.queue().is_full() {
            let Some(feed) = self.next(legs) else { return };
            self.give(feed);
        }
        while self.hand.back().map_or(self.fed_ticks, Segment::last_ticks) < until_ticks && self.can_compile() {
            self.compile();
        }
    }

    /// Compiles and gives one piece. There is room.
    fn feed_one(&mut self, legs: &[Leg]) {
        match self.next(legs) {
            Some(feed) => self.give(feed),
            None => self.is_done = true,
        }
    }

    /// Whether something of the leg under way is still to be compiled, and there is room for it.
    fn can_compile(&self) -> bool {
        self.segments.is_some() && self.compiled < self.end && !self.hand.is_full()
    }

    /// Compiles one segment ahead.
    fn compile(&mut self) {
        match self.next_compiled() {
            // There is room.
            Some(segment) => _ = self.hand.push_back(segment),
            None => self.segments = None,
        }
    }

    /// The segment after all that has been compiled of the leg under way.
    fn next_compiled(&mut self) -> Option<Segment> {
        let segment = self.segments.as_mut()?.next()?;
        self.compiled += segment.steps();
        Some(segment)
    }

    /// Whether it is to be fed now: it has not been fed until `enough_us` from the start of the run.
    fn is_wanting(&self, enough_us: u64) -> bool {
        !self.is_done && self.fed.get().until_us <= enough_us
    }

    fn queue(&self) -> &'a SegmentQueue {
        &self.machine.link(self.axis).segments
    }

    /// What to give next, if there is any.
    fn next(&mut self, legs: &[Leg]) -> Option<Feed> {
        let Some(segment) = self.next_segment(legs) else {
            return (!mem::replace(&mut self.has_ended, true)).then_some(Feed::End);
        };
        // All legs are of one move.
        let direction = Direction::of(legs.first().map_or(0, |leg| leg.part.steps[self.axis as usize]));
        let (fed_ticks, piece_ticks) = (self.fed_ticks, self.piece_ticks);
        if segment.first_ticks() > fed_ticks + 2 * piece_ticks {
            let _ = self.hand.push_front(segment);
            return Some(Feed::Rest { until_ticks: fed_ticks + piece_ticks });
        }
        let lasts_ticks = segment.last_ticks() - segment.first_ticks();
        let fitting = if lasts_ticks > piece_ticks {
            // Less than the steps there are; what a ramp makes of it need not be exact.
            ((u64::from(segment.steps()) * piece_ticks / lasts_ticks) as u32).max(1)
        } else {
            segment.steps()
        };
        let steps = fitting.min(self.end - self.fed.get().steps);
        if steps == segment.steps() {
            return Some(Feed::Steps { segment, direction });
        }
        let (piece, others) = segment.split(steps);
        // There is room: the whole was taken from there, or came when there was nothing.
        let _ = self.hand.push_front(others);
        Some(Feed::Steps { segment: piece, direction })
    }

    /// The steps that follow those given, of the leg that they are in.
    fn next_segment(&mut self, legs: &[Leg]) -> Option<Segment> {
        let fed_steps = self.fed.get().steps;
        while fed_steps >= self.end {
            let leg = legs.get(self.begun)?;
            self.begun += 1;
            self.end = leg.last_step(self.axis);
            self.hand.clear();
            self.compiled = fed_steps;
            self.segments =
                (fed_steps < self.end).then(|| leg.part.segments_from(self.axis as usize, fed_steps + 1, self.tick_hz));
        }
        self.hand.pop_front().or_else(|| self.next_compiled())
    }

    /// There is room, and this task is the only sender.
    fn give(&mut self, feed: Feed) {
        let Fed { mut steps, .. } = self.fed.get();
        match feed {
            Feed::Steps { segment, .. } => {
                steps += segment.steps();
                self.fed_ticks = segment.last_ticks();
            }
            Feed::Rest { until_ticks } => self.fed_ticks = until_ticks,
            Feed::End => {}
        }
        self.fed.set(Fed { steps, until_us: self.fed_ticks * 1_000_000 / u64::from(self.tick_hz) });
        let _ = self.queue().try_send(feed);
    }
}

fn ticks(time: Duration, tick_hz: u32) -> u64 {
    time.as_micros() * u64::from(tick_hz) / 1_000_000
}
