//! Tests the position contract in the simulator with either step port, and compares the tables of `docs/position.md`
//! with it.

use std::cell::RefCell;
use std::fs;
use std::rc::Rc;

use embassy_futures::select::select;
use embassy_time::{Duration, Instant, Timer};
use isostep_motion::coordinator::{self, PlanMemory};
use isostep_motion::{AXES, Axis, Machine, Motion, Move, State, axis};
use isostep_sim::drive::MotorData;
use isostep_sim::executor::Executor;
use isostep_sim::pin::Output;
use isostep_sim::port::AxisPort;
use isostep_sim::world::{Shared, Wire, World};
use isostep_sim::{Config, Port};
use isostep_tests::contract::{self, CASES, On};
use isostep_tests::dialogue;
use isostep_tests::root;

/// A machine whose motors are so strong that they follow any edge.
fn config(port: Port) -> Config {
    let motor = MotorData::RIGID;
    Config { port, motor, start_mm: [3.0, 40.0, 15.0], ..Config::default() }
}

#[test]
fn every_way_to_end_keeps_the_contract() {
    // The frame of the second motor of X, which stands still in most cases while X moves, never binds.
    let machine = "with $905=1\nwith $745=1\nwith loose frame\nwith rigid motors\n";
    for port in ["pio", "timer"] {
        let machine = format!("{machine}with port {port}\n");
        contract::keep(dialogue::On::Simulator, &machine, |case| case.on == On::Every, "");
    }
}

/// Crossed belts move two axes by each motor, and neither may have a second one.
#[test]
fn every_way_to_end_keeps_the_contract_with_crossed_belts() {
    for port in ["pio", "timer"] {
        let machine = format!("with $907=1\nwith $745=1\nwith rigid motors\nwith port {port}\n");
        contract::keep(dialogue::On::Simulator, &machine, |case| case.on == On::Every && !case.is_squared(), "");
    }
}

/// The rows of the table under a heading.
fn rows(heading: &str) -> Vec<String> {
    let page = fs::read_to_string(root().join("docs/position.md")).unwrap();
    let section = page.split("\n## ").find(|section| section.starts_with(heading)).expect(heading);
    section.lines().filter(|line| line.starts_with('|')).skip(2).map(str::to_owned).collect()
}

#[test]
fn the_table_says_what_the_cases_hold() {
    let held: Vec<_> = CASES.iter().map(|case| case.row()).collect();
    assert_eq!(rows("How a motion ends").join("\n"), held.join("\n"), "docs/position.md beside tests/src/contract.rs");
}

/// A machine made of tasks alone. Its coordinator is dropped once and then restarted.
fn with_dropped_coordinator(executor: &mut Executor, world: &Shared, config: &Config) -> &'static Machine {
    let machine: &'static Machine =
        Box::leak(Box::new(Machine::new(isostep_controller::config(&config.settings), config.emergency_contact)));
    for (axis, mut port) in Axis::ALL.into_iter().zip(AxisPort::all(config, executor, world)) {
        executor.spawn("axis", async move {
            axis::run(machine, axis, &mut port).await;
        });
    }
    let enables = [(); 2].map(|()| Output::new(world, Wire::Enable));
    executor.spawn("coordinator", async move {
        for (enable, until) in enables.into_iter().zip([DROPPED_AT, REST * 60]) {
            let mut path = Box::new(PlanMemory::new());
            let run =
                coordinator::run(machine, &mut path, &isostep_controller::least_times::RP2040, enable, |_event| {});
            select(run, Timer::after(until)).await;
            Timer::after(REST).await;
        }
    });
    machine
}

/// In the middle of a move.
const DROPPED_AT: Duration = Duration::from_millis(700);
/// Longer than the motion that the axes have been given.
const REST: Duration = Duration::from_secs(1);

fn submit(executor: &mut Executor, machine: &'static Machine, target_steps: [i32; AXES]) {
    executor.spawn("sender", async move {
        let motion = Motion::Move(Move { feed_mm_s: 30.0, ..Move::to(target_steps) });
        machine.submit(motion).await.expect("a machine that takes moves");
    });
}

#[test]
fn a_dropped_coordinator_starves_the_axes_and_the_count_is_exact() {
    const TARGET_STEPS: [i32; AXES] = [2_000, -1_300, 400];
    for port in Port::ALL {
        let mut executor = Executor::new();
        let _current = executor.clock().enter();
        let config = config(port);
        let world = Rc::new(RefCell::new(World::new(executor.clock().clone(), &config)));
        let machine = with_dropped_coordinator(&mut executor, &world, &config);
        let counted = || world.borrow().counted_steps();
        submit(&mut executor, machine, TARGET_STEPS);
        executor.run_for(DROPPED_AT + REST / 2).unwrap();
        let stopped_at = counted();
        assert_eq!(machine.position_steps(), stopped_at, "{port}");
        assert!((1..TARGET_STEPS[0]).contains(&stopped_at[0]), "{port}: {stopped_at:?}");
        assert_eq!(machine.state(), State::Run, "{port}: as it was");
        executor.run_for(REST / 4).unwrap();
        assert_eq!(counted(), stopped_at, "{port}: nothing moves");

        executor.run_for(REST).unwrap();
        submit(&mut executor, machine, TARGET_STEPS);
        executor.run_until_quiescent(Instant::from_secs(60)).unwrap();
        assert_eq!((machine.position_steps(), counted()), (TARGET_STEPS, TARGET_STEPS), "{port}");
    }
}
