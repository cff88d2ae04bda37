//! A run: what all axes do from standstill to standstill, over any number of moves.
//!
//! # Design
//! The chain of moves knows the path ahead; a run makes it, on one clock. It has the chain tell as much as the ports are to
//! have, as legs, and feeds the axes with their steps. Meanwhile it takes moves as they come, and what is asked for: a
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
use isostep_profile::chain::LegKind;

use crate::axes::{AXES, Axis};
use crate::coordinator::{Coordinator, all_armed, all_done, begun};
use crate::event::{Event, Finish};
use crate::feeder::{AHEAD, Feeder, PIECE, feed};
use crate::flow::Purpose;
use crate::machine::Underway;
use crate::port::Run;

/// Motion compiled per axis before a run starts, as far as there is room: near standstill compiling is slowest against
/// moving.
const COMPILED_BEFORE_START: Duration = Duration::from_millis(20);

/// So much is told ahead of the ports at a time: as long as a change may have to wait for more.
const TOLD: Duration = Duration::from_millis(15);

/// While little is known, it is looked for more so often, unless something wakes.
const LOOK_AGAIN: Duration = Duration::from_millis(1);

/// While a port has less than that to go on with, feeding it comes before all else in thread mode.
const HUNGRY: Duration = Duration::from_millis(15);

