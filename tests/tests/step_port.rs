//! What every [`StepPort`] promises, on every port of the simulator behind every driver: edges at their closed-form
//! instants, exact counts, whole pulses, a fault instead of a wrong step. What a machine makes of it, on the emulated
//! board too, is in `isostep_tests::cases`.

use std::cell::RefCell;
use std::convert::Infallible;
use std::fmt;
use std::future::pending;
use std::rc::Rc;

use embassy_futures::join::join;
use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Timer};
use embedded_hal::digital::OutputPin;
use isostep_motion::{
    AXES, Axis, Capabilities, ConfigError, Direction, DriverTiming, Feed, Odometer, PortFault, Run, SegmentQueue,
    StartLine, StepPort, Wiring,
};
use isostep_profile::{ACCEL_MAX_STEPS_S2, IntervalLaw, Limits, SpeedLaw, SyncMove};
use isostep_sim::executor::Executor;
use isostep_sim::pin::Output;
use isostep_sim::port::AxisPort;
use isostep_sim::time::{self, Clock};
use isostep_sim::world::{Edge, Shared, Wire, World};
use isostep_sim::{Config, Port, Sim};
use isostep_tests::cases;
use isostep_tests::rig::{Rig as _, Simulated};
use oorandom::Rand32;

/// A port of one kind on X's pins, a driver behind it.
#[derive(Clone, Copy, Debug)]
struct Rig {
    port: Port,
    driver: DriverTiming,
}

impl Rig {
    fn all() -> impl Iterator<Item = Self> {
        let drivers = [DriverTiming::DRV8825, DriverTiming::TMC2209];
        Port::ALL.into_iter().flat_map(move |port| drivers.map(|driver| Self { port, driver }))
    }

    /// Runs `task` with the port; what the world saw.
    fn run<F, T>(self, task: F) -> Shared
    where
        F: FnOnce(AxisPort, Clock) -> T,
        T: Future<Output = ()> + 'static,
    {
        let mut executor = Executor::new();
        let clock = executor.clock().clone();
        let _current = clock.enter();
        let config = Config { port: self.port, driver: self.driver, ..Config::default() };
        let world = Rc::new(RefCell::new(World::new(clock.clone(), &config)));
        Output::new(&world, Wire::Enable).set_low().unwrap();
        let [port, ..] = AxisPort::all(&config, &mut executor, &world);
        executor.spawn("port", task(port, clock.clone()));
        executor.run_until_quiescent(Instant::from_secs(24 * 3600)).unwrap();
        assert!(!executor.waiting().contains(&"port"), "{self}");
        assert_eq!(world.borrow().record().violations, [], "{self}");
        world
    }

    fn capabilities(self) -> Capabilities {
        let found = Rc::new(RefCell::new(None));
        let kept = found.clone();
        self.run(|port, _| async move {
            kept.replace(Some(port.capabilities()));
        });
        found.take().unwrap()
    }

    /// Holds every edge against the closed form of the moves, which began at these instants and ended or were ended in
    /// this order.
    fn hold(self, edges: &[Edge], moves: &[(Instant, Plan)]) {
        self.hold_to(edges, moves.iter().flat_map(|(start, plan)| plan.instants_ns(*start)));
    }

