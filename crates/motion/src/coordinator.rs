//! Carries out one motion after another.
//!
//! # Design
//! Planning is float work and compiling takes roots, both far longer than a step may wait, so this task runs below the
//! axis tasks, which only add. Moves that follow each other go into a chain (`flow`), and the chain is made by runs of all
//! axes (`run`).
//!
//! Stops come from anywhere ([`Machine::reset`], a limit switch): the axes halt first, at their own priority, and
//! this task finds out from their answers, reads the exact positions and decides what the machine's state is.

use core::convert::Infallible;
use core::future::pending;

use embassy_futures::join::join_array;
use embassy_futures::select::{Either, select};
use embassy_futures::yield_now;
use embassy_time::{Duration, Instant, Timer};
use embedded_hal::digital::OutputPin;
use isostep_profile::chain::Chain;

use crate::axes::{AXES, Axis};
use crate::chunks::Chunks;
use crate::event::{Alarm, Event, Finish, State};
use crate::flow::Purpose;
use crate::machine::{CHAIN_MOVES, Cause, Machine, Motion, Overrides};
use crate::port::PortFault;

/// No pulse lasts so long, and no driver wants ENABLE to be held for longer behind a step: `$0` is 20 us at most.
const PULSE_MAX: Duration = Duration::from_millis(1);

/// What is known of the path ahead. It is large: on a chip, a static.
pub struct Path {
    chain: Chain<AXES, CHAIN_MOVES>,
    chunks: Chunks,
}

impl Path {
    /// Nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self { chain: Chain::empty(), chunks: Chunks::new() }
    }
}

impl Default for Path {
    fn default() -> Self {
        Self::new()
    }
}

/// Carries out the motions asked of `machine` for ever. `path` is room to plan in; `enable` is the drivers' ENABLE, active
/// low; every [`Event`] goes to `on_event` as it happens.
///
/// # Cancellation
/// Dropping it mid-move starves the axes: each stops after the segments already queued, its position exact, and the
/// state stays as it was. Nothing moves until another `run` is spawned, which begins where they stand.
pub async fn run<E, F>(machine: &Machine, path: &mut Path, enable: E, on_event: F) -> !
where
    E: OutputPin<Error = Infallible>,
    F: FnMut(Event),
{
    let Path { chain, chunks } = path;
    let mut coordinator = Coordinator {
        machine,
        chain,
        chunks,
        overrides: Overrides::NONE,
        planned_steps: [0; AXES],
        is_curved: false,
        taken: 0,
        contact_steps: None,
        waiting: None,
        enable,
        energised: true,
        standstill: Instant::MIN,
        told: State::Idle,
        on_event,
    };
    coordinator.energise(false);
    // An axis may still be in a run of a coordinator that was dropped, waiting for more of it.
    machine.halt();
    yield_now().await;
    loop {
        let motion = coordinator.next().await;
        coordinator.carry_out(motion).await;
    }
}

pub(crate) struct Coordinator<'a, E, F> {
    pub(crate) machine: &'a Machine,
    pub(crate) chain: &'a mut Chain<AXES, CHAIN_MOVES>,
    pub(crate) chunks: &'a mut Chunks,
    /// The overrides that the chain goes by.
    pub(crate) overrides: Overrides,
    /// Where the chain ends.
    pub(crate) planned_steps: [i32; AXES],
    /// Ramps are curved.
    pub(crate) is_curved: bool,
    /// Motions that have gone into the chain since it was begun.
    pub(crate) taken: usize,
    /// The steps that each axis of a probing motion had made at the contact.
    pub(crate) contact_steps: Option<[i32; AXES]>,
    /// A motion that cannot follow the others without a stop.
    pub(crate) waiting: Option<Motion>,
    enable: E,
    energised: bool,
    /// When the plan of the last run ends, half a step after its last edge. Nothing moves before.
    pub(crate) standstill: Instant,
    /// The state last told as an event.
    told: State,
    on_event: F,
}

