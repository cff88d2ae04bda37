//! Tests of what the simulator needs from its own port. `isostep-conformance` tests what all ports promise.

use std::cell::RefCell;
use std::rc::Rc;

use embassy_time::Instant;
use isostep_motion::{StartBarrier, StepCounter, StreamQueue};
use isostep_profile::{IntervalSplit, Limits, SpeedProfile, SyncMove};

use super::*;
use crate::config::Config;
use crate::executor::Executor;
use crate::world::World;

/// A move at one constant speed.
fn steady(steps: i32, speed_steps_s: f64) -> SyncMove<1> {
    let (start_speed_steps_s, top_speed_steps_s) = (speed_steps_s, speed_steps_s);
    let limits = Limits {
        start_speed_steps_s,
        top_speed_steps_s,
        accel_steps_s2: 1e6,
        decel_steps_s2: 1e6,
        jerk_steps_s3: f64::INFINITY,
    };
    SyncMove::plan([steps], &[limits], IntervalSplit::Fastest, SpeedProfile::Trapezoid, None).unwrap()
}

/// A queue with all its steps.
fn queue_of(plan: &SyncMove<1>) -> StreamQueue {
    let queue = StreamQueue::new();
    let direction = Direction::of(plan.steps[0]);
    plan.segments(0, TICK_HZ).for_each(|segment| queue.try_send(StreamItem::Steps { segment, direction }).unwrap());
    queue
}

/// A start barrier that lets a port go as soon as it is armed.
fn open_barrier() -> StartBarrier {
    let barrier = StartBarrier::new();
    barrier.go(Instant::MIN);
    barrier
}

/// A run that starts as soon as the port is armed.
async fn run(
    port: &mut SimPort,
    wiring: Wiring,
    segments: &StreamQueue,
    step_counter: &StepCounter,
) -> Result<(), PortFault> {
    let motors = Motors { wiring, ..Motors::default() };
    port.run(Run::new(motors, &open_barrier(), segments, step_counter)).await
}

/// Runs `task` with X's port, with its driver energised; returns the instants of the edges, ns.
fn edges_ns<F, T>(task: F) -> Vec<u64>
where
    F: FnOnce(SimPort) -> T,
    T: Future<Output = ()> + 'static,
{
    let mut executor = Executor::new();
    let _current = executor.clock().clone().enter();
    let world = Rc::new(RefCell::new(World::new(executor.clock().clone(), &Config::default())));
    Output::new(&world, Wire::Enable).set_low().unwrap();
    let pins = AxisPins::new(&world, Axis::X);
    executor.spawn("port", task(SimPort::new(pins, executor.clock(), DriverTiming::DRV8825)));
    executor.run_until_quiescent(Instant::from_secs(10)).unwrap();
    assert_eq!(world.borrow().record().violations, []);
    world.borrow().record().edges.iter().map(|edge| edge.t_ns).collect()
}

#[test]
fn edges_rise_within_the_drivers_tick() {
    let edges = edges_ns(|mut port| async move {
        let queue = queue_of(&steady(3, 48_000.0));
        queue.try_send(StreamItem::End).unwrap();
        run(&mut port, Wiring::default(), &queue, &StepCounter::new()).await.unwrap();
    });
    // The 650 ns of DIR are rounded up to a microsecond. Then comes half a step, then whole steps of 20,833.3 ns,
    // rounded to multiples of 8.
    assert_eq!(edges, [11_416, 32_248, 53_080]);
}

#[test]
fn running_dry_is_a_fault_at_the_last_step_given() {
    let edges = edges_ns(|mut port| async move {
        let queue = queue_of(&steady(7, 1e5));
        let step_counter = StepCounter::new();
        assert_eq!(run(&mut port, Wiring::default(), &queue, &step_counter).await, Err(PortFault::Underrun));
        assert_eq!(Instant::now(), Instant::from_micros(67), "1 us, 65 us and the pulse");
        assert_eq!(step_counter.position_steps(), 7);
    });
    assert_eq!(edges.len(), 7);
}

#[test]
fn steps_too_close_do_not_rise() {
    let edges = edges_ns(|mut port| async move {
        let queue = queue_of(&steady(2, 1e5));
        let wiring = Wiring { pulse_ns: 9_000, ..Wiring::default() };
        let result = run(&mut port, wiring, &queue, &StepCounter::new()).await;
        // 9 us high, 1.9 us low.
        assert_eq!(result, Err(PortFault::TooFast { interval: 1_250, min: 1_363 }));
    });
    assert!(edges.is_empty());
}