    /// Holds every edge against an instant, ns since power-up, and a direction.
    fn hold_to(self, edges: &[Edge], planned: impl Iterator<Item = (f64, i32)>) {
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

/// An axis's part of a move: the second of two, the first being the longer.
#[derive(Clone, Copy, Debug)]
struct Plan(SyncMove<2>);

const LIMITS: Limits = Limits {
    start_speed_steps_s: 0.0,
    top_speed_steps_s: 20_000.0,
    accel_steps_s2: 400_000.0,
    decel_steps_s2: 400_000.0,
    jerk_steps_s3: f64::INFINITY,
};

impl Plan {
    fn new(steps: i32) -> Self {
        Self::within(steps, LIMITS)
    }

    fn within(steps: i32, limits: Limits) -> Self {
        Self::beside(steps, steps, limits)
    }

    fn beside(longer: i32, steps: i32, limits: Limits) -> Self {
        Self(SyncMove::plan([longer, steps], &[limits; 2], IntervalLaw::Fastest, SpeedLaw::Trapezoid, None).unwrap())
    }

    fn steps(&self) -> i32 {
        self.0.steps[1]
    }

    /// Its steps, as a port of this tick rate is given them.
    fn feeds(&self, tick_hz: u32) -> impl Iterator<Item = Feed> + use<> {
        let direction = Direction::of(self.steps());
        self.0.segments(1, tick_hz).map(move |segment| Feed::Steps { segment, direction })
    }

    /// In closed form, ns since power-up, and the direction.
    fn instants_ns(self, start: Instant) -> impl Iterator<Item = (f64, i32)> {
        let start_ns = time::ns(start) as f64;
        let of = move |k| (start_ns + self.0.step_time_s(1, k) * 1e9, self.steps().signum());
        (1..=self.steps().unsigned_abs()).map(of)
    }
}

/// As drivers are wired usually.
const WIRED: Run = Run { wiring: Wiring { direction_inverted: false, pulse_ns: 0 } };

/// What it is given moves it so far.
fn steps_of(feed: Feed) -> i32 {
    match feed {
        Feed::Steps { segment, direction } => segment.steps() as i32 * direction.sign(),
        Feed::Rest { .. } | Feed::End => 0,
    }
}

/// Lets a port that is armed go at `start`, or as soon as it is armed after that: when it has begun.
async fn let_go(start_line: &StartLine, start: Instant) -> Instant {
    start_line.wait_armed().await;
    Timer::at(start).await;
    start_line.go();
    start_line.wait_begun().await
}

/// Moves one after the other, each from the instant on at which the one before ends, to the port's tick.
#[derive(Clone, Debug, Default)]
struct Chain {
    tick_hz: u32,
    /// When each begins, ticks from the start of the run.
    moves: Vec<(u64, Plan)>,
    end_ticks: u64,
}

impl Chain {
    fn new(tick_hz: u32, plans: impl IntoIterator<Item = Plan>) -> Self {
        let mut chain = Self { tick_hz, ..Self::default() };
        for plan in plans {
            let lasts_ticks = (plan.0.end_s() * f64::from(tick_hz)).ceil() as u64;
            chain.push(plan, lasts_ticks);
        }
        chain
    }

    /// Single steps to and fro, so many ticks apart.
    fn to_and_fro(tick_hz: u32, steps: i32, period_ticks: u32) -> Self {
        let rate = f64::from(tick_hz) / f64::from(period_ticks);
        let limits = Limits { start_speed_steps_s: rate, top_speed_steps_s: rate, ..LIMITS };
        let mut chain = Self { tick_hz, ..Self::default() };
        (0..steps).for_each(|k| chain.push(Plan::within(1 - 2 * (k % 2), limits), period_ticks.into()));
        chain
    }

    /// A hundred moves of up to `steps` steps at random speeds, there and back by chance.
    fn random(random: &mut Rand32, capabilities: &Capabilities, steps: u32) -> Self {
        let rate = f64::from(capabilities.rate_max_steps_s(Wiring::default()));
        let plan = |_| {
            // By turns as fast as can be, and slow.
            let speed = 1_000.0 + (rate - 1_000.0) * f64::from(random.rand_float()).powi(3);
            let start = speed * f64::from(random.rand_float());
            let limits = Limits { start_speed_steps_s: start, top_speed_steps_s: speed, ..LIMITS };
            let steps = 1 + random.rand_range(0..steps) as i32;
            Plan::within(if random.rand_range(0..2) == 0 { steps } else { -steps }, limits)
        };
        Self::new(capabilities.tick_hz, (0..100).map(plan))
    }

    fn push(&mut self, plan: Plan, lasts_ticks: u64) {
        self.moves.push((self.end_ticks, plan));
        self.end_ticks += lasts_ticks;
    }

    fn steps(&self) -> i32 {
        self.moves.iter().map(|(_, plan)| plan.steps()).sum()
    }

    /// As a port is given them, to the end.
    fn feeds(&self) -> Vec<Feed> {
        let later = |(begin_ticks, plan): &(u64, Plan)| {
            let begin_ticks = *begin_ticks;
            plan.feeds(self.tick_hz).map(move |feed| delayed(feed, begin_ticks))
        };
        self.moves.iter().flat_map(later).chain([Feed::End]).collect()
    }

    /// In closed form, ns since power-up, and the direction.
    fn instants_ns(&self, start: Instant) -> impl Iterator<Item = (f64, i32)> {
        let ns_per_tick = 1e9 / f64::from(self.tick_hz);
        self.moves.iter().flat_map(move |(begin_ticks, plan)| {
            let begin_ns = *begin_ticks as f64 * ns_per_tick;
            plan.instants_ns(start).map(move |(at_ns, direction)| (at_ns + begin_ns, direction))
        })
    }
}

fn delayed(feed: Feed, ticks: u64) -> Feed {
    match feed {
        Feed::Steps { segment, direction } => Feed::Steps { segment: segment.delayed(ticks), direction },
        Feed::Rest { until_ticks } => Feed::Rest { until_ticks: until_ticks + ticks },
        Feed::End => Feed::End,
    }
}

/// Has the port carry out a plan, let go and its segments fed as the coordinator does.
async fn carry_out(
    port: &mut AxisPort,
    plan: Plan,
    at: (Instant, Wiring),
    odometer: &Odometer,
) -> Result<(), PortFault> {
    let feeds = plan.feeds(port.capabilities().tick_hz).chain([Feed::End]).collect();
    carry_out_all(port, feeds, at, odometer).await
}

/// The same, of whatever the port is given.
async fn carry_out_all(
    port: &mut AxisPort,
    feeds: Vec<Feed>,
    (start, wiring): (Instant, Wiring),
    odometer: &Odometer,
) -> Result<(), PortFault> {
    let (queue, start_line) = (SegmentQueue::new(), StartLine::new());
    let feed = async {
        for feed in feeds {
            queue.send(feed).await;
        }
        pending::<Infallible>().await
    };
    let side = join(let_go(&start_line, start), feed);
    match select(port.run(Run { wiring }, &start_line, &queue, odometer), side).await {
        Either::First(result) => result,
        Either::Second((_, never)) => match never {},
    }
}

fn edges(world: &Shared) -> Vec<Edge> {
    world.borrow().record().edges.clone()
}

#[test]
fn every_step_leaves_at_its_instant_there_and_back() {
    for rig in Rig::all() {
        let moves = [(1, 500), (101, -501), (201, 1), (211, -1), (221, 2)];
        let moves = moves.map(|(at_ms, steps)| (Instant::from_millis(at_ms), Plan::new(steps)));
        let world = rig.run(|mut port, _| async move {
            let odometer = Odometer::new();
            for (start, plan) in moves {
                carry_out(&mut port, plan, (start, Wiring::default()), &odometer).await.unwrap();
            }
            assert_eq!(odometer.position_steps(), 1);
        });
        rig.hold(&edges(&world), &moves);
    }
}

#[test]
fn directions_can_be_inverted() {
    for rig in Rig::all() {
        let world = rig.run(|mut port, _| async move {
            let odometer = Odometer::new();
            let wiring = Wiring { direction_inverted: true, ..Wiring::default() };
            carry_out(&mut port, Plan::new(5), (Instant::from_millis(1), wiring), &odometer).await.unwrap();
            assert_eq!(odometer.position_steps(), 5);
        });
        assert_eq!(world.borrow().counted_steps()[0], -5, "{rig}");
    }
}

#[test]
fn pulses_are_as_wide_as_the_driver_or_the_wiring_asks() {
    for rig in Rig::all() {
        for asked_ns in [0, 2_000, 10_000] {
            let wiring = Wiring { pulse_ns: asked_ns, ..Wiring::default() };
            let world = rig.run(|mut port, _| async move {
                let start = Instant::from_millis(1);
                carry_out(&mut port, Plan::new(3), (start, wiring), &Odometer::new()).await.unwrap();
            });
            let world = world.borrow();
            let step = world.record().waves.iter().filter(|wave| wave.wire == Wire::Step(Axis::X));
            let pulses: Vec<_> = step.skip_while(|wave| !wave.high).collect();
            let widths_ns: Vec<_> = pulses.chunks(2).map(|pulse| pulse[1].t_ns - pulse[0].t_ns).collect();
            assert_eq!(widths_ns, [u64::from(asked_ns.max(rig.driver.step_high_ns)); 3], "{rig}");
        }
    }
}

/// The run is dropped at 400 instants, spread by a fixed stride over the move and into its pulses, with the brake on as a
/// stopped machine has it.
#[test]
fn stopping_it_anywhere_leaves_the_exact_count_and_whole_pulses() {
    for rig in Rig::all() {
        for i in 0..400 {
            let world = rig.run(|mut port, clock| async move {
                let odometer = Odometer::new();
                let (start, brake) = (Instant::from_millis(1), port.brake());
                let cut = async {
                    clock.until(time::ns(start) + i * 177_013).await;
                    brake(true);
                };
                select(carry_out(&mut port, Plan::new(500), (start, Wiring::default()), &odometer), cut).await;
                let stopped_at = odometer.position_steps();
                Timer::after_millis(1).await;
                assert_eq!(odometer.position_steps(), stopped_at, "{rig}, cut {i}");
                brake(false);
                let (start, back) = (Instant::now() + Duration::from_millis(1), Plan::new(-stopped_at - 3));
                carry_out(&mut port, back, (start, Wiring::default()), &odometer).await.unwrap();
                assert_eq!(odometer.position_steps(), -3, "{rig}, cut {i}");
            });
            assert_eq!(world.borrow().counted_steps()[0], -3, "{rig}, cut {i}");
        }
    }
}

/// Let go at once, at the highest speed from the first step on: the driver's set-up times are kept all the same, and every
/// step is at its instant from the start that the port chose.
#[test]
fn a_port_starts_when_it_can_keep_its_first_step() {
    for rig in Rig::all() {
        let rate = f64::from(rig.capabilities().rate_max_steps_s(Wiring::default()));
        let limits = Limits { start_speed_steps_s: rate, top_speed_steps_s: rate, ..LIMITS };
        let plans = [1, -1, 1].map(|steps| Plan::within(steps, limits));
        let begun = Rc::new(RefCell::new(Vec::new()));
        let told = begun.clone();
        let world = rig.run(|mut port, _| async move {
            for plan in plans {
                let (queue, start_line) = (SegmentQueue::new(), StartLine::new());
                for feed in plan.feeds(port.capabilities().tick_hz).chain([Feed::End]) {
                    queue.try_send(feed).unwrap();
                }
                let odometer = Odometer::new();
                let run = port.run(WIRED, &start_line, &queue, &odometer);
                let (result, at) = join(run, let_go(&start_line, Instant::MIN)).await;
                assert_eq!((result, odometer.position_steps()), (Ok(()), plan.steps()), "{rig}");
                told.borrow_mut().push((at, plan));
            }
        });
        rig.hold(&edges(&world), &begun.take());
    }
}

#[test]
fn an_armed_port_makes_no_step_before_it_is_let_go() {
    for rig in Rig::all() {
        let start = Instant::from_secs(3_600);
        let world = rig.run(|mut port, _| async move {
            carry_out(&mut port, Plan::new(500), (start, Wiring::default()), &Odometer::new()).await.unwrap();
        });
        rig.hold(&edges(&world), &[(start, Plan::new(500))]);
    }
}

/// Dropped at the start line, and let go only then.
#[test]
fn a_run_dropped_before_its_start_makes_no_step() {
    for rig in Rig::all() {
        let world = rig.run(|mut port, _| async move {
            let odometer = Odometer::new();
            let late = (Instant::from_secs(1), Wiring::default());
            select(carry_out(&mut port, Plan::new(3), late, &odometer), Timer::after_millis(5)).await;
            Timer::after_secs(2).await;
            assert_eq!(odometer.position_steps(), 0, "{rig}");
            let again = (Instant::from_secs(3), Wiring::default());
            carry_out(&mut port, Plan::new(2), again, &odometer).await.unwrap();
            assert_eq!(odometer.position_steps(), 2, "{rig}");
        });
        rig.hold(&edges(&world), &[(Instant::from_secs(3), Plan::new(2))]);
    }
}

/// After the first segments nothing comes for a second. What then comes is too late for every port.
#[test]
fn running_dry_is_a_fault_and_nothing_rises_after_it() {
    for rig in Rig::all() {
        let (start, plan) = (Instant::from_millis(1), Plan::new(500));
        let world = rig.run(|mut port, _| async move {
            let (queue, start_line, odometer) = (SegmentQueue::new(), StartLine::new(), Odometer::new());
            let mut feeds = plan.feeds(port.capabilities().tick_hz);
            let fed: i32 = feeds.by_ref().take(3).inspect(|feed| queue.try_send(*feed).unwrap()).map(steps_of).sum();
            let feed = async {
                let_go(&start_line, start).await;
                Timer::after_secs(1).await;
                for feed in feeds {
                    queue.send(feed).await;
                }
                pending::<Infallible>().await
            };
            let Either::First(result) = select(port.run(WIRED, &start_line, &queue, &odometer), feed).await;
            assert!(matches!(result, Err(PortFault::Underrun | PortFault::Late { .. })), "{rig}: {result:?}");
            assert_eq!(odometer.position_steps(), fed, "{rig}");
        });
        let edges = edges(&world);
        let last = edges.last().unwrap().t_ns;
        assert!(last < time::ns(start) + 100_000_000, "{rig}: nothing but what was given in time");
    }
}

#[test]
fn steps_that_are_too_close_for_the_pulses_end_in_a_fault_not_in_a_cut_pulse() {
    for rig in Rig::all() {
        let count = Rc::new(RefCell::new(0));
        let counted = count.clone();
        let world = rig.run(|mut port, _| async move {
            let odometer = Odometer::new();
            // 20,000 steps/s are 50 us apart.
            let wiring = Wiring { pulse_ns: 60_000, ..Wiring::default() };
            let result = carry_out(&mut port, Plan::new(2_000), (Instant::from_millis(1), wiring), &odometer).await;
            assert!(matches!(result, Err(PortFault::TooFast { .. } | PortFault::Late { .. })), "{rig}: {result:?}");
            counted.replace(odometer.position_steps());
        });
        let count = count.take();
        assert!(count > 0, "{rig}: the slow steps are made");
        assert_eq!(edges(&world).len() as i32, count, "{rig}");
    }
}

#[test]
fn the_highest_rate_it_claims_works_from_rest_and_the_next_is_refused() {
    for rig in Rig::all() {
        let capabilities = rig.capabilities();
        let rate = f64::from(capabilities.rate_max_steps_s(Wiring::default()));
        // A ramp of at least 500 steps.
        let accel = (rate * rate / 1_000.0).min(ACCEL_MAX_STEPS_S2);
        let limits = Limits {
            start_speed_steps_s: 0.0,
            top_speed_steps_s: rate,
            accel_steps_s2: accel,
            decel_steps_s2: accel,
            jerk_steps_s3: f64::INFINITY,
        };
        let moves = [2_000, -2_001].map(|steps| Plan::within(steps, limits));
        let moves = [1, 101].map(Instant::from_millis).into_iter().zip(moves).collect::<Vec<_>>();
        let carried_out = moves.clone();
        let world = rig.run(|mut port, _| async move {
            for (start, plan) in carried_out {
                carry_out(&mut port, plan, (start, Wiring::default()), &Odometer::new()).await.unwrap();
            }
        });
        rig.hold(&edges(&world), &moves);

        let mut config = Sim::new(&Config::default()).machine().config();
        config.wiring = [Wiring::default(); AXES];
        config.limits = [limits; AXES];
        assert_eq!(config.check([Some(capabilities); AXES]), Ok(()), "{rig}");
        config.limits[2].top_speed_steps_s = rate + 1.0;
        let refused = config.check([Some(capabilities); AXES]);
        assert!(
            matches!(refused, Err(ConfigError::Rate { axis: Axis::Z, max, .. }) if max == rate),
            "{rig}: {refused:?}"
        );
    }
}

/// Three steps over three hours: an hour is 4.5e11 ticks of 8 ns, far beyond 32 bits.
#[test]
fn steps_may_be_an_hour_apart() {
    for rig in Rig::all() {
        let limits = Limits { top_speed_steps_s: 1.0, accel_steps_s2: 1.0, decel_steps_s2: 1.0, ..LIMITS };
        let moves = [(Instant::from_millis(1), Plan::beside(10_800, 3, limits))];
        let world = rig.run(|mut port, _| async move {
            let [(start, plan)] = moves;
            carry_out(&mut port, plan, (start, Wiring::default()), &Odometer::new()).await.unwrap();
        });
        rig.hold(&edges(&world), &moves);
    }
}

/// Seed of the random chains.
const SEED: u64 = 11;

#[test]
fn moves_there_and_back_in_one_run_are_exact() {
    for rig in Rig::all() {
        let mut random = Rand32::new(SEED);
        for steps in [1, 2, 16, 100] {
            let chain = Chain::random(&mut random, &rig.capabilities(), steps);
            let (start, feeds, net) = (Instant::from_millis(1), chain.feeds(), chain.steps());
            let world = rig.run(|mut port, _| async move {
                let odometer = Odometer::new();
                carry_out_all(&mut port, feeds, (start, Wiring::default()), &odometer).await.unwrap();
                assert_eq!(odometer.position_steps(), net, "{rig}, SEED={SEED}");
            });
            rig.hold_to(&edges(&world), chain.instants_ns(start));
        }
    }
}

/// As close as the port takes steps in one direction.
#[test]
fn steps_to_and_fro_may_be_as_close_as_others() {
    for rig in Rig::all() {
        let capabilities = rig.capabilities();
        for pulse_ns in [0, 3_000] {
            let wiring = Wiring { pulse_ns, ..Wiring::default() };
            let chain = Chain::to_and_fro(capabilities.tick_hz, 1_001, capabilities.period_min_ticks(wiring));
            let (start, feeds) = (Instant::from_millis(1), chain.feeds());
            let world = rig.run(|mut port, _| async move {
                let odometer = Odometer::new();
                carry_out_all(&mut port, feeds, (start, wiring), &odometer).await.unwrap();
                assert_eq!(odometer.position_steps(), 1, "{rig}");
            });
            rig.hold_to(&edges(&world), chain.instants_ns(start));
        }
    }
}

/// A quarter closer: the run ends by a fault; no pulse is cut short, and DIR's times are kept.
#[test]
fn steps_to_and_fro_that_are_too_close_are_refused() {
    for rig in Rig::all() {
        let capabilities = rig.capabilities();
        let period_ticks = capabilities.period_min_ticks(Wiring::default()) * 3 / 4;
        let chain = Chain::to_and_fro(capabilities.tick_hz, 2_000, period_ticks);
        let (start, feeds) = (Instant::from_millis(1), chain.feeds());
        let counted = Rc::new(RefCell::new(0));
        let told = counted.clone();
        let world = rig.run(|mut port, _| async move {
            let odometer = Odometer::new();
            let result = carry_out_all(&mut port, feeds, (start, Wiring::default()), &odometer).await;
            assert!(matches!(result, Err(PortFault::TooFast { .. } | PortFault::Late { .. })), "{rig}: {result:?}");
            told.replace(odometer.position_steps());
        });
        assert_eq!(world.borrow().counted_steps()[0], counted.take(), "{rig}");
    }
}

/// Stopped in the midst of a random chain, with the brake on and dropped; inverted or not.
#[test]
fn stopping_it_between_reversals_leaves_the_exact_count() {
    for rig in Rig::all() {
        let mut random = Rand32::new(SEED);
        for i in 0..200 {
            let chain = Chain::random(&mut random, &rig.capabilities(), 12);
            let start = Instant::from_millis(1);
            let lasts_ns = (1_000_000_000 * chain.end_ticks / u64::from(chain.tick_hz)) as u32;
            let (stop_ns, feeds) = (time::ns(start) + u64::from(random.rand_range(0..lasts_ns)), chain.feeds());
            let inverted = i % 2 == 1;
            let wiring = Wiring { direction_inverted: inverted, ..Wiring::default() };
            let world = rig.run(|mut port, clock| async move {
                let (odometer, brake) = (Odometer::new(), port.brake());
                let cut = async {
                    clock.until(stop_ns).await;
                    brake(true);
                };
                select(carry_out_all(&mut port, feeds, (start, wiring), &odometer), cut).await;
                let stopped_at = odometer.position_steps();
                Timer::after_millis(1).await;
                assert_eq!(odometer.position_steps(), stopped_at, "{rig}, SEED={SEED}, stop {i}");
                brake(false);
                let back = Plan::new(-stopped_at - 2_000);
                carry_out(&mut port, back, (Instant::now(), wiring), &odometer).await.unwrap();
                assert_eq!(odometer.position_steps(), -2_000, "{rig}, SEED={SEED}, stop {i}");
            });
            let seen = world.borrow().counted_steps()[0];
            assert_eq!(seen, if inverted { 2_000 } else { -2_000 }, "{rig}, SEED={SEED}, stop {i}");
        }
    }
}

/// While it runs the odometer shows where the edges have led, as of 10 ms ago or less.
#[test]
fn the_count_follows_through_reversals() {
    for rig in Rig::all() {
        let mut random = Rand32::new(SEED);
        let chain = Chain::random(&mut random, &rig.capabilities(), 60);
        let (start, feeds) = (Instant::from_millis(1), chain.feeds());
        let looks = Rc::new(RefCell::new(Vec::new()));
        let noted = looks.clone();
        let world = rig.run(|mut port, _| async move {
            let odometer = Odometer::new();
            let look = async {
                loop {
                    Timer::after_micros(random.rand_range(100..5_000).into()).await;
                    noted.borrow_mut().push((time::ns(Instant::now()), odometer.position_steps()));
                }
            };
            let run = carry_out_all(&mut port, feeds, (start, Wiring::default()), &odometer);
            let Either::First(result) = select(run, look).await;
            result.unwrap();
        });
        let edges = edges(&world);
        assert!(looks.borrow().len() > 20, "{rig}");
        for &(now_ns, steps) in looks.borrow().iter() {
            // A step may rise at the instant of the look.
            let seen = edges.iter().take_while(|edge| edge.t_ns <= now_ns);
            let (old, recent): (Vec<&Edge>, Vec<&Edge>) = seen.partition(|edge| edge.t_ns + 10_000_000 < now_ns);
            let was = old.last().map_or(0, |edge| edge.position_steps);
            let is_recent = was == steps || recent.iter().any(|edge| edge.position_steps == steps);
            assert!(is_recent, "{rig}, SEED={SEED}: {steps} steps at {now_ns} ns");
        }
    }
}

/// No step at all, after many rests, one or none; and a step behind minutes of them. A run begins and ends all the same, and
/// not before it is let go.
#[test]
fn an_axis_may_rest_throughout_its_run() {
    const STEP_AT_S: u64 = 120;
    for rig in Rig::all() {
        let tick_hz = u64::from(rig.capabilities().tick_hz);
        let rests = |count: u64| (1..=count).map(move |k| Feed::Rest { until_ticks: k * tick_hz * 15 / 1_000 });
        let step = Plan::new(-1).feeds(tick_hz as u32).map(|feed| delayed(feed, STEP_AT_S * tick_hz));
        let late = rests(STEP_AT_S * 66).chain(step).collect::<Vec<_>>();
        let start = Instant::from_secs(1);
        for feeds in [vec![], rests(1).collect(), rests(1_000).collect(), late.clone(), vec![]] {
            let makes = feeds.iter().copied().map(steps_of).sum::<i32>();
            let world = rig.run(|mut port, _| async move {
                let odometer = Odometer::new();
                let feeds = feeds.into_iter().chain([Feed::End]).collect();
                carry_out_all(&mut port, feeds, (start, Wiring::default()), &odometer).await.unwrap();
                assert!(Instant::now() >= start, "{rig}: it ended before it began");
                assert_eq!(odometer.position_steps(), makes, "{rig}");
                // And another, which turns.
                let at = (Instant::now() + Duration::from_millis(1), Wiring::default());
                carry_out(&mut port, Plan::new(2), at, &odometer).await.unwrap();
                assert_eq!(odometer.position_steps(), makes + 2, "{rig}");
            });
            assert_eq!(world.borrow().counted_steps()[0], makes + 2, "{rig}");
        }
    }
}

#[test]
fn machines_keep_count_whenever_they_are_stopped() {
    Port::ALL.into_iter().for_each(|port| cases::stops_leave_the_exact_count(Simulated(port)));
}

#[test]
fn machines_make_single_steps_and_many_of_all_axes_there_and_back() {
    Port::ALL.into_iter().for_each(|port| cases::moves_there_and_back_are_exact(Simulated(port)));
}

#[test]
fn machines_take_as_long_as_planned_over_single_steps() {
    Port::ALL.into_iter().for_each(|port| cases::single_steps_take_as_long_as_planned(Simulated(port), 3.0));
}

#[test]
fn machines_make_every_speed_law() {
    for port in Port::ALL {
        cases::every_law_is_exact(Simulated(port), Simulated(port).pace());
    }
}

#[test]
fn machines_make_the_highest_rate_their_ports_take() {
    // 248,015 and 200,000 steps/s at 50 steps/mm.
    for (port, top_mm_min) in [(Port::Pio, 297_618), (Port::Timer, 240_000)] {
        cases::the_highest_rate_is_made(Simulated(port), top_mm_min);
    }
}
