//! The promises of every [`StepPort`] on the ports of the simulator, and what `TimerPort` promises besides.
//! `isostep_tests::cases` tests the same for whole machines, on the emulated board too.

use std::cell::{Cell, RefCell};
use std::convert::Infallible;
use std::fmt;
use std::future::pending;
use std::rc::Rc;

use embassy_futures::join::{join, join4};
use embassy_futures::poll_once;
use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Timer};
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use isostep_conformance::plan::{LIMITS, Plan, steps_of};
use isostep_conformance::rig::{WIRED, edges, let_go};
use isostep_conformance::{Bench, Ports, Rig};
use isostep_motion::{
    AXES, Axis, DriverTiming, MotorPins, Motors, PortFault, Run, StartBarrier, StepCounter, StepPort, StreamItem,
    StreamQueue, TimerBank,
};
use isostep_profile::Limits;
use isostep_sim::executor::{Executor, Priority};
use isostep_sim::pin::{Delay, Output};
use isostep_sim::port::{AxisPins, AxisPort};
use isostep_sim::time;
use isostep_sim::world::{Wire, World};
use isostep_sim::{Config, Port};
use isostep_tests::cases;
use isostep_tests::rig::{Rig as _, Simulated};

/// The simulator's ports of one kind.
#[derive(Clone, Copy)]
struct Of(Port);

impl Ports for Of {
    type Port = AxisPort;

    fn open(&self, bench: &mut Bench<'_>) -> [AxisPort; AXES] {
        let config = Config { port: self.0, driver: bench.driver, ..Config::default() };
        AxisPort::all(&config, bench.executor, bench.world)
    }
}

impl fmt::Display for Of {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} port", self.0)
    }
}

mod pio {
    isostep_conformance::keeps_its_promises!(super::Of(isostep_sim::Port::Pio));
}

