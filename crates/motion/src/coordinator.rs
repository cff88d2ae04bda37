//! Carries out one motion after another.
//!
//! # Design
//! Planning is float work and compiling takes roots. Both take far longer than a step may wait, so this task runs at a
//! lower priority than the axis tasks, which only add. Moves that follow each other go into a chain (`flow`), and runs
//! of all axes make the moves of the chain (`run`).
//!
//! A stop may come from any context ([`Machine::reset`], a limit switch). The axes halt first, at their own priority.
//! This task learns of the stop from their answers and reads the exact positions. Then it tells the machine that the
//! motion has ended, and the machine's life cycle decides on the state.

use core::convert::Infallible;
use core::future::pending;
use core::pin::pin;

use embassy_futures::join::join_array;
use embassy_futures::select::{Either, select};
use embassy_futures::yield_now;
use embassy_time::{Duration, Instant, Timer};
use embedded_hal::digital::OutputPin;
use isostep_profile::chain::Chain;

use crate::axes::{AXES, Axis};
use crate::chunks::Chunks;
use crate::cold_path::cold_path;
use crate::config::Config;
use crate::effort::LeastTimes;
use crate::event::{Alarm, Event, Finish, State};
use crate::group::{Begin, Course, GroupRule, MoveGroup};
use crate::kinematics::Kinematics;
use crate::machine::{CHAIN_MOVES, Cause, Machine, Motion, SpeedOverrides};
use crate::marks::Marks;
use crate::motor::GangedMotor;
use crate::port::PortFault;
use crate::run::CHUNK_S;
use crate::shaping::Shaping;
use crate::tag::Tag;

/// Longer than any pulse lasts (`$0` is 20 us at most), and longer than any driver requires ENABLE to be held after a
/// step.
const PULSE_MAX: Duration = Duration::from_millis(1);

/// The path ahead, as far as it is known. It is large: on a chip, put it into a static.
pub struct PlanMemory {
    chain: Chain<AXES, CHAIN_MOVES, Tag>,
    chunks: Chunks,
    marks: Marks,
}

impl PlanMemory {
    /// Nothing is known of the path yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { chain: Chain::empty(Tag::NONE), chunks: Chunks::new(), marks: Marks::new() }
    }
}

impl Default for PlanMemory {
    fn default() -> Self {
        Self::new()
    }
}

/// Carries out the motions asked of `machine` for ever. `memory` is what it plans in; `least_times` are the board's; `enable` is
/// the drivers' ENABLE, active low; every [`Event`] goes to `on_event` as it happens.
///
/// # Cancellation
/// Dropping it in the middle of a move starves the axes: they stop when the first of them has made the segments already
/// queued, or each does where its port cannot tell; every position is exact, and the state stays as it was. Nothing
/// moves until another `run` is spawned, which begins where the axes stand.
pub async fn run<E, F>(
    machine: &Machine,
    memory: &mut PlanMemory,
    least_times: &LeastTimes,
    enable: E,
    on_event: F,
) -> !
where
    E: OutputPin<Error = Infallible>,
    F: FnMut(Event),
{
    let mut coordinator = Coordinator::new(machine, memory, least_times, enable, on_event);
    coordinator.energise(false);
    // An axis may still be in a run of a coordinator that was dropped, waiting for more items.
    machine.take_over();
    yield_now().await;
    loop {
        let motion = coordinator.next().await;
        coordinator.carry_out(motion).await;
    }
}

/// The purpose of moves, which decides what may change them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// A program: it can be held, and its speed overridden.
    Program,
    /// A jog: it can be cancelled.
    Jog,
    /// Probing: a contact ends it, and it can be held.
    Probe,
    /// A homing seek that brakes behind its switch: the first touch ends it, and nothing else changes it.
    Seek,
    /// Homing: nothing changes it.
    Homing {
        /// The ganged motor of the axis that stands still, if it has two.
        held: Option<GangedMotor>,
    },
}

impl Purpose {
    /// True if a contact ends it, by braking.
    pub fn ends_by_contact(self) -> bool {
        matches!(self, Self::Probe | Self::Seek)
    }

    pub fn is_homing(self) -> bool {
        matches!(self, Self::Homing { .. } | Self::Seek)
    }

    /// The shaping of runs for this, if they are shaped.
    pub fn shaping(self, config: &Config) -> Option<Shaping> {
        if matches!(self, Self::Program | Self::Jog) { config.shaping() } else { None }
    }
}

