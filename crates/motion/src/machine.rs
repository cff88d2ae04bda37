//! What the tasks of one machine share.

mod door;
mod hold;
mod life;
mod outputs;
mod probe;
mod stop;

use core::cell::RefCell;
use core::future::poll_fn;
use core::task::{Context, Poll};

use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_sync::signal::Signal;
use embassy_sync::watch::{DynReceiver, Watch};
use embassy_time::{Duration, Instant, Timer};
use isostep_profile::chain::Chunk;

pub use self::door::Door;
pub use self::hold::Overrides;
pub(crate) use self::life::Cause;
use self::life::{Kind, Life, Reaction, Trigger};
use self::outputs::{OutputsAsked, ToolLink};
use self::probe::Probe;
pub use self::probe::Probed;
use crate::axes::{AXES, Axis};
use crate::config::{Config, ConfigError};
use crate::event::{Alarm, State};
use crate::link::AxisLink;
use crate::motor::{LimitInput, Motor, Side};
use crate::port::{Capabilities, StepPort};
use crate::switch::{Contact, Switch};
use crate::tool::{Level, Outputs, Power, Tag};

/// How many moves are planned ahead, so that they follow each other without a stop.
pub(crate) const CHAIN_MOVES: usize = 64;
/// How many motions wait in the queue before the chain takes them. Grbl's planner has as many blocks in all.
const QUEUE_MOVES: usize = 15;
/// How many moves can be asked for at rest without waiting.
pub const MOVES_AHEAD: usize = CHAIN_MOVES + QUEUE_MOVES;
/// How many tasks may watch the state at once.
const WATCHERS: usize = 8;

/// A motion. Motions are carried out in the order in which they are asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Go to a place in a straight line.
    Move {
        /// The place, steps.
        target_steps: [i32; AXES],
        /// Speed along the path, mm/s; `None` is as fast as the limits allow.
        feed_mm_s: Option<f64>,
        /// It ends at rest, instead of flowing into the next move.
        exact_stop: bool,
        /// The program line that it comes from, for [`Status::line`]; 0 for none.
        line: u32,
        /// How strongly a laser shines meanwhile.
        power: Power,
    },
    /// Go to a place at a speed along the path, mm/s, by hand: it may be cancelled.
    Jog {
        /// The place, steps.
        target_steps: [i32; AXES],
        /// Speed along the path, mm/s.
        feed_mm_s: f64,
    },
    /// Go to a place until the probe finds what it looks for: see [`Machine::probed`].
    Probe(ProbeMove),
    /// Stand still.
    Dwell(Duration),
    /// Find the zero of these axes, one after the other in the configured order. In an alarm this unlocks the machine,
    /// and the other axes are as trusted as the alarm left them. If it fails, no axis is trusted.
    Home {
        /// Which.
        axes: [bool; AXES],
    },
}

impl Motion {
    fn kind(&self) -> Kind {
        match self {
            Self::Move { .. } | Self::Probe(_) | Self::Dwell(_) => Kind::Program,
            Self::Jog { .. } => Kind::Jog,
            Self::Home { .. } => Kind::Homing,
        }
    }
}

/// A straight move until the probe touches, or until it no longer touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeMove {
    /// Where it ends if the probe finds nothing, steps.
    pub target_steps: [i32; AXES],
    /// Speed along the path, mm/s.
    pub feed_mm_s: f64,
    /// It looks for the end of the contact.
    pub away: bool,
    /// Finding nothing is an alarm.
    pub must: bool,
    /// The program line that it comes from; 0 for none.
    pub line: u32,
}

