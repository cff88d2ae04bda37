//! The controller's tasks, spawned as a board spawns them.

use std::rc::Rc;

use embassy_futures::join::join;
use embassy_futures::select::select;
use embedded_io_async::{Read, Write};
use isostep_controller::{Controller, DriverHardware, FlowControl, Store};
use isostep_motion::coordinator::{self, PlanMemory};
use isostep_motion::{Axis, Event, LimitInput, Machine, Motor, axis, buttons, limit, probing, tool};

use super::Console;
use crate::config::Config;
use crate::drivers::DriverWire;
use crate::executor::{Executor, Priority};
use crate::flash::Flash;
use crate::link::{Pipe, Uart};
use crate::pin::{Input, Output};
use crate::port::AxisPort;
use crate::record::Wire;
use crate::time::in_background;
use crate::tool::SimTool;
use crate::vfd::VfdLine;
use crate::world::Shared;

/// Spawns the tasks that run at high priority on a board, then the coordinator.
pub(super) fn spawn_motion(executor: &mut Executor, world: &Shared, config: &Config) -> Rc<Machine> {
    // On a board it is a static. Here every task keeps it alive, and with the last of them it goes.
    let machine = Rc::new(Machine::new(isostep_controller::config(&config.settings), config.emergency_contact));
    world.borrow_mut().follow(machine.clone());
    let ports = AxisPort::all(config, executor, world);
    for ((axis, name), mut port) in Axis::ALL.into_iter().zip(["axis X", "axis Y", "axis Z", "axis A"]).zip(ports) {
        let machine = machine.clone();
        executor.spawn_at(Priority::P2, name, async move {
            axis::run(&machine, axis, &mut port).await;
        });
    }
    // One input of the board, whichever axis has the second motor.
    let second = world.borrow().second_axis().unwrap_or(Axis::X);
    let limits = Axis::ALL.map(|axis| (LimitInput::Of(axis), Motor::first(axis)));
    let limits = limits.into_iter().chain([(LimitInput::Second, Motor::second(second))]);
    let limits = limits.map(|(limit, motor)| (limit, Wire::Limit(motor)));
    let alarms = Axis::ALL.map(|axis| (LimitInput::Alarm(axis), Wire::DriveAlarm(axis)));
    for (limit, wire) in limits.chain(alarms) {
        let name = match limit {
            LimitInput::Of(axis) => ["limit X", "limit Y", "limit Z", "limit A"][axis as usize],
            LimitInput::Second => "second limit",
            LimitInput::Alarm(_) => "drive alarm",
        };
        let (machine, input) = (machine.clone(), Input::new(world, wire));
        executor.spawn_at(Priority::P1, name, async move {
            limit::watch(&machine, limit, input).await;
        });
    }
    let (stopped, input) = (machine.clone(), Input::new(world, Wire::EmergencyStop));
    executor.spawn_at(Priority::P1, "emergency stop", async move {
        limit::watch_emergency_stop(&stopped, input).await;
    });
    spawn_tool(executor, world, &machine);
    let (enable, world, coordinated) = (Output::new(world, Wire::Enable), world.clone(), machine.clone());
    let least_times = config.least_times;
    executor.spawn("coordinator", async move {
        let mut path = Box::new(PlanMemory::new());
        let on_event = |event| {
            let config = matches!(event, Event::Run { .. }).then(|| coordinated.config());
            let mut world = world.borrow_mut();
            config.into_iter().for_each(|config| world.on_config(config.of_motors()));
            world.on_event(event);
        };
        coordinator::run(&coordinated, &mut path, &least_times, enable, on_event).await;
    });
    machine
}