mod timer {
    isostep_conformance::keeps_its_promises!(super::Of(isostep_sim::Port::Timer));
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
fn machines_make_every_speed_profile() {
    for port in Port::ALL {
        cases::every_speed_profile_is_exact(Simulated(port), Simulated(port).pace(), 1);
    }
}

#[test]
fn machines_make_the_highest_rate_their_ports_take() {
    // These are 248,015 and 200,000 steps/s at 50 steps/mm.
    for (port, top_mm_min) in [(Port::Pio, 297_618), (Port::Timer, 240_000)] {
        cases::the_highest_rate_is_made(Simulated(port), top_mm_min);
    }
}

/// A run may be stopped between arming and the start. What was signalled for it must not start the next one.
#[test]
fn a_start_barrier_forgets_an_earlier_run() {
    let line = StartBarrier::new();
    assert!(poll_once(line.armed()).is_pending(), "nobody has let it go");
    line.go(Instant::MIN);
    line.begun(Instant::from_ticks(1));
    line.reset();
    assert!(poll_once(line.wait_armed()).is_pending(), "armed for the run before");
    assert!(poll_once(line.wait_begun()).is_pending(), "begun in the run before");
    assert!(poll_once(line.armed()).is_pending(), "let go for the run before");
}

/// Steps are accepted up to half a period of the axis's top speed late, or up to half of the time that a step takes the
/// processor, 26 us and the pulse. Until shortly before the step that is late the port knows that none is due.
#[test]
fn a_step_that_is_too_late_by_microseconds_is_a_fault() {
    for (top_speed_steps_s, late_us, is_made) in [
        (2_400, 100, true),
        (2_400, 200, true),
        (2_400, 215, false),
        (2_400, 300, false),
        (20_000, 20, true),
        (20_000, 30, false),
        (200_000, 8, true),
        (200_000, 20, false),
        (100, 4_900, true),
        (100, 5_100, false),
    ] {
        let made = made_late(top_speed_steps_s, late_us);
        let is_late = matches!(made, Err(PortFault::Late { .. }));
        assert!(made.is_ok() == is_made && is_late != is_made, "{late_us} us late at {top_speed_steps_s}: {made:?}");
    }
}

/// Has an axis make steps, the second segment of which comes so late.
fn made_late(top_speed_steps_s: u32, late_us: u64) -> Result<(), PortFault> {
    let slow = Limits { top_speed_steps_s: 90.0, accel_steps_s2: 1_000.0, decel_steps_s2: 1_000.0, ..LIMITS };
    let result = Rc::new(Cell::new(None));
    let kept = result.clone();
    Rig::new(Of(Port::Timer), DriverTiming::DRV8825).run(move |mut port, _| async move {
        let (start, plan) = (Instant::from_millis(1), Plan::within(60, slow));
        let (queue, start_barrier, step_counter) = (StreamQueue::new(), StartBarrier::new(), StepCounter::new());
        let mut items = plan.items(port.capabilities().tick_hz);
        let fed: i32 = items.by_ref().take(1).inspect(|item| queue.try_send(*item).unwrap()).map(steps_of).sum();
        let due_ns = plan.instants_ns(start).nth(fed as usize).unwrap().0;
        let until_ticks = (due_ns as u64 - time::ns(start)) / 1_000 - 5;
        queue.try_send(StreamItem::Rest { until_ticks }).unwrap();
        let feed = async {
            let_go(&start_barrier, start).await;
            Timer::at(Instant::from_micros(due_ns as u64 / 1_000 + late_us)).await;
            send_all(&queue, items.chain([StreamItem::End])).await;
            pending::<Infallible>().await
        };
        let motors = Motors { top_speed_steps_s, ..WIRED };
        let run = Run::new(motors, &start_barrier, &queue, &step_counter);
        let Either::First(result) = select(port.run(run), feed).await;
        kept.set(Some(result));
    });
    result.get().expect("the run has ended")
}

/// The tasks of the axes may get no time while steps are due, so the task that makes the steps stops all axes itself, at
/// the instant at which it notices that one is late.
#[test]
fn a_step_that_is_too_late_stops_all_axes() {
    const LATE: Duration = Duration::from_millis(1);
    let rig = Rig::new(Of(Port::Timer), DriverTiming::DRV8825);
    let noticed = Rc::new(Cell::new(None));
    let noting = noticed.clone();
    let world = rig.run_all(|[mut x, mut y, ..], _| async move {
        let (start, plan) = (Instant::from_millis(1), Plan::new(3_000));
        let (queues, step_counters) = ([const { StreamQueue::new() }; 2], [const { StepCounter::new() }; 2]);
        let lines = [const { StartBarrier::new() }; 2];
        let items = plan.items(x.capabilities().tick_hz);
        let mut steps = 0;
        let (in_time, late): (Vec<_>, Vec<_>) = items.clone().partition(|&item| {
            steps += steps_of(item);
            steps < 1_500
        });
        let made: i32 = in_time.iter().copied().map(steps_of).sum();
        let due_ns = plan.instants_ns(start).nth(made as usize).unwrap().0;
        let feed_late = async {
            send_all(&queues[0], in_time.into_iter()).await;
            Timer::at(Instant::from_nanos(due_ns as u64) + LATE).await;
            send_all(&queues[0], late.into_iter()).await;
        };
        let go = join(let_go(&lines[0], start), let_go(&lines[1], start));
        let run = |axis: usize| {
            let (start_barrier, segments, step_counter) = (&lines[axis], &queues[axis], &step_counters[axis]);
            Run::new(WIRED, start_barrier, segments, step_counter)
        };
        let others = join4(y.run(run(1)), feed_late, send_all(&queues[1], items), go);
        let fault = async {
            let result = x.run(run(0)).await;
            assert!(matches!(result, Err(PortFault::Late { .. })), "{result:?}");
            noting.set(Some(time::ns(Instant::now())));
            Timer::after_millis(20).await;
        };
        assert!(matches!(select(fault, others).await, Either::First(())));
    });
    let noticed_ns = noticed.get().unwrap();
    let last = edges(&world).last().copied().unwrap();
    assert_eq!(last.axis, Axis::Y as usize);
    assert!((noticed_ns - 100_000..=noticed_ns).contains(&last.t_ns), "{last:?}, noticed at {noticed_ns} ns");
}

/// STEP and DIR of an axis on which DIR takes long to set, as behind a port expander.
struct SlowDir(AxisPins, Delay);

impl SlowDir {
    const NS: u32 = 20_000;
}

impl MotorPins for SlowDir {
    fn begin(&mut self, motors: &Motors) {
        self.0.begin(motors);
    }

    fn set_step(&mut self, high: bool) {
        self.0.set_step(high);
    }

