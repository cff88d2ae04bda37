//! A port on simulated pins with a driver, and the part of the coordinator in a run.

use std::cell::{Cell, RefCell};
use std::convert::Infallible;
use std::fmt;
use std::future::pending;
use std::rc::Rc;

use embassy_futures::join::join;
use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Timer};
use embedded_hal::digital::OutputPin;
use isostep_motion::{
    AXES, Axis, Capabilities, DriverTiming, Motor, Motors, PortFault, Run, StartBarrier, StepCounter, StepPort,
    StreamItem, StreamQueue, Wiring,
};
use isostep_profile::fit_error_max_ticks;
use isostep_sim::Config;
use isostep_sim::executor::{Executor, Priority};
use isostep_sim::pin::{Delay, Output};
use isostep_sim::port::AxisPins;
use isostep_sim::time::Clock;
use isostep_sim::world::{Edge, Shared, Wave, Wire, World};

use crate::plan::Plan;

/// The ports of a board, as the tests open them. It displays as their name.
pub trait Ports: fmt::Display + Copy + 'static {
    /// The port of one axis.
    type Port: StepPort + 'static;

    /// Opens the ports of all axes on the pins of `bench`, for drivers of its timing.
    fn open(&self, bench: &mut Bench<'_>) -> [Self::Port; AXES];

    /// From the instant at which the ports are let go to their start, in time that code does not take.
    fn lead(&self) -> Duration {
        Duration::MIN
    }

    /// True if an axis may have a second motor. If not, what a port promises of it is not tested.
    fn take_second_motors(&self) -> bool {
        true
    }
}

/// The place where ports are opened: pins and time of a simulated machine.
pub struct Bench<'a> {
    /// The spawner of tasks that the ports need.
    pub executor: &'a mut Executor,
    /// The machine that the pins belong to.
    pub world: &'a Shared,
    /// The times that the drivers need.
    pub driver: DriverTiming,
}

impl Bench<'_> {
    /// STEP and DIR of an axis, both low.
    #[must_use]
    pub fn pins(&self, axis: Axis) -> AxisPins {
        AxisPins::new(self.world, axis)
    }

    /// A delay that blocks the task that owns it.
    #[must_use]
    pub fn delay(&self) -> Delay {
        Delay::new(self.executor.clock())
    }

    /// Spawns a task that the ports need, above the tasks of the axes.
    pub fn spawn(&mut self, name: &'static str, task: impl Future<Output = ()> + 'static) {
        self.executor.spawn_at(Priority::P1, name, task);
    }
}

/// Ports with a kind of drivers.
#[derive(Clone, Copy, Debug)]
pub struct Rig<P> {
    ports: P,
    /// The times that the drivers need.
    pub driver: DriverTiming,
}

impl<P: Ports> Rig<P> {
    /// These ports, with slow drivers and with fast ones.
    pub fn all(ports: P) -> impl Iterator<Item = Self> {
        [DriverTiming::DRV8825, DriverTiming::TMC2209].into_iter().map(move |driver| Self { ports, driver })
    }

    /// These ports with these drivers.
    pub fn new(ports: P, driver: DriverTiming) -> Self {
        Self { ports, driver }
    }

    /// Runs `task` with the port of X. Returns the simulated world with its record.
    pub fn run<F, T>(self, task: F) -> Shared
    where
        F: FnOnce(P::Port, Clock) -> T,
        T: Future<Output = ()> + 'static,
    {
        self.run_all(|[port, ..], clock| task(port, clock))
    }

    /// Runs `task` with the ports of all axes.
    pub fn run_all<F, T>(self, task: F) -> Shared
    where
        F: FnOnce([P::Port; AXES], Clock) -> T,
        T: Future<Output = ()> + 'static,
    {
        self.run_tasks(|ports, clock| [task(ports, clock)])
    }

    /// Runs tasks with the ports of all axes. Each has its own time, as on a core of its own.
    pub(crate) fn run_tasks<F, I, T>(self, tasks: F) -> Shared
    where
        F: FnOnce([P::Port; AXES], Clock) -> I,
        I: IntoIterator<Item = T>,
        T: Future<Output = ()> + 'static,
    {
        let mut executor = Executor::new();
        let clock = executor.clock().clone();
        let _current = clock.enter();
        let mut config = Config { driver: self.driver, ..Config::default() };
        // X has a second motor, which makes steps in runs that ask for it.
        config.settings.second_motor_axis = 1;
        let world = Rc::new(RefCell::new(World::new(clock.clone(), &config)));
        Output::new(&world, Wire::Enable).set_low().unwrap();
        let mut bench = Bench { executor: &mut executor, world: &world, driver: self.driver };
        let ports = self.ports.open(&mut bench);
        for task in tasks(ports, clock.clone()) {
            executor.spawn("port", task);
        }
        executor.run_until_quiescent(Instant::from_secs(24 * 3600)).unwrap();
        assert!(!executor.waiting().contains(&"port"), "{self}");
        assert_eq!(world.borrow().record().violations, [], "{self}");
        world
    }

