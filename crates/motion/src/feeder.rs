//! Feeds one axis's port with the steps of a run, as far ahead as is of use.
//!
//! # Design
//! What a port has been given is made, come what may. So that a hold, or another speed, takes effect soon, a port is
//! given [`AHEAD`] of motion and little more, in pieces of [`PIECE`] at most: long segments are split, and a long wait for
//! a step is told as rests. While an axis stands still it rests for as long as is known that it does.
//!
//! Of a curved ramp near standstill a segment takes longer to compile than it lasts. So while no port wants anything, what
//! comes next of the same part is compiled and kept in [`HAND`]: in a cruise most of the ramp at its end. That may still be
//! changed.

use embassy_time::{Duration, Instant};
use heapless::Deque;
use isostep_profile::chain::Leg;
use isostep_profile::{Lane, Segment};

use crate::axes::{AXES, Axis};
use crate::legs::{Legs, last_step};
use crate::machine::Machine;
use crate::port::{Direction, Feed, SegmentQueue};

/// How much motion a port is given ahead of time, at least.
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
const HAND: usize = 64;

/// Feeds one axis with its steps of a run.
pub(crate) struct Feeder<'a> {
    machine: &'a Machine,
    axis: Axis,
    tick_hz: u32,
    piece_ticks: u64,
    rest_min_ticks: u64,
    /// Until when it is to be fed, ticks from the start of the run.
    enough_ticks: u64,
    /// The number of the leg that it is fed with.
    leg: u32,
    /// What that is, once it is under way.
    part: Option<Part>,
    /// Compiled of it and not given yet.
    hand: Deque<Segment, HAND>,
    /// Until when it has been fed, ticks from the start of the run.
    fed_ticks: u64,
    /// All has been given, and the end told.
    is_done: bool,
}

/// The steps of a part of a move.
struct Part {
    direction: Direction,
    /// None of an axis that has no steps in it.
    lane: Option<Lane>,
    /// The last step that has been compiled, and given: by their numbers in the move.
    compiled: u32,
    given: u32,
    /// The last of the whole part, of which more may be told.
    last: u32,
    /// Up to where it has been told, steps of the longest axis, and the last step before that.
    until_steps: f64,
    end: u32,
}

/// What a turn of feeding came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Fed {
    /// A port was given something.
    pub has_given: bool,
    /// Something was given, or compiled ahead.
    pub has_worked: bool,
}

/// What an axis can be given next.
enum Next {
    /// Steps of the leg under way.
    Steps,
    /// Nothing until then, ticks from the start of the run.
    Rest(u64),
    /// The end of the run.
    End,
    /// It is not known yet.
    Unknown,
}

