//! What the tasks of one machine share.

use core::cell::RefCell;
use core::sync::atomic::{AtomicBool, Ordering};

use embassy_futures::select::select;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_sync::signal::Signal;
use embassy_sync::watch::{DynReceiver, Watch};
use embassy_time::{Duration, Instant, Timer};
use isostep_profile::SyncMove;

use crate::axes::{AXES, Axis};
use crate::config::{Config, ConfigError};
use crate::event::{Alarm, State};
use crate::link::AxisLink;
use crate::port::{Capabilities, StepPort};

/// Motions that wait behind the one under way: Grbl's planner has as many blocks.
pub const QUEUE_MOVES: usize = 15;
/// Tasks that may watch the state at once.
const WATCHERS: usize = 8;

/// One thing to do, in the order asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Go to a place in a straight line.
    Move {
        /// The place, steps.
        target_steps: [i32; AXES],
        /// Speed along the path, mm/s; `None` is as fast as the limits allow.
        feed_mm_s: Option<f64>,
    },
    /// Go to a place at a speed along the path, mm/s, by hand: it may be cancelled.
    Jog {
        /// The place, steps.
        target_steps: [i32; AXES],
        /// Speed along the path, mm/s.
        feed_mm_s: f64,
    },
    /// Stand still.
    Dwell(Duration),
    /// Find the zero of every axis.
    Home,
}

/// What the machine would say if asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Status {
    /// What it is doing.
    pub state: State,
    /// Where each axis stands, steps: the exact count of emitted edges.
    pub position_steps: [i32; AXES],
    /// Which switches are pressed, debounced.
    pub pressed: [bool; AXES],
    /// Whether the emergency stop is pressed.
    pub emergency_stop: bool,
    /// Which axes have been homed and not lost their position since.
    pub homed: [bool; AXES],
    /// Motions that can be asked for without waiting.
    pub queue_free: usize,
    /// Speed along the path at this instant, mm/s.
    pub speed_mm_s: f64,
}

/// How fast to move, of what is asked for; never faster than the limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overrides {
    /// Of a feed, percent, above 0.
    pub feed_percent: u8,
    /// Of the limits' speed where no feed was asked for, percent, 1 to 100.
    pub rapid_percent: u8,
}

impl Overrides {
    /// As asked for.
    pub const NONE: Self = Self { feed_percent: 100, rapid_percent: 100 };
}

/// The machine is locked by an alarm, or not idle where it must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Busy(pub State);

/// Why everything was stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cause {
    Reset,
    Limit(Axis),
    EmergencyStop,
}

impl Cause {
    /// What it means when it stopped a machine in `state`.
    pub fn alarm(self, state: State) -> Alarm {
        match (self, state) {
            (Self::Limit(axis), _) => Alarm::HardLimit { axis },
            (Self::EmergencyStop, _) => Alarm::EmergencyStop,
            (Self::Reset, State::Home) => Alarm::HomingReset,
            (Self::Reset, _) => Alarm::ResetInMotion,
        }
    }
}

/// The move under way, for [`Status::speed_mm_s`].
#[derive(Clone, Copy)]
pub(crate) struct Underway {
    pub start: Instant,
    pub part: SyncMove<AXES>,
    /// Path length of one step of the master axis.
    pub mm_per_step: f64,
}

struct Inner {
    config: Config,
    capabilities: [Option<Capabilities>; AXES],
    faults: [u32; AXES],
    homed: [bool; AXES],
    cause: Option<Cause>,
    emergency: bool,
    underway: Option<Underway>,
    /// Motions asked for and not finished.
    pending: usize,
    overrides: Overrides,
    /// Nothing moves until [`Machine::resume`].
    held: bool,
    /// Jogs asked for are to be forgotten.
    cancelled: bool,
}

/// A limit switch, debounced.
pub(crate) struct Switch {
    pressed: AtomicBool,
    changed: Signal<CriticalSectionRawMutex, ()>,
}

