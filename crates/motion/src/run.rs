//! A run: what all axes do from standstill to standstill, over any number of moves.
//!
//! # Design
//! The chain of moves knows the path ahead; a run makes it, on one clock. It has the chain tell as much as the ports are to
//! have, as chunks, and streams the steps of the axes. Meanwhile it takes moves as they come, and what is asked for: a
//! hold, other overrides. They count from what has been told on: nothing that was given is taken back.
//!
//! The run ends where the chain comes to rest and no move has come in time to go on. After a hold what is left of the chain
//! is another run.
//!
//! A run starts when every port is armed and the last run's plan is over, whichever comes later. So the last half step of
//! a plan, in which no edge falls, is not cut off, and the next run gets ready in it.

use core::convert::Infallible;
use core::future::poll_fn;
use core::pin::pin;
use core::task::Poll;

use embassy_futures::select::{Either, select};
use embassy_futures::yield_now;
use embassy_time::{Duration, Instant, Timer, with_timeout};
use embedded_hal::digital::OutputPin;
use isostep_profile::chain::{Chunk, ChunkKind};

use crate::axes::{AXES, Axis};
use crate::coordinator::{Coordinator, all_armed, all_done, begun};
use crate::event::{Event, Finish};
use crate::flow::Purpose;
use crate::machine::CurrentChunk;
use crate::port::Run;
use crate::stream::{AHEAD, PIECE, SegmentStream, fill_queues};
use crate::tool::BeamStream;

/// Motion compiled per axis before a run starts, as far as there is room: near standstill compiling is slowest against
/// moving, by curved laws many times slower than by the trapezoid.
const COMPILED_BEFORE_START: Duration = Duration::from_millis(10);
const COMPILED_BEFORE_CURVED_START: Duration = Duration::from_millis(20);

/// So much is told ahead of the ports at a time: as long as a change may have to wait for more.
const TOLD: Duration = Duration::from_millis(15);

/// So much is known ahead while probing: what is given is made, and bends the probe. Nothing else is planned meanwhile.
const PROBED_AHEAD: Duration = Duration::from_millis(10);
const PROBED_TOLD: Duration = Duration::from_millis(5);

/// More is looked for so often while little is known, unless a move wakes; and while the queues are full: a port takes longer
/// to empty one.
const LOOK_AGAIN: Duration = Duration::from_millis(1);

/// So often while enough is known: moves that come meanwhile are taken together.
const GATHER: Duration = Duration::from_millis(4);

/// As many moves are taken at once: planning more would take too long beside a port that is to be progress.
const TAKEN_AT_ONCE: usize = 8;

/// While a port has less than that to go on with, filling its queue comes before all else in thread mode.
const LOW: Duration = Duration::from_millis(15);

/// The streams of all axes.
type Streams<'a> = [SegmentStream<'a>; AXES];

