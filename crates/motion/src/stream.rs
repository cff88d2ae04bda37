//! Streams the steps of a run to the port of one axis, as far ahead as is useful.
//!
//! # Design
//! Steps that are queued for a port are committed: they will be made. So that a hold, or another speed, takes effect
//! soon, a port is queued [`AHEAD`] of motion and little more, in items of [`ITEM_MAX`] at most: long segments are split,
//! and a long wait for a step is queued as rests. While an axis stands still, rests are queued for as long as it is
//! known to stand still.
//!
//! On a curved ramp near standstill a segment takes longer to compile than it lasts. So while no port needs anything,
//! the next segments of the same plan are compiled ahead, up to [`COMPILED_MAX`] of them. In a cruise these are most of
//! the ramp at its end. What is compiled beyond the chunks handed out can still be discarded.
//!
//! Where an axis turns just beyond an edge, and passes it again in another plan, the second step would follow the first
//! at once. It is made a shortest period after it instead: so near to where it turns, the axis hardly moves in that time.

use embassy_time::{Duration, Instant};
use heapless::Deque;
use isostep_profile::chain::Plan;
use isostep_profile::{AxisCompiler, CountedPhase, Segment, SyncMove};

use crate::axes::{AXES, Axis};
use crate::chunks::Chunks;
use crate::clock::PortTicks;
use crate::machine::Machine;
use crate::port::{Direction, StreamItem, StreamQueue};

/// The time of motion that is queued for a port ahead, at least.
pub(crate) const AHEAD: Duration = Duration::from_millis(30);
/// Longest stream item. A single step may last longer, and an item may last an eighth longer if only a very short one
/// would be left after it.
pub(crate) const ITEM_MAX: Duration = Duration::from_millis(15);
/// Shortest rest that is queued for an axis that stands still. Its rests also end this long before the end of what is
/// known, because its next step may follow at once.
const REST_MIN: Duration = Duration::from_millis(2);
/// The time for which the queues are filled at a time, unless an item takes longer. A wake-up takes as long as compiling several
/// items of a trapezoid.
const TURN: Duration = Duration::from_micros(500);
/// The number of segments that are compiled before a port needs them.
const COMPILED_MAX: usize = 32;

/// Streams the steps of a run to one axis.
pub(crate) struct SegmentStream<'a> {
    machine: &'a Machine,
    axis: Axis,
    ticks: PortTicks,
    item_ticks: u64,
    rest_min_ticks: u64,
    /// The shortest time from one step to the next.
    period_ticks: u64,
    /// The direction of the last step that has been queued, and when it is due.
    last_step: Option<(Direction, u64)>,
    /// Up to when its queue is to be filled, ticks from the start of the run.
    target_ticks: u64,
    /// The number of the chunk that it streams.
    chunk: u32,
    /// The phase of the blend that comes next, if that chunk is one.
    phase: usize,
    /// The steps of that chunk's plan, or of a phase, once the stream has reached it.
    plan: Option<PlanSteps>,
    /// Compiles the axis there, if it has steps.
    compiler: AxisCompiler,
    /// Segments of that plan that are compiled and not queued yet.
    compiled: Deque<Segment, COMPILED_MAX>,
    /// Up to when its queue has been filled, ticks from the start of the run.
    queued_ticks: u64,
    /// Everything has been queued, the end included.
    is_done: bool,
    /// The axis's top speed if the run is shaped: then it streams shaped phases. 0 otherwise.
    shaped_top_steps_s: f64,
}

/// One axis's steps of the plan of a line, with their numbers in the move; or of a phase of a blend or of a shaped axis, counted in it.
struct PlanSteps {
    is_phase: bool,
    /// The direction of the first steps, and the last of them: in a phase the axis may turn.
    direction: Direction,
    turns: u32,
    /// The last step that has been compiled.
    compiled: u32,
    /// The last step that has been queued.
    queued: u32,
    /// The last step of the whole plan, which may be longer than the chunk known so far.
    last: u32,
    /// The place where the known chunk ends, steps of the longest axis.
    until_steps: f64,
    /// The last step before that place.
    end: u32,
}