/// What the tasks of one machine share. Everyone holds a `&Machine`; nobody holds a lock across an await.
pub struct Machine {
    links: [AxisLink; AXES],
    switches: [Switch; AXES],
    queue: Channel<CriticalSectionRawMutex, Motion, QUEUE_MOVES>,
    state: Watch<CriticalSectionRawMutex, State, WATCHERS>,
    /// Wakes the coordinator from a wait that no axis ends.
    stopped: Signal<CriticalSectionRawMutex, ()>,
    /// Tells it of a hold, a resume, or other overrides.
    asked: Signal<CriticalSectionRawMutex, ()>,
    inner: Mutex<CriticalSectionRawMutex, RefCell<Inner>>,
}

impl Machine {
    /// A machine at rest at zero, not homed.
    #[must_use]
    pub const fn new(config: Config) -> Self {
        Self {
            links: [const { AxisLink::new() }; AXES],
            switches: [const { Switch { pressed: AtomicBool::new(false), changed: Signal::new() } }; AXES],
            queue: Channel::new(),
            state: Watch::new_with(State::Idle),
            stopped: Signal::new(),
            asked: Signal::new(),
            inner: Mutex::new(RefCell::new(Inner {
                config,
                capabilities: [None; AXES],
                faults: [0; AXES],
                homed: [false; AXES],
                cause: None,
                emergency: false,
                underway: None,
                pending: 0,
                overrides: Overrides::NONE,
                held: false,
                cancelled: false,
            })),
        }
    }

    /// The present configuration.
    #[must_use]
    pub fn config(&self) -> Config {
        self.with(|inner| inner.config)
    }

    /// Takes a new configuration; moves that wait will be planned with it, so ask while idle.
    ///
    /// # Errors
    /// What cannot work is refused and nothing changes.
    pub fn configure(&self, config: Config) -> Result<(), ConfigError> {
        config.check(self.capabilities())?;
        self.with(|inner| inner.config = config);
        Ok(())
    }

    /// What each axis's port can do; `None` until its task has run.
    #[must_use]
    pub fn capabilities(&self) -> [Option<Capabilities>; AXES] {
        self.with(|inner| inner.capabilities)
    }

    /// How often each axis's port has faulted since power-up.
    #[must_use]
    pub fn faults(&self) -> [u32; AXES] {
        self.with(|inner| inner.faults)
    }

    /// What it is doing, where, and how fast.
    #[must_use]
    pub fn status(&self) -> Status {
        let (homed, emergency_stop, underway) = self.with(|inner| (inner.homed, inner.emergency, inner.underway));
        let speed_mm_s = underway.map_or(0.0, |underway| {
            let t_us = Instant::now().saturating_duration_since(underway.start).as_micros();
            // A part is known a little before it begins.
            underway.part.speed_at((t_us as f64 * 1e-6).max(underway.part.begin_s())) * underway.mm_per_step
        });
        Status {
            state: self.state(),
            position_steps: self.position_steps(),
            pressed: Axis::ALL.map(|axis| self.switch(axis).is_pressed()),
            emergency_stop,
            homed,
            queue_free: self.queue.free_capacity(),
            speed_mm_s,
        }
    }

    /// What it is doing.
    #[must_use]
    pub fn state(&self) -> State {
        self.state.try_get().unwrap_or(State::Idle)
    }

