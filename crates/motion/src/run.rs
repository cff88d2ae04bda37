//! One move: planned, compiled ahead of time, all axes started at one instant; held, resumed, and changed in speed.
//!
//! # Design
//! A run is what the axes do from standstill to standstill. It begins with one plan; a hold or another override has it go
//! on by other parts of the same path ([`SyncMove::held`], [`SyncMove::respeeded`]) from an instant on up to which every
//! port has been fed, or will be in time: nothing that was given is taken back. A hold ends the run; what is left of the
//! path is another.

use core::convert::Infallible;
use core::pin::pin;

use embassy_futures::join::join_array;
use embassy_futures::select::{Either3, select3};
use embassy_futures::yield_now;
use embassy_time::{Duration, Instant};
use embedded_hal::digital::OutputPin;
use isostep_profile::replan::Parts;
use isostep_profile::{Limits, PlanError, SyncMove};

use crate::axes::{AXES, Axis};
use crate::config::Config;
use crate::coordinator::{Coordinator, all_done, alongside};
use crate::event::{Alarm, Event, Finish};
use crate::feeder::{Fed, Feeder};
use crate::machine::{Overrides, Underway};
use crate::port::{Direction, Feed, Run};

/// From the start signal to instant zero of a move: the axis tasks wake, set DIR and wait out its set-up, and
/// ENABLE's (650 ns for a DRV8825), long before the first step.
const LEAD: Duration = Duration::from_micros(500);

/// Motion compiled per axis before a move starts, as far as the queue has room: time to fill the queues in. Of a curved
/// ramp the first segments take milliseconds each, so there it is a full queue mostly; more would only delay the start.
const COMPILED_BEFORE_START: Duration = Duration::from_millis(20);

/// From a wish to the instant from which on it holds, at least: time to plan and compile in.
const CHANGE_LEAD: Duration = Duration::from_millis(20);

/// Legs that a run may still have to go through: the one under way, and two changes' worth.
const PARTS: usize = 7;

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

/// A part of a move, and how far on the path it is made.
#[derive(Clone, Copy)]
struct Leg {
    part: SyncMove<AXES>,
    /// Steps of the longest axis from the beginning of the whole move.
    until_steps: f64,
    /// When that is, s from the start of the run.
    until_s: f64,
}

impl Leg {
    /// The whole part.
    fn new(part: SyncMove<AXES>) -> Self {
        Self { part, until_steps: part.end_steps(), until_s: part.end_s() }
    }
}

