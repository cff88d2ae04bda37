//! What every [`StepPort`] promises: exact counts, instants to the tick, safe cancellation, no late step.

use std::cell::RefCell;
use std::convert::Infallible;
use std::future::pending;
use std::rc::Rc;

use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Timer};
use embedded_hal::digital::OutputPin;
use isostep_motion::{
    Axis, Direction, DriverTiming, Odometer, PortFault, Run, SegmentQueue, StepPort, TimerPort, Wiring,
};
use isostep_profile::{IntervalLaw, Limits, SyncMove};
use isostep_sim::Config;
use isostep_sim::executor::Executor;
use isostep_sim::pin::{Delay, Output};
use isostep_sim::world::{Edge, Shared, Wire, World};

const LIMITS: Limits = Limits {
    start_speed_steps_s: 0.0,
    top_speed_steps_s: 20_000.0,
    accel_steps_s2: 400_000.0,
    decel_steps_s2: 400_000.0,
};

/// Runs `task` with a port on X's pins, its motors energised; what the world saw.
fn with_port<F, T>(task: F) -> Shared
where
    F: FnOnce(TimerPort<Output, Output, Delay>) -> T,
    T: Future<Output = ()> + 'static,
{
    let mut executor = Executor::new();
    let _current = executor.clock().clone().enter();
    let world = Rc::new(RefCell::new(World::new(executor.clock().clone(), &Config::default())));
    Output::new(&world, Wire::Enable).set_low().unwrap();
    let (step, dir) = (Output::new(&world, Wire::Step(Axis::X)), Output::new(&world, Wire::Dir(Axis::X)));
    let port = TimerPort::new(step, dir, Delay::new(executor.clock()), DriverTiming::DRV8825);
    executor.spawn("port", task(port));
    executor.run_until_quiescent(Instant::from_secs(10)).unwrap();
    world
}

async fn run_all(
    port: &mut impl StepPort,
    start: Instant,
    plan: &SyncMove<1>,
    odometer: &Odometer,
) -> Result<(), PortFault> {
    let queue = SegmentQueue::new();
    let [n] = plan.steps;
    let run = Run { start, direction: Direction::of(n), wiring: Wiring::default(), steps: n.unsigned_abs() };
    let segments = plan.segments(0, port.capabilities().tick_hz);
    let feed = async {
        for segment in segments {
            queue.send(segment).await;
        }
        pending::<Infallible>().await
    };
    match select(port.run(run, &queue, odometer), feed).await {
        Either::First(result) => result,
        Either::Second(never) => match never {},
    }
}

async fn emit_all(port: &mut impl StepPort, start: Instant, plan: &SyncMove<1>, odometer: &Odometer) {
    run_all(port, start, plan, odometer).await.unwrap();
}

fn plan(steps: i32) -> SyncMove<1> {
    SyncMove::plan([steps], &[LIMITS], IntervalLaw::Fastest, None).unwrap()
}

fn edges(world: &Shared) -> Vec<Edge> {
    world.borrow().record().edges.clone()
}

#[test]
fn every_step_leaves_at_its_tick_there_and_back() {
    let world = with_port(|mut port| async move {
        let odometer = Odometer::new();
        emit_all(&mut port, Instant::from_millis(1), &plan(500), &odometer).await;
        emit_all(&mut port, Instant::from_millis(501), &plan(-501), &odometer).await;
        assert_eq!(odometer.position_steps(), -1);
    });
    let instants = |start_us: u64, steps: i32| {
        let ticks = plan(steps).segments(0, 1_000_000).flat_map(|segment| segment.ticks());
        ticks.map(move |tick| (start_us + tick) * 1_000).collect::<Vec<_>>()
    };
    let wanted = [instants(1_000, 500), instants(501_000, -501)].concat();
    assert_eq!(edges(&world).iter().map(|edge| edge.t_ns).collect::<Vec<_>>(), wanted);
    assert_eq!(world.borrow().record().violations, []);
    assert_eq!(world.borrow().counted_steps()[0], -1);
}

/// The future is dropped at 400 instants, spread by a fixed stride over the move and into its pulses.
#[test]
fn dropping_it_anywhere_leaves_the_exact_count_and_whole_pulses() {
    for i in 0..400 {
        let world = with_port(|mut port| async move {
            let odometer = Odometer::new();
            let start = Instant::from_millis(1);
            let cut = Timer::at(start + Duration::from_micros(i * 101));
            select(emit_all(&mut port, start, &plan(500), &odometer), cut).await;
            let stopped_at = odometer.position_steps();
            emit_all(&mut port, Instant::now(), &plan(-stopped_at - 3), &odometer).await;
            assert_eq!(odometer.position_steps(), -3, "cut {i}");
        });
        assert_eq!(world.borrow().counted_steps()[0], -3, "cut {i}");
        assert_eq!(world.borrow().record().violations, [], "cut {i}");
    }
}

#[test]
fn a_turn_waits_for_the_set_up_time_even_if_the_step_is_due() {
    let world = with_port(|mut port| async move {
        let odometer = Odometer::new();
        let limits = Limits { start_speed_steps_s: 20_000.0, ..LIMITS };
        for steps in [1, -1, 1] {
            // Long after the last pulse, so that only the set-up time holds the step back.
            Timer::after_millis(1).await;
            let plan = SyncMove::plan([steps], &[limits], IntervalLaw::Fastest, None).unwrap();
            // Due at this very tick: half a step at 20,000 steps/s ago.
            emit_all(&mut port, Instant::now() - Duration::from_micros(25), &plan, &odometer).await;
        }
    });
    assert_eq!(edges(&world).len(), 3);
    assert_eq!(world.borrow().record().violations, []);
}

#[test]
fn a_step_that_would_be_too_late_is_a_fault_and_does_not_leave() {
    let world = with_port(|mut port| async move {
        let odometer = Odometer::new();
        Timer::after_millis(5).await;
        let fault = run_all(&mut port, Instant::from_ticks(0), &plan(3), &odometer).await;
        assert!(matches!(fault, Err(PortFault::Late { late, max }) if late > max), "{fault:?}");
        assert_eq!(odometer.position_steps(), 0);
    });
    assert_eq!(edges(&world), []);
}

#[test]
fn the_highest_rate_it_claims_is_one_the_driver_takes() {
    let world = with_port(|mut port| async move {
        let rate = f64::from(port.capabilities().rate_max_steps_s(Wiring::default()));
        let limits = Limits { start_speed_steps_s: rate, top_speed_steps_s: rate, ..LIMITS };
        let plan = SyncMove::plan([1_000], &[limits], IntervalLaw::Fastest, None).unwrap();
        emit_all(&mut port, Instant::from_millis(1), &plan, &Odometer::new()).await;
    });
    let edges = edges(&world);
    assert_eq!(edges.len(), 1_000);
    assert!(edges.windows(2).all(|pair| pair[1].t_ns - pair[0].t_ns == 5_000), "200,000 steps/s");
    assert_eq!(world.borrow().record().violations, []);
}