    /// Tells of every change of state from now on; `None` when too many watch already.
    #[must_use]
    pub fn watch_state(&self) -> Option<DynReceiver<'_, State>> {
        self.state.dyn_receiver()
    }

    /// Where each axis stands, steps.
    #[must_use]
    pub fn position_steps(&self) -> [i32; AXES] {
        Axis::ALL.map(|axis| self.link(axis).odometer.position_steps())
    }

    /// Asks for a motion; waits while the queue is full.
    ///
    /// # Errors
    /// In alarm nothing but homing is taken, and not even that while the emergency stop is pressed. While it jogs, only
    /// jogs are.
    ///
    /// # Cancellation
    /// Safe: the motion is either in the queue or was never asked for.
    pub async fn submit(&self, motion: Motion) -> Result<(), Busy> {
        self.transition(|inner, state| {
            if matches!(state, State::Alarm(_)) && (motion != Motion::Home || inner.emergency) {
                return (state, Err(Busy(state)));
            }
            if (state == State::Jog) != matches!(motion, Motion::Jog { .. }) && state != State::Idle {
                return (state, Err(Busy(state)));
            }
            inner.pending += 1;
            let next = match (state, motion) {
                (State::Idle | State::Alarm(_), Motion::Home) => State::Home,
                (State::Idle, Motion::Jog { .. }) => State::Jog,
                (State::Idle, _) => State::Run,
                _ => state,
            };
            (next, Ok(()))
        })?;
        let mut place = Place { machine: self, taken: false };
        self.queue.send(motion).await;
        place.taken = true;
        Ok(())
    }

    /// Waits until nothing is under way: idle, or an alarm, which is returned as the error. A hold is under way.
    ///
    /// # Errors
    /// The alarm the machine is in.
    ///
    /// # Cancellation
    /// Safe: it only looks.
    pub async fn settled(&self) -> Result<(), Alarm> {
        let mut states = self.state.dyn_receiver();
        while !matches!(self.state(), State::Idle | State::Alarm(_)) {
            match &mut states {
                Some(states) => _ = states.changed().await,
                // More tasks watch than the machine has room for: look instead.
                None => Timer::after_millis(1).await,
            }
        }
        match self.state() {
            State::Alarm(alarm) => Err(alarm),
            _ => Ok(()),
        }
    }

    /// Stops everything within one pulse and forgets what waits. At rest it does nothing; in motion the stop is
    /// abrupt, so an alarm says that the position is not trusted.
    pub fn reset(&self) {
        self.stop(Cause::Reset);
    }

    /// Brakes the move under way, on its path, and holds what waits until [`resume`](Self::resume): some 60 ms after this
    /// it brakes as fast as the limits allow. A jog is cancelled instead. Homing goes on; nothing to do in an alarm.
    pub fn hold(&self) {
        self.transition(|inner, state| {
            inner.held |= matches!(state, State::Idle | State::Run);
            inner.cancelled |= state == State::Jog;
            match state {
                State::Idle => (State::Hold { still: true }, ()),
                State::Run => (State::Hold { still: false }, ()),
                _ => (state, ()),
            }
        });
        self.asked.signal(());
    }

    /// Goes on after a [`hold`](Self::hold), once the machine stands still.
    pub fn resume(&self) {
        self.transition(|inner, state| match state {
            State::Hold { still: true } => {
                inner.held = false;
                (if inner.pending == 0 { State::Idle } else { State::Run }, ())
            }
            _ => (state, ()),
        });
        self.asked.signal(());
    }

    /// Brakes a jog on its path, and forgets the jogs that wait. Nothing to do in any other state.
    pub fn cancel_jog(&self) {
        self.with(|inner| inner.cancelled |= self.state() == State::Jog);
        self.asked.signal(());
    }

    /// Changes the speed of moves, the one under way included, some 60 ms after this.
    pub fn set_overrides(&self, overrides: Overrides) {
        self.with(|inner| inner.overrides = overrides);
        self.asked.signal(());
    }

    /// The overrides in force.
    #[must_use]
    pub fn overrides(&self) -> Overrides {
        self.with(|inner| inner.overrides)
    }

    /// Locks the machine, unless it is locked already. For what is found before anything moves.
    pub fn raise(&self, alarm: Alarm) {
        self.transition(|_, state| match state {
            State::Alarm(_) => (state, ()),
            _ => (State::Alarm(alarm), ()),
        });
    }

    /// Leaves an alarm; the position is as trusted as the alarm left it.
    ///
    /// # Errors
    /// While the emergency stop is pressed the alarm stands.
    pub fn unlock(&self) -> Result<(), Busy> {
        self.transition(|inner, state| match state {
            _ if inner.emergency => (state, Err(Busy(state))),
            State::Alarm(_) => (State::Idle, Ok(())),
            _ => (state, Ok(())),
        })
    }
}