/// The machine's status at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Status {
    /// What it is doing.
    pub state: State,
    /// Where each axis stands, steps: the exact count of emitted edges.
    pub position_steps: [i32; AXES],
    /// Which switches are pressed, debounced: each axis's first.
    pub pressed: [bool; AXES],
    /// The second motor's switch is pressed, if there is a second motor: the axis that it moves.
    pub second_pressed: Option<Axis>,
    /// Whether the emergency stop is pressed.
    pub emergency_stop: bool,
    /// Which axes have been homed and not lost their position since.
    pub homed: [bool; AXES],
    /// How many moves, or jogs, can be asked for without waiting: [`MOVES_AHEAD`] at most.
    pub queue_free: usize,
    /// Speed along the path at this instant, mm/s.
    pub speed_mm_s: f64,
    /// The line of the move under way; 0 for none.
    pub line: u32,
    /// What the outputs are; off where a hold or the safety door keeps them off.
    pub outputs: Outputs,
    /// The level that the PWM output has now, with the override applied.
    pub level: Level,
    /// The probe touches.
    pub probe_touches: bool,
    /// What the safety door has done.
    pub door: Door,
    /// The button of the feed hold, and that of the cycle start, are pressed, in this order.
    pub buttons: [bool; 2],
}

/// The machine is locked by an alarm, or not idle where it must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Busy(pub State);

/// The chunk under way, for [`Status`]; at most 15 ms out of date.
#[derive(Clone, Copy)]
pub(crate) struct CurrentChunk {
    pub start: Instant,
    pub chunk: Chunk<AXES>,
}

impl CurrentChunk {
    /// Speed along the path now, mm/s.
    fn speed_mm_s(&self) -> f64 {
        let Chunk { plan, mm_per_step, .. } = &self.chunk;
        let t_s = Instant::now().saturating_duration_since(self.start).as_micros() as f64 * 1e-6;
        // The chunk is known a little before it begins, and may have ended.
        plan.speed_at(t_s.max(plan.begin_s()).min(plan.end_s())) * mm_per_step
    }
}

struct Inner {
    config: Config,
    capabilities: [Option<Capabilities>; AXES],
    faults: [u32; AXES],
    homed: [bool; AXES],
    life: Life,
    current: Option<CurrentChunk>,
    /// How many motions the coordinator would take off the queue at once.
    room: usize,
    overrides: Overrides,
    outputs: OutputsAsked,
    probe: Probe,
    buttons: [bool; 2],
}

/// What the tasks of one machine share. Every task holds a `&Machine`; none holds a lock across an await.
pub struct Machine {
    links: [AxisLink; AXES],
    /// The limit switches, in the order of the axes, then the second motor's.
    switches: [Switch; AXES + 1],
    emergency_contact: Contact,
    queue: Channel<CriticalSectionRawMutex, Motion, QUEUE_MOVES>,
    state: Watch<CriticalSectionRawMutex, State, WATCHERS>,
    /// Wakes the coordinator from a wait that no axis ends.
    stopped: Signal<CriticalSectionRawMutex, ()>,
    /// Wakes the coordinator for a hold, a resume, or other overrides, and when more motions are asked for than there
    /// is room for.
    asked: Signal<CriticalSectionRawMutex, ()>,
    /// Has the coordinator free the motors.
    released: Signal<CriticalSectionRawMutex, ()>,
    /// Wakes the task that watches the emergency stop.
    emergency: Signal<CriticalSectionRawMutex, ()>,
    tool: ToolLink,
    inner: Mutex<CriticalSectionRawMutex, RefCell<Inner>>,
}

impl Machine {
    /// A machine at rest at zero, not homed, whose emergency stop has this contact.
    #[must_use]
    pub const fn new(config: Config, emergency_contact: Contact) -> Self {
        Self {
            links: [const { AxisLink::new() }; AXES],
            switches: [const { Switch::new() }; AXES + 1],
            emergency_contact,
            queue: Channel::new(),
            state: Watch::new_with(State::Idle),
            stopped: Signal::new(),
            asked: Signal::new(),
            released: Signal::new(),
            emergency: Signal::new(),
            tool: ToolLink::new(),
            inner: Mutex::new(RefCell::new(Inner {
                config,
                capabilities: [None; AXES],
                faults: [0; AXES],
                homed: [false; AXES],
                life: Life::new(),
                current: None,
                room: CHAIN_MOVES,
                overrides: Overrides::NONE,
                outputs: OutputsAsked::new(),
                probe: Probe::new(),
                buttons: [false; 2],
            })),
        }
    }

