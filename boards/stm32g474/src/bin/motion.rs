//! Motion without a console: a program of one's own asks for moves. Here it homes, and draws squares for ever.
#![no_std]
#![no_main]

use core::convert::Infallible;

use embassy_executor::Spawner;
use embassy_time::{Duration, Timer};
use isostep_motion::{AXES, Axis, Busy, Config, Contact, Direction, HomingConfig, Machine, Motion, Move, Wiring};
use isostep_profile::Limits;
use static_cell::StaticCell;
use stm32g474::pins::Pins;
use stm32g474::{clock, executors, pins, steps, tasks};

#[embassy_executor::main]
async fn main(rest: Spawner) -> ! {
    let Pins { motors, enable, limits, emergency_stop, .. } = pins::open(embassy_stm32::init(clock::config()));
    let [switches, makes_steps, axes] = executors::start();
    let machine = machine();
    tasks::spawn_axes(axes, machine, steps::open(makes_steps, motors));
    // The axes' tasks have run by now, above this one, so it is known what the ports can do.
    machine.configure(config()).expect("the ports can do this");
    tasks::spawn_limits(switches, machine, limits);
    switches.spawn(tasks::watch_emergency_stop(machine, emergency_stop).expect("it is spawned once"));
    rest.spawn(tasks::coordinate(machine, enable).expect("it is spawned once"));
    loop {
        // A limit switch or the emergency stop ends it, and a machine with a display would say which alarm that is. Homing
        // unlocks the machine, unless the emergency stop is still pressed.
        let Err(_stopped) = draw(machine).await;
        Timer::after(Duration::from_secs(5)).await;
    }
}

/// Homes, then draws squares. A machine that was stopped takes nothing: that is the error.
async fn draw(machine: &Machine) -> Result<Infallible, Busy> {
    machine.submit(Motion::Home { axes: [true; AXES] }).await?;
    loop {
        for [x_steps, y_steps] in [[4_000, 0], [4_000, 4_000], [0, 4_000], [0, 0]] {
            let mut target_steps = [0; AXES];
            (target_steps[0], target_steps[1]) = (x_steps, y_steps);
            // It waits only while the queue is full: moves are planned ahead, and follow each other.
            machine.submit(straight_to(target_steps)).await?;
        }
    }
}

fn straight_to(target_steps: [i32; AXES]) -> Motion {
    Motion::Move(Move { feed_mm_s: 40.0, deviation_mm: 0.01, ..Move::to(target_steps) })
}

/// Not inlined: what is made here is large, and must not stay on the stack of `main`.
#[inline(never)]
fn machine() -> &'static Machine {
    static MACHINE: StaticCell<Machine> = StaticCell::new();

    MACHINE.init(Machine::new(config(), Contact::NormallyClosed))
}

/// Three axes of 80 steps/mm, 200 mm long, with their switches at the origin.
fn config() -> Config {
    const STEPS_PER_MM: f64 = 80.0;
    let limits = Limits {
        start_speed_steps_s: 0.0,
        top_speed_steps_s: 60.0 * STEPS_PER_MM,
        accel_steps_s2: 400.0 * STEPS_PER_MM,
        decel_steps_s2: 400.0 * STEPS_PER_MM,
        jerk_steps_s3: f64::INFINITY,
    };
    let homing = HomingConfig {
        order: Axis::ALL.map(Some),
        towards: [Direction::Negative; AXES],
        seek_mm_s: 10.0,
        room_mm: 0.0,
        latch_mm_s: 1.0,
        pull_off_mm: 2.0,
        debounce: Duration::from_millis(25),
        by_stall: [false; AXES],
    };
    Config {
        wiring: [Wiring { direction_inverted: false, pulse_ns: 2_000 }; AXES],
        ..Config::new([limits; AXES], [STEPS_PER_MM; AXES], [200.0; AXES], homing)
    }
}
