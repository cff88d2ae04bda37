//! The whole controller: Grbl's dialect on a UART, settings in flash, homing, limits, an emergency stop.
#![no_std]
#![no_main]

use embassy_executor::Spawner;
use embassy_futures::yield_now;
use embassy_stm32::usart::BufferedUart;
use isostep_controller::{Controller, FlowControl, Settings, Store, config};
use isostep_motion::{Contact, Machine};
use static_cell::{ConstStaticCell, StaticCell};
use stm32g474::flash::SettingsFlash;
use stm32g474::pins::Pins;
use stm32g474::{clock, executors, flash, pins, steps, tasks};

#[embassy_executor::main]
async fn main(rest: Spawner) -> ! {
    let Pins { motors, enable, limits, emergency_stop, console, flash } =
        pins::open(embassy_stm32::init(clock::config()));
    let [switches, makes_steps, axes] = executors::start();
    let machine = machine();
    tasks::spawn_axes(axes, machine, steps::open(makes_steps, motors));
    let controller = controller(machine, flash::open(flash));
    // What is stored, before anything looks at it or moves.
    controller.load().await;
    tasks::spawn_limits(switches, machine, limits);
    switches.spawn(tasks::watch_emergency_stop(machine, emergency_stop).expect("it is spawned once"));
    rest.spawn(tasks::coordinate(machine, enable).expect("it is spawned once"));
    serve(controller, link(console)).await
}

/// Serves the console. What a link loses, such as bytes that came too fast, is an error, and the session begins again.
/// Any number of consoles may be served at once, each by such a loop in a task of its own.
async fn serve(controller: &Controller<'static, SettingsFlash>, link: BufferedUart<'static>) -> ! {
    let (mut tx, mut rx) = link.split();
    loop {
        let Err(_lost) = controller.serve(&mut rx, &mut tx, FlowControl::None).await;
        yield_now().await;
    }
}

fn link(console: pins::Console) -> BufferedUart<'static> {
    static RX_BYTES: ConstStaticCell<[u8; 1_024]> = ConstStaticCell::new([0; 1_024]);
    static TX_BYTES: ConstStaticCell<[u8; 256]> = ConstStaticCell::new([0; 256]);

    console.open(RX_BYTES.take(), TX_BYTES.take())
}

/// Not inlined, like the next one: what is made here is large, and must not stay on the stack of `main`.
#[inline(never)]
fn machine() -> &'static Machine {
    static MACHINE: StaticCell<Machine> = StaticCell::new();

    MACHINE.init(Machine::new(config(&Settings::default()), Contact::NormallyClosed))
}

#[inline(never)]
fn controller(machine: &'static Machine, store: Store<SettingsFlash>) -> &'static Controller<'static, SettingsFlash> {
    static CONTROLLER: StaticCell<Controller<'static, SettingsFlash>> = StaticCell::new();

    CONTROLLER.init(Controller::new(machine, Settings::default(), store).without_second_motor())
}