    /// The present configuration.
    #[must_use]
    pub fn config(&self) -> Config {
        self.with(|inner| inner.config)
    }

    /// Puts a new configuration in force. Waiting moves will be planned with it, so call this while idle. If an axis's
    /// direction, the side of its switch or its resolution changes, its positions mean other places, and it is not
    /// homed any more.
    ///
    /// # Errors
    /// A configuration that cannot work is refused, and nothing changes.
    pub fn configure(&self, config: Config) -> Result<(), ConfigError> {
        config.check(self.capabilities())?;
        let before = self.config();
        // Computed outside the critical section: this is called only while nothing moves, so no axis becomes homed
        // meanwhile.
        let keeps_places = Axis::ALL.map(|axis| config.has_places_of(&before, axis));
        self.with(|inner| {
            for axis in Axis::ALL {
                inner.homed[axis as usize] &= keeps_places[axis as usize];
            }
            inner.config = config;
        });
        self.reread_hold_input();
        Ok(())
    }

    /// What each axis's port can do; `None` until its task has run.
    #[must_use]
    pub fn capabilities(&self) -> [Option<Capabilities>; AXES] {
        self.with(|inner| inner.capabilities)
    }

    /// The contact of the emergency stop, which is the same for ever.
    #[must_use]
    pub fn emergency_contact(&self) -> Contact {
        self.emergency_contact
    }

    /// Which axes have been homed and not lost their position since.
    #[must_use]
    pub fn homed(&self) -> [bool; AXES] {
        self.with(|inner| inner.homed)
    }

    /// How often each axis's port has faulted since power-up.
    #[must_use]
    pub fn faults(&self) -> [u32; AXES] {
        self.with(|inner| inner.faults)
    }

    /// What the machine is doing, where it is, and how fast it moves.
    #[must_use]
    pub fn status(&self) -> Status {
        let (homed, emergency_stop, current) = self.with(|inner| (inner.homed, inner.life.emergency, inner.current));
        let room = self.with(|inner| if inner.life.is_to_brake() { 0 } else { inner.room });
        let (outputs, buttons, squared) = self.with(|inner| (inner.effective(), inner.buttons, inner.config.squared));
        Status {
            state: self.state(),
            position_steps: self.position_steps(),
            pressed: Axis::ALL.map(|axis| self.switch(LimitInput::Of(axis)).is_pressed()),
            second_pressed: squared
                .map(|squared| squared.axis)
                .filter(|_| self.switch(LimitInput::Second).is_pressed()),
            emergency_stop,
            homed,
            queue_free: self.queue_free() + room,
            speed_mm_s: current.map_or(0.0, |current| current.speed_mm_s()),
            line: current.map_or(0, |current| Tag::unpack(current.chunk.tag).line),
            outputs,
            level: self.tool.level(),
            probe_touches: self.probe_touches(),
            door: self.door(),
            buttons,
        }
    }

    /// What the machine is doing.
    #[must_use]
    #[inline(never)]
    pub fn state(&self) -> State {
        self.with(|inner| inner.life.state)
    }

    /// Reports every change of state from now on; `None` if too many tasks watch already.
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
    /// [`Busy`], if the machine does not take the motion now:
    /// - In an alarm it takes homing only, and not even that while the emergency stop is pressed, or before the motions
    ///   that waited when the alarm came have been passed over.
    /// - While it jogs it takes jogs only, and while it does anything else it takes no jog.
    /// - While the safety door is open it takes neither homing nor jogs. Other motions are taken, and wait for the
    ///   door.
    /// - While a reset brakes, or a cancelled jog, it takes nothing. A motion that waits for room at that time is
    ///   forgotten.
    ///
    /// # Cancellation
    /// Safe: the motion is either in the queue or was never asked for.
    pub async fn submit(&self, motion: Motion) -> Result<(), Busy> {
        let resets = self.with(|inner| match self.apply(inner, Trigger::Asked(motion.kind())) {
            Reaction::Refuse => Err(Busy(inner.life.state)),
            _ => Ok(inner.life.resets),
        })?;
        let mut place = QueueSlot { machine: self, taken: false };
        poll_fn(|context| self.poll_enqueue(context, motion)).await;
        place.taken = true;
        // If a reset came while the motion waited for room, the motion is forgotten.
        if self.with(|inner| inner.life.resets) == resets { Ok(()) } else { Err(Busy(self.state())) }
    }

