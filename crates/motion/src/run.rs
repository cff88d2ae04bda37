//! One move: planned, compiled ahead of time, all axes started together; held, resumed, and changed in speed.
//!
//! # Design
//! A run is what the axes do from standstill to standstill. It begins with one plan; a hold or another override has it go
//! on by other parts of the same path ([`SyncMove::held`], [`SyncMove::respeeded`]) from an instant on up to which every
//! port has been fed, or will be in time: nothing that was given is taken back. A hold ends the run; what is left of the
//! path is another.
//!
//! A run starts when every port is armed and the last run's plan is over, whichever comes later. So the last half step of
//! a plan, in which no edge falls, is not cut off, and the next run gets ready in it.
//!
//! Planning and compiling a change takes time, milliseconds an axis under a curved law, in which nothing is fed. So one
//! waits until the one before it has been fed and every port has enough to go on with; what is asked for meanwhile is one
//! change.

use core::cell::Cell;
use core::convert::Infallible;
use core::pin::pin;

use embassy_futures::select::{Either, select};
use embassy_futures::yield_now;
use embassy_time::{Duration, Instant, Timer};
use embedded_hal::digital::OutputPin;
use isostep_profile::replan::Parts;
use isostep_profile::{Limits, PlanError, SPEED_MIN_STEPS_S, SyncMove};

use crate::axes::{AXES, Axis};
use crate::config::Config;
use crate::coordinator::{Coordinator, all_armed, all_done, alongside, begun};
use crate::event::{Alarm, Event, Finish};
use crate::feeder::{AHEAD, Feeder, Progress, feed};
use crate::legs::{Fed, Leg, Legs};
use crate::machine::{Machine, Overrides, Underway};
use crate::port::Run;

/// Motion compiled per axis before a move starts, as far as there is room: near standstill compiling is slowest against
/// moving.
const COMPILED_BEFORE_START: Duration = Duration::from_millis(20);

/// From a change to the instant from which on it holds, at least: time to plan and compile in. A port with so much to go
/// on with has enough; so has one whose queue is full.
const CHANGE_LEAD: Duration = Duration::from_millis(20);

/// What a move is for: that decides what changes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// A program: it is held, and its speed overridden.
    Program,
    /// A jog: it is cancelled.
    Jog,
    /// Homing: nothing.
    Homing,
}

/// What a move is planned by.
struct Terms {
    config: Config,
    /// Path length of a step of the longest axis.
    mm_per_step: f64,
    feed_mm_s: Option<f64>,
    purpose: Purpose,
    /// Those it is planned by now.
    overrides: Overrides,
}

/// How a run goes on otherwise.
struct Change {
    /// The leg that is cut.
    index: usize,
    /// Where, and when.
    until_steps: f64,
    until_s: f64,
    /// What it goes on by.
    parts: Parts<AXES>,
    is_braking: bool,
}