/// Gives the ports what they want until `enough` from the start of the run, for one turn. Each piece goes to the axis that
/// has been fed the least.
pub(crate) fn feed(feeders: &mut [Feeder<'_>; AXES], legs: &mut Legs, enough: Duration) -> Fed {
    let end = Instant::now() + TURN;
    feeders.iter_mut().for_each(|feeder| feeder.feed_until(enough));
    let mut fed = Fed::default();
    loop {
        let has_given = give(feeders, legs);
        if !has_given && !compile(feeders, legs) {
            return fed;
        }
        fed = Fed { has_given: fed.has_given || has_given, has_worked: true };
        if Instant::now() >= end {
            return fed;
        }
    }
}

/// Gives one piece; false if none is wanted, or known.
fn give(feeders: &mut [Feeder<'_>; AXES], legs: &mut Legs) -> bool {
    // Those of which nothing is known are passed over.
    let mut stuck = [false; AXES];
    loop {
        let wanting = feeders
            .iter_mut()
            .zip(&mut stuck)
            .filter(|(feeder, is_stuck)| !**is_stuck && feeder.is_wanting() && !feeder.queue().is_full());
        // All tick at one rate, or nearly: it is only for what comes first.
        let Some((feeder, is_stuck)) = wanting.min_by_key(|(feeder, _)| feeder.fed_ticks) else { return false };
        if feeder.feed_one(legs) {
            return true;
        }
        *is_stuck = true;
    }
}

/// Compiles a segment ahead; false if there is none, or no room.
fn compile(feeders: &mut [Feeder<'_>; AXES], legs: &mut Legs) -> bool {
    let able = feeders.iter_mut().filter(|feeder| feeder.can_compile());
    able.min_by_key(|feeder| feeder.hand.len()).map(|feeder| feeder.compile(legs)).is_some()
}

impl<'a> Feeder<'a> {
    pub fn new(machine: &'a Machine, axis: Axis) -> Self {
        let tick_hz = machine.tick_hz(axis);
        Self {
            machine,
            axis,
            tick_hz,
            piece_ticks: ticks(PIECE, tick_hz),
            rest_min_ticks: ticks(REST_MIN, tick_hz),
            enough_ticks: 0,
            leg: 0,
            part: None,
            hand: Deque::new(),
            fed_ticks: 0,
            is_done: false,
        }
    }

    /// Compiles what there is of the first legs, up to `time`, and gives what the queue takes. Before the run starts.
    pub fn prepare(&mut self, legs: &mut Legs, time: Duration) {
        self.feed_until(time);
        while self.is_wanting() && !self.queue().is_full() && self.feed_one(legs) {}
        while self.hand.back().map_or(self.fed_ticks, Segment::last_ticks) < self.enough_ticks && self.can_compile() {
            self.compile(legs);
        }
    }

    /// It is to be fed until `enough` from the start of the run.
    pub fn feed_until(&mut self, enough: Duration) {
        self.enough_ticks = ticks(enough, self.tick_hz);
    }

    /// The number of the leg that it is fed with.
    pub fn leg(&self) -> u32 {
        self.leg
    }

    /// Whether it is to be fed now.
    pub fn is_wanting(&self) -> bool {
        !self.is_done && self.fed_ticks <= self.enough_ticks
    }

    /// Whether it has no more than until `time` from the start of the run.
    pub fn is_hungry(&self, time: Duration) -> bool {
        !self.is_done && self.fed_ticks <= ticks(time, self.tick_hz)
    }

    pub fn queue(&self) -> &'a SegmentQueue {
        &self.machine.link(self.axis).segments
    }

    /// Gives one piece, for which there is room; false if nothing is known to give.
    fn feed_one(&mut self, legs: &mut Legs) -> bool {
        let feed = match self.next(legs) {
            Next::Steps => self.steps(legs),
            Next::Rest(until_ticks) => {
                self.fed_ticks = until_ticks;
                Some(Feed::Rest { until_ticks })
            }
            Next::End => {
                self.is_done = true;
                Some(Feed::End)
            }
            Next::Unknown => None,
        };
        let Some(feed) = feed else { return false };
        // There is room, and this task is the only sender.
        let _ = self.queue().try_send(feed);
        true
    }

    /// Goes over to the leg of the next step, if there is one.
    fn next(&mut self, legs: &mut Legs) -> Next {
        loop {
            let Some((leg, courses)) = legs.get_with_courses(self.leg) else { return self.rest(legs) };
            let part = self.part.get_or_insert_with(|| {
                self.hand.clear();
                // An axis that stands still is ahead of the others: it must not lay courses that they do not want yet.
                let lane = (leg.part.steps[self.axis as usize] != 0)
                    .then(|| leg.part.lane(self.axis as usize, courses.of(self.leg, leg, self.tick_hz)));
                Part::of(leg, self.axis, lane)
            });
            if part.until_steps != leg.until_steps {
                (part.until_steps, part.end) = (leg.until_steps, last_step(leg, self.axis));
            }
            if part.given < part.end {
                return Next::Steps;
            }
            if !legs.has_next(self.leg) {
                return if legs.is_closed() { Next::End } else { self.rest(legs) };
            }
            self.leg += 1;
            self.part = None;
        }
    }

    /// It stands still for as long as is known.
    fn rest(&self, legs: &Legs) -> Next {
        if legs.is_closed() {
            return Next::End;
        }
        let known_ticks = ((legs.end_s() * f64::from(self.tick_hz)) as u64).saturating_sub(self.fed_ticks);
        let rest_ticks = (known_ticks - self.rest_min_ticks.min(known_ticks / 2)).min(self.piece_ticks);
        // A port waits for something before it starts.
        let is_worth_it = rest_ticks >= self.rest_min_ticks || self.fed_ticks == 0 && rest_ticks > 0;
        if is_worth_it { Next::Rest(self.fed_ticks + rest_ticks) } else { Next::Unknown }
    }

    /// The next steps of the leg under way, or a rest until they are near.
    fn steps(&mut self, legs: &mut Legs) -> Option<Feed> {
        let segment = self.hand.pop_front().or_else(|| self.next_compiled(legs))?;
        let (fed_ticks, piece_ticks) = (self.fed_ticks, self.piece_ticks);
        let part = self.part.as_mut()?;
        if segment.first_ticks() > fed_ticks + 2 * piece_ticks {
            let _ = self.hand.push_front(segment);
            self.fed_ticks = fed_ticks + piece_ticks;
            return Some(Feed::Rest { until_ticks: self.fed_ticks });
        }
        let last_ticks = segment.last_ticks();
        let lasts_ticks = last_ticks - segment.first_ticks();
        let fitting = if lasts_ticks > piece_ticks {
            // Less than the steps there are; what a ramp makes of it need not be exact.
            ((u64::from(segment.steps()) * piece_ticks / lasts_ticks) as u32).max(1)
        } else {
            segment.steps()
        };
        let known = segment.steps().min(part.end - part.given);
        // No crumb is left: a port takes as long over it as over a whole piece.
        let steps = if known <= fitting + fitting / 8 { known } else { fitting };
        part.given += steps;
        let direction = part.direction;
        if steps == segment.steps() {
            self.fed_ticks = last_ticks;
            return Some(Feed::Steps { segment, direction });
        }
        let (segment, others) = segment.split(steps);
        // There is room: the whole was taken from there, or came when there was nothing.
        let _ = self.hand.push_front(others);
        self.fed_ticks = segment.last_ticks();
        Some(Feed::Steps { segment, direction })
    }

    /// Whether something of the part under way is still to be compiled, and there is room for it.
    fn can_compile(&self) -> bool {
        self.part.as_ref().is_some_and(|part| part.compiled < part.last) && !self.hand.is_full()
    }

    /// Compiles one segment ahead.
    fn compile(&mut self, legs: &mut Legs) {
        if let Some(segment) = self.next_compiled(legs) {
            // There is room.
            let _ = self.hand.push_back(segment);
        }
    }

    /// The segment after all that has been compiled of the part under way.
    fn next_compiled(&mut self, legs: &mut Legs) -> Option<Segment> {
        let part = self.part.as_mut()?;
        let (leg, courses) = legs.get_with_courses(self.leg)?;
        let course = courses.of(self.leg, leg, self.tick_hz);
        let segment = part.lane.as_mut()?.next(course)?;
        part.compiled += segment.steps();
        Some(segment)
    }
}

impl Part {
    fn of(leg: &Leg<AXES>, axis: Axis, lane: Option<Lane>) -> Self {
        let (plan, until_steps) = (&leg.part, leg.part.end_steps());
        let [before, last] =
            lane.as_ref().map_or([0; 2], |lane| [lane.steps_before(), lane.steps_before() + lane.steps()]);
        let direction = Direction::of(plan.steps[axis as usize]);
        Self { direction, lane, compiled: before, given: before, last, until_steps, end: last }
    }
}

fn ticks(time: Duration, tick_hz: u32) -> u64 {
    // Of a port with a whole number of ticks a microsecond, exactly; of another, a little less.
    time.as_micros() * u64::from(tick_hz / 1_000_000)
}
