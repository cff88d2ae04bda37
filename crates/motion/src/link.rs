//! The state that the coordinator and one axis task share.

use core::cell::Cell;

use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;

use crate::event::Finish;
use crate::port::{Inhibit, Motors, StepCounter, StreamQueue};
use crate::start_barrier::StartBarrier;

/// The state that the coordinator and one axis task share.
pub(crate) struct AxisLink {
    pub step_counter: StepCounter,
    pub segments: StreamQueue,
    pub run: Signal<CriticalSectionRawMutex, Motors>,
    pub start_barrier: StartBarrier,
    pub halt: Signal<CriticalSectionRawMutex, ()>,
    pub done: Signal<CriticalSectionRawMutex, Finish>,
    inhibit: Mutex<CriticalSectionRawMutex, Cell<Inhibit>>,
}

impl AxisLink {
    pub const fn new() -> Self {
        Self {
            step_counter: StepCounter::new(),
            segments: StreamQueue::new(),
            run: Signal::new(),
            start_barrier: StartBarrier::new(),
            halt: Signal::new(),
            done: Signal::new(),
            inhibit: Mutex::new(Cell::new(|_engaged| {})),
        }
    }

    /// Takes over the inhibit of the axis's port.
    pub fn fit(&self, inhibit: Inhibit) {
        self.inhibit.lock(|fitted| fitted.set(inhibit));
    }

    pub fn inhibit(&self, engaged: bool) {
        self.inhibit.lock(Cell::get)(engaged);
    }
}
