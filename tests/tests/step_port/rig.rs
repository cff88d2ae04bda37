//! Equipment to test a [`StepPort`]: a port on X's pins with a driver, plans of one move and of several, and the part
//! of the coordinator in a run.

use std::cell::RefCell;
use std::convert::Infallible;
use std::fmt;
use std::future::pending;
use std::rc::Rc;

use embassy_futures::join::join;
use embassy_futures::select::{Either, select};
use embassy_time::{Instant, Timer};
use embedded_hal::digital::OutputPin;
use isostep_motion::{
    AXES, Capabilities, Direction, DriverTiming, Motor, Odometer, PortFault, Run, StartLine, StepPort, StreamItem,
    StreamQueue, Wiring,
};
use isostep_profile::{IntervalLaw, Limits, SpeedLaw, SyncMove};
use isostep_sim::executor::Executor;
use isostep_sim::pin::Output;
use isostep_sim::port::AxisPort;
use isostep_sim::time::{self, Clock};
use isostep_sim::world::{Edge, Shared, Wave, Wire, World};
use isostep_sim::{Config, Port};
use oorandom::Rand32;

/// A port of one kind on X's pins, with a driver.
#[derive(Clone, Copy, Debug)]
pub struct Rig {
    pub port: Port,
    pub driver: DriverTiming,
}

impl Rig {
    pub fn all() -> impl Iterator<Item = Self> {
        let drivers = [DriverTiming::DRV8825, DriverTiming::TMC2209];
        Port::ALL.into_iter().flat_map(move |port| drivers.map(|driver| Self { port, driver }))
    }

    /// Runs `task` with the port. Returns the simulated world with its record.
    pub fn run<F, T>(self, task: F) -> Shared
    where
        F: FnOnce(AxisPort, Clock) -> T,
        T: Future<Output = ()> + 'static,
    {
        self.run_all(|[port, ..], clock| task(port, clock))
    }

    /// Runs `task` with the ports of all axes.
    pub fn run_all<F, T>(self, task: F) -> Shared
    where
        F: FnOnce([AxisPort; AXES], Clock) -> T,
        T: Future<Output = ()> + 'static,
    {
        let mut executor = Executor::new();
        let clock = executor.clock().clone();
        let _current = clock.enter();
        let mut config = Config { port: self.port, driver: self.driver, ..Config::default() };
        // X has a second motor, which makes steps in runs that ask for it.
        config.settings.second_motor_axis = 1;
        let world = Rc::new(RefCell::new(World::new(clock.clone(), &config)));
        Output::new(&world, Wire::Enable).set_low().unwrap();
        let ports = AxisPort::all(&config, &mut executor, &world);
        executor.spawn("port", task(ports, clock.clone()));
        executor.run_until_quiescent(Instant::from_secs(24 * 3600)).unwrap();
        assert!(!executor.waiting().contains(&"port"), "{self}");
        assert_eq!(world.borrow().record().violations, [], "{self}");
        world
    }

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

    /// Compares every edge with an instant, ns since power-up, and a direction.
    pub fn assert_edges(self, edges: &[Edge], planned: impl Iterator<Item = (f64, i32)>) {
        let planned: Vec<_> = planned.collect();
        assert_eq!(edges.len(), planned.len(), "{self}");
        for (k, (edge, (at_ns, direction))) in edges.iter().zip(planned).enumerate() {
            let error_ns = edge.t_ns as f64 - at_ns;
            assert!(error_ns.abs() <= self.port.tolerance_ns(), "{self}: edge {k} is off by {error_ns} ns");
            assert_eq!(edge.direction, direction, "{self}: edge {k}");
        }
    }
}

impl fmt::Display for Rig {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} port, steps of {} ns and more", self.port, self.driver.period_ns)
    }
}

/// The plan of an axis in a move of two axes. The axis is the second; the first is the longer.
#[derive(Clone, Copy, Debug)]
pub struct Plan(pub SyncMove<2>);