/// The progress of one turn of filling the queues.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Progress {
    /// Something was queued for a port.
    pub has_queued: bool,
    /// Something was queued, or compiled ahead.
    pub has_worked: bool,
}

/// The next item that can be queued for an axis.
enum Next {
    /// Steps of the chunk under way.
    Steps,
    /// A rest until this instant, ticks from the start of the run.
    Rest(u64),
    /// The end of the run.
    End,
    /// The next item is not known yet.
    Unknown,
}

/// Fills the ports' queues up to `enough` from the start of the run, for one turn. Each item goes to the axis whose
/// queue ends first.
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

/// Queues one item for the axis whose queue ends first; false if no port needs one, or that queue is full, or nothing
/// more is known. No other axis goes on while that queue is full: it would only compile chunks at another time than
/// that axis, which would have to convert them to ticks again.
fn give(streams: &mut [SegmentStream<'_>; AXES], chunks: &mut Chunks) -> bool {
    // Axes for which nothing more is known are passed over.
    let mut stuck = [false; AXES];
    loop {
        // All tick rates are equal, or nearly so, and the comparison only decides which axis comes first.
        let mut next = None;
        let mut least_ticks = u64::MAX;
        for (axis, stream) in streams.iter().enumerate() {
            if stream.queued_ticks < least_ticks && !stuck[axis] && stream.is_short() {
                (next, least_ticks) = (Some(axis), stream.queued_ticks);
            }
        }
        let Some(axis) = next else { return false };
        let stream = &mut streams[axis];
        if stream.queue().is_full() {
            return false;
        }
        if stream.queue_one(chunks) {
            return true;
        }
        stuck[axis] = true;
    }
}

/// Compiles a segment ahead; false if there is none to compile, or no room.
fn compile(streams: &mut [SegmentStream<'_>; AXES], chunks: &mut Chunks) -> bool {
    let able = streams.iter_mut().filter(|stream| stream.can_compile());
    able.min_by_key(|stream| stream.compiled.len()).map(|stream| stream.compile(chunks)).is_some()
}

impl<'a> SegmentStream<'a> {
    pub fn new(machine: &'a Machine, axis: Axis, is_shaped: bool) -> Self {
        let shaped_top_steps_s =
            if is_shaped { machine.config().of_motors().limits[axis as usize].top_speed_steps_s } else { 0.0 };
        let ticks = PortTicks::new(machine.tick_hz(axis));
        Self {
            machine,
            axis,
            ticks,
            item_ticks: ticks.of(ITEM_MAX),
            rest_min_ticks: ticks.of(REST_MIN),
            period_ticks: machine.period_min_ticks(axis).into(),
            last_step: None,
            target_ticks: 0,
            chunk: 0,
            phase: 0,
            plan: None,
            compiler: AxisCompiler::empty(),
            compiled: Deque::new(),
            queued_ticks: 0,
            is_done: false,
            shaped_top_steps_s,
        }
    }

    /// Before the run starts: compiles the first chunks up to `time`, and queues as much of them as the queue takes. Returns whether
    /// there was something to do.
    pub fn prepare(&mut self, chunks: &mut Chunks, time: Duration) -> bool {
        self.set_target(time);
        let mut has_worked = false;
        while self.is_short() && !self.queue().is_full() && self.queue_one(chunks) {
            has_worked = true;
        }
        while self.compiled.back().map_or(self.queued_ticks, Segment::last_ticks) < self.target_ticks
            && self.can_compile()
        {
            self.compile(chunks);
            has_worked = true;
        }
        has_worked
    }

    /// Sets up to when its queue is to be filled: `enough` from the start of the run.
    pub fn set_target(&mut self, enough: Duration) {
        self.target_ticks = self.ticks.of(enough);
    }

    /// The number of the chunk that it streams.
    pub fn chunk(&self) -> u32 {
        self.chunk
    }

    /// True if its queue is to be filled now.
    pub fn is_short(&self) -> bool {
        !self.is_done && self.queued_ticks <= self.target_ticks
    }

    /// True if its queue ends at `time` from the start of the run, or earlier.
    pub fn is_low(&self, time: Duration) -> bool {
        !self.is_done && self.queued_ticks <= self.ticks.of(time)
    }

    pub fn queue(&self) -> &'a StreamQueue {
        &self.machine.link(self.axis).segments
    }

    /// Queues one item, for which there is room; false if nothing more is known.
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

    /// Moves on to the chunk of the next step, if there is one, and says what can be queued.
    fn next(&mut self, chunks: &mut Chunks) -> Next {
        if self.is_shaped() {
            return self.next_of_shaped(chunks);
        }
        loop {
            let Some((chunk, sources)) = chunks.get_with_sources(self.chunk) else { return self.rest(chunks) };
            if let Plan::Line(line) = &chunk.plan {
                let plan = self.plan.get_or_insert_with(|| {
                    // An axis that stands still is ahead of the others. It must not have timed plans computed that the others
                    // do not need yet.
                    let moves = line.steps[self.axis as usize] != 0;
                    if moves && let Some(timed_plan) = sources.begin(self.axis, self.chunk, line, self.ticks.hz) {
                        line.begin_compiler(self.axis as usize, timed_plan, &mut self.compiler);
                    }
                    PlanSteps::of_line(line, self.axis, moves.then_some(&self.compiler))
                });
                // As whole numbers: comparing floats is a call.
                if plan.until_steps.to_bits() != chunk.until_steps.to_bits() {
                    (plan.until_steps, plan.end) =
                        (chunk.until_steps, line.steps_before(self.axis as usize, chunk.until_steps));
                }
            }
            if self.has_steps() {
                return Next::Steps;
            }
            if let Plan::Blend(blend) = &chunk.plan
                && let Some(phase) = blend.counted_phase(self.axis as usize, self.phase)
            {
                self.phase += 1;
                self.begin_phase(&phase);
                continue;
            }
            if !chunks.has_next(self.chunk) {
                return self.rest(chunks);
            }
            (self.chunk, self.phase, self.plan) = (self.chunk + 1, 0, None);
            self.compiled.clear();
        }
    }

    /// True if steps of the plan under way are known and not queued yet.
    fn has_steps(&self) -> bool {
        self.plan.as_ref().is_some_and(|plan| plan.queued < plan.end)
    }

    fn is_shaped(&self) -> bool {
        self.shaped_top_steps_s > 0.0
    }

    /// The same in a shaped run.
    fn next_of_shaped(&mut self, chunks: &mut Chunks) -> Next {
        loop {
            if self.has_steps() {
                return Next::Steps;
            }
            let phase = chunks.shaped_phase(self.axis, self.shaped_top_steps_s);
            self.chunk = chunks.shaped_chunk(self.axis).unwrap_or(self.chunk);
            let Some(phase) = phase else { return self.rest(chunks) };
            self.begin_phase(&phase);
        }
    }

    /// Goes on to a phase, in which it may make no step. All steps before it have been queued.
    fn begin_phase(&mut self, phase: &CountedPhase) {
        self.plan = (phase.step_counts().0 > 0).then(|| PlanSteps::of_phase(phase));
        if self.plan.is_some() {
            self.compiler.begin_phase(phase, self.ticks.hz);
        }
    }

    /// The item that follows where no step is known: a rest for as long as the axis is known to stand still, or the end.
    fn rest(&self, chunks: &Chunks) -> Next {
        let (known_s, is_over) = chunks.shaped_until(self.axis).unwrap_or_else(|| (chunks.end_s(), chunks.is_closed()));
        if is_over {
            return Next::End;
        }
        let known_ticks = ((known_s * f64::from(self.ticks.hz)) as u64).saturating_sub(self.queued_ticks);
        let rest_ticks = (known_ticks - self.rest_min_ticks.min(known_ticks / 2)).min(self.item_ticks);
        // A port needs an item before it can start, so the first rest may be short.
        let is_worth_it = rest_ticks >= self.rest_min_ticks || self.queued_ticks == 0 && rest_ticks > 0;
        if is_worth_it { Next::Rest(self.queued_ticks + rest_ticks) } else { Next::Unknown }
    }

    /// The next steps of the chunk under way, or a rest until they are near.
    fn steps(&mut self, chunks: &mut Chunks) -> Option<StreamItem> {
        let segment = self.compiled.pop_front().or_else(|| self.next_compiled(chunks))?;
        let (queued_ticks, item_ticks) = (self.queued_ticks, self.item_ticks);
        let plan = self.plan.as_mut()?;
        if segment.first_ticks() > queued_ticks + 2 * item_ticks {
            let _ = self.compiled.push_front(segment);
            self.queued_ticks = queued_ticks + item_ticks;
            return Some(StreamItem::Rest { until_ticks: self.queued_ticks });
        }
        let last_ticks = segment.last_ticks();
        let lasts_ticks = last_ticks - segment.first_ticks();
        let fitting = if lasts_ticks > item_ticks {
            // Fewer than the segment has. On a ramp they last more or less than an item, which does not matter.
            ((u64::from(segment.steps()) * item_ticks / lasts_ticks) as u32).max(1)
        } else {
            segment.steps()
        };
        let known = segment.steps().min(plan.end - plan.queued);
        // No very short item is left over: it would take a port as long as a long one.
        let fitting = if known <= fitting + fitting / 8 { known } else { fitting };
        let direction = if plan.queued < plan.turns { plan.direction } else { plan.direction.reversed() };
        let late_ticks = match self.last_step {
            Some((before, at_ticks)) if before != direction => {
                (at_ticks + self.period_ticks).saturating_sub(segment.first_ticks())
            }
            _ => 0,
        };
        let steps = if late_ticks == 0 { fitting } else { 1 };
        plan.queued += steps;
        let (queued, last_ticks) = if steps == segment.steps() {
            (segment, last_ticks)
        } else {
            let (queued, others) = segment.split(steps);
            // There is room in `compiled`: the whole segment came from there, or `compiled` was empty.
            let _ = self.compiled.push_front(others);
            (queued, queued.last_ticks())
        };
        self.queued_ticks = last_ticks + late_ticks;
        self.last_step = Some((direction, self.queued_ticks));
        Some(StreamItem::Steps { segment: queued.delayed(late_ticks), direction })
    }

    /// True if some of the plan under way is still to be compiled, and there is room for it.
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

    /// Compiles the next segment of the plan under way.
    fn next_compiled(&mut self, chunks: &mut Chunks) -> Option<Segment> {
        let plan = self.plan.as_mut()?;
        let segment = if plan.is_phase {
            self.compiler.next_of_phase()?
        } else {
            self.compiler.next(chunks.begun(self.axis)?)?
        };
        plan.compiled += segment.steps();
        Some(segment)
    }
}

impl PlanSteps {
    /// `compiler` is `None` if the axis has no steps in the plan.
    fn of_line(line: &SyncMove<AXES>, axis: Axis, compiler: Option<&AxisCompiler>) -> Self {
        let [before, last] =
            compiler.map_or([0; 2], |compiler| [compiler.steps_before(), compiler.steps_before() + compiler.steps()]);
        let (direction, until_steps) = (Direction::of(line.steps[axis as usize]), line.end_steps());
        Self { is_phase: false, direction, turns: last, compiled: before, queued: before, last, until_steps, end: last }
    }

    fn of_phase(phase: &CountedPhase) -> Self {
        let (direction, turns, (last, _)) =
            (Direction::of(phase.direction()), phase.turns_after(), phase.step_counts());
        Self { is_phase: true, direction, turns, compiled: 0, queued: 0, last, until_steps: 0.0, end: last }
    }
}
