//! The controller on an LM3S6965 (Cortex-M3), as QEMU emulates it: the template of a board. README.md says what a board
//! has to provide, and in which of these files it is.
#![no_std]
#![no_main]

mod chip;
mod executors;
mod flash;
mod gantry;
mod pins;
mod steps;
mod time_driver;
mod uart;

use core::panic::PanicInfo;

use embassy_executor::SendSpawner;
use isostep_controller::{Controller, FlowControl, Settings, config, least_times};
use isostep_motion::coordinator::{self, PlanMemory};
use isostep_motion::{AXES, Axis, Contact, LimitInput, Machine, TimerPort, axis, limit};
use portable_atomic as _;
use static_cell::{ConstStaticCell, StaticCell};

use crate::flash::Flash;

#[cortex_m_rt::entry]
fn main() -> ! {
    time_driver::start();
    pins::init();
    let machine = machine();
    let [switches, makes_steps, axes, rest] = executors::start();
    spawn_axes(axes, makes_steps, machine);
    rest.spawn(serve(switches, rest, machine).unwrap());
    loop {
        cortex_m::asm::wfi();
    }
}

fn spawn_axes(axes: SendSpawner, makes_steps: SendSpawner, machine: &'static Machine) {
    static PORTS: StaticCell<[TimerPort<'static>; AXES]> = StaticCell::new();

    for (axis, port) in Axis::ALL.into_iter().zip(PORTS.init(steps::open(makes_steps))) {
        axes.spawn(run_axis(machine, axis, port).unwrap());
    }
}

/// Reads the settings, which must be done before anything looks at them or moves; then begins all other tasks, and serves
/// the console.
#[embassy_executor::task]
async fn serve(switches: SendSpawner, rest: SendSpawner, machine: &'static Machine) -> ! {
    let controller = controller(machine);
    controller.load().await;
    for axis in Axis::ALL {
        switches.spawn(watch_limit(machine, axis).unwrap());
    }
    rest.spawn(coordinate(machine).unwrap());
    let (rx, tx) = uart::open();
    match controller.serve(rx, tx, FlowControl::None).await {
        Ok(never) => match never {},
        Err(_) => unreachable!("the link does not fail"),
    }
}

/// Not inlined, like the next one: what is made here is large, and must not stay on the stack of `main`.
#[inline(never)]
fn machine() -> &'static Machine {
    static MACHINE: StaticCell<Machine> = StaticCell::new();

    MACHINE.init(Machine::new(config(&Settings::default()), Contact::NormallyOpen))
}

#[inline(never)]
fn controller(machine: &'static Machine) -> &'static Controller<'static, Flash> {
    static CONTROLLER: StaticCell<Controller<'static, Flash>> = StaticCell::new();

    CONTROLLER.init(Controller::new(machine, Settings::default(), flash::open()).without_second_motor())
}

#[embassy_executor::task(pool_size = AXES)]
async fn run_axis(machine: &'static Machine, axis: Axis, port: &'static mut TimerPort<'static>) -> ! {
    axis::run(machine, axis, port).await
}

#[embassy_executor::task(pool_size = AXES)]
async fn watch_limit(machine: &'static Machine, axis: Axis) -> ! {
    limit::watch(machine, LimitInput::Of(axis), gantry::Switch(axis as usize)).await
}

#[embassy_executor::task]
async fn coordinate(machine: &'static Machine) -> ! {
    static MEMORY: ConstStaticCell<PlanMemory> = ConstStaticCell::new(PlanMemory::new());

    // Not measured: QEMU counts no cycles.
    coordinator::run(machine, MEMORY.take(), &least_times::RP2040, pins::Enable, |_event| {}).await
}

/// Stops for ever, with no more edges: the interrupts are masked.
#[panic_handler]
fn panic(_info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    uart::say("\r\n[MSG:panic]\r\n");
    loop {
        cortex_m::asm::nop();
    }
}
