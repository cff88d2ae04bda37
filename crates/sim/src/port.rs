//! The simulator's step ports: the firmware's `TimerPort`, and [`SimPort`], which stands for its `PioPort`.
//!
//! # Design
//! `PioPort` leaves the edges to hardware, and this port does the same: a step rises at its own instant whatever the
//! tasks do. It has the same tick rate, so equal plans compile into equal segments. It also has the same faults: when
//! it has made all its steps and gets no more, and when steps are too close. DIR changes with the end of a pulse, a few
//! cycles earlier than with `PioPort`.

use std::cell::Cell;
use std::rc::Rc;

use embassy_time::{Duration, Instant};
use embedded_hal::digital::OutputPin;
use isostep_motion::{
    AXES, Axis, Capabilities, Direction, DriverTiming, GangedMotor, Inhibit, Motor, MotorPins, Motors, PortFault, Run,
    StepPort, StreamItem, TimerBank, TimerPort, Wiring, ticks_covering,
};
use isostep_profile::Segment;

use crate::config::{Config, PIO_TICK_HZ, Port};
use crate::executor::{Executor, Priority};
use crate::pin::{Delay, Output};
use crate::record::Wire;
use crate::time::{self, Clock};
use crate::world::Shared;

const TICK_HZ: u32 = PIO_TICK_HZ;
const NS_PER_TICK: u64 = 1_000_000_000 / TICK_HZ as u64;
/// The time by which an interval may be shorter than planned, because both its ends are rounded and its segment is fitted.
const MARGIN_TICKS: u32 = 4;
/// From the fall of STEP to the change of DIR. `PioPort` takes as many cycles.
const TURN_TICKS: u32 = 4;

/// The step port of one axis.
pub enum AxisPort {
    /// For [`Port::Pio`].
    Pio(SimPort),
    /// For [`Port::Timer`].
    Timer(TimerPort<'static>),
}

impl AxisPort {
    /// The ports of all axes for `config`. Tasks that the ports need are spawned on `executor`; spawn the axes' tasks
    /// after them.
    pub fn all(config: &Config, executor: &mut Executor, world: &Shared) -> [Self; AXES] {
        let timing = config.driver;
        let clock = executor.clock().clone();
        let pins = Axis::ALL.map(|axis| AxisPins::new(world, axis));
        match config.port {
            Port::Pio => {
                let barrier = Barrier::default();
                pins.map(|pins| {
                    let port = SimPort::new(pins, &clock, timing);
                    Self::Pio(SimPort { only_time: config.only_time, barrier: barrier.clone(), ..port })
                })
            }
            Port::Timer => {
                // It lives for ever, like a static on a board.
                let bank: &'static TimerBank<AXES> = Box::leak(Box::new(TimerBank::new()));
                let delay = Delay::new(&clock);
                executor.spawn_at(Priority::P2, "steps", async move {
                    // Waking up takes no time here, so no edge needs to be made ahead of time.
                    bank.drive(pins, delay, Duration::MIN).await;
                });
                // A stop takes no time either: an axis's task runs at once, so no inhibit is needed.
                bank.ports(timing, [|_engaged| {}; AXES]).map(Self::Timer)
            }
        }
    }
}

impl StepPort for AxisPort {
    fn capabilities(&self) -> Capabilities {
        match self {
            Self::Pio(port) => port.capabilities(),
            Self::Timer(port) => port.capabilities(),
        }
    }

    fn inhibit(&self) -> Inhibit {
        match self {
            Self::Pio(port) => port.inhibit(),
            Self::Timer(port) => port.inhibit(),
        }
    }

    async fn run(&mut self, run: Run<'_>) -> Result<(), PortFault> {
        match self {
            Self::Pio(port) => port.run(run).await,
            Self::Timer(port) => port.run(run).await,
        }
    }
}

/// STEP and DIR of an axis's motors: of its own, and of the second motor if that is on this axis.
pub struct AxisPins {
    motors: [(Output, Output); 2],
    /// The motors that move in the run.
    moving: [bool; 2],
    /// The second motor's DIR has the other level.
    is_inverted: bool,
    dirs_high: [bool; 2],
}

impl AxisPins {
    /// The pins of `axis`, STEP and DIR low.
    pub fn new(world: &Shared, axis: Axis) -> Self {
        let pins = |motor| (Output::new(world, Wire::Step(motor)), Output::new(world, Wire::Dir(motor)));
        Self {
            motors: [pins(Motor::first(axis)), pins(Motor::second(axis))],
            moving: [true, false],
            is_inverted: false,
            dirs_high: [false; 2],
        }
    }
}

impl MotorPins for AxisPins {
    fn begin(&mut self, motors: &Motors) {
        self.moving = [GangedMotor::First, GangedMotor::Second].map(|ganged| motors.moves(ganged));
        self.is_inverted = motors.is_second_inverted();
        self.set_dir(self.dirs_high[0]);
    }

    fn set_step(&mut self, high: bool) {
        for ((step, _), _) in self.motors.iter_mut().zip(self.moving).filter(|(_, is_moving)| *is_moving) {
            let Ok(()) = if high { step.set_high() } else { step.set_low() };
        }
    }