    /// Has the port of X carry out these works, one after the other. Returns the world and where the count stands.
    pub(crate) fn makes<W: Work + 'static>(self, works: Vec<(Instant, W)>, motors: Motors) -> (Shared, i32) {
        let position_steps = Rc::new(Cell::new(0));
        let counted = position_steps.clone();
        let world = self.run(|mut port, _| async move {
            let step_counter = StepCounter::new();
            for (start, work) in works {
                carry_out(&mut port, work, (start, motors), &step_counter).await.unwrap();
            }
            counted.set(step_counter.position_steps());
        });
        (world, position_steps.get())
    }

    /// The capabilities of the port of X.
    pub fn capabilities(self) -> Capabilities {
        let found = Rc::new(RefCell::new(None));
        let kept = found.clone();
        self.run(|port, _| async move {
            kept.replace(Some(port.capabilities()));
        });
        found.take().unwrap()
    }

    /// Compares every edge with the closed form of the moves, given with the instants at which they began, in the order
    /// in which they were made.
    pub fn assert_plans(self, edges: &[Edge], moves: &[(Instant, Plan)]) {
        self.assert_edges(edges, moves.iter().flat_map(|(start, plan)| plan.instants_ns(*start)));
    }

    /// Compares every edge with an instant, ns since power-up, and a direction, when the ports are let go at the start.
    pub(crate) fn assert_edges(self, edges: &[Edge], planned: impl Iterator<Item = (f64, i32)>) {
        let planned: Vec<_> = planned.collect();
        let tick_hz = self.capabilities().tick_hz;
        let lead_ns = self.ports.lead().as_micros() as f64 * 1e3;
        // An edge is on the nearest tick.
        let tolerance_ns = (0.5 + fit_error_max_ticks(tick_hz)) * 1e9 / f64::from(tick_hz);
        assert_eq!(edges.len(), planned.len(), "{self}");
        for (k, (edge, (at_ns, direction))) in edges.iter().zip(planned).enumerate() {
            let error_ns = edge.t_ns as f64 - at_ns - lead_ns;
            assert!(error_ns.abs() <= tolerance_ns, "{self}: edge {k} is off by {error_ns} ns");
            assert_eq!(edge.direction, direction, "{self}: edge {k}");
        }
    }
}

impl<P: Ports> fmt::Display for Rig<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, steps of {} ns and more", self.ports, self.driver.period_ns)
    }
}

/// The usual wiring of the only motor.
pub const WIRED: Motors =
    Motors { wiring: Wiring { direction_inverted: false, pulse_ns: 0 }, top_speed_steps_s: 20_000, second: None };

/// Lets an armed port go at `start`, or as soon after that as it is armed. Returns the instant at which it was let go.
pub async fn let_go(start_barrier: &StartBarrier, start: Instant) -> Instant {
    start_barrier.wait_armed().await;
    Timer::at(start).await;
    start_barrier.go(Instant::now());
    start_barrier.wait_begun().await
}

/// The work that a port can be given.
pub(crate) trait Work {
    /// Its items for a port with this tick rate, the end included.
    fn items(self, tick_hz: u32) -> Vec<StreamItem>;
}

impl Work for Plan {
    fn items(self, tick_hz: u32) -> Vec<StreamItem> {
        Plan::items(&self, tick_hz).chain([StreamItem::End]).collect()
    }
}

impl Work for Vec<StreamItem> {
    fn items(self, _tick_hz: u32) -> Vec<StreamItem> {
        self
    }
}

/// Has the port carry out a work. Lets it go and supplies its segments like the coordinator.
pub(crate) async fn carry_out(
    port: &mut impl StepPort,
    work: impl Work,
    (start, motors): (Instant, Motors),
    step_counter: &StepCounter,
) -> Result<(), PortFault> {
    let (queue, start_barrier) = (StreamQueue::new(), StartBarrier::new());
    let items = work.items(port.capabilities().tick_hz);
    let item = async {
        for item in items {
            queue.send(item).await;
        }
        pending::<Infallible>().await
    };
    let run = Run::new(motors, &start_barrier, &queue, step_counter);
    let side = join(let_go(&start_barrier, start), item);
    match select(port.run(run), side).await {
        Either::First(result) => result,
        Either::Second((_, never)) => match never {},
    }
}

/// The instants at which STEP of a motor has risen, ns.
pub fn rises(world: &Shared, motor: Motor) -> Vec<u64> {
    let is_rise = |wave: &&Wave| wave.wire == Wire::Step(motor) && wave.high;
    world.borrow().record().waves.iter().filter(is_rise).map(|wave| wave.t_ns).collect()
}

/// Every edge of STEP, in order.
#[must_use]
pub fn edges(world: &Shared) -> Vec<Edge> {
    world.borrow().record().edges.clone()
}
