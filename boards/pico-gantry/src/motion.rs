//! The tasks of `isostep-motion`, with this board's pins.

use embassy_executor::{SendSpawner, Spawner};
use embassy_rp::gpio::Input;
use isostep_motion::coordinator::{self, PlanMemory};
use isostep_motion::{AXES, Axis, Event, LimitInput, Machine, axis, buttons, limit, probing, tool};
use static_cell::{ConstStaticCell, StaticCell};

use crate::pins::{ControlPins, LIMIT_INPUTS, StepPins, SwitchPins, ToolPins};
#[cfg(not(feature = "timer-port"))]
use crate::pio_port as port;
#[cfg(feature = "timer-port")]
use crate::timer_port as port;
use crate::tool::Tool;
use crate::{board_words, guard};

/// The outputs by which the coordinator switches the motors.
#[cfg(not(feature = "prove"))]
pub type Enable = crate::pins::Enables;
#[cfg(feature = "prove")]
pub type Enable = crate::prove::MotorsOff;

/// Spawns the axis tasks.
pub fn spawn_axes(spawner: SendSpawner, machine: &'static Machine, pins: StepPins) {
    static PORTS: StaticCell<[port::Port; AXES]> = StaticCell::new();

    for (axis, port) in Axis::ALL.into_iter().zip(PORTS.init(port::open(pins, board_words::driver_timing()))) {
        spawner.spawn(run_axis(machine, axis, port).unwrap());
    }
}

/// Spawns the tasks that stop the axes, and starts the guard that engages the inhibit before them.
pub fn spawn_switches(spawner: SendSpawner, machine: &'static Machine, pins: SwitchPins) {
    for (which, limit) in guard::LIMIT_INPUTS.into_iter().zip(pins.limits) {
        spawner.spawn(watch_limit(machine, which, limit).unwrap());
    }
    spawner.spawn(watch_emergency_stop(machine, pins.emergency_stop).unwrap());
    guard::start(machine, pins.pio);
}

/// Spawns the tasks for the tool, the probe and the buttons.
pub fn spawn_tool(spawner: SendSpawner, machine: &'static Machine, pins: ToolPins, controls: ControlPins) {
    spawner.spawn(run_tool(machine, Tool::new(pins)).unwrap());
    spawner.spawn(watch_probe(machine, controls.probe).unwrap());
    spawner.spawn(watch_hold(machine, controls.hold).unwrap());
    if let Some(start) = controls.start {
        spawner.spawn(watch_start(machine, start).unwrap());
    }
}

/// Spawns the coordinator, which plans ahead, in thread mode.
pub fn spawn_coordinator(spawner: Spawner, machine: &'static Machine, enable: Enable) {
    spawner.spawn(coordinate(machine, enable).unwrap());
}

#[embassy_executor::task(pool_size = AXES)]
async fn run_axis(machine: &'static Machine, axis: Axis, port: &'static mut port::Port) -> ! {
    axis::run(machine, axis, port).await
}

#[embassy_executor::task(pool_size = LIMIT_INPUTS)]
async fn watch_limit(machine: &'static Machine, which: LimitInput, input: Input<'static>) -> ! {
    limit::watch(machine, which, input).await
}

#[embassy_executor::task]
async fn watch_emergency_stop(machine: &'static Machine, input: Input<'static>) -> ! {
    limit::watch_emergency_stop(machine, input).await
}

#[embassy_executor::task]
async fn run_tool(machine: &'static Machine, port: Tool) -> ! {
    tool::run(machine, port).await
}

#[embassy_executor::task]
async fn watch_probe(machine: &'static Machine, input: Input<'static>) -> ! {
    probing::watch(machine, input).await
}

#[embassy_executor::task]
async fn watch_hold(machine: &'static Machine, input: Input<'static>) -> ! {
    buttons::watch_hold(machine, input).await
}

#[embassy_executor::task]
async fn watch_start(machine: &'static Machine, input: Input<'static>) -> ! {
    buttons::watch_start(machine, input).await
}

#[embassy_executor::task]
async fn coordinate(machine: &'static Machine, enable: Enable) -> ! {
    static PATH: ConstStaticCell<PlanMemory> = ConstStaticCell::new(PlanMemory::new());

    coordinator::run(machine, PATH.take(), board_words::least_times(), enable, log).await
}

/// While a log line is encoded, it masks every interrupt: a move's plan for 85 us, its end for 26 us. So events that
/// come with every move, or during moves, are logged only if asked for.
fn log(event: Event) {
    match event {
        Event::State(state) => defmt::info!("{}", state),
        Event::Homing { axis, phase } => defmt::info!("{} homes: {}", axis, phase),
        Event::Homed { axis } => defmt::info!("{} is homed", axis),
        _ => defmt::debug!("{}", event),
    }
}