pub(crate) struct Coordinator<'a, E, F> {
    pub(crate) machine: &'a Machine,
    pub(crate) chain: &'a mut Chain<AXES, CHAIN_MOVES, Tag>,
    pub(crate) chunks: &'a mut Chunks,
    /// The marks in the blocks of the chain, and in what has been handed out of it.
    pub(crate) marks: &'a mut Marks,
    pub(crate) least_times: &'a LeastTimes,
    /// The overrides that the chain is planned with.
    pub(crate) overrides: SpeedOverrides,
    /// The place where the chain ends, steps of the motors.
    pub(crate) planned_steps: [i32; AXES],
    /// How the motors move the axes.
    pub(crate) kinematics: Kinematics,
    /// How that place is beside whole steps, and beside where the last move was to end.
    pub(crate) begin: Begin,
    /// Which moves are taken together.
    pub(crate) group_rule: GroupRule,
    /// The last moves, which are not in the chain yet, because more may be taken together with them.
    pub(crate) group: Option<MoveGroup>,
    /// How far the last block's path may be beside the ends of its moves, mm.
    pub(crate) used_mm: f32,
    /// How the path of the groups before goes on.
    pub(crate) course: Course,
    /// The alarm for a group that the chain has refused.
    pub(crate) refused: Option<Alarm>,
    /// The number of the move that goes into the chain next: see [`Event::Taken`].
    pub(crate) next_number: u16,
    /// Ramps are curved.
    pub(crate) is_curved: bool,
    /// The longest chunk that the chain hands out at a time, s.
    pub(crate) chunk_s: f64,
    /// The number of motions that have gone into the chain since it was begun.
    pub(crate) taken: usize,
    /// The steps that each axis of a probing motion had made at the contact, or where each was when the switch of a seek was touched.
    pub(crate) contact_steps: Option<[i32; AXES]>,
    /// A motion that cannot follow the others without a stop, and waits until they have ended.
    pub(crate) waiting: Option<Motion>,
    enable: E,
    energised: bool,
    /// The instant at which the plan of the last run ends, half a step after its last edge. No motion begins before then.
    pub(crate) standstill: Instant,
    /// The state that was reported last as an event.
    reported: State,
    pub(crate) on_event: F,
}

impl<'a, E, F> Coordinator<'a, E, F>
where
    E: OutputPin<Error = Infallible>,
    F: FnMut(Event),
{
    /// A coordinator that has done nothing yet.
    #[cold]
    fn new(
        machine: &'a Machine,
        memory: &'a mut PlanMemory,
        least_times: &'a LeastTimes,
        enable: E,
        on_event: F,
    ) -> Self {
        let PlanMemory { chain, chunks, marks } = memory;
        Self {
            machine,
            chain,
            chunks,
            marks,
            least_times,
            overrides: SpeedOverrides::NONE,
            planned_steps: [0; AXES],
            kinematics: Kinematics::Cartesian,
            begin: Begin::WHOLE,
            group_rule: GroupRule::NONE,
            group: None,
            used_mm: 0.0,
            course: Course::NONE,
            refused: None,
            next_number: 0,
            is_curved: false,
            chunk_s: CHUNK_S,
            taken: 0,
            contact_steps: None,
            waiting: None,
            enable,
            energised: true,
            standstill: Instant::MIN,
            reported: State::Idle,
            on_event,
        }
    }
}

