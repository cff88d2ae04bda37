//! A run: what all axes do from standstill to standstill, over any number of moves.
//!
//! # Design
//! The chain knows the path ahead; a run makes it, on one clock. The run has the chain hand out as much of the path as
//! the ports are to have, as chunks, and streams the steps of the axes. Meanwhile it takes moves as they arrive, and
//! obeys holds and overrides. These take effect where the last chunk ends: what has been handed out is not taken back.
//!
//! The run ends where the chain comes to rest, unless another move arrives in time. After a hold, another run makes
//! what is left of the chain.
//!
//! A run starts when every port is armed and the last run's plan is over, whichever comes later. So the last half step
//! of a plan, in which no edge falls, is not cut off. The next run gets ready during that half step.

use core::convert::Infallible;
use core::future::poll_fn;
use core::pin::pin;
use core::task::Poll;

use embassy_futures::select::{Either, select};
use embassy_futures::yield_now;
use embassy_time::{Duration, Instant, Timer, with_timeout};
use embedded_hal::digital::OutputPin;
use isostep_profile::chain::{ChunkKind, Plan};

use crate::axes::{AXES, Axis};
use crate::clock::{instant_after, instant_near, seconds};
use crate::coordinator::{Coordinator, Purpose, all_armed, all_done, begun};
use crate::event::{Event, Finish};
use crate::machine::{CHAIN_MOVES, CurrentChunk, Machine};
use crate::marks::Mark;
use crate::motor::SecondMotor;
use crate::port::{Motors, PortFault};
use crate::stream::{AHEAD, ITEM_MAX, SegmentStream, fill_queues};
use crate::tag::Chunk;
use crate::tool::BeamStream;

/// The time of motion that is compiled per axis before a run starts, as far as there is room. Near standstill compiling is
/// slowest compared with moving, and with curved speed profiles it is many times slower than with the trapezoid.
const COMPILED_BEFORE_START: Duration = Duration::from_millis(10);
const COMPILED_BEFORE_CURVED_START: Duration = Duration::from_millis(20);

/// The longest chunk that the chain hands out at a time, s. A change may have to wait for the end of such a chunk.
pub(crate) const CHUNK_S: f64 = 15e-3;

/// The time for which the path is known ahead while a contact is looked for. It is less than otherwise, because what has been handed
/// out is made after the contact, too, and bends the probe. It is enough, because nothing else is planned meanwhile.
const PROBED_AHEAD: Duration = Duration::from_millis(10);
/// The longest chunk while a contact is looked for, s.
pub(crate) const PROBED_CHUNK_S: f64 = 5e-3;
/// The time for which a motion goes on after a contact before it brakes, at most: what is handed out by then, and the time until the
/// contact is noticed.
pub(crate) const COMMITTED_AT_CONTACT: Duration = Duration::from_millis(16);

/// Longest wait before the run looks for more to do, while little is known (a new move ends this wait early), or while
/// a queue is full (a port takes longer than this to empty one).
const LOOK_AGAIN: Duration = Duration::from_millis(1);

/// Longest wait while enough is known. Moves that arrive meanwhile are taken together.
const GATHER: Duration = Duration::from_millis(4);
const GATHER_S: f64 = 4e-3;

/// The number of moves that are taken at once. To plan more would take too long while a port's queue has to be filled.
const TAKEN_AT_ONCE: usize = 8;

/// The number of moves that are taken while a port has little left, if so many are in the chain that there is no hurry to know
/// more.
const TAKEN_IN_HASTE: usize = 2;
const ENOUGH_MOVES: usize = CHAIN_MOVES / 2;

/// The number of chunks that are committed at once, for the same reason: between blends they are short, and many make up what is
/// to be known.
const COMMITTED_AT_ONCE: usize = 8;

/// While a port has less motion queued than this, filling its queue comes before everything else in thread mode.
const LOW: Duration = Duration::from_millis(15);

/// The streams of all axes.
type Streams<'a> = [SegmentStream<'a>; AXES];