pub const LIMITS: Limits = Limits {
    start_speed_steps_s: 0.0,
    top_speed_steps_s: 20_000.0,
    accel_steps_s2: 400_000.0,
    decel_steps_s2: 400_000.0,
    jerk_steps_s3: f64::INFINITY,
};

impl Plan {
    pub fn new(steps: i32) -> Self {
        Self::within(steps, LIMITS)
    }

    pub fn within(steps: i32, limits: Limits) -> Self {
        Self::beside(steps, steps, limits)
    }

    pub fn beside(longer: i32, steps: i32, limits: Limits) -> Self {
        Self(SyncMove::plan([longer, steps], &[limits; 2], IntervalLaw::Fastest, SpeedLaw::Trapezoid, None).unwrap())
    }

    pub fn steps(&self) -> i32 {
        self.0.steps[1]
    }

    /// The steps as the items for a port with this tick rate.
    pub fn items(&self, tick_hz: u32) -> impl Iterator<Item = StreamItem> + Clone + use<> {
        let direction = Direction::of(self.steps());
        self.0.segments(1, tick_hz).map(move |segment| StreamItem::Steps { segment, direction })
    }

    /// The closed-form instants of the steps, ns since power-up, and their direction.
    pub fn instants_ns(self, start: Instant) -> impl Iterator<Item = (f64, i32)> {
        let start_ns = time::ns(start) as f64;
        let of = move |k| (start_ns + self.0.step_time_s(1, k) * 1e9, self.steps().signum());
        (1..=self.steps().unsigned_abs()).map(of)
    }
}

/// The usual wiring of drivers.
pub const WIRED: Run = Run { wiring: Wiring { direction_inverted: false, pulse_ns: 0 }, second: None };

/// The signed number of steps that an item makes.
pub fn steps_of(item: StreamItem) -> i32 {
    match item {
        StreamItem::Steps { segment, direction } => segment.steps() as i32 * direction.sign(),
        StreamItem::Rest { .. } | StreamItem::End => 0,
    }
}

/// Lets an armed port go at `start`, or as soon after that as it is armed. Returns the instant at which it was let go.
pub async fn let_go(start_line: &StartLine, start: Instant) -> Instant {
    start_line.wait_armed().await;
    Timer::at(start).await;
    start_line.go();
    start_line.wait_begun().await
}

/// Consecutive moves. Each begins when the previous one ends, rounded to the port's tick.
#[derive(Clone, Debug, Default)]
pub struct Chain {
    pub tick_hz: u32,
    /// When each move begins, ticks from the start of the run, and its plan.
    pub moves: Vec<(u64, Plan)>,
    pub end_ticks: u64,
}

impl Chain {
    pub fn new(tick_hz: u32, plans: impl IntoIterator<Item = Plan>) -> Self {
        let mut chain = Self { tick_hz, ..Self::default() };
        for plan in plans {
            let lasts_ticks = (plan.0.end_s() * f64::from(tick_hz)).ceil() as u64;
            chain.push(plan, lasts_ticks);
        }
        chain
    }

    /// Single steps in alternating directions, `period_ticks` apart.
    pub fn to_and_fro(tick_hz: u32, steps: i32, period_ticks: u32) -> Self {
        let rate = f64::from(tick_hz) / f64::from(period_ticks);
        let limits = Limits { start_speed_steps_s: rate, top_speed_steps_s: rate, ..LIMITS };
        let mut chain = Self { tick_hz, ..Self::default() };
        (0..steps).for_each(|k| chain.push(Plan::within(1 - 2 * (k % 2), limits), period_ticks.into()));
        chain
    }

