//! Plans a move, compiles it ahead of time and starts all axes at one instant.
//!
//! # Design
//! Planning is float work and compiling takes roots, both far longer than a step may wait, so this task runs below the
//! axis tasks, which only add. It compiles every axis's first segments before the start, then keeps the queues full
//! while the axes drain them.
//!
//! Stops come from anywhere ([`Machine::reset`], a limit switch): the axes halt first, at their own priority, and
//! this task finds out from their answers, reads the exact positions and decides what the machine's state is.

use core::convert::Infallible;
use core::future::pending;

use embassy_futures::join::join_array;
use embassy_futures::select::{Either, select};
use embassy_futures::yield_now;
use embassy_time::{Duration, Instant, Timer, with_timeout};
use embedded_hal::digital::OutputPin;
use isostep_profile::{Segments, SyncMove};

use crate::axes::{AXES, Axis};
use crate::event::{Alarm, Event, Finish, State};
use crate::machine::{Cause, Machine, Motion, Underway};
use crate::port::{Direction, PortFault, Run};

/// From the start signal to instant zero of a move: the axis tasks wake, set DIR and wait out its set-up, and
/// ENABLE's (650 ns for a DRV8825), long before the first step.
const LEAD: Duration = Duration::from_micros(500);

/// Motion compiled per axis before a move starts, as far as the queue has room: time to fill the queues in. Of a curved
/// ramp the first segments take milliseconds each, so there it is a full queue mostly; more would only delay the start.
const COMPILED_BEFORE_START: Duration = Duration::from_millis(20);

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
    let mut coordinator = Coordinator { machine, enable, energised: true, told: State::Idle, on_event };
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
    /// The state last told as an event.
    told: State,
    on_event: F,
}

