//! One axis: an async task between a queue of segments and a step port.

use embassy_futures::select::{Either, select};

use crate::axes::Axis;
use crate::event::Finish;
use crate::machine::Machine;
use crate::port::{Run, StepPort};

/// Runs `axis` through `port` for ever. Spawn one for each axis, at a priority that nothing delays for long. The port is
/// borrowed, because a future has room for all that it was given beside what it does with it.
///
/// # Cancellation
/// Dropping it stops the axis at once. The position stays exact, and nothing moves the axis until another `run` is
/// spawned.
pub async fn run(machine: &Machine, axis: Axis, port: &mut impl StepPort) -> ! {
    let link = machine.link(axis);
    machine.publish_port(axis, port);
    loop {
        let motors = link.run.wait().await;
        let run = Run::new(motors, &link.start_barrier, &link.segments, &link.step_counter);
        // The halt is polled first, so no step rises once a halt has been signalled.
        let finish = match select(link.halt.wait(), port.run(run)).await {
            Either::First(()) => Finish::Stopped,
            Either::Second(Ok(())) => Finish::Done,
            Either::Second(Err(fault)) => {
                machine.fail(axis, fault);
                Finish::Fault { axis, fault }
            }
        };
        link.done.signal(finish);
    }
}