    /// A hundred moves of up to `steps` steps at random speeds and in random directions.
    pub fn random(random: &mut Rand32, capabilities: &Capabilities, steps: u32) -> Self {
        let rate = f64::from(capabilities.rate_max_steps_s(Wiring::default()));
        let plan = |_| {
            // Speeds range from the highest to slow; slow ones are more frequent.
            let speed = 1_000.0 + (rate - 1_000.0) * f64::from(random.rand_float()).powi(3);
            let start = speed * f64::from(random.rand_float());
            let limits = Limits { start_speed_steps_s: start, top_speed_steps_s: speed, ..LIMITS };
            let steps = 1 + random.rand_range(0..steps) as i32;
            Plan::within(if random.rand_range(0..2) == 0 { steps } else { -steps }, limits)
        };
        Self::new(capabilities.tick_hz, (0..100).map(plan))
    }

    pub fn push(&mut self, plan: Plan, lasts_ticks: u64) {
        self.moves.push((self.end_ticks, plan));
        self.end_ticks += lasts_ticks;
    }

    pub fn steps(&self) -> i32 {
        self.moves.iter().map(|(_, plan)| plan.steps()).sum()
    }

    /// The items for the port, the end included.
    pub fn items(&self) -> Vec<StreamItem> {
        let later = |(begin_ticks, plan): &(u64, Plan)| {
            let begin_ticks = *begin_ticks;
            plan.items(self.tick_hz).map(move |item| delayed(item, begin_ticks))
        };
        self.moves.iter().flat_map(later).chain([StreamItem::End]).collect()
    }

    /// The closed-form instants of the steps, ns since power-up, and their direction.
    pub fn instants_ns(&self, start: Instant) -> impl Iterator<Item = (f64, i32)> {
        let ns_per_tick = 1e9 / f64::from(self.tick_hz);
        self.moves.iter().flat_map(move |(begin_ticks, plan)| {
            let begin_ns = *begin_ticks as f64 * ns_per_tick;
            plan.instants_ns(start).map(move |(at_ns, direction)| (at_ns + begin_ns, direction))
        })
    }
}

pub fn delayed(item: StreamItem, ticks: u64) -> StreamItem {
    match item {
        StreamItem::Steps { segment, direction } => StreamItem::Steps { segment: segment.delayed(ticks), direction },
        StreamItem::Rest { until_ticks } => StreamItem::Rest { until_ticks: until_ticks + ticks },
        StreamItem::End => StreamItem::End,
    }
}

/// Has the port carry out a plan. Lets it go and supplies its segments like the coordinator.
pub async fn carry_out(
    port: &mut AxisPort,
    plan: Plan,
    at: (Instant, Wiring),
    odometer: &Odometer,
) -> Result<(), PortFault> {
    let items = plan.items(port.capabilities().tick_hz).chain([StreamItem::End]).collect();
    carry_out_all(port, items, at, odometer).await
}

/// The same with any items.
pub async fn carry_out_all(
    port: &mut AxisPort,
    items: Vec<StreamItem>,
    (start, wiring): (Instant, Wiring),
    odometer: &Odometer,
) -> Result<(), PortFault> {
    carry_out_run(port, items, (start, Run { wiring, second: None }), odometer).await
}

/// The same in any run.
pub async fn carry_out_run(
    port: &mut AxisPort,
    items: Vec<StreamItem>,
    (start, run): (Instant, Run),
    odometer: &Odometer,
) -> Result<(), PortFault> {
    let (queue, start_line) = (StreamQueue::new(), StartLine::new());
    let item = async {
        for item in items {
            queue.send(item).await;
        }
        pending::<Infallible>().await
    };
    let side = join(let_go(&start_line, start), item);
    match select(port.run(run, &start_line, &queue, odometer), side).await {
        Either::First(result) => result,
        Either::Second((_, never)) => match never {},
    }
}

/// The instants at which STEP of a motor has risen, ns.
pub fn rises(world: &Shared, motor: Motor) -> Vec<u64> {
    let is_rise = |wave: &&Wave| wave.wire == Wire::Step(motor) && wave.high;
    world.borrow().record().waves.iter().filter(is_rise).map(|wave| wave.t_ns).collect()
}

pub fn edges(world: &Shared) -> Vec<Edge> {
    world.borrow().record().edges.clone()
}
