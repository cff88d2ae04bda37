//! The tasks of `isostep-motion`, with this board's pins.

use embassy_executor::{SendSpawner, Spawner};
use embassy_rp::gpio::{Input, Output};
use embedded_hal::delay::DelayNs;
use isostep_motion::{Axis, DriverTiming, Machine, TimerPort, axis, coordinator, limit};

use crate::pins::AxisPins;

/// The drivers on the gantry.
const DRIVERS: DriverTiming = DriverTiming::DRV8825;

/// Spawns what must not be late on the urgent executor.
pub fn spawn_axes(
    spawner: SendSpawner,
    machine: &'static Machine,
    pins: [AxisPins; 3],
    emergency_stop: Input<'static>,
) {
    for (axis, pins) in Axis::ALL.into_iter().zip(pins) {
        spawner.spawn(run_axis(machine, axis, pins.step, pins.dir).unwrap());
        spawner.spawn(watch_limit(machine, axis, pins.limit).unwrap());
    }
    spawner.spawn(watch_emergency_stop(machine, emergency_stop).unwrap());
}

/// Spawns what plans ahead, in thread mode.
pub fn spawn_coordinator(spawner: Spawner, machine: &'static Machine, enable: Output<'static>) {
    spawner.spawn(coordinate(machine, enable).unwrap());
}

#[embassy_executor::task(pool_size = 3)]
async fn run_axis(machine: &'static Machine, axis: Axis, step: Output<'static>, dir: Output<'static>) -> ! {
    axis::run(machine, axis, TimerPort::new(step, dir, CoreDelay, DRIVERS)).await
}

#[embassy_executor::task(pool_size = 3)]
async fn watch_limit(machine: &'static Machine, axis: Axis, input: Input<'static>) -> ! {
    limit::watch(machine, axis, input).await
}

#[embassy_executor::task]
async fn watch_emergency_stop(machine: &'static Machine, input: Input<'static>) -> ! {
    limit::watch_emergency_stop(machine, input).await
}

#[embassy_executor::task]
async fn coordinate(machine: &'static Machine, enable: Output<'static>) -> ! {
    coordinator::run(machine, enable, |event| defmt::info!("{}", event)).await
}

/// Blocks for the width of a pulse.
struct CoreDelay;

impl DelayNs for CoreDelay {
    fn delay_ns(&mut self, ns: u32) {
        // `delay(n)` goes n + 1 times round a loop of 3 cycles, 24 ns at 125 MHz. 3/64 asks for a turn each 21.3 ns: an
        // eighth too long, never too short, and no division, of which this core has none.
        cortex_m::asm::delay(ns * 3 / 64);
    }
}