    fn set_dir(&mut self, high: bool) {
        let levels = [high, high != self.is_inverted];
        for (((_, dir), was_high), high) in self.motors.iter_mut().zip(&mut self.dirs_high).zip(levels) {
            if std::mem::replace(was_high, high) != high {
                let Ok(()) = if high { dir.set_high() } else { dir.set_low() };
            }
        }
    }
}

/// Drives STEP and DIR of one axis of the [`World`](crate::world::World) with edges as exact as the clock of an RP2040.
pub struct SimPort {
    clock: Clock,
    pins: AxisPins,
    dir_high: bool,
    capabilities: Capabilities,
    /// When STEP may rise next, ns since power-up.
    ready_ns: u64,
    /// True if no edges are made: see [`Config::only_time`].
    only_time: bool,
    barrier: Barrier,
}

/// The start barrier at which the axes of a run wait. It was opened at this instant, by the first of them that was let go.
#[derive(Clone, Default)]
struct Barrier(Rc<Cell<Option<Instant>>>);

impl Barrier {
    fn close(&self) {
        self.0.set(None);
    }

    /// When it was opened, which is the next tick of the machine's clock if it is closed still.
    fn open(&self, clock: &Clock) -> Instant {
        let opened = self.0.get().unwrap_or_else(|| time::instant_from(clock.now_ns()));
        self.0.set(Some(opened));
        opened
    }
}

impl SimPort {
    /// A port on these pins, in the time of `clock`, for drivers that need `timing`.
    pub fn new(pins: AxisPins, clock: &Clock, timing: DriverTiming) -> Self {
        let mut capabilities = Capabilities::new(TICK_HZ, timing);
        (capabilities.margin_ticks, capabilities.turn_ticks) = (MARGIN_TICKS, TURN_TICKS);
        Self {
            clock: clock.clone(),
            pins,
            dir_high: false,
            capabilities,
            ready_ns: 0,
            only_time: false,
            barrier: Barrier::default(),
        }
    }

    /// Sets DIR. The last pulse has ended, and so has the hold time of DIR.
    fn face(&mut self, direction: Direction, wiring: Wiring) {
        let high = (direction == Direction::Positive) != wiring.direction_inverted;
        if high != self.dir_high {
            self.dir_high = high;
            self.pins.set_dir(high);
            self.await_setup();
        }
    }

    /// DIR has changed, or may have.
    fn await_setup(&mut self) {
        let setup_ticks = ticks_covering(self.capabilities.timing.setup_ns, TICK_HZ);
        self.ready_ns = self.ready_ns.max(self.clock.now_ns() + u64::from(setup_ticks) * NS_PER_TICK);
    }

    /// Prepares for the first item and waits for the start of the run; returns its instant, ns since power-up.
    async fn start(&mut self, first: &StreamItem, run: &Run<'_>) -> u64 {
        self.pins.begin(&run.motors);
        if run.motors.second.is_some() {
            self.await_setup();
        }
        if let StreamItem::Steps { direction, .. } = first {
            self.face(*direction, run.motors.wiring);
        }
        self.clock.until(self.ready_ns).await;
        self.barrier.close();
        run.start_barrier.armed().await;
        let start = self.barrier.open(&self.clock);
        run.start_barrier.begun(start);
        time::ns(start)
    }

    /// Checks the segment's intervals, including the one since the previous step at `last_ticks`, against the driver's
    /// limit.
    fn check_speed(&self, last_ticks: Option<u64>, segment: &Segment, wiring: Wiring) -> Result<(), PortFault> {
        let min = self.capabilities.period_min_ticks(wiring) - MARGIN_TICKS;
        let gap = last_ticks.map(|last| u32::try_from(segment.first_ticks() - last).unwrap_or(u32::MAX));
        match gap.into_iter().chain(segment.interval_min_ticks()).min() {
            Some(interval) if interval < min => Err(PortFault::TooFast { interval, min }),
            _ => Ok(()),
        }
    }

    /// Waits for the duration of a whole segment, and counts its steps.
    async fn pass(&mut self, until_ns: u64, segment: &Segment, direction: Direction, run: &Run<'_>) {
        self.clock.until(until_ns).await;
        self.ready_ns = until_ns + u64::from(self.capabilities.period_min_ticks(run.motors.wiring)) * NS_PER_TICK;
        run.step_counter.advance(direction.sign() * segment.steps() as i32);
    }

    async fn step_at(&mut self, at_ns: u64, direction: Direction, run: &Run<'_>) {
        self.clock.until(at_ns).await;
        self.ready_ns = at_ns + u64::from(self.capabilities.period_min_ticks(run.motors.wiring)) * NS_PER_TICK;
        self.pins.set_step(true);
        run.step_counter.count(direction);
        // Nothing is awaited during the pulse, so no stop cuts it short.
        self.clock.spend(self.capabilities.pulse_ns(run.motors.wiring).into());
        self.pins.set_step(false);
    }
}

impl StepPort for SimPort {
    fn capabilities(&self) -> Capabilities {
        self.capabilities
    }

    async fn run(&mut self, run: Run<'_>) -> Result<(), PortFault> {
        let mut item = run.segments.receive().await;
        let start_ns = self.start(&item, &run).await;
        let mut last_ticks = None;
        let at_ns = |ticks: u64| start_ns + ticks * NS_PER_TICK;
        loop {
            match item {
                StreamItem::Steps { segment, direction } => {
                    self.check_speed(last_ticks, &segment, run.motors.wiring)?;
                    if self.only_time {
                        self.pass(at_ns(segment.last_ticks()), &segment, direction, &run).await;
                    } else {
                        self.face(direction, run.motors.wiring);
                        for ticks in segment.ticks() {
                            self.step_at(at_ns(ticks), direction, &run).await;
                        }
                    }
                    last_ticks = Some(segment.last_ticks());
                }
                StreamItem::Rest { until_ticks } => self.clock.until(at_ns(until_ticks)).await,
                StreamItem::End => return Ok(()),
            }
            // The wait for the next step has begun, so the next item must be there.
            item = run.segments.try_receive().map_err(|_| PortFault::Underrun)?;
        }
    }
}

#[cfg(test)]
mod tests;