impl<E, F> Coordinator<'_, E, F>
where
    E: OutputPin<Error = Infallible>,
    F: FnMut(Event),
{
    /// Moves by signed `steps` and returns when every axis has answered. A halt is not an error here: homing halts
    /// on purpose. Of a move held and not resumed the rest is forgotten.
    pub(crate) async fn travel(
        &mut self,
        steps: [i32; AXES],
        feed_mm_s: Option<f64>,
        purpose: Purpose,
    ) -> Result<Finish, Alarm> {
        let config = self.machine.config();
        let mm_squared = |i: usize| {
            let mm = f64::from(steps[i]) / config.steps_per_mm[i];
            mm * mm
        };
        let path_mm = libm::sqrt((0..AXES).map(mm_squared).sum());
        let longest = steps.iter().map(|n| n.unsigned_abs()).max().unwrap_or(0);
        let mm_per_step = path_mm / f64::from(longest);
        let mut terms = Terms { config, mm_per_step, feed_mm_s, purpose, overrides: self.overrides(purpose) };
        let Config { interval_law, speed_law, .. } = config;
        let mut plan =
            terms.plan(|limits, speed| SyncMove::plan(steps, limits, interval_law, speed_law, speed).map(Some))?;
        while let Some(whole) = plan {
            self.machine.set_moving(true);
            let (finish, place_steps) = self.run(&mut terms, whole).await;
            self.machine.set_moving(false);
            if finish != Finish::Held || !self.machine.outlast_hold().await {
                return Ok(finish);
            }
            terms.overrides = self.overrides(purpose);
            plan = terms.plan(|limits, speed| whole.resumed(place_steps, limits, interval_law, speed_law, speed))?;
        }
        Ok(Finish::Done)
    }

    fn overrides(&self, purpose: Purpose) -> Overrides {
        if purpose == Purpose::Program { self.machine.overrides() } else { Overrides::NONE }
    }

    /// Runs `plan` to its end, or to where it is held: how it ended, and where on the path, steps of the longest axis.
    async fn run(&mut self, terms: &mut Terms, plan: SyncMove<AXES>) -> (Finish, f64) {
        self.energise(true);
        let machine = self.machine;
        let origin_steps = machine.position_steps();
        let numbers = Axis::ALL.map(|axis| plan.step_numbers(axis as usize));
        let moving = numbers.clone().map(|numbers| !numbers.is_empty());
        let fed = numbers.map(|numbers| Cell::new(Fed { steps: numbers.start - 1, until_us: 0 }));
        let mut legs = Legs::new(plan);
        let mut feeders = Axis::ALL.map(|axis| Feeder::new(machine, axis, &fed[axis as usize]));
        for axis in Axis::ALL {
            machine.ready(axis);
        }
        prepare(&mut feeders, &legs).await;
        if machine.cause().is_some() {
            // Stopped before it started. A stop after this check finds its halt signal standing.
            return (self.end_move(Finish::Stopped, End::NONE), 0.0);
        }
        self.arm_axes(moving);
        let mut done = pin!(all_done(machine, moving));
        let starting = start(machine, moving, self.standstill, &mut feeders, &legs);
        // It comes first: a short run may have ended before this task gets to know of its start.
        let start = match select(starting, done.as_mut()).await {
            Either::First(start) => start,
            Either::Second(finish) => return (self.end_move(finish, End::NONE), 0.0),
        };
        self.tell(Event::Move { start, plan, origin_steps });
        let progress = Progress::new();
        let mut is_braking = false;
        let mut end = End { steps: plan.end_steps(), s: plan.end_s() };
        loop {
            let feeding = feed(&mut feeders, legs.all(), start, &progress);
            let following = follow(machine, legs.all(), start, terms.mm_per_step);
            let asked = async {
                machine.wait_asked().await;
                while !is_ready(machine, &plan, &legs, &fed, start) {
                    progress.wait().await;
                }
            };
            let asked = alongside(alongside(asked, feeding), following);
            if let Either::First(finish) = select(done.as_mut(), asked).await {
                if finish == Finish::Done {
                    self.standstill = instant(start, end.s);
                }
                let finish = match finish {
                    // It stands still only some time after its last step.
                    Finish::Done if is_braking && machine.is_stopped_before(self.standstill).await => Finish::Stopped,
                    Finish::Done if is_braking => Finish::Held,
                    _ => finish,
                };
                return (self.end_move(finish, end), end.steps);
            }
            if terms.purpose == Purpose::Homing || is_braking {
                continue;
            }
            let Some(change) = self.change(terms, legs.all(), at_s(start, &fed)) else { continue };
            is_braking = change.is_braking;
            end = self.apply(&mut legs, change, &fed, &mut feeders);
        }
    }

    /// How the legs go on otherwise from `at_s` on, if that is asked for and they do not brake by then anyway.
    fn change(&mut self, terms: &mut Terms, legs: &[Leg], mut at_s: f64) -> Option<Change> {
        let (is_braking, overrides) = (self.machine.is_to_brake(), self.overrides(terms.purpose));
        if !is_braking && overrides == terms.overrides {
            return None;
        }
        terms.overrides = overrides;
        let speed_law = terms.config.speed_law;
        for (index, leg) in legs.iter().enumerate() {
            if leg.until_s <= at_s {
                continue;
            }
            if index == 0 {
                // Those before it are gone as soon as no step of theirs is to be fed: it may begin later.
                at_s = at_s.max(leg.part.begin_s());
            }
            let changed = if is_braking {
                // By its own limits: a rapid override is no reason to brake less.
                leg.part.held(at_s, &terms.config.limits, speed_law).map_err(unplannable)
            } else {
                terms.plan(|limits, speed| leg.part.respeeded(at_s, limits, speed_law, speed))
            };
            // What cannot be planned otherwise goes on as it is.
            if let Some(parts) = changed.ok()? {
                let first = parts.iter().flatten().next();
                let until_steps = first.map_or_else(|| leg.part.place_at(at_s), SyncMove::begin_steps);
                return Some(Change { index, until_steps, until_s: at_s, parts, is_braking });
            }
            // It brakes by then, to the end or to what comes next.
            at_s = leg.until_s;
        }
        None
    }

    /// Changes the legs that an axis has still to be fed with; where and when the path ends then.
    fn apply(
        &mut self,
        legs: &mut Legs,
        change: Change,
        fed: &[Cell<Fed>; AXES],
        feeders: &mut [Feeder<'_>; AXES],
    ) -> End {
        legs.cut(change.index, change.until_steps, change.until_s);
        for feeder in feeders.iter_mut() {
            feeder.cut(legs.all(), change.index);
        }
        let gone = legs.forget_fed(fed);
        for feeder in feeders {
            feeder.forget(gone);
        }
        let mut end = End { steps: change.until_steps, s: change.until_s };
        for part in change.parts.into_iter().flatten() {
            self.tell(Event::Part { plan: part });
            legs.push(part);
            end = End { steps: part.end_steps(), s: part.end_s() };
        }
        end
    }

    fn arm_axes(&self, moving: [bool; AXES]) {
        let wiring = self.machine.config().wiring;
        for axis in Axis::ALL {
            if moving[axis as usize] {
                self.machine.link(axis).run.signal(Run { wiring: wiring[axis as usize] });
            }
        }
    }

    fn end_move(&mut self, finish: Finish, end: End) -> Finish {
        self.machine.set_underway(None);
        let position_steps = self.machine.position_steps();
        self.tell(Event::MoveEnd { finish, held_at_steps: end.steps, plan_s: end.s, position_steps });
        finish
    }
}

impl Terms {
    /// What `plan` makes of the limits and the path speed, overridden.
    fn plan<T>(&self, plan: impl FnOnce(&[Limits; AXES], Option<f64>) -> Result<T, PlanError>) -> Result<T, Alarm> {
        let share = |percent: u8| f64::from(percent) / 100.0;
        let path_speed = self.feed_mm_s.map(|mm_s| {
            let asked = mm_s / self.mm_per_step;
            // A feed that can be planned does not become too slow by an override.
            (asked * share(self.overrides.feed_percent)).max(asked.min(SPEED_MIN_STEPS_S))
        });
        let mut limits = self.config.limits;
        if self.feed_mm_s.is_none() && self.overrides.rapid_percent != 100 {
            for own in &mut limits {
                own.top_speed_steps_s *= share(self.overrides.rapid_percent);
                own.start_speed_steps_s = own.start_speed_steps_s.min(own.top_speed_steps_s);
            }
        }
        plan(&limits, path_speed).map_err(unplannable)
    }
}

fn unplannable(error: PlanError) -> Alarm {
    Alarm::Unplannable { reason: error.into() }
}

/// Where and when the path of a run ends.
#[derive(Clone, Copy)]
struct End {
    /// Steps of the longest axis from the beginning of the whole move.
    steps: f64,
    /// From the start of the run, s.
    s: f64,
}

impl End {
    /// Of a run that has not started.
    const NONE: Self = Self { steps: 0.0, s: 0.0 };
}

/// Starts the moving axes, which have been told of their run, once all are armed and it is time: the instant that their
/// segments count from.
async fn start(
    machine: &Machine,
    moving: [bool; AXES],
    not_before: Instant,
    feeders: &mut [Feeder<'_>; AXES],
    legs: &Legs,
) -> Instant {
    all_armed(machine, moving).await;
    // In place of what the ports have taken.
    prepare(feeders, legs).await;
    Timer::at(not_before).await;
    machine.let_go(moving);
    begun(machine, moving).await
}

/// Compiles and queues the first steps of all axes, as far as there is room.
async fn prepare(feeders: &mut [Feeder<'_>; AXES], legs: &Legs) {
    for feeder in feeders {
        feeder.prepare(legs.all(), COMPILED_BEFORE_START);
        yield_now().await;
    }
}

/// Tells the machine what is under way, leg by leg, for its status.
async fn follow(machine: &Machine, legs: &[Leg], start: Instant, mm_per_step: f64) {
    let mut begin = start;
    for leg in legs {
        Timer::at(begin).await;
        machine.set_underway(Some(Underway { start, part: leg.part, mm_per_step }));
        begin = instant(start, leg.until_s);
    }
}

/// `t_s` from the start of a run, to the next whole microsecond.
fn instant(start: Instant, t_s: f64) -> Instant {
    start + Duration::from_micros(libm::ceil(t_s * 1e6) as u64)
}

/// Whether the run can be changed: the change before has been fed, and every axis has enough to go on with meanwhile.
fn is_ready(machine: &Machine, plan: &SyncMove<AXES>, legs: &Legs, fed: &[Cell<Fed>; AXES], start: Instant) -> bool {
    let enough = Instant::now() + AHEAD;
    let has_enough = |axis| {
        has_all(plan, fed, axis)
            || start + Duration::from_micros(fed[axis as usize].get().until_us) >= enough
            || machine.link(axis).segments.is_full()
    };
    legs.are_old_fed(fed) && Axis::ALL.into_iter().all(has_enough)
}

/// Whether the axis has been fed with all its steps.
fn has_all(plan: &SyncMove<AXES>, fed: &[Cell<Fed>; AXES], axis: Axis) -> bool {
    fed[axis as usize].get().steps == plan.steps[axis as usize].unsigned_abs()
}

/// From when on a run that began at `start` can go on otherwise, s from its start: all that was given is made by then.
fn at_s(start: Instant, fed: &[Cell<Fed>; AXES]) -> f64 {
    let fed_us = fed.iter().map(|fed| fed.get().until_us).max().unwrap_or(0);
    let soonest_us = (Instant::now() + CHANGE_LEAD).saturating_duration_since(start).as_micros();
    // A microsecond later, since the ports' ticks are finer.
    (fed_us.max(soonest_us) + 1) as f64 * 1e-6
}