/// For those who hear a switch before the tasks of [`limit`](crate::limit) do: an interrupt of the board's own.
impl Machine {
    /// A limit input has changed, and is low or high. The first edge of a press stops a running machine at once, if
    /// hard limits are on. Any number of times, from any context.
    pub fn limit_edge(&self, axis: Axis, is_low: bool) {
        let is_press = self.with(|inner| inner.config.hard_limits && is_low != inner.config.switches_inverted);
        // A switch that is pressed and being left bounces; that is no press.
        if is_press && !self.switch(axis).is_pressed() {
            self.stop(Cause::Limit(axis));
        }
    }

    /// The emergency-stop input has changed, and is low or high. The first edge of a press stops the machine at once.
    /// Any number of times, from any context.
    pub fn emergency_stop_edge(&self, is_low: bool) {
        if is_low {
            self.set_emergency(true);
        }
    }
}

/// For the tasks of this crate.
impl Machine {
    pub(crate) fn link(&self, axis: Axis) -> &AxisLink {
        &self.links[axis as usize]
    }

    pub(crate) fn switch(&self, axis: Axis) -> &Switch {
        &self.switches[axis as usize]
    }

    pub(crate) fn set_state(&self, state: State) {
        self.state.dyn_sender().send(state);
    }

    pub(crate) fn publish_port(&self, axis: Axis, port: &impl StepPort) {
        self.link(axis).fit(port.brake());
        self.with(|inner| inner.capabilities[axis as usize] = Some(port.capabilities()));
    }

    pub(crate) fn count_fault(&self, axis: Axis) {
        self.with(|inner| inner.faults[axis as usize] += 1);
    }

    /// The tick rate in which the axis's port reads segments, Hz.
    pub(crate) fn tick_hz(&self, axis: Axis) -> u32 {
        self.with(|inner| inner.capabilities[axis as usize].map_or(crate::TICK_HZ, |port| port.tick_hz))
    }

    pub(crate) fn set_underway(&self, underway: Option<Underway>) {
        self.with(|inner| inner.underway = underway);
    }

    pub(crate) fn set_homed(&self, axis: Axis, homed: bool) {
        self.with(|inner| inner.homed[axis as usize] = homed);
    }

    /// A stop asked for and not yet answered by the coordinator.
    pub(crate) fn cause(&self) -> Option<Cause> {
        self.with(|inner| inner.cause)
    }

    pub(crate) fn set_emergency(&self, pressed: bool) {
        self.with(|inner| inner.emergency = pressed);
        if pressed {
            self.stop(Cause::EmergencyStop);
        }
    }

    /// Whether the move under way is to brake.
    pub(crate) fn is_to_brake(&self) -> bool {
        self.with(|inner| inner.held || inner.cancelled)
    }

    /// Waits for a hold, a resume, or other overrides.
    pub(crate) async fn wait_asked(&self) {
        self.asked.wait().await;
    }

    /// Waits, standing still, until a hold is over; false if what was held is to be forgotten.
    pub(crate) async fn outlast_hold(&self) -> bool {
        self.transition(|inner, state| match state {
            State::Hold { .. } if inner.held => (State::Hold { still: true }, ()),
            _ => (state, ()),
        });
        loop {
            let (held, forgotten) = self.with(|inner| (inner.held, inner.cancelled || inner.cause.is_some()));
            if !held || forgotten {
                return !forgotten;
            }
            select(self.asked.wait(), self.stopped.wait()).await;
        }
    }

    /// The next motion asked for.
    pub(crate) async fn next_motion(&self) -> Motion {
        self.queue.receive().await
    }

    /// One motion less pending, without having been carried out.
    pub(crate) fn pass_over(&self) {
        self.transition(|inner, state| {
            inner.pending -= 1;
            (if matches!(state, State::Run | State::Jog) && inner.pending == 0 { State::Idle } else { state }, ())
        });
    }

    /// Stops the axes within one pulse. Safe at any priority.
    pub(crate) fn halt(&self) {
        for link in &self.links {
            link.brake(true);
        }
        for link in &self.links {
            link.halt.signal(());
        }
    }

    /// Makes an axis ready for its part of a move: nothing queued, no halt standing, the brake off.
    pub(crate) fn ready(&self, axis: Axis) {
        let link = self.link(axis);
        link.segments.clear();
        link.done.reset();
        link.halt.reset();
        link.brake(false);
    }