impl<E, F> Coordinator<'_, E, F>
where
    E: OutputPin<Error = Infallible>,
    F: FnMut(Event),
{
    /// Makes the moves of the chain, and those that come in time, up to where it comes to rest, or is held, or stopped.
    pub(crate) async fn run(&mut self, purpose: Purpose) -> Finish {
        self.energise(true);
        let machine = self.machine;
        let origin_steps = machine.position_steps();
        self.chunks.clear();
        for axis in Axis::ALL {
            machine.ready(axis);
        }
        let mut streams = Axis::ALL.map(|axis| SegmentStream::new(machine, axis));
        self.prepare(&mut streams).await;
        if machine.cause().is_some() {
            // Stopped before it started. A stop after this check finds its halt signal standing.
            return self.end_run(Finish::Stopped);
        }
        let wiring = machine.config().wiring;
        for axis in Axis::ALL {
            machine.link(axis).run.signal(Run { wiring: wiring[axis as usize] });
        }
        let mut done = pin!(all_done(machine));
        // It comes first: a short run may have ended before this task gets to know of its start.
        let start = match select(self.start(&mut streams), done.as_mut()).await {
            Either::First(start) => start,
            Either::Second(finish) => return self.end_run(finish),
        };
        self.tell(Event::Run { start, origin_steps });
        for number in 0.. {
            let Some(chunk) = self.chunks.get(number).copied() else { break };
            self.tell_chunk(&chunk);
        }
        let finish = match select(done, self.keep_going(start, purpose, &mut streams)).await {
            Either::First(finish) => finish,
            Either::Second(never) => match never {},
        };
        if purpose == Purpose::Probe {
            // It may have come with the last step.
            self.note_contact(start);
        }
        if finish == Finish::Done {
            self.standstill = instant(start, self.chunks.end_s());
        }
        // It stands still only some time after its last step.
        let is_held = self.chain.is_held();
        let finish = match finish {
            Finish::Done if is_held && machine.is_stopped_before(self.standstill).await => Finish::Stopped,
            Finish::Done if is_held => Finish::Held,
            _ => finish,
        };
        self.end_run(finish)
    }

    /// Starts the axes, which have been told of their run, once all are armed and it is time: the instant that their
    /// segments count from. Until then it gets them as ready as they can be.
    async fn start(&mut self, streams: &mut Streams<'_>) -> Instant {
        let machine = self.machine;
        all_armed(machine).await;
        // Arming has taken the first segments off the queues.
        self.prepare(streams).await;
        Timer::at(self.standstill).await;
        machine.let_go();
        begun(machine).await
    }

    /// Compiles what the run begins with.
    async fn prepare(&mut self, streams: &mut Streams<'_>) {
        let time = if self.is_curved { COMPILED_BEFORE_CURVED_START } else { COMPILED_BEFORE_START };
        while let Some(chunk) = self.next_chunk(seconds(time), TOLD) {
            self.chunks.push(chunk);
        }
        for stream in streams {
            stream.prepare(self.chunks, time);
            yield_now().await;
        }
    }

    /// Takes what comes, and gives what the ports want, each piece in its time, for as long as the run lasts.
    ///
    /// # Cancellation
    /// Safe: the axes go on to the end of what they have been given.
    async fn keep_going(&mut self, start: Instant, purpose: Purpose, streams: &mut Streams<'_>) -> Infallible {
        let mut beam = BeamStream::new(self.machine, start);
        loop {
            self.obey(purpose, start);
            let passed = Instant::now().saturating_duration_since(start);
            let enough = passed + ahead(purpose);
            let is_due = self.is_short_of(enough);
            if is_due || self.machine.is_crowded() {
                // First: without another move the run would end with what is known.
                self.take_some(purpose);
            }
            if is_due {
                self.tell_until(enough, purpose);
            }
            if let Some(beam) = &mut beam {
                beam.fill_queue(self.chunks, seconds(enough));
            }
            let progress = fill_queues(streams, self.chunks, enough);
            let is_low = streams.iter().any(|stream| stream.is_low(passed + LOW));
            if progress.has_queued && is_low {
                // What is known comes first: were it queued too late, the ports would run dry.
                continue;
            }
            let oldest_chunk =
                streams.iter().map(SegmentStream::chunk).chain(beam.iter().map(BeamStream::chunk)).min().unwrap_or(0);
            self.follow(start, passed, oldest_chunk);
            if is_due && !self.is_short_of(enough) || progress.has_worked {
                yield_now().await;
            } else {
                self.wait(streams, is_low, enough).await;
            }
        }
    }

    /// Whether more of the path is to be told for what is to be known until `enough` from the start of the run. Some is
    /// gathered, so that moves which come one by one are planned together.
    fn is_short_of(&self, enough: Duration) -> bool {
        !self.chunks.is_closed() && self.chunks.end_s() <= seconds(enough - GATHER)
    }

    /// Takes the moves that wait, some at a time: planning them takes long, and what is known must be queued meanwhile.
    fn take_some(&mut self, purpose: Purpose) {
        for _ in 0..TAKEN_AT_ONCE {
            if !self.take_next(purpose) {
                break;
            }
        }
    }

    /// Has the chain tell of its path until then, as far as there is room for it, and tells of that.
    fn tell_until(&mut self, until: Duration, purpose: Purpose) {
        let told = if purpose == Purpose::Probe { PROBED_TOLD } else { TOLD };
        while let Some(chunk) = self.next_chunk(seconds(until), told) {
            self.tell_chunk(&chunk);
            self.chunks.push(chunk);
        }
    }

    /// What the chain tells of its path, if what is known ends before `until_s` and there is room for more.
    fn next_chunk(&mut self, until_s: f64, told: Duration) -> Option<Chunk<AXES>> {
        if self.chunks.is_closed() || !self.chunks.has_room() || self.chunks.end_s() > until_s {
            return None;
        }
        // Of a curved law compiling is slow near standstill: what follows is got ready before it starts.
        let is_over = self.is_curved && self.chunks.last().is_some() && self.chain.is_at_rest();
        let chunk = if is_over { None } else { self.chain.advance(seconds(told)) };
        if chunk.is_none() {
            self.chunks.close();
        }
        chunk
    }

    fn tell_chunk(&mut self, chunk: &Chunk<AXES>) {
        let plan = chunk.plan;
        match chunk.kind {
            ChunkKind::Move => self.tell(Event::Move { plan }),
            ChunkKind::Replan => self.tell(Event::Replan { plan }),
            ChunkKind::Continuation => {}
        }
    }

    /// Passes on to the chain what has been asked for.
    fn obey(&mut self, purpose: Purpose, start: Instant) {
        // While it is held, too: what tells of the place is forgotten when it is over.
        let is_found = purpose == Purpose::Probe && self.note_contact(start);
        if purpose == Purpose::Homing || self.chain.is_held() {
            return;
        }
        if is_found || self.machine.is_to_brake() {
            self.chain.hold();
        } else if self.is_overridden(purpose) {
            self.override_chain(purpose);
        }
    }

    /// Says what is under way, and forgets what is over.
    fn follow(&mut self, start: Instant, passed: Duration, oldest_chunk: u32) {
        self.chunks.forget(oldest_chunk, seconds(passed));
        if let Some(chunk) = self.chunks.newly_under_way(seconds(passed)) {
            self.machine.set_current(Some(CurrentChunk { start, chunk: *chunk }));
        }
    }

    /// Waits for something to do.
    async fn wait(&self, streams: &Streams<'_>, is_low: bool, enough: Duration) {
        let machine = self.machine;
        let is_short = self.is_short_of(enough);
        let is_full = streams.iter().any(|stream| stream.is_short() && stream.queue().is_full());
        let look_again = if is_short || is_low || is_full { LOOK_AGAIN } else { GATHER };
        let takes = is_short && self.takes();
        let has_motion = poll_fn(|context| if takes { machine.poll_motion(context) } else { Poll::Pending });
        // Not at an instant reckoned from a step's: it would be another step's, again and again.
        let _ = with_timeout(look_again, select(has_motion, machine.wait_asked())).await;
    }

    fn end_run(&mut self, finish: Finish) -> Finish {
        self.machine.set_current(None);
        let position_steps = self.machine.position_steps();
        let (held_at_steps, plan_s) = self.chunks.last().map_or((0.0, 0.0), |chunk| (chunk.until_steps, chunk.until_s));
        self.tell(Event::RunEnd { finish, held_at_steps, plan_s, position_steps });
        finish
    }
}

/// How much is to be known ahead of the ports.
fn ahead(purpose: Purpose) -> Duration {
    if purpose == Purpose::Probe { PROBED_AHEAD } else { AHEAD + PIECE }
}

fn seconds(time: Duration) -> f64 {
    time.as_micros() as f64 * 1e-6
}

/// `t_s` from the start of a run, to the next whole microsecond.
fn instant(start: Instant, t_s: f64) -> Instant {
    start + Duration::from_micros(libm::ceil(t_s * 1e6) as u64)
}