    /// Frees the motors, as soon as nothing moves and no motion waits. The next motion energises them again. Nothing
    /// holds the axes then, so their positions are not trusted any more.
    // Not inlined: see `with`.
    #[inline(never)]
    pub fn release(&self) {
        self.released.signal(());
    }

    /// Waits until nothing is under way: until the machine is idle, or in an alarm, which is returned as the error. A
    /// hold counts as under way.
    ///
    /// # Errors
    /// The alarm the machine is in.
    ///
    /// # Cancellation
    /// Safe: it only reads the state.
    pub async fn settled(&self) -> Result<(), Alarm> {
        self.until(|inner| matches!(inner.life.state, State::Idle | State::Alarm(_))).await;
        match self.state() {
            State::Alarm(alarm) => Err(alarm),
            _ => Ok(()),
        }
    }

    /// Waits until no motion is under way or waits, or for an alarm. A hold without a motion counts as rest: it may
    /// never be resumed.
    ///
    /// # Cancellation
    /// Safe: it only reads the state.
    pub async fn emptied(&self) {
        self.until(|inner| inner.life.pending == 0 || inner.life.is_locked()).await;
    }

    async fn until(&self, wanted: impl Fn(&Inner) -> bool) {
        let mut states = self.state.dyn_receiver();
        while !self.with(|inner| wanted(inner)) {
            match &mut states {
                Some(states) => _ = states.changed().await,
                // More tasks watch than the machine has room for, so poll instead.
                None => Timer::after_millis(1).await,
            }
        }
    }
}

/// For the tasks of this crate.
impl Machine {
    pub(crate) fn link(&self, axis: Axis) -> &AxisLink {
        &self.links[axis as usize]
    }

    pub(crate) fn switch(&self, input: LimitInput) -> &Switch {
        match input {
            LimitInput::Of(axis) => &self.switches[axis as usize],
            LimitInput::Second => &self.switches[AXES],
        }
    }

    pub(crate) fn switch_of(&self, motor: Motor) -> &Switch {
        self.switch(match motor.side {
            Side::First => LimitInput::Of(motor.axis),
            Side::Second => LimitInput::Second,
        })
    }

    pub(crate) fn publish_port(&self, axis: Axis, port: &impl StepPort) {
        self.link(axis).fit(port.brake());
        self.with(|inner| inner.capabilities[axis as usize] = Some(port.capabilities()));
    }

    /// The tick rate of the segments that the axis's port reads, Hz.
    pub(crate) fn tick_hz(&self, axis: Axis) -> u32 {
        self.with(|inner| inner.capabilities[axis as usize].map_or(crate::TICK_HZ, |port| port.tick_hz))
    }

    pub(crate) fn set_current(&self, current: Option<CurrentChunk>) {
        self.with(|inner| inner.current = current);
    }

    /// Sets how many motions would be taken off the queue at once, if nothing is to brake.
    pub(crate) fn set_room(&self, room: usize) {
        self.with(|inner| inner.room = room);
    }

    pub(crate) fn set_homed(&self, axis: Axis, homed: bool) {
        self.with(|inner| inner.homed[axis as usize] = homed);
    }

    /// The next motion asked for.
    pub(crate) async fn next_motion(&self) -> Motion {
        self.queue.receive().await
    }

    /// The next motion asked for, if there is one. Not inlined: see [`with`](Self::with).
    #[inline(never)]
    pub(crate) fn try_motion(&self) -> Option<Motion> {
        self.queue.try_receive().ok()
    }

    /// Whether a motion waits; if none does, the caller is woken when there is one. Not inlined: see
    /// [`with`](Self::with).
    #[inline(never)]
    pub(crate) fn poll_motion(&self, context: &mut Context<'_>) -> Poll<()> {
        self.queue.poll_ready_to_receive(context)
    }