impl<E, F> Coordinator<'_, E, F>
where
    E: OutputPin<Error = Infallible>,
    F: FnMut(Event),
{
    /// Makes the moves of the chain, and those that arrive in time, until the chain comes to rest, is held or is
    /// stopped.
    pub(crate) async fn run(&mut self, purpose: Purpose) -> Finish {
        self.energise(true);
        let machine = self.machine;
        let origin_steps = machine.motor_steps();
        self.clear_chunks(purpose);
        for axis in Axis::ALL {
            machine.ready(axis);
        }
        let mut streams = streams(machine, self.chunks.shaping().is_some());
        self.prepare(&mut streams).await;
        if machine.cause().is_some() {
            // The run was stopped before it started. If a stop comes after this check, the axis tasks find the halt
            // signal set.
            return self.end_run(Finish::Stopped);
        }
        self.hand_over(purpose);
        let mut done = pin!(all_done(machine));
        // The start is polled first: a short run may have ended before this task learns of its start.
        let start = match select(self.start(&mut streams), done.as_mut()).await {
            Either::First(Ok(start)) => start,
            Either::First(Err((axis, fault))) => {
                machine.fail(axis, fault);
                done.await;
                return self.end_run(Finish::Fault { axis, fault });
            }
            Either::Second(finish) => return self.end_run(finish),
        };
        self.report(Event::Run { start, origin_steps, shaping: self.chunks.shaping().copied() });
        for number in 0.. {
            let Some(chunk) = self.chunks.get(number).copied() else { break };
            self.report_chunk(&chunk);
        }
        let finish = match select(done, self.keep_going(start, purpose, &mut streams)).await {
            Either::First(finish) => finish,
            Either::Second(never) => match never {},
        };
        if purpose == Purpose::Probe {
            // The contact may have come with the last step.
            self.note_contact(start);
        }
        if finish == Finish::Done {
            self.standstill = instant_after(start, self.chunks.over_s());
        }
        // The machine stands still only when the plan is over, some time after the last step.
        let is_held = self.chain.is_held();
        let finish = match finish {
            Finish::Done if is_held && machine.is_stopped_before(self.standstill).await => Finish::Stopped,
            Finish::Done if is_held => Finish::Held,
            _ => finish,
        };
        self.end_run(finish)
    }

    /// Forgets the chunks of the run before.
    #[cold]
    fn clear_chunks(&mut self, purpose: Purpose) {
        let config = self.machine.config();
        let shaping = purpose.shaping(&config);
        self.chunks.clear(shaping, &config.of_motors());
    }

    /// Gives the axes their run.
    // The compiler takes a function for cold that calls a cold one, and this has critical sections.
    #[inline(always)]
    fn hand_over(&self, purpose: Purpose) {
        for (axis, motors) in Axis::ALL.into_iter().zip(self.told(purpose)) {
            self.machine.link(axis).run.signal(motors);
        }
    }

    /// What the axes are told of a run.
    #[cold]
    fn told(&self, purpose: Purpose) -> [Motors; AXES] {
        let config = self.machine.config().of_motors();
        let held = if let Purpose::Homing { held } = purpose { held } else { None };
        Axis::ALL.map(|axis| {
            let second = config
                .squared_axis(axis)
                .map(|squared| SecondMotor { direction_inverted: squared.direction_inverted, held });
            let (wiring, limits) = (config.wiring[axis as usize], config.limits[axis as usize]);
            Motors { wiring, top_speed_steps_s: libm::ceil(limits.top_speed_steps_s) as u32, second }
        })
    }

    /// Starts the axes, which already have their run, once all are armed and the plan of the run before is over. Until
    /// then it compiles as much as it can. Returns the instant from which their segments count.
    ///
    /// # Errors
    /// An axis that started at another instant than the first.
    async fn start(&mut self, streams: &mut Streams<'_>) -> Result<Instant, (Axis, PortFault)> {
        let machine = self.machine;
        all_armed(machine).await;
        // Arming has taken the first segments off the queues, so there is room for more.
        self.prepare(streams).await;
        Timer::at(self.standstill).await;
        machine.let_go();
        begun(machine).await
    }

    /// Compiles the beginning of the run.
    async fn prepare(&mut self, streams: &mut Streams<'_>) {
        let time = if self.is_curved { COMPILED_BEFORE_CURVED_START } else { COMPILED_BEFORE_START };
        let time_s = seconds(time);
        while let Some(chunk) = &self.next_chunk(time_s) {
            self.chunks.push(chunk);
        }
        loop {
            let mut has_worked = false;
            for stream in streams.iter_mut() {
                has_worked |= stream.prepare(self.chunks, time);
                yield_now().await;
            }
            if !(has_worked && self.chunks.take_turns()) {
                break;
            }
        }
    }

    /// Takes moves as they arrive, obeys holds and overrides, and keeps the ports' queues filled, for as long as the
    /// run lasts.
    ///
    /// # Cancellation
    /// Safe: the axes go on to the end of what has been queued for them.
    async fn keep_going(&mut self, start: Instant, purpose: Purpose, streams: &mut Streams<'_>) -> Infallible {
        let mut beam = BeamStream::new(self.machine, instant_near(start, self.chunks.delay_s()));
        loop {
            self.obey(purpose, start);
            let horizons = Horizons::from_now(start, purpose);
            let was_short = self.is_short_of(horizons.known_s);
            if was_short || self.machine.is_crowded() {
                // Moves are taken first: without another move the run would end where the known path ends.
                self.take_in_time(purpose, horizons.are_urgent(streams));
            }
            if was_short {
                self.commit_until(horizons.known_s);
            }
            if let Some(beam) = &mut beam {
                beam.fill_queue(self.chunks, self.marks, horizons.known_s);
            }
            let progress = fill_queues(streams, self.chunks, horizons.known);
            let is_low = horizons.are_low(streams);
            if progress.has_queued && is_low {
                // Queueing what is known comes first: if it were queued too late, the ports would run out of steps.
                continue;
            }
            self.follow(start, horizons.now, oldest_chunk(streams, beam.as_ref()));
            let is_short = self.is_short_of(horizons.known_s);
            if was_short && !is_short || progress.has_worked {
                yield_now().await;
            } else {
                self.wait(streams, is_low, is_short).await;
            }
        }
    }

    /// True if the chain has to hand out more, so that the path is known until `known_s` from the start of the run. It
    /// has to only when [`GATHER`] or more is missing, so that moves which arrive one by one are planned together.
    fn is_short_of(&self, known_s: f64) -> bool {
        !self.chunks.is_closed() && self.chunks.end_s() <= known_s - GATHER_S
    }

    /// Takes some of the waiting moves. It does not take all at once, because planning takes long and what is known
    /// must be queued meanwhile: very soon if a port has little left in a queue that is not full, and enough moves are known.
    fn take_in_time(&mut self, purpose: Purpose, is_urgent: bool) {
        let is_enough = is_urgent && self.chain.len() >= ENOUGH_MOVES;
        self.take_some(if is_enough { TAKEN_IN_HASTE } else { TAKEN_AT_ONCE }, purpose);
    }

    /// Has the chain hand out some of its path up to `until_s`, as far as there is room, and reports the chunks as events.
    fn commit_until(&mut self, until_s: f64) {
        for _ in 0..COMMITTED_AT_ONCE {
            // By reference: a chunk is large.
            let Some(chunk) = &self.next_chunk(until_s) else { break };
            self.report_chunk(chunk);
            self.chunks.push(chunk);
        }
    }

    /// The next chunk that the chain hands out, if the known path ends before `until_s` and there is room for more.
    fn next_chunk(&mut self, until_s: f64) -> Option<Chunk> {
        if self.chunks.is_closed() || !self.chunks.has_room() || self.chunks.end_s() > until_s {
            return None;
        }
        // With a curved speed profile compiling is slow near standstill. So the moves after a standstill become another run,
        // which is prepared before it starts.
        let is_over = self.is_curved && self.chunks.last().is_some() && self.chain.is_at_rest();
        if is_over {
            self.chunks.close();
            return None;
        }
        let chunk = self.chain.advance(self.chunk_s);
        if chunk.is_none() {
            self.chunks.close();
        }
        chunk
    }

    fn report_chunk(&mut self, chunk: &Chunk) {
        let begin_steps = match (chunk.kind, &chunk.plan) {
            (ChunkKind::Continuation, _) => return,
            (ChunkKind::Replan, Plan::Line(plan)) => return self.report(Event::Replan { plan: *plan }),
            (_, Plan::Line(plan)) => {
                self.report(Event::Move { plan: *plan, number: chunk.tag.number });
                plan.begin_steps()
            }
            (_, Plan::Blend(blend)) => {
                self.report(Event::Blend { blend: *blend, end_steps: chunk.until_steps, number: chunk.tag.number });
                0.0
            }
        };
        let Self { marks, on_event, .. } = self;
        for (Mark { place_steps, .. }, after) in marks.of(&chunk.tag).zip(1..) {
            if f64::from(place_steps) > begin_steps {
                on_event(Event::Mark { place_steps, number: chunk.tag.number.wrapping_add(after) });
            }
        }
    }

    /// Passes holds and overrides on to the chain.
    fn obey(&mut self, purpose: Purpose, start: Instant) {
        // Also while it is held: the place of the contact comes from the chunks, which are forgotten when they are
        // over.
        let is_found = match purpose {
            Purpose::Probe => self.note_contact(start),
            Purpose::Seek => self.note_touch(),
            _ => false,
        };
        if self.chain.is_held() {
            return;
        }
        if is_found || !purpose.is_homing() && self.machine.is_to_brake() {
            self.chain.hold();
        } else if self.is_overridden(purpose) {
            self.override_chain(purpose);
        }
    }

    /// Publishes the chunk under way for the status, and forgets the chunks that are over.
    fn follow(&mut self, start: Instant, passed: Duration, oldest_chunk: u32) {
        let delay_s = self.chunks.delay_s();
        let now_s = seconds(passed) - delay_s;
        self.chunks.forget(oldest_chunk, now_s);
        if let Some(oldest) = self.chunks.oldest() {
            self.marks.forget_before(&oldest.tag);
        }
        if let Some(chunk) = self.chunks.newly_under_way(now_s) {
            let line = chunk.tag.line;
            let start = instant_near(start, delay_s);
            self.machine.set_current(Some(CurrentChunk { start, chunk: *chunk, line }));
        }
        self.follow_line(now_s);
    }

    /// Publishes the line under way, if the chunk under way is of several; all of them have numbers, or none.
    fn follow_line(&self, now_s: f64) {
        let Some(chunk) = self.chunks.under_way() else { return };
        let tag = chunk.tag;
        if tag.line != 0
            && tag.marks().count > 0
            && let Some(line) = chunk.plan.line()
            && now_s >= line.begin_s()
        {
            let place_steps = line.place_at(now_s);
            let passed = self.marks.of(&tag).take_while(|mark| f64::from(mark.place_steps) <= place_steps);
            self.machine.set_line(passed.last().map_or(tag.line, |mark| mark.line));
        }
    }

    /// Waits for something to do.
    async fn wait(&self, streams: &Streams<'_>, is_low: bool, is_short: bool) {
        let machine = self.machine;
        let is_full = streams.iter().any(|stream| stream.is_short() && stream.queue().is_full());
        let look_again = if is_short || is_low || is_full { LOOK_AGAIN } else { GATHER };
        let takes = is_short && self.takes();
        let has_motion = poll_fn(|context| if takes { machine.poll_motion(context) } else { Poll::Pending });
        // The wait does not end at an instant that is computed from a step's instant: it would coincide with another
        // step again and again.
        let _ = with_timeout(look_again, select(has_motion, machine.wait_asked())).await;
    }

    fn end_run(&mut self, finish: Finish) -> Finish {
        self.machine.set_current(None);
        let position_steps = self.machine.motor_steps();
        let held_at_steps = self.chunks.last().map_or(0.0, |chunk| chunk.until_steps);
        let plan_s = self.chunks.over_s();
        self.report(Event::RunEnd { finish, held_at_steps, plan_s, position_steps });
        finish
    }
}

