//! The state that the tasks of one machine share.

mod armed;
mod door;
mod hold;
mod life;
mod outputs;
mod probe;
mod queue;
mod status;
mod stop;

use core::cell::RefCell;
use core::pin::pin;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_sync::signal::Signal;
use embassy_sync::watch::{DynReceiver, Watch};
use embassy_time::{Instant, Timer};

pub use self::door::Door;
pub use self::hold::SpeedOverrides;
pub(crate) use self::life::Cause;
use self::life::{Life, Reaction, Trigger};
use self::outputs::{OutputsAsked, ToolLink};
use self::probe::ProbeInput;
pub use self::probe::Probed;
use self::queue::QUEUE_MOVES;
pub use self::queue::{MOVES_AHEAD, Motion, Move, ProbeMove};
pub use self::status::Status;
pub(crate) use self::status::{CurrentChunk, path_speed_mm_s, plan_speed_steps_s};
use crate::axes::{AXES, Axis};
use crate::cold_path::cold_path;
use crate::config::{Config, ConfigError};
use crate::event::{Alarm, State};
use crate::link::AxisLink;
use crate::motor::{GangedMotor, LimitInput, Motor};
use crate::port::{Capabilities, StepPort};
use crate::switch::{Contact, Switch};

/// The number of moves that are planned ahead, so that they follow each other without a stop.
pub(crate) const CHAIN_MOVES: usize = if cfg!(feature = "short-look-ahead") { 32 } else { 64 };
/// The number of tasks that may watch the state at once.
const WATCHERS: usize = 8;

/// The machine is locked by an alarm, or not idle where it must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Busy(pub State);

struct Inner {
    config: Config,
    /// The edges of limit inputs that are presses: see `armed`.
    presses: u32,
    capabilities: [Option<Capabilities>; AXES],
    faults: [u32; AXES],
    homed: [bool; AXES],
    stalls_apart_steps: [i32; AXES],
    life: Life,
    current: Option<CurrentChunk>,
    /// The number of motions that the coordinator would take off the queue at once.
    room: usize,
    overrides: SpeedOverrides,
    outputs: OutputsAsked,
    probe: ProbeInput,
    buttons: [bool; 2],
}

/// The state that the tasks of one machine share. Every task holds a `&Machine`; none holds a lock across an await.
pub struct Machine {
    links: [AxisLink; AXES],
    /// The limit inputs, each in its place.
    switches: [Switch; LimitInput::COUNT],
    emergency_contact: Contact,
    queue: Channel<CriticalSectionRawMutex, Motion, QUEUE_MOVES>,
    state: Watch<CriticalSectionRawMutex, State, WATCHERS>,
    /// Wakes the coordinator from a wait that no axis ends.
    stopped: Signal<CriticalSectionRawMutex, ()>,
    /// Wakes the coordinator for a hold, a resume, or other overrides, and when more motions are asked for than there
    /// is room for.
    asked: Signal<CriticalSectionRawMutex, ()>,
    /// Has the coordinator free the motors, or energise them again.
    switched: Signal<CriticalSectionRawMutex, ()>,
    is_to_energise: AtomicBool,
    /// Wakes the task that watches the emergency stop.
    emergency: Signal<CriticalSectionRawMutex, ()>,
    tool: ToolLink,
    /// The edges that stop everything: see `armed`.
    armed: AtomicU32,
    /// The switch that a seek goes to has been touched.
    touched: AtomicBool,
    inner: Mutex<CriticalSectionRawMutex, RefCell<Inner>>,
}

