//! The tasks of isostep-motion that both firmwares spawn. A library cannot spawn them: a task of `embassy-executor` is a
//! static, with the types of the board.

use embassy_executor::SendSpawner;
use embassy_stm32::gpio::Output;
use isostep_controller::least_times;
use isostep_motion::coordinator::{self, PlanMemory};
use isostep_motion::{AXES, Axis, LimitInput, Machine, TimerPort, axis, limit};
use static_cell::{ConstStaticCell, StaticCell};

use crate::pins::Switch;

/// Spawns the task of each axis. They publish what their ports can do, so let them run before the settings are read.
///
/// # Panics
/// When it is called twice.
pub fn spawn_axes(spawner: SendSpawner, machine: &'static Machine, ports: [TimerPort<'static>; AXES]) {
    static PORTS: StaticCell<[TimerPort<'static>; AXES]> = StaticCell::new();

    for (axis, port) in Axis::ALL.into_iter().zip(PORTS.init(ports)) {
        spawner.spawn(run_axis(machine, axis, port).expect("the pool has room for all axes"));
    }
}

/// Spawns what watches the limit switches.
///
/// # Panics
/// When it is called twice.
pub fn spawn_limits(spawner: SendSpawner, machine: &'static Machine, switches: [Switch; AXES]) {
    for (axis, switch) in Axis::ALL.into_iter().zip(switches) {
        spawner.spawn(watch_limit(machine, axis, switch).expect("the pool has room for all axes"));
    }
}

#[embassy_executor::task(pool_size = AXES)]
async fn run_axis(machine: &'static Machine, axis: Axis, port: &'static mut TimerPort<'static>) -> ! {
    axis::run(machine, axis, port).await
}

#[embassy_executor::task(pool_size = AXES)]
async fn watch_limit(machine: &'static Machine, axis: Axis, switch: Switch) -> ! {
    limit::watch(machine, LimitInput::Of(axis), switch).await
}

/// Watches the emergency stop.
#[embassy_executor::task]
pub async fn watch_emergency_stop(machine: &'static Machine, switch: Switch) -> ! {
    limit::watch_emergency_stop(machine, switch).await
}

/// Plans, and starts runs.
#[embassy_executor::task]
pub async fn coordinate(machine: &'static Machine, enable: Output<'static>) -> ! {
    static MEMORY: ConstStaticCell<PlanMemory> = ConstStaticCell::new(PlanMemory::new());

    // Not measured: this core is faster than that of an RP2040, and so never late by its times.
    coordinator::run(machine, MEMORY.take(), &least_times::RP2040, enable, |_event| {}).await
}