/// The streams at the beginning of a run. Not inlined: where they are made they take some KiB of stack, which all that a
/// run calls would have to do without.
#[cold]
fn streams(machine: &Machine, is_shaped: bool) -> Streams<'_> {
    Axis::ALL.map(|axis| SegmentStream::new(machine, axis, is_shaped))
}

/// The oldest chunk that somebody still needs.
fn oldest_chunk(streams: &Streams<'_>, beam: Option<&BeamStream<'_>>) -> u32 {
    streams.iter().map(SegmentStream::chunk).chain(beam.map(BeamStream::chunk)).min().unwrap_or(0)
}

/// The instants, from the start of the run, by which it is decided what is to be done next.
struct Horizons {
    /// The time that the run has come to.
    now: Duration,
    /// Until here a port's queue must reach, or filling it comes first.
    low: Duration,
    /// Until here the path is to be known, and queued.
    known: Duration,
    /// The same, s.
    known_s: f64,
}

impl Horizons {
    fn from_now(start: Instant, purpose: Purpose) -> Self {
        let now = Instant::now().saturating_duration_since(start);
        let known = now + if purpose.ends_by_contact() { PROBED_AHEAD } else { AHEAD + ITEM_MAX };
        Self { now, low: now + LOW, known, known_s: seconds(known) }
    }

    /// True if a port has little left.
    fn are_low(&self, streams: &Streams<'_>) -> bool {
        streams.iter().any(|stream| stream.is_low(self.low))
    }

    /// True if one has, and there is room in its queue for more.
    fn are_urgent(&self, streams: &Streams<'_>) -> bool {
        streams.iter().any(|stream| stream.is_low(self.low) && !stream.queue().is_full())
    }
}
