//! One axis: an async task between a queue of segments and a step port.

use core::fmt;

use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_sync::signal::Signal;
use embassy_time::Instant;
use isostep_profile::Segment;

use crate::event::Finish;
use crate::machine::Machine;
use crate::port::{Direction, Odometer, StepPort, Wiring};

/// How many axes a machine has.
pub const AXES: usize = 3;

/// Segments queued per axis. Near standstill a segment is three steps, so eight are 24 steps: at 2,500 steps/s² from
/// rest the last of them leaves after 139 ms, hundreds of times what compiling one takes.
const QUEUE_SEGMENTS: usize = 8;

/// An axis of the gantry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Axis {
    /// Across.
    X = 0,
    /// Up.
    Y = 1,
    /// Into the rack.
    Z = 2,
}

impl Axis {
    /// All of them, in order.
    pub const ALL: [Self; AXES] = [Self::X, Self::Y, Self::Z];
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::X => "X",
            Self::Y => "Y",
            Self::Z => "Z",
        })
    }
}

/// An axis's part of a move.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    /// The instant from which segments count.
    pub start: Instant,
    pub direction: Direction,
    pub wiring: Wiring,
    pub steps: u32,
}

/// Between the coordinator and one axis task.
pub(crate) struct AxisLink {
    pub odometer: Odometer,
    pub segments: Channel<CriticalSectionRawMutex, Segment, QUEUE_SEGMENTS>,
    pub run: Signal<CriticalSectionRawMutex, Run>,
    pub halt: Signal<CriticalSectionRawMutex, ()>,
    pub done: Signal<CriticalSectionRawMutex, Finish>,
}

impl AxisLink {
    pub const fn new() -> Self {
        Self {
            odometer: Odometer::new(),
            segments: Channel::new(),
            run: Signal::new(),
            halt: Signal::new(),
            done: Signal::new(),
        }
    }
}

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