    /// Stops everything and says why; the first cause stands. A limit switch is what homing looks for.
    pub(crate) fn stop(&self, cause: Cause) {
        let moving = self.transition(|inner, state| match (state, cause) {
            (State::Home, Cause::Limit(_)) => (state, false),
            // Held with nothing to go on with.
            (State::Hold { .. }, Cause::Reset) if inner.pending == 0 => {
                inner.held = false;
                (State::Idle, false)
            }
            (State::Run | State::Jog | State::Home, _) => {
                inner.cause = inner.cause.or(Some(cause));
                (state, true)
            }
            (State::Hold { .. }, _) if inner.pending > 0 => {
                inner.cause = inner.cause.or(Some(cause));
                (state, true)
            }
            (State::Idle | State::Hold { .. }, Cause::EmergencyStop) => {
                inner.held = false;
                (State::Alarm(Alarm::EmergencyStop), false)
            }
            (State::Hold { .. }, _) => (state, false),
            (State::Idle | State::Alarm(_), _) => (state, false),
        });
        if moving {
            self.halt();
            self.stopped.signal(());
        }
    }

    /// What the machine is after a motion that ended with `result`, which no stop asked for meanwhile gets lost in.
    ///
    /// A stop that found nothing moving any more is judged here. After a reset the machine is ready, its position
    /// trusted; but its cause stands until every motion that waited has been passed over.
    pub(crate) fn conclude(&self, result: Result<(), Alarm>) -> State {
        self.transition(|inner, state| {
            inner.pending -= 1;
            let last = inner.pending == 0;
            let next = match (result, inner.cause) {
                (Err(alarm), _) => State::Alarm(alarm),
                // Pressed after a reset, whose cause stands.
                (Ok(()), _) if inner.emergency => State::Alarm(Alarm::EmergencyStop),
                (Ok(()), Some(cause @ (Cause::Limit(_) | Cause::EmergencyStop))) => State::Alarm(cause.alarm(state)),
                (Ok(()), None) if inner.held => State::Hold { still: true },
                (Ok(()), _) if last => State::Idle,
                (Ok(()), _) if state == State::Jog => State::Jog,
                (Ok(()), _) => State::Run,
            };
            if last || matches!(next, State::Alarm(_)) {
                inner.cause = None;
            }
            // A stop ends a hold; what was held is forgotten.
            inner.held &= matches!(next, State::Hold { .. });
            inner.cancelled &= next == State::Jog;
            // Nothing has moved that could not be planned; after any other alarm the motors may have overshot.
            if matches!(next, State::Alarm(alarm) if alarm != Alarm::Unplannable) {
                inner.homed = [false; AXES];
            }
            (next, next)
        })
    }

    pub(crate) async fn wait_stopped(&self) {
        self.stopped.wait().await;
    }

    pub(crate) fn forget_stopped(&self) {
        self.stopped.reset();
    }

    /// Changes the state, and what goes with it, in one critical section: a stop that came between looking and changing
    /// would be lost.
    fn transition<R>(&self, change: impl FnOnce(&mut Inner, State) -> (State, R)) -> R {
        self.with(|inner| {
            let state = self.state();
            let (next, result) = change(inner, state);
            if next != state {
                self.set_state(next);
            }
            result
        })
    }

    fn with<R>(&self, f: impl FnOnce(&mut Inner) -> R) -> R {
        self.inner.lock(|inner| f(&mut inner.borrow_mut()))
    }
}

/// A place in the queue that is given back if the motion never enters it.
struct Place<'a> {
    machine: &'a Machine,
    taken: bool,
}

impl Drop for Place<'_> {
    fn drop(&mut self) {
        if !self.taken {
            self.machine.pass_over();
        }
    }
}

impl Switch {
    pub fn is_pressed(&self) -> bool {
        self.pressed.load(Ordering::Relaxed)
    }

    pub fn publish(&self, pressed: bool) {
        self.pressed.store(pressed, Ordering::Relaxed);
        self.changed.signal(());
    }

    /// Waits until it is pressed. Only the coordinator waits.
    pub async fn wait_pressed(&self) {
        while !self.is_pressed() {
            self.changed.wait().await;
        }
    }
}