/// Spawns the tasks for the tool, the probe and the buttons.
fn spawn_tool(executor: &mut Executor, world: &Shared, machine: &Rc<Machine>) {
    let (own, port) = (machine.clone(), SimTool::new(world));
    executor.spawn_at(Priority::P1, "tool", async move {
        tool::run(&own, port).await;
    });
    let [probe, hold, start] = [Wire::Probe, Wire::Hold, Wire::Start].map(|wire| Input::new(world, wire));
    let own = machine.clone();
    executor.spawn_at(Priority::P1, "probe", async move {
        probing::watch(&own, probe).await;
    });
    let own = machine.clone();
    executor.spawn_at(Priority::P1, "feed hold", async move {
        buttons::watch_hold(&own, hold).await;
    });
    let own = machine.clone();
    executor.spawn_at(Priority::P1, "cycle start", async move {
        buttons::watch_start(&own, start).await;
    });
}

/// The parts that a controller is made with: its store, the UART drivers, whether one wire tells the alarm of all others, and the wire to a
/// VFD.
pub(super) type Parts = (Store<Flash>, Option<(DriverHardware, DriverWire)>, bool, VfdLine);

/// Spawns the task of the consoles.
pub(super) fn spawn_consoles(
    executor: &mut Executor,
    machine: &Rc<Machine>,
    parts: Parts,
    consoles: &[Console],
    baud: Option<u32>,
) {
    let pipes = consoles.iter().map(|console| (&console.to_controller, &console.from_controller, &console.opened));
    match baud {
        None => {
            let links = pipes.map(|(rx, tx, opened)| (rx.clone(), tx.clone(), opened.clone())).collect();
            executor.spawn("console", serve_all(machine.clone(), parts, links, FlowControl::Link));
        }
        Some(baud) => {
            let uart = |pipe: &Pipe| Uart::new(pipe.clone(), executor.clock().clone(), baud);
            let links = pipes.map(|(rx, tx, opened)| (uart(rx), uart(tx), opened.clone())).collect();
            executor.spawn("console", serve_all(machine.clone(), parts, links, FlowControl::None));
        }
    }
}

/// Serves one console, or two.
async fn serve_all(
    machine: Rc<Machine>,
    (store, mut drivers, has_one_alarm_wire, vfd): Parts,
    links: Vec<(impl Read, impl Write, Pipe)>,
    flow: FlowControl,
) {
    let mut controller = Controller::new(&machine, store.kept().settings, store);
    match &drivers {
        Some((hardware, _)) => controller = controller.with_drivers(*hardware),
        // Where the drivers are on the board, there is no drive with a wire of its own.
        None if has_one_alarm_wire => controller = controller.with_one_drive_alarm(),
        None => controller = controller.with_drive_alarms(),
    }
    controller.load().await;
    if let Some((_, wire)) = &mut drivers {
        controller.set_drivers(wire).await;
    }
    let watching = async {
        if let Some((_, wire)) = drivers {
            let clock = wire.clock().clone();
            in_background(&clock, || controller.sets_drivers(), controller.watch_drivers(wire)).await;
        }
    };
    let takes_vfd = controller.takes_vfd();
    let turning = async {
        if takes_vfd {
            let clock = vfd.clock().clone();
            in_background(&clock, || controller.vfd_settles(), controller.watch_vfd(vfd)).await;
        }
    };
    join(serve_links(&controller, links, flow), join(watching, turning)).await;
}

async fn serve_links(controller: &Controller<'_, Flash>, links: Vec<(impl Read, impl Write, Pipe)>, flow: FlowControl) {
    let mut links = links.into_iter().map(|link| serve(controller, link, flow));
    match (links.next(), links.next()) {
        (Some(first), Some(second)) => drop(join(first, second).await),
        (Some(only), None) => only.await,
        _ => {}
    }
}

/// Serves one console, session after session, as on a board whose host opens and closes the port.
async fn serve(
    controller: &Controller<'_, Flash>,
    (mut rx, mut tx, mut opened): (impl Read, impl Write, Pipe),
    flow: FlowControl,
) {
    loop {
        // The link cannot fail, so a session ends only when the console is opened again.
        select(controller.serve(&mut rx, &mut tx, flow), opened.read(&mut [0])).await;
    }
}
