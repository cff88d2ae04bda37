//! isostep-motion without a console: a program of your own asks for moves and waits for them. Pins, clock and executor are
//! simulated here; on a chip they are the HAL's.
//!
//! The tasks that a machine needs are `axis::run` for each axis and `coordinator::run`, and with `TimerPort` the one that
//! makes the steps. `limit::watch` is needed to home and to be stopped by a switch. All others may be left out:
//! `limit::watch_emergency_stop`, `tool::run`, `probing::watch`, `buttons::watch_hold`, `watch_start`.
//!
//! Run it with `cargo run -p isostep-sim --example 2_motion_alone`.

use std::cell::RefCell;
use std::rc::Rc;

use embassy_time::{Duration, Instant};
use isostep_motion::coordinator::{self, PlanMemory};
use isostep_motion::{AXES, Alarm, Axis, Contact, DriverTiming, Machine, Motion, Move, TimerBank, axis};
use isostep_sim::executor::{Executor, Priority};
use isostep_sim::pin::{Delay, Output};
use isostep_sim::port::AxisPins;
use isostep_sim::world::{Wire, World};

/// On a chip this is measured: from the alarm of the clock to the first reading of the clock by the task that makes the
/// steps, with all that may delay it. In virtual time code takes none.
const WAKE_UP: Duration = Duration::MIN;

/// Draws a square and returns to where it began.
async fn program(machine: &Machine) -> Result<(), Alarm> {
    for [x, y] in [[500, 0], [500, 500], [0, 500], [0, 0]] {
        let mut target_steps = [0; AXES];
        (target_steps[0], target_steps[1]) = (x, y);
        let motion = Motion::Move(Move { feed_mm_s: 20.0, ..Move::to(target_steps) });
        // It waits only while the queue is full: the moves are planned ahead, and follow each other.
        machine.submit(motion).await.expect("a machine that nobody stops accepts moves");
    }
    machine.settled().await
}

/// Runs it, and prints where the machine stood when.
pub fn main() {
    // The properties of the simulator's gantry. A program of your own uses `Config::new`.
    let config = isostep_controller::config(&isostep_controller::Settings::DEFAULT);
    // These live for ever, like statics on a chip.
    let machine: &'static Machine = Box::leak(Box::new(Machine::new(config, Contact::NormallyOpen)));
    let bank: &'static TimerBank<AXES> = Box::leak(Box::new(TimerBank::new()));

    let mut executor = Executor::new();
    let clock = executor.clock().clone();
    let world = Rc::new(RefCell::new(World::new(clock.clone(), &isostep_sim::Config::default())));
    let (pins, delay) = (Axis::ALL.map(|axis| AxisPins::new(&world, axis)), Delay::new(&clock));
    executor.spawn_at(Priority::P2, "steps", async move { bank.drive(pins, delay, WAKE_UP).await });
    // A stop takes no time in the simulator. On a chip each of these calls `bank.inhibit` for its axis.
    for (axis, mut port) in Axis::ALL.into_iter().zip(bank.ports(DriverTiming::DRV8825, [|_engaged| {}; AXES])) {
        executor.spawn_at(Priority::P2, "axis", async move { axis::run(machine, axis, &mut port).await });
    }
    let enable = Output::new(&world, Wire::Enable);
    executor.spawn("coordinator", async move {
        let mut memory = Box::new(PlanMemory::new());
        // On another chip these are measured, too, or those of a slower one.
        let least_times = isostep_controller::least_times::RP2040;
        coordinator::run(machine, &mut memory, &least_times, enable, |_event| {}).await;
    });
    executor.spawn("program", async move {
        program(machine).await.expect("it ends without an alarm");
    });

    for _ in 0..10 {
        executor.run_for(Duration::from_millis(250)).expect("nothing panics");
        let position_steps = machine.position_steps();
        println!("{:>5} ms  {position_steps:?}", executor.clock().now_ns() / 1_000_000);
    }
    executor.run_until_quiescent(Instant::from_secs(60)).expect("nothing panics");
    assert_eq!(machine.position_steps(), [0; AXES]);
    assert_eq!(world.borrow().steps()[..2], [1_000, 1_000]);
    println!("all that is planned ahead takes {} bytes of RAM (PlanMemory)", size_of::<PlanMemory>());
}