impl<E, F> Coordinator<'_, E, F>
where
    E: OutputPin<Error = Infallible>,
    F: FnMut(Event),
{
    /// Waits for the next motion. Meanwhile it frees the motors, when that is asked for or when the idle delay is over, or
    /// energises them again.
    async fn next(&mut self) -> Motion {
        if let Some(motion) = self.waiting.take() {
            return motion;
        }
        loop {
            match select(self.machine.next_motion(), self.rested()).await {
                Either::First(motion) => return motion,
                Either::Second(()) => self.energise(self.machine.is_to_energise()),
            }
        }
    }

    /// Waits until the motors are to be freed, or energised again, and may be: the plan of the last run is over, and ENABLE has been held
    /// for as long as the drivers require. The latter is needed because the last step of a run, or of a stopped motion,
    /// may have risen at this very instant.
    async fn rested(&self) {
        let now = Instant::now();
        let delay = self.machine.config().idle_delay.filter(|_| self.energised);
        let idle = async {
            match delay {
                Some(delay) => Timer::at(now + delay).await,
                None => pending().await,
            }
        };
        let is_asked = select(idle, self.machine.wait_switched()).await.is_second();
        Timer::at(self.standstill.max(now) + PULSE_MAX).await;
        if is_asked {
            // Whoever frees the motors may push the axes. After an idle delay they are trusted to stay, as in Grbl.
            for axis in Axis::ALL {
                self.machine.set_homed(axis, false);
            }
        } else if let Some(squared) = self.machine.config().squared {
            // A frame that two motors hold square springs back when they let go.
            self.machine.set_homed(squared.axis, false);
        }
    }

    async fn carry_out(&mut self, motion: Motion) {
        if matches!(self.machine.state(), State::Alarm(_)) {
            // The motion was waiting when the machine locked itself.
            self.machine.pass_over();
            return;
        }
        self.machine.forget_stopped();
        self.machine.set_room(0);
        let (result, motions) = match motion {
            // The motion was stopped or cancelled before it began.
            _ if self.machine.cause().is_some() || !self.machine.outlast_hold().await => (Ok(()), 1),
            Motion::Move(_) => self.flow(motion, Purpose::Program).await,
            Motion::Jog(_) => self.flow(motion, Purpose::Jog).await,
            Motion::Probe(probe) => (cold_path(pin!(self.probe(probe))).await, 1),
            Motion::Dwell(duration) => (cold_path(pin!(self.dwell(duration))).await, 1),
            Motion::Home { axes } => (cold_path(pin!(self.home(axes))).await, 1),
        };
        self.machine.set_room(CHAIN_MOVES);
        if result.is_ok() && self.machine.config().tool.laser {
            // The laser shines to the end of the plan, half a step after the last edge.
            self.machine.is_stopped_before(self.standstill).await;
        }
        let state = self.machine.conclude(result, motions);
        self.report_state(state);
    }

    /// Stands still for `duration`. While the machine is held that time does not pass.
    async fn dwell(&mut self, duration: Duration) -> Result<(), Alarm> {
        let (mut begin, mut left) = (self.standstill.max(Instant::now()), duration);
        while select(self.machine.wait_interrupted(), Timer::at(begin + left)).await.is_first() {
            left -= Instant::now().saturating_duration_since(begin).min(left);
            if !self.machine.outlast_hold().await {
                // If a stop ended it, `Machine::conclude` judges that at the end, as for every motion.
                break;
            }
            begin = begin.max(Instant::now());
        }
        Ok(())
    }

    /// The alarm for a stop, or a fault, in the middle of a move. Only a cause, or homing on purpose, halts the axes.
    #[cold]
    pub(crate) fn stop_alarm(&self) -> Alarm {
        self.machine.cause().unwrap_or(Cause::Reset).alarm(self.machine.state())
    }

    pub(crate) fn report_state(&mut self, state: State) {
        if self.reported != state {
            self.reported = state;
            (self.on_event)(Event::State(state));
        }
    }

    pub(crate) fn report(&mut self, event: Event) {
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

/// The output of `main`. `side` runs beside it for as long as `main` lasts.
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
        machine.link(axis).start_barrier.wait_armed().await;
    }
}

/// Waits until the axes have started. Returns the instant from which their segments count.
///
/// # Errors
/// An axis that started at another instant than the first: its steps would be beside the path.
pub(crate) async fn begun(machine: &Machine) -> Result<Instant, (Axis, PortFault)> {
    let start = machine.link(Axis::ALL[0]).start_barrier.wait_begun().await;
    for axis in Axis::ALL {
        let other = if axis == Axis::ALL[0] { start } else { machine.link(axis).start_barrier.wait_begun().await };
        if other != start {
            let by = if other > start { other - start } else { start - other };
            return Err((axis, PortFault::Apart { by }));
        }
    }
    Ok(start)
}

/// Waits until every axis has ended its run.
pub(crate) async fn all_done(machine: &Machine) -> Finish {
    let answers = join_array(Axis::ALL.map(|axis| machine.link(axis).done.wait())).await;
    let fault = answers.into_iter().find(|finish| matches!(finish, Finish::Fault { .. }));
    fault.or(answers.into_iter().find(|finish| *finish == Finish::Stopped)).unwrap_or(Finish::Done)
}