/// The legs of a run, in order; the first is under way.
type Legs = heapless::Deque<Leg, PARTS>;

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
            let (finish, place_steps) = self.run(&mut terms, whole).await;
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
        let ends = numbers.clone().map(|numbers| numbers.end - 1);
        let mut fed = numbers.map(|numbers| Fed { steps: numbers.start - 1, until_ticks: 0 });
        let mut legs = Legs::new();
        let _ = legs.push_back(Leg::new(plan));
        let (mut started, mut is_braking) = (None, false);
        let mut done = pin!(all_done(machine, moving));
        let mut end_steps = plan.end_steps();
        while let Some(&leg) = legs.front() {
            let mut feeders = Axis::ALL.map(|axis| Feeder::new(machine, axis, &leg.part, fed[axis as usize]));
            let start = match started {
                Some(start) => start,
                None => {
                    for (axis, feeder) in Axis::ALL.into_iter().zip(&mut feeders) {
                        machine.ready(axis);
                        feeder.prepare(COMPILED_BEFORE_START);
                        yield_now().await;
                    }
                    if machine.cause().is_some() {
                        // Stopped before it started. A stop after this check finds its halt signal standing.
                        return (self.end_move(Finish::Stopped), 0.0);
                    }
                    let start = Instant::now() + LEAD;
                    self.tell(Event::Move { start, plan, origin_steps });
                    self.start_axes(&plan, start);
                    *started.insert(start)
                }
            };
            machine.set_underway(Some(Underway { start, part: leg.part, mm_per_step: terms.mm_per_step }));
            loop {
                limit(&mut feeders, legs.front().unwrap_or(&leg));
                let [x, y, z] = &mut feeders;
                let feeding = join_array([x, y, z].map(|feeder| feeder.feed(start)));
                match select3(done.as_mut(), feeding, machine.wait_asked()).await {
                    Either3::First(finish) => return (self.end_move(finish), end_steps),
                    Either3::Second(_) => break,
                    Either3::Third(()) if terms.purpose != Purpose::Homing && !is_braking => {
                        is_braking = self.change(terms, &mut legs, at_s(start, &feeders));
                    }
                    Either3::Third(()) => {}
                }
            }
            fed = feeders.map(|feeder| feeder.fed());
            legs.pop_front();
            end_steps = leg.until_steps;
        }
        let ending = async {
            for axis in Axis::ALL {
                // No axis is told that has had all its steps: it may have ended.
                if is_braking && moving[axis as usize] && fed[axis as usize].steps < ends[axis as usize] {
                    machine.link(axis).segments.send(Feed::End).await;
                }
            }
        };
        let finish = match alongside(done, ending).await {
            Finish::Done if is_braking => Finish::Held,
            finish => finish,
        };
        (self.end_move(finish), end_steps)
    }

    /// Has the legs go on otherwise from `at_s` on, if that is asked for and they do not brake by then anyway; whether they
    /// brake now.
    fn change(&mut self, terms: &mut Terms, legs: &mut Legs, at_s: f64) -> bool {
        let (is_to_brake, overrides) = (self.machine.is_to_brake(), self.overrides(terms.purpose));
        if !is_to_brake && overrides == terms.overrides {
            return false;
        }
        terms.overrides = overrides;
        let Some(index) = legs.iter().position(|leg| leg.part.end_s() > at_s) else { return false };
        let Some(leg) = legs.iter().nth(index).copied() else { return false };
        let speed_law = terms.config.speed_law;
        let changed = if is_to_brake {
            // By its own limits: a rapid override is no reason to brake less.
            leg.part.held(at_s, &terms.config.limits, speed_law).map_err(|_| Alarm::Unplannable)
        } else {
            terms.plan(|limits, speed| leg.part.respeeded(at_s, limits, speed_law, speed))
        };
        // What cannot be planned otherwise goes on as it is.
        let Ok(Some(parts)) = changed else { return false };
        self.replace(legs, index, Leg { until_steps: leg.part.place_at(at_s), until_s: at_s, ..leg }, parts);
        is_to_brake
    }

    /// Has the leg with this index be `cut`, and goes on by `parts`.
    fn replace(&mut self, legs: &mut Legs, index: usize, cut: Leg, parts: Parts<AXES>) {
        while legs.len() > index {
            legs.pop_back();
        }
        let _ = legs.push_back(cut);
        for part in parts.into_iter().flatten() {
            self.tell(Event::Part { plan: part });
            let _ = legs.push_back(Leg::new(part));
        }
    }

    fn start_axes(&self, plan: &SyncMove<AXES>, start: Instant) {
        let wiring = self.machine.config().wiring;
        for axis in Axis::ALL {
            let numbers = plan.step_numbers(axis as usize);
            if !numbers.is_empty() {
                let (direction, wiring) = (Direction::of(plan.steps[axis as usize]), wiring[axis as usize]);
                let steps = numbers.end - numbers.start;
                self.machine.link(axis).run.signal(Run { start, direction, wiring, steps });
            }
        }
    }

    fn end_move(&mut self, finish: Finish) -> Finish {
        self.machine.set_underway(None);
        self.tell(Event::MoveEnd { finish, position_steps: self.machine.position_steps() });
        finish
    }
}

impl Terms {
    /// What `plan` makes of the limits and the path speed, overridden.
    fn plan<T>(&self, plan: impl FnOnce(&[Limits; AXES], Option<f64>) -> Result<T, PlanError>) -> Result<T, Alarm> {
        let share = |percent: u8| f64::from(percent) / 100.0;
        let path_speed = self.feed_mm_s.map(|mm_s| mm_s * share(self.overrides.feed_percent) / self.mm_per_step);
        let mut limits = self.config.limits;
        if self.feed_mm_s.is_none() && self.overrides.rapid_percent != 100 {
            for own in &mut limits {
                own.top_speed_steps_s *= share(self.overrides.rapid_percent);
                own.start_speed_steps_s = own.start_speed_steps_s.min(own.top_speed_steps_s);
            }
        }
        plan(&limits, path_speed).map_err(|_| Alarm::Unplannable)
    }
}

/// Has the feeders end where their leg does.
fn limit(feeders: &mut [Feeder<'_>; AXES], leg: &Leg) {
    for (axis, feeder) in feeders.iter_mut().enumerate() {
        feeder.end_with(leg.part.steps_before(axis, leg.until_steps), leg.until_s);
    }
}

/// From when on a run that began at `start` can go on otherwise, s from its start: all that was given is made by then.
fn at_s(start: Instant, feeders: &[Feeder<'_>; AXES]) -> f64 {
    let fed_us = feeders.iter().map(Feeder::fed_until_us).max().unwrap_or(0);
    let soonest_us = (Instant::now() + CHANGE_LEAD).saturating_duration_since(start).as_micros();
    // A microsecond later, since the ports' ticks are finer.
    (fed_us.max(soonest_us) + 1) as f64 * 1e-6
}