/// The feeders of all axes.
type Feeders<'a> = [Feeder<'a>; AXES];

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
        self.legs.clear();
        for axis in Axis::ALL {
            machine.ready(axis);
        }
        let mut feeders = Axis::ALL.map(|axis| Feeder::new(machine, axis));
        self.prepare(&mut feeders).await;
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
        let start = match select(self.start(&mut feeders), done.as_mut()).await {
            Either::First(start) => start,
            Either::Second(finish) => return self.end_run(finish),
        };
        self.tell(Event::Run { start, origin_steps });
        self.tell_legs();
        let finish = match select(done, self.keep_going(start, purpose, &mut feeders)).await {
            Either::First(finish) => finish,
            Either::Second(never) => match never {},
        };
        if finish == Finish::Done {
            self.standstill = instant(start, self.legs.end_s());
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
    async fn start(&mut self, feeders: &mut Feeders<'_>) -> Instant {
        let machine = self.machine;
        all_armed(machine).await;
        // Arming has taken the first segments off the queues.
        self.prepare(feeders).await;
        Timer::at(self.standstill).await;
        machine.let_go();
        begun(machine).await
    }

    /// Tells and compiles what the run begins with.
    async fn prepare(&mut self, feeders: &mut Feeders<'_>) {
        self.tell_until(COMPILED_BEFORE_START.as_micros() as f64 * 1e-6);
        for feeder in feeders {
            feeder.prepare(self.legs, COMPILED_BEFORE_START);
            yield_now().await;
        }
    }

    /// Takes what comes, and gives what the ports want, each piece in its time, for as long as the run lasts.
    ///
    /// # Cancellation
    /// Safe: the axes go on to the end of what they have been given.
    async fn keep_going(&mut self, start: Instant, purpose: Purpose, feeders: &mut Feeders<'_>) -> Infallible {
        loop {
            if self.chain.is_empty() {
                // Without another the run would end with what has been told.
                self.take_next(purpose);
            }
            self.obey(purpose);
            let now = Instant::now();
            let passed = now.saturating_duration_since(start);
            let enough = passed + AHEAD + PIECE;
            let has_told = self.tell_until(enough.as_micros() as f64 * 1e-6);
            self.tell_legs();
            let has_fed = feed(feeders, self.legs, enough);
            if has_fed && feeders.iter().any(|feeder| feeder.is_wanting(passed + HUNGRY)) {
                // What is known comes first: were it fed too late, the ports would run dry.
                continue;
            }
            self.follow(start, now, feeders);
            // One at a time: planning it takes long, and what is known is to be fed meanwhile.
            let has_taken = self.take_next(purpose);
            if has_told || has_fed || has_taken {
                yield_now().await;
            } else {
                self.wait(feeders, passed, enough).await;
            }
        }
    }

    /// Has the chain tell of its path until then, as far as there is room for it; false if there was nothing to do.
    fn tell_until(&mut self, until_s: f64) -> bool {
        let mut has_told = false;
        while !self.legs.is_closed() && self.legs.has_room() && self.legs.end_s() <= until_s {
            has_told = true;
            if self.is_curved && self.legs.last().is_some() && self.chain.is_at_rest() {
                // Near standstill compiling is slow: what follows is got ready before it starts.
                self.legs.close();
                break;
            }
            match self.chain.advance(TOLD.as_micros() as f64 * 1e-6) {
                Some(leg) => {
                    if leg.kind != LegKind::Further {
                        self.untold += 1;
                    }
                    self.legs.push(leg);
                }
                None => self.legs.close(),
            }
        }
        has_told
    }

    /// Tells of the legs that have been added.
    fn tell_legs(&mut self) {
        let known = self.legs.iter().count();
        for index in known - self.untold.min(known)..known {
            let Some(leg) = self.legs.iter().nth(index) else { break };
            let plan = leg.part;
            let event = if leg.kind == LegKind::Move { Event::Move { plan } } else { Event::Part { plan } };
            self.tell(event);
        }
        self.untold = 0;
    }

    /// Passes on to the chain what has been asked for.
    fn obey(&mut self, purpose: Purpose) {
        if purpose == Purpose::Homing || self.chain.is_held() {
            return;
        }
        if self.machine.is_to_brake() {
            self.chain.hold();
        } else if self.is_overridden(purpose) {
            self.override_chain(purpose);
        }
    }

    /// Says what is under way, and forgets what is over.
    fn follow(&mut self, start: Instant, now: Instant, feeders: &Feeders<'_>) {
        let now_s = now.saturating_duration_since(start).as_micros() as f64 * 1e-6;
        let fed = feeders.iter().map(Feeder::leg).min().unwrap_or(0);
        self.legs.forget(fed, now_s);
        let leg = self.legs.iter().find(|leg| leg.until_s > now_s).or(self.legs.last()).copied();
        self.machine.set_underway(leg.map(|leg| Underway { start, leg }));
    }

    /// Waits for something to do.
    async fn wait(&self, feeders: &Feeders<'_>, passed: Duration, enough: Duration) {
        let machine = self.machine;
        let takes = self.takes();
        // Of the others nothing is known to give.
        let waits = feeders.each_ref().map(|feeder| feeder.is_wanting(enough) && feeder.queue().is_full());
        // Where no more is known for want of room, there is some when part of it has been made.
        let is_short = !self.legs.is_closed() && self.legs.end_s() * 1e6 < enough.as_micros() as f64;
        let is_hungry = feeders.iter().any(|feeder| feeder.is_wanting(passed + HUNGRY));
        let look_again = if is_short || is_hungry { LOOK_AGAIN } else { PIECE };
        let has_room = poll_fn(|context| {
            let waiting = feeders.iter().zip(waits).filter(|(_, waits)| *waits);
            // Each is to wake this task.
            let rooms = waiting.filter(|(feeder, _)| feeder.queue().poll_ready_to_send(context).is_ready()).count();
            if rooms > 0 || takes && machine.poll_motion(context).is_ready() { Poll::Ready(()) } else { Poll::Pending }
        });
        // Not at an instant reckoned from a step's: it would be another step's, again and again.
        let _ = with_timeout(look_again, select(has_room, machine.wait_asked())).await;
    }

    fn end_run(&mut self, finish: Finish) -> Finish {
        self.machine.set_underway(None);
        let position_steps = self.machine.position_steps();
        let (held_at_steps, plan_s) = self.legs.last().map_or((0.0, 0.0), |leg| (leg.until_steps, leg.until_s));
        self.tell(Event::RunEnd { finish, held_at_steps, plan_s, position_steps });
        finish
    }
}

/// `t_s` from the start of a run, to the next whole microsecond.
fn instant(start: Instant, t_s: f64) -> Instant {
    start + Duration::from_micros(libm::ceil(t_s * 1e6) as u64)
}
