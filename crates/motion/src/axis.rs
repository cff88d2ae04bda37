//! One axis: an async task between a queue of segments and a step port.

use embassy_futures::select::{Either, select};

use crate::axes::Axis;
use crate::event::Finish;
use crate::link::{AxisLink, Run};
use crate::machine::Machine;
use crate::port::StepPort;

/// Runs `axis` by `port` for ever. Spawn one per axis, at a priority nothing delays.
///
/// # Cancellation
/// Dropping it stops the axis at once; the position stays exact, and nothing moves the axis until another
/// `run` is spawned.
pub async fn run(machine: &Machine, axis: Axis, mut port: impl StepPort) -> ! {
    let link = machine.link(axis);
    machine.publish_capabilities(axis, port.capabilities());
    loop {
        let run = link.run.wait().await;
        // The halt is polled first: once it is there, no further step rises.
        let finish = match select(link.halt.wait(), follow(link, &mut port, run, axis)).await {
            Either::First(()) => Finish::Stopped,
            Either::Second(finish) => finish,
        };
        link.done.signal(finish);
    }
}

async fn follow(link: &AxisLink, port: &mut impl StepPort, run: Run, axis: Axis) -> Finish {
    port.prepare(run.direction, run.wiring);
    let mut left = run.steps;
    while left > 0 {
        let segment = link.segments.receive().await;
        left -= segment.steps();
        if port.emit(run.start, segment, &link.odometer).await.is_err() {
            return Finish::Late { axis };
        }
    }
    Finish::Done
}
