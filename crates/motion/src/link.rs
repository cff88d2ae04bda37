//! Between the coordinator and one axis task.

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_sync::signal::Signal;
use embassy_time::Instant;
use isostep_profile::Segment;

use crate::event::Finish;
use crate::port::{Direction, Odometer, Wiring};

/// Segments queued per axis. Near standstill a segment is three steps, so eight are 24 steps: at 2,500 steps/s² from
/// rest the last of them leaves after 139 ms, hundreds of times what compiling one takes.
const QUEUE_SEGMENTS: usize = 8;

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
