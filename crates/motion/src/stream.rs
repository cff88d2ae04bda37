//! Streams the steps of a run to the port of one axis, as far ahead as is useful.
//!
//! # Design
//! What a port has been queued is made, come what may. So that a hold, or another speed, takes effect soon, a port is
//! queued [`AHEAD`] of motion and little more, in pieces of [`PIECE`] at most: long segments are split, and a long wait for
//! a step is told as rests. While an axis stands still it rests for as long as is known that it does.
//!
//! Of a curved ramp near standstill a segment takes longer to compile than it lasts. So while no port wants anything, what
//! comes next of the same part is compiled and kept in [`COMPILED_MAX`]: in a cruise most of the ramp at its end. That may still be
//! changed.

use embassy_time::{Duration, Instant};
use heapless::Deque;
use isostep_profile::chain::Chunk;
use isostep_profile::{Lane, Segment};

use crate::axes::{AXES, Axis};
use crate::chunks::{Chunks, last_step};
use crate::machine::Machine;
use crate::port::{Direction, SegmentQueue, StreamItem};

/// How much motion a port is queued ahead of time, at least.
pub(crate) const AHEAD: Duration = Duration::from_millis(30);
/// A piece of motion lasts no longer, unless it is a single step; an eighth longer where a crumb would be left.
pub(crate) const PIECE: Duration = Duration::from_millis(15);
/// An axis that stands still is not told of shorter rests, and not told up to the last of what is known: its next step may
/// follow at once.
const REST_MIN: Duration = Duration::from_millis(2);
/// Feeding goes on so long at a time, unless a piece takes longer. Waking up takes as long as to compile several pieces of a
/// trapezoid's.
const TURN: Duration = Duration::from_micros(500);
/// Segments that are compiled before a port wants them.
const COMPILED_MAX: usize = 64;

/// Streams the steps of a run to one axis.
pub(crate) struct SegmentStream<'a> {
    machine: &'a Machine,
    axis: Axis,
    tick_hz: u32,
    piece_ticks: u64,
    rest_min_ticks: u64,
    /// Until when its queue is to be filled, ticks from the start of the run.
    target_ticks: u64,
    /// The number of the chunk that it streams.
    chunk: u32,
    /// What that is, once it is under way.
    plan: Option<PlanSteps>,
    /// Compiled of it and not queued yet.
    compiled: Deque<Segment, COMPILED_MAX>,
    /// Until when its queue has been filled, ticks from the start of the run.
    queued_ticks: u64,
    /// All has been queued, and the end told.
    is_done: bool,
}

/// The steps of a part of a move.
struct PlanSteps {
    direction: Direction,
    /// None of an axis that has no steps in it.
    lane: Option<Lane>,
    /// The last step that has been compiled, and queued: by their numbers in the move.
    compiled: u32,
    queued: u32,
    /// The last of the whole part, of which more may be told.
    last: u32,
    /// Up to where it has been told, steps of the longest axis, and the last step before that.
    until_steps: f64,
    end: u32,
}

/// What a turn of filling the queues came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Progress {
    /// A port was queued something.
    pub has_queued: bool,
    /// Something was queued, or compiled ahead.
    pub has_worked: bool,
}

/// What an axis can be queued next.
enum Next {
    /// Steps of the chunk under way.
    Steps,
    /// Nothing until then, ticks from the start of the run.
    Rest(u64),
    /// The end of the run.
    End,
    /// It is not known yet.
    Unknown,
}