impl<E, F> Coordinator<'_, E, F>
where
    E: OutputPin<Error = Infallible>,
    F: FnMut(Event),
{
    /// The next motion; while there is none, the idle delay may run out and free the motors.
    async fn next(&mut self) -> Motion {
        if let (true, Some(delay)) = (self.energised, self.machine.config().idle_delay) {
            if let Ok(motion) = with_timeout(delay, self.machine.next_motion()).await {
                return motion;
            }
            self.energise(false);
        }
        self.machine.next_motion().await
    }

    async fn carry_out(&mut self, motion: Motion) {
        if matches!(self.machine.state(), State::Alarm(_)) {
            // It was waiting when the machine locked itself.
            self.machine.pass_over();
            return;
        }
        self.machine.forget_stopped();
        let result = match motion {
            // Stopped before it began.
            _ if self.machine.cause().is_some() => Ok(()),
            Motion::Move { target_steps, feed_mm_s } => self.go_to(target_steps, feed_mm_s).await,
            Motion::Dwell(duration) => self.dwell(duration).await,
            Motion::Home => self.home().await,
        };
        let state = self.machine.conclude(result);
        self.tell_state(state);
    }

    async fn go_to(&mut self, target_steps: [i32; AXES], feed_mm_s: Option<f64>) -> Result<(), Alarm> {
        let origin = self.machine.position_steps();
        let steps = core::array::from_fn(|i| target_steps[i].wrapping_sub(origin[i]));
        if steps == [0; AXES] {
            return Ok(());
        }
        match self.travel(steps, feed_mm_s).await? {
            Finish::Done => Ok(()),
            Finish::Stopped => Err(self.stop_alarm()),
            Finish::Fault { axis, fault } => Err(self.fault_alarm(axis, fault)),
        }
    }

    async fn dwell(&mut self, duration: Duration) -> Result<(), Alarm> {
        // What stopped it, if anything, is judged with every other motion's end.
        select(self.machine.wait_stopped(), Timer::after(duration)).await;
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

    /// Moves by signed `steps` and returns when every axis has answered. A halt is not an error here: homing halts
    /// on purpose.
    pub(crate) async fn travel(&mut self, steps: [i32; AXES], feed_mm_s: Option<f64>) -> Result<Finish, Alarm> {
        let config = self.machine.config();
        let mm_squared = |i: usize| {
            let mm = f64::from(steps[i]) / config.steps_per_mm[i];
            mm * mm
        };
        let path_mm = libm::sqrt((0..AXES).map(mm_squared).sum());
        let longest = steps.iter().map(|n| n.unsigned_abs()).max().unwrap_or(0);
        let mm_per_step = path_mm / f64::from(longest);
        let path_speed = feed_mm_s.map(|mm_s| mm_s / mm_per_step);
        let plan = SyncMove::plan(steps, &config.limits, config.interval_law, config.speed_law, path_speed)
            .map_err(|_| Alarm::Unplannable)?;
        Ok(self.run_plan(plan, mm_per_step).await)
    }

    async fn run_plan(&mut self, plan: SyncMove<AXES>, mm_per_step: f64) -> Finish {
        self.energise(true);
        let origin_steps = self.machine.position_steps();
        let mut segments = Axis::ALL.map(|axis| plan.segments(axis as usize, self.machine.tick_hz(axis)));
        for (axis, segments) in Axis::ALL.into_iter().zip(&mut segments) {
            self.prepare(axis, segments);
            yield_now().await;
        }
        if self.machine.cause().is_some() {
            // Stopped before it started. A stop after this check finds its halt signal standing.
            return self.end_move(Finish::Stopped);
        }
        let start = Instant::now() + LEAD;
        self.machine.set_underway(Some(Underway { start, profile: plan.profile, mm_per_step }));
        (self.on_event)(Event::Move { start, plan, origin_steps });
        self.start_axes(&plan, start);
        let moving = Axis::ALL.map(|axis| plan.steps[axis as usize] != 0);
        let [x, y, z] = &mut segments;
        let feeding = join_array(
            [(Axis::X, x), (Axis::Y, y), (Axis::Z, z)].map(|(axis, segments)| feed(self.machine, axis, segments)),
        );
        let finish = alongside(all_done(self.machine, moving), feeding).await;
        self.end_move(finish)
    }

    fn start_axes(&self, plan: &SyncMove<AXES>, start: Instant) {
        let wiring = self.machine.config().wiring;
        for axis in Axis::ALL {
            let n = plan.steps[axis as usize];
            if n != 0 {
                let (direction, wiring) = (Direction::of(n), wiring[axis as usize]);
                self.machine.link(axis).run.signal(Run { start, direction, wiring, steps: n.unsigned_abs() });
            }
        }
    }

    /// Makes the axis ready and queues its first segments.
    fn prepare(&self, axis: Axis, segments: &mut Segments<'_>) {
        self.machine.ready(axis);
        let queue = &self.machine.link(axis).segments;
        let enough_ticks = COMPILED_BEFORE_START.as_micros() * u64::from(self.machine.tick_hz(axis)) / 1_000_000;
        while !queue.is_full() {
            let Some(segment) = segments.next() else { return };
            // There is room, and this task is the only sender.
            let _ = queue.try_send(segment);
            if segment.last_ticks() >= enough_ticks {
                return;
            }
        }
    }

    fn end_move(&mut self, finish: Finish) -> Finish {
        self.machine.set_underway(None);
        (self.on_event)(Event::MoveEnd { finish, position_steps: self.machine.position_steps() });
        finish
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

    fn energise(&mut self, on: bool) {
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

/// Keeps one axis's queue full until its part of the move is compiled. One segment a poll: the axes take turns, and so
/// do the other tasks of this priority.
async fn feed(machine: &Machine, axis: Axis, segments: &mut Segments<'_>) {
    for segment in segments {
        machine.link(axis).segments.send(segment).await;
        yield_now().await;
    }
}

/// Waits for every moving axis. One whose port faults halts the others.
async fn all_done(machine: &Machine, moving: [bool; AXES]) -> Finish {
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