impl Machine {
    /// A machine at rest at zero, not homed, whose emergency stop has this contact.
    #[must_use]
    pub const fn new(config: Config, emergency_contact: Contact) -> Self {
        Self {
            links: [const { AxisLink::new() }; AXES],
            switches: [const { Switch::new() }; LimitInput::COUNT],
            emergency_contact,
            queue: Channel::new(),
            state: Watch::new_with(State::Idle),
            stopped: Signal::new(),
            asked: Signal::new(),
            switched: Signal::new(),
            is_to_energise: AtomicBool::new(false),
            emergency: Signal::new(),
            tool: ToolLink::new(),
            armed: AtomicU32::new(0),
            touched: AtomicBool::new(false),
            inner: Mutex::new(RefCell::new(Inner {
                config,
                // No edge is one before its task has read the switch.
                presses: 0,
                capabilities: [None; AXES],
                faults: [0; AXES],
                homed: [false; AXES],
                stalls_apart_steps: [0; AXES],
                life: Life::new(),
                current: None,
                room: CHAIN_MOVES,
                overrides: SpeedOverrides::NONE,
                outputs: OutputsAsked::new(),
                probe: ProbeInput::new(),
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
            self.rearm(inner);
        });
        self.reread_hold_input();
        self.switches.iter().for_each(Switch::reread);
        Ok(())
    }

    /// The capabilities of each axis's port; `None` until its task has run.
    #[must_use]
    pub fn capabilities(&self) -> [Option<Capabilities>; AXES] {
        self.with(|inner| inner.capabilities)
    }

    /// The contact of the emergency stop, which is the same for ever.
    #[must_use]
    pub fn emergency_contact(&self) -> Contact {
        self.emergency_contact
    }

    /// The axes that have been homed and not lost their position since.
    #[must_use]
    pub fn homed(&self) -> [bool; AXES] {
        self.with(|inner| inner.homed)
    }

    /// The distance between the two stalls by which each axis last homed by stall, steps; 0 if it never has.
    #[must_use]
    pub fn stalls_apart_steps(&self) -> [i32; AXES] {
        self.with(|inner| inner.stalls_apart_steps)
    }

    /// The number of times that each axis's port has faulted since power-up.
    #[must_use]
    pub fn faults(&self) -> [u32; AXES] {
        self.with(|inner| inner.faults)
    }

    /// The state of the machine.
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

    /// The places where each axis stands, steps.
    #[must_use]
    #[cold]
    pub fn position_steps(&self) -> [i32; AXES] {
        self.with(|inner| inner.config.kinematics).axes(self.motor_steps())
    }

    /// The places where the motors of the axes stand, steps: the exact count of emitted edges. Where an axis has its own motor, that is
    /// the axis's place.
    #[must_use]
    pub fn motor_steps(&self) -> [i32; AXES] {
        Axis::ALL.map(|axis| self.link(axis).step_counter.position_steps())
    }

    /// Frees the motors, or energises them again, as soon as nothing moves and no motion waits. The next motion energises them, too.
    /// Nothing holds the axes meanwhile, so their positions are not trusted any more.
    // Not inlined: see `with`.
    #[inline(never)]
    pub fn energise(&self, on: bool) {
        self.is_to_energise.store(on, Ordering::Relaxed);
        self.switched.signal(());
    }

    /// True if a drive is in alarm, or may be: a machine that is locked stays so.
    #[must_use]
    #[cold]
    pub fn is_drive_in_alarm(&self) -> bool {
        self.has_drive_in_alarm(&self.config())
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
        self.until(|life| matches!(life.state, State::Idle | State::Alarm(_))).await;
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
        cold_path(pin!(self.until(|life| life.pending == 0 || life.is_locked()))).await;
    }

    async fn until(&self, wanted: impl Fn(Life) -> bool) {
        let mut states = self.state.dyn_receiver();
        while !wanted(self.life()) {
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
        &self.switches[input.index()]
    }

    pub(crate) fn switch_of(&self, motor: Motor) -> &Switch {
        self.switch(match motor.ganged {
            GangedMotor::First => LimitInput::Of(motor.axis),
            GangedMotor::Second => LimitInput::Second,
        })
    }

    pub(crate) fn publish_port(&self, axis: Axis, port: &impl StepPort) {
        self.link(axis).fit(port.inhibit());
        self.with(|inner| inner.capabilities[axis as usize] = Some(port.capabilities()));
    }

    /// The tick rate of the segments that the axis's port reads, Hz.
    pub(crate) fn tick_hz(&self, axis: Axis) -> u32 {
        self.with(|inner| inner.capabilities[axis as usize].map_or(crate::clock::TICK_HZ, |port| port.tick_hz))
    }

    /// The shortest time from one step of an axis to the next, in whichever direction, ticks of its port.
    pub(crate) fn period_min_ticks(&self, axis: Axis) -> u32 {
        let (port, wiring) = self.with(|inner| (inner.capabilities[axis as usize], inner.config.wiring[axis as usize]));
        // Its divisions take 10 us, which are none of a critical section.
        port.map_or(0, |port| port.period_min_ticks(wiring))
    }

    pub(crate) fn set_homed(&self, axis: Axis, homed: bool) {
        self.with(|inner| inner.homed[axis as usize] = homed);
    }

    /// Makes the place where `axis` stands its zero. With crossed belts the places of the motors change so that the other axis keeps its
    /// own.
    pub(crate) fn set_zero(&self, axis: Axis) {
        let kinematics = self.with(|inner| inner.config.kinematics);
        let motors = kinematics.with_zero(self.motor_steps(), axis);
        self.links.iter().zip(motors).for_each(|(link, steps)| link.step_counter.set(steps));
    }

    pub(crate) fn set_stalls_apart(&self, axis: Axis, steps: i32) {
        self.with(|inner| inner.stalls_apart_steps[axis as usize] = steps);
    }

    /// Waits until the motors are to be freed, or energised again.
    pub(crate) async fn wait_switched(&self) {
        self.switched.wait().await;
    }

    /// True if they are to be energised. The next time they are to be freed again.
    pub(crate) fn is_to_energise(&self) -> bool {
        let on = self.is_to_energise.load(Ordering::Relaxed);
        self.is_to_energise.store(false, Ordering::Relaxed);
        on
    }

    /// Makes an axis ready for a run: nothing queued, no halt signalled, the inhibit off.
    pub(crate) fn ready(&self, axis: Axis) {
        let link = self.link(axis);
        link.segments.clear();
        link.done.reset();
        link.halt.reset();
        link.start_barrier.reset();
        link.inhibit(false);
    }

    /// Lets the axes of a run go, all of which are armed. The critical section makes sure that none of their tasks is
    /// polled before all have been let go.
    pub(crate) fn let_go(&self) {
        self.with(|_| {
            let now = Instant::now();
            for axis in Axis::ALL {
                self.link(axis).start_barrier.go(now);
            }
        });
    }

    /// The life of the machine at this instant. It copies all of it: what is asked for with every move has a section of
    /// its own.
    fn life(&self) -> Life {
        self.with(|inner| inner.life)
    }

    /// Changes the state in a critical section of its own. Returns what it leads to, and the life after it.
    fn change(&self, trigger: Trigger) -> (Reaction, Life) {
        self.with(|inner| (self.apply(inner, trigger), inner.life))
    }

    /// Something has happened: the state changes, and what it leads to is done. A stop must not wait for a copy of the
    /// life, so this is not [`change`](Self::change).
    fn on(&self, trigger: Trigger) {
        let reaction = self.with(|inner| self.apply(inner, trigger));
        self.react(reaction);
    }

    /// Something is asked for that may be refused.
    fn ask(&self, trigger: Trigger) -> Result<Life, Busy> {
        match self.change(trigger) {
            (Reaction::Refuse, life) => Err(Busy(life.state)),
            (_, life) => Ok(life),
        }
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
    /// any more; an alarm is notified only once. A machine stays locked while a drive is in alarm. Not inlined, so that it is
    /// not copied into every caller.
    #[inline(never)]
    fn apply(&self, inner: &mut Inner, trigger: Trigger) -> Reaction {
        let unlocks = inner.life.is_locked() && matches!(trigger, Trigger::Unlock | Trigger::Asked(_));
        if unlocks && self.has_drive_in_alarm(&inner.config) {
            return Reaction::Refuse;
        }
        let before = inner.life;
        let reaction = inner.life.on(trigger);
        inner.rest_outputs();
        self.arm(inner);
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

    fn has_drive_in_alarm(&self, config: &Config) -> bool {
        let mut alarms = config.drive_alarms.iter().zip(&self.switches[LimitInput::ALARMS..]);
        alarms.any(|(contact, switch)| contact.is_some() && switch.may_be_pressed())
    }

    /// Calls `f` in a critical section. Not inlined: on a chip the caller's code may be in slow memory, and this
    /// crate's is not.
    #[inline(never)]
    fn with<R>(&self, f: impl FnOnce(&mut Inner) -> R) -> R {
        self.inner.lock(|inner| f(&mut inner.borrow_mut()))
    }
}