    /// Waits until the motors are to be freed.
    pub(crate) async fn wait_released(&self) {
        self.released.wait().await;
    }

    /// Takes one motion off those that are pending, without having carried it out.
    pub(crate) fn pass_over(&self) {
        self.on(Trigger::PassedOver);
    }

    /// Makes an axis ready for a run: nothing queued, no halt signalled, the brake off.
    pub(crate) fn ready(&self, axis: Axis) {
        let link = self.link(axis);
        link.segments.clear();
        link.done.reset();
        link.halt.reset();
        link.start_line.reset();
        link.brake(false);
    }

    /// Lets the axes of a run go, all of which are armed. The critical section makes sure that none of their tasks is
    /// polled before all have been let go.
    pub(crate) fn let_go(&self) {
        self.with(|_| {
            for axis in Axis::ALL {
                self.link(axis).start_line.go();
            }
        });
    }

    /// Puts a motion into the queue, or has the caller woken when there is room. Not inlined: see [`with`](Self::with).
    #[inline(never)]
    fn poll_enqueue(&self, context: &mut Context<'_>, motion: Motion) -> Poll<()> {
        loop {
            if self.queue.try_send(motion).is_ok() {
                return Poll::Ready(());
            }
            if self.queue.poll_ready_to_send(context).is_pending() {
                // The coordinator may wait a while to gather motions, but no more fit, so wake it.
                self.wake();
                return Poll::Pending;
            }
        }
    }

    /// Room in the queue. Not inlined: see [`with`](Self::with).
    #[inline(never)]
    fn queue_free(&self) -> usize {
        self.queue.free_capacity()
    }

    /// Whether no other motion can be asked for without waiting.
    pub(crate) fn is_crowded(&self) -> bool {
        self.queue.is_full()
    }

    /// Something has happened: the state changes, and what it leads to is done.
    fn on(&self, trigger: Trigger) {
        let reaction = self.with(|inner| self.apply(inner, trigger));
        self.react(reaction);
    }

    /// Does what a change of the state asks for, outside the critical section.
    fn react(&self, reaction: Reaction) {
        match reaction {
            Reaction::None | Reaction::Refuse | Reaction::Distrust => {}
            Reaction::Wake => self.wake(),
            Reaction::Halt => {
                // The steps are stopped first. Meanwhile the outputs stay as they are: nothing switches them on while
                // there is a cause.
                self.halt();
                self.cut();
                self.stopped.signal(());
            }
        }
    }

    /// Changes the state in one critical section with its condition: a stop that came between reading and changing the
    /// state would be lost. The tasks that watch the state are notified of a change, and also when nothing is pending
    /// any more; an alarm is notified only once. Not inlined, so that it is not copied into every caller.
    #[inline(never)]
    fn apply(&self, inner: &mut Inner, trigger: Trigger) -> Reaction {
        let before = inner.life;
        let reaction = inner.life.on(trigger);
        inner.rest_outputs();
        let Life { state, pending, .. } = inner.life;
        let (is_other, is_emptied) = (state != before.state, pending == 0 && before.pending > 0);
        if is_other || is_emptied && !inner.life.is_locked() {
            self.state.dyn_sender().send(state);
            self.tool.ask();
        }
        if is_other && inner.life.is_locked() {
            self.cut_outputs(inner);
        }
        if reaction == Reaction::Distrust {
            inner.homed = [false; AXES];
        }
        reaction
    }

    /// Calls `f` in a critical section. Not inlined: on a chip the caller's code may be in slow memory, and this
    /// crate's is not.
    #[inline(never)]
    fn with<R>(&self, f: impl FnOnce(&mut Inner) -> R) -> R {
        self.inner.lock(|inner| f(&mut inner.borrow_mut()))
    }
}

/// A place in the queue that is given back if the motion never enters it.
struct QueueSlot<'a> {
    machine: &'a Machine,
    taken: bool,
}

impl Drop for QueueSlot<'_> {
    fn drop(&mut self) {
        if !self.taken {
            self.machine.pass_over();
        }
    }
}
