//! Carries out one motion after another.
//!
//! # Design
//! Planning is float work and compiling takes roots, both far longer than a step may wait, so this task runs below the
//! axis tasks, which only add. A move is a run of all axes (`run`).
//!
//! Stops come from anywhere ([`Machine::reset`], a limit switch): the axes halt first, at their own priority, and
//! this task finds out from their answers, reads the exact positions and decides what the machine's state is.

use core::convert::Infallible;
use core::future::pending;

use embassy_futures::join::join_array;
use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Timer};
use embedded_hal::digital::OutputPin;

use crate::axes::{AXES, Axis};
use crate::event::{Alarm, Event, Finish, State};
use crate::machine::{Cause, Machine, Motion};
use crate::port::PortFault;
use crate::run::Purpose;

/// Carries out the motions asked of `machine` for ever. `enable` is the drivers' ENABLE, active low; every
/// [`Event`] goes to `on_event` as it happens.
///
/// # Cancellation
/// Dropping it mid-move starves the axes: each stops after the segments already queued, its position exact, and the
/// state stays as it was. Nothing moves until another `run` is spawned.
pub async fn run<E, F>(machine: &Machine, enable: E, on_event: F) -> !
where
    E: OutputPin<Error = Infallible>,
    F: FnMut(Event),
{
    let standstill = Instant::MIN;
    let mut coordinator = Coordinator { machine, enable, energised: true, standstill, told: State::Idle, on_event };
    coordinator.energise(false);
    loop {
        let motion = coordinator.next().await;
        coordinator.carry_out(motion).await;
    }
}

pub(crate) struct Coordinator<'a, E, F> {
    pub(crate) machine: &'a Machine,
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
        loop {
            let delay = self.machine.config().idle_delay.filter(|_| self.energised);
            let idle = async {
                match delay {
                    Some(delay) => Timer::after(delay).await,
                    None => pending().await,
                }
            };
            match select(self.machine.next_motion(), select(idle, self.machine.wait_released())).await {
                Either::First(motion) => return motion,
                Either::Second(_) => self.energise(false),
            }
        }
    }

    async fn carry_out(&mut self, motion: Motion) {
        if matches!(self.machine.state(), State::Alarm(_)) {
            // It was waiting when the machine locked itself.
            self.machine.pass_over();
            return;
        }
        self.machine.forget_stopped();
        let result = match motion {
            // Stopped or cancelled before it began.
            _ if self.machine.cause().is_some() || !self.machine.outlast_hold().await => Ok(()),
            Motion::Move { target_steps, feed_mm_s, .. } => self.go_to(target_steps, feed_mm_s, Purpose::Program).await,
            Motion::Jog { target_steps, feed_mm_s } => self.go_to(target_steps, Some(feed_mm_s), Purpose::Jog).await,
            Motion::Dwell(duration) => self.dwell(duration).await,
            Motion::Home { axes } => self.home(axes).await,
        };
        let state = self.machine.conclude(result);
        self.tell_state(state);
    }

    async fn go_to(
        &mut self,
        target_steps: [i32; AXES],
        feed_mm_s: Option<f64>,
        purpose: Purpose,
    ) -> Result<(), Alarm> {
        let origin = self.machine.position_steps();
        let steps = core::array::from_fn(|i| target_steps[i].wrapping_sub(origin[i]));
        if steps == [0; AXES] {
            return Ok(());
        }
        if let Some(axis) = self.machine.onto_switch(steps) {
            return Err(Alarm::HardLimit { axis });
        }
        match self.travel(steps, feed_mm_s, purpose).await? {
            // What was held and not resumed is forgotten.
            Finish::Done | Finish::Held => Ok(()),
            Finish::Stopped => Err(self.stop_alarm()),
            Finish::Fault { axis, fault } => Err(self.fault_alarm(axis, fault)),
        }
    }

    async fn dwell(&mut self, duration: Duration) -> Result<(), Alarm> {
        let end = self.standstill.max(Instant::now()) + duration;
        // What stopped it, if anything, is judged with every other motion's end.
        select(self.machine.wait_stopped(), Timer::at(end)).await;
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

/// Waits until every moving axis is ready to start.
pub(crate) async fn all_armed(machine: &Machine, moving: [bool; AXES]) {
    for axis in Axis::ALL.into_iter().filter(|&axis| moving[axis as usize]) {
        machine.link(axis).start_line.wait_armed().await;
    }
}

/// Waits until the moving axes have started: the instant that their segments count from.
pub(crate) async fn begun(machine: &Machine, moving: [bool; AXES]) -> Instant {
    let mut start = Instant::MIN;
    for axis in Axis::ALL.into_iter().filter(|&axis| moving[axis as usize]) {
        start = start.max(machine.link(axis).start_line.wait_begun().await);
    }
    start
}

/// Waits for every moving axis. One whose port faults halts the others.
pub(crate) async fn all_done(machine: &Machine, moving: [bool; AXES]) -> Finish {
    let answers = join_array(Axis::ALL.map(|axis| async move {
        if !moving[axis as usize] {
            return Finish::Done;
        }
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