impl<E, F> Coordinator<'_, E, F>
where
    E: OutputPin<Error = Infallible>,
    F: FnMut(Event),
{
    /// The next motion; while there is none the motors are freed when they are to be, or when the idle delay runs out.
    async fn next(&mut self) -> Motion {
        if let Some(motion) = self.waiting.take() {
            return motion;
        }
        loop {
            match select(self.machine.next_motion(), self.rested()).await {
                Either::First(motion) => return motion,
                Either::Second(()) => self.energise(false),
            }
        }
    }

    /// Waits until the motors are to be freed, and may be: the plan of the last run is over, and ENABLE has been held for as long
    /// as the drivers ask. A step may have risen at this very instant, the last one of a run or of what was stopped.
    async fn rested(&self) {
        let now = Instant::now();
        let delay = self.machine.config().idle_delay.filter(|_| self.energised);
        let idle = async {
            match delay {
                Some(delay) => Timer::at(now + delay).await,
                None => pending().await,
            }
        };
        select(idle, self.machine.wait_released()).await;
        Timer::at(self.standstill.max(now) + PULSE_MAX).await;
    }

    async fn carry_out(&mut self, motion: Motion) {
        if matches!(self.machine.state(), State::Alarm(_)) {
            // It was waiting when the machine locked itself.
            self.machine.pass_over();
            return;
        }
        self.machine.forget_stopped();
        self.machine.set_room(0);
        let (result, motions) = match motion {
            // Stopped or cancelled before it began.
            _ if self.machine.cause().is_some() || !self.machine.outlast_hold().await => (Ok(()), 1),
            Motion::Move { .. } => self.flow(motion, Purpose::Program).await,
            Motion::Jog { .. } => self.flow(motion, Purpose::Jog).await,
            Motion::Probe(probe) => (self.probe(probe).await, 1),
            Motion::Dwell(duration) => (self.dwell(duration).await, 1),
            Motion::Home { axes } => (self.home(axes).await, 1),
        };
        self.machine.set_room(CHAIN_MOVES);
        if result.is_ok() && self.machine.config().tool.laser {
            // It shines to the end of the plan, half a step after the last edge.
            self.machine.is_stopped_before(self.standstill).await;
        }
        let state = self.machine.conclude(result, motions);
        self.tell_state(state);
    }

    /// Stands still for that long. While it is held its time stands still, too.
    async fn dwell(&mut self, duration: Duration) -> Result<(), Alarm> {
        let (mut begin, mut left) = (self.standstill.max(Instant::now()), duration);
        while select(self.machine.wait_interrupted(), Timer::at(begin + left)).await.is_first() {
            left -= Instant::now().saturating_duration_since(begin).min(left);
            if !self.machine.outlast_hold().await {
                // What stopped it, if anything, is judged with every other motion's end.
                break;
            }
            begin = begin.max(Instant::now());
        }
        Ok(())
    }

    /// What a stop in the middle of a move means. Only a cause, or homing on purpose, halts the axes.
    pub(crate) fn stop_alarm(&self) -> Alarm {
        self.machine.cause().unwrap_or(Cause::Reset).alarm(self.machine.state())
    }

    /// What a fault of a port means.
    pub(crate) fn fault_alarm(&self, axis: Axis, fault: PortFault) -> Alarm {
        self.machine.count_fault(axis);
        match fault {
            // Either way a step could not be made at its instant, in mid-move: the position is not trusted.
            PortFault::Late { .. } | PortFault::TooFast { .. } => Alarm::LateStep { axis },
            PortFault::Underrun => Alarm::Underrun { axis },
        }
    }

    pub(crate) fn tell_state(&mut self, state: State) {
        if self.told != state {
            self.told = state;
            (self.on_event)(Event::State(state));
        }
    }

    pub(crate) fn tell(&mut self, event: Event) {
        (self.on_event)(event);
    }

    pub(crate) fn energise(&mut self, on: bool) {
        if self.energised != on {
            let high = on == self.machine.config().enable_inverted;
            let Ok(()) = if high { self.enable.set_high() } else { self.enable.set_low() };
            self.energised = on;
        }
    }
}

/// The output of `main`, with `side` running beside it for as long as it lasts.
pub(crate) async fn alongside<T>(main: impl Future<Output = T>, side: impl Future) -> T {
    let side = async {
        side.await;
        pending::<Infallible>().await
    };
    match select(main, side).await {
        Either::First(output) => output,
        Either::Second(never) => match never {},
    }
}

/// Waits until every axis is ready to start.
pub(crate) async fn all_armed(machine: &Machine) {
    for axis in Axis::ALL {
        machine.link(axis).start_line.wait_armed().await;
    }
}

/// Waits until the axes have started: the instant that their segments count from.
pub(crate) async fn begun(machine: &Machine) -> Instant {
    let mut start = Instant::MIN;
    for axis in Axis::ALL {
        start = start.max(machine.link(axis).start_line.wait_begun().await);
    }
    start
}

/// Waits for every axis. One whose port faults halts the others.
pub(crate) async fn all_done(machine: &Machine) -> Finish {
    let answers = join_array(Axis::ALL.map(|axis| async move {
        let finish = machine.link(axis).done.wait().await;
        if matches!(finish, Finish::Fault { .. }) {
            machine.halt();
        }
        finish
    }))
    .await;
    let fault = answers.into_iter().find(|finish| matches!(finish, Finish::Fault { .. }));
    fault.or(answers.into_iter().find(|finish| *finish == Finish::Stopped)).unwrap_or(Finish::Done)
}