    fn set_dir(&mut self, high: bool) {
        self.1.delay_ns(Self::NS);
        self.0.set_dir(high);
    }
}

const WAKE_UP: Duration = Duration::from_micros(10);
/// The rest with which Y begins, until the next item of it has to be there, and then some.
const REST_TICKS: u64 = 20_000;

/// The task that makes the steps wakes up for one, and in that instant learns of another axis's next segment. To go on to that
/// takes long, so it comes after the step.
#[test]
fn a_step_that_is_near_comes_before_what_is_new() {
    const STEP: usize = 50;
    let (due_ns, _) = Plan::new(200).instants_ns(Instant::MIN).nth(STEP).unwrap();
    let late_ns = late_beside(Duration::from_micros(due_ns as u64 / 1_000) - WAKE_UP);
    let late_ns = late_ns.into_iter().take(STEP + 1).fold(0.0, f64::max);
    assert!(late_ns < 1_000.0, "{late_ns} ns late");
}

/// The task wakes up to find out whether an item is missing, and in that instant it comes.
#[test]
fn an_item_that_comes_at_the_last_moment_is_in_time() {
    let late_max = Duration::from_hz(2 * u64::from(WIRED.top_speed_steps_s));
    let missing = Duration::from_ticks(REST_TICKS) + late_max + Duration::from_ticks(1);
    assert_eq!(late_beside(missing - WAKE_UP).len(), 200);
}

/// How late X makes each step, ns, while Y, whose DIR is slow, gets what follows its rest so long after the start.
fn late_beside(comes_after: Duration) -> Vec<f64> {
    const GO: Instant = Instant::from_millis(1);
    let bank: &'static TimerBank<AXES> = Box::leak(Box::new(TimerBank::new()));
    let mut executor = Executor::new();
    let clock = executor.clock().clone();
    let _current = clock.enter();
    let world = Rc::new(RefCell::new(World::new(clock.clone(), &Config::default())));
    Output::new(&world, Wire::Enable).set_low().unwrap();
    let pins = Axis::ALL.map(|axis| SlowDir(AxisPins::new(&world, axis), Delay::new(&clock)));
    let [mut x, mut y, ..] = bank.ports(DriverTiming::DRV8825, [|_engaged| {}; AXES]);
    let plan = Plan::new(200);
    // It is spawned first, so of both that are woken in an instant it goes first.
    executor.spawn("axes", async move {
        let (queues, lines) = ([const { StreamQueue::new() }; 2], [const { StartBarrier::new() }; 2]);
        let step_counters = [const { StepCounter::new() }; 2];
        let run = |axis: usize| Run::new(WIRED, &lines[axis], &queues[axis], &step_counters[axis]);
        let items = plan.items(x.capabilities().tick_hz).chain([StreamItem::End]);
        let later = items.clone().map(|item| match item {
            StreamItem::Steps { segment, direction } => {
                StreamItem::Steps { segment: segment.delayed(REST_TICKS), direction }
            }
            other => other,
        });
        let feed = async {
            queues[1].send(StreamItem::Rest { until_ticks: REST_TICKS }).await;
            let (start, _) = join(let_go(&lines[0], GO), let_go(&lines[1], GO)).await;
            Timer::at(start + comes_after).await;
            send_all(&queues[1], later).await;
        };
        let (made, others, ..) = join4(x.run(run(0)), y.run(run(1)), feed, send_all(&queues[0], items)).await;
        assert_eq!((made, others), (Ok(()), Ok(())));
    });
    let delay = Delay::new(&clock);
    executor.spawn_at(Priority::P2, "steps", async move { bank.drive(pins, delay, WAKE_UP).await });
    executor.run_until_quiescent(Instant::from_secs(1)).unwrap();
    let made_ns = edges(&world).into_iter().filter(|edge| edge.axis == Axis::X as usize).map(|edge| edge.t_ns);
    let due_ns = plan.instants_ns(GO + WAKE_UP).map(|(due_ns, _)| due_ns);
    assert_eq!(edges(&world).len(), 400);
    made_ns.zip(due_ns).map(|(made_ns, due_ns)| made_ns as f64 - due_ns).collect()
}

async fn send_all(queue: &StreamQueue, items: impl Iterator<Item = StreamItem>) {
    for item in items {
        queue.send(item).await;
    }
}