/// Gives the ports what they want until `enough` from the start of the run, for one turn. Each piece goes to the axis that
/// has the least.
pub(crate) fn fill_queues(streams: &mut [SegmentStream<'_>; AXES], chunks: &mut Chunks, enough: Duration) -> Progress {
    let end = Instant::now() + TURN;
    streams.iter_mut().for_each(|stream| stream.set_target(enough));
    let mut progress = Progress::default();
    loop {
        let has_queued = give(streams, chunks);
        if !has_queued && !compile(streams, chunks) {
            return progress;
        }
        progress = Progress { has_queued: progress.has_queued || has_queued, has_worked: true };
        if Instant::now() >= end {
            return progress;
        }
    }
}

/// Gives one piece; false if none is wanted, or known.
fn give(streams: &mut [SegmentStream<'_>; AXES], chunks: &mut Chunks) -> bool {
    // Those of which nothing is known are passed over.
    let mut stuck = [false; AXES];
    loop {
        let wanting = streams
            .iter_mut()
            .zip(&mut stuck)
            .filter(|(stream, is_stuck)| !**is_stuck && stream.is_short() && !stream.queue().is_full());
        // All tick at one rate, or nearly: it is only for what comes first.
        let Some((stream, is_stuck)) = wanting.min_by_key(|(stream, _)| stream.queued_ticks) else { return false };
        if stream.queue_one(chunks) {
            return true;
        }
        *is_stuck = true;
    }
}

/// Compiles a segment ahead; false if there is none, or no room.
fn compile(streams: &mut [SegmentStream<'_>; AXES], chunks: &mut Chunks) -> bool {
    let able = streams.iter_mut().filter(|stream| stream.can_compile());
    able.min_by_key(|stream| stream.compiled.len()).map(|stream| stream.compile(chunks)).is_some()
}

impl<'a> SegmentStream<'a> {
    pub fn new(machine: &'a Machine, axis: Axis) -> Self {
        let tick_hz = machine.tick_hz(axis);
        Self {
            machine,
            axis,
            tick_hz,
            piece_ticks: ticks(PIECE, tick_hz),
            rest_min_ticks: ticks(REST_MIN, tick_hz),
            target_ticks: 0,
            chunk: 0,
            plan: None,
            compiled: Deque::new(),
            queued_ticks: 0,
            is_done: false,
        }
    }

    /// Compiles what there is of the first chunks, up to `time`, and gives what the queue takes. Before the run starts.
    pub fn prepare(&mut self, chunks: &mut Chunks, time: Duration) {
        self.set_target(time);
        while self.is_short() && !self.queue().is_full() && self.queue_one(chunks) {}
        while self.compiled.back().map_or(self.queued_ticks, Segment::last_ticks) < self.target_ticks
            && self.can_compile()
        {
            self.compile(chunks);
        }
    }

    /// Its queue is to be filled until `enough` from the start of the run.
    pub fn set_target(&mut self, enough: Duration) {
        self.target_ticks = ticks(enough, self.tick_hz);
    }

    /// The number of the chunk that it streams.
    pub fn chunk(&self) -> u32 {
        self.chunk
    }

    /// Whether its queue is to be filled now.
    pub fn is_short(&self) -> bool {
        !self.is_done && self.queued_ticks <= self.target_ticks
    }

    /// Whether it has no more than until `time` from the start of the run.
    pub fn is_low(&self, time: Duration) -> bool {
        !self.is_done && self.queued_ticks <= ticks(time, self.tick_hz)
    }

    pub fn queue(&self) -> &'a SegmentQueue {
        &self.machine.link(self.axis).segments
    }

    /// Gives one piece, for which there is room; false if nothing is known to give.
    fn queue_one(&mut self, chunks: &mut Chunks) -> bool {
        let item = match self.next(chunks) {
            Next::Steps => self.steps(chunks),
            Next::Rest(until_ticks) => {
                self.queued_ticks = until_ticks;
                Some(StreamItem::Rest { until_ticks })
            }
            Next::End => {
                self.is_done = true;
                Some(StreamItem::End)
            }
            Next::Unknown => None,
        };
        let Some(item) = item else { return false };
        // There is room, and this task is the only sender.
        let _ = self.queue().try_send(item);
        true
    }

    /// Goes over to the chunk of the next step, if there is one.
    fn next(&mut self, chunks: &mut Chunks) -> Next {
        loop {
            let Some((chunk, courses)) = chunks.get_with_courses(self.chunk) else { return self.rest(chunks) };
            let plan = self.plan.get_or_insert_with(|| {
                self.compiled.clear();
                // An axis that stands still is ahead of the others: it must not lay courses that they do not want yet.
                let lane = (chunk.plan.steps[self.axis as usize] != 0)
                    .then(|| chunk.plan.lane(self.axis as usize, courses.of(self.chunk, chunk, self.tick_hz)));
                PlanSteps::of(chunk, self.axis, lane)
            });
            if plan.until_steps != chunk.until_steps {
                (plan.until_steps, plan.end) = (chunk.until_steps, last_step(chunk, self.axis));
            }
            if plan.queued < plan.end {
                return Next::Steps;
            }
            if !chunks.has_next(self.chunk) {
                return if chunks.is_closed() { Next::End } else { self.rest(chunks) };
            }
            self.chunk += 1;
            self.plan = None;
        }
    }

    /// It stands still for as long as is known.
    fn rest(&self, chunks: &Chunks) -> Next {
        if chunks.is_closed() {
            return Next::End;
        }
        let known_ticks = ((chunks.end_s() * f64::from(self.tick_hz)) as u64).saturating_sub(self.queued_ticks);
        let rest_ticks = (known_ticks - self.rest_min_ticks.min(known_ticks / 2)).min(self.piece_ticks);
        // A port waits for something before it starts.
        let is_worth_it = rest_ticks >= self.rest_min_ticks || self.queued_ticks == 0 && rest_ticks > 0;
        if is_worth_it { Next::Rest(self.queued_ticks + rest_ticks) } else { Next::Unknown }
    }

    /// The next steps of the chunk under way, or a rest until they are near.
    fn steps(&mut self, chunks: &mut Chunks) -> Option<StreamItem> {
        let segment = self.compiled.pop_front().or_else(|| self.next_compiled(chunks))?;
        let (queued_ticks, piece_ticks) = (self.queued_ticks, self.piece_ticks);
        let plan = self.plan.as_mut()?;
        if segment.first_ticks() > queued_ticks + 2 * piece_ticks {
            let _ = self.compiled.push_front(segment);
            self.queued_ticks = queued_ticks + piece_ticks;
            return Some(StreamItem::Rest { until_ticks: self.queued_ticks });
        }
        let last_ticks = segment.last_ticks();
        let lasts_ticks = last_ticks - segment.first_ticks();
        let fitting = if lasts_ticks > piece_ticks {
            // Less than the steps there are; what a ramp makes of it need not be exact.
            ((u64::from(segment.steps()) * piece_ticks / lasts_ticks) as u32).max(1)
        } else {
            segment.steps()
        };
        let known = segment.steps().min(plan.end - plan.queued);
        // No crumb is left: a port takes as long over it as over a whole piece.
        let steps = if known <= fitting + fitting / 8 { known } else { fitting };
        plan.queued += steps;
        let direction = plan.direction;
        if steps == segment.steps() {
            self.queued_ticks = last_ticks;
            return Some(StreamItem::Steps { segment, direction });
        }
        let (segment, others) = segment.split(steps);
        // There is room: the whole was taken from there, or came when there was nothing.
        let _ = self.compiled.push_front(others);
        self.queued_ticks = segment.last_ticks();
        Some(StreamItem::Steps { segment, direction })
    }

    /// Whether something of the part under way is still to be compiled, and there is room for it.
    fn can_compile(&self) -> bool {
        self.plan.as_ref().is_some_and(|plan| plan.compiled < plan.last) && !self.compiled.is_full()
    }

    /// Compiles one segment ahead.
    fn compile(&mut self, chunks: &mut Chunks) {
        if let Some(segment) = self.next_compiled(chunks) {
            // There is room.
            let _ = self.compiled.push_back(segment);
        }
    }

    /// The segment after all that has been compiled of the part under way.
    fn next_compiled(&mut self, chunks: &mut Chunks) -> Option<Segment> {
        let plan = self.plan.as_mut()?;
        let (chunk, courses) = chunks.get_with_courses(self.chunk)?;
        let course = courses.of(self.chunk, chunk, self.tick_hz);
        let segment = plan.lane.as_mut()?.next(course)?;
        plan.compiled += segment.steps();
        Some(segment)
    }
}

impl PlanSteps {
    fn of(chunk: &Chunk<AXES>, axis: Axis, lane: Option<Lane>) -> Self {
        let (plan, until_steps) = (&chunk.plan, chunk.plan.end_steps());
        let [before, last] =
            lane.as_ref().map_or([0; 2], |lane| [lane.steps_before(), lane.steps_before() + lane.steps()]);
        let direction = Direction::of(plan.steps[axis as usize]);
        Self { direction, lane, compiled: before, queued: before, last, until_steps, end: last }
    }
}

fn ticks(time: Duration, tick_hz: u32) -> u64 {
    // Of a port with a whole number of ticks a microsecond, exactly; of another, a little less.
    time.as_micros() * u64::from(tick_hz / 1_000_000)
}
