//! What the coordinator and one axis task share.

use core::cell::Cell;

use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;

use crate::event::Finish;
use crate::port::{Brake, Motors, StepCounter, StreamQueue};
use crate::start_barrier::StartBarrier;

/// What the coordinator and one axis task share.
pub(crate) struct AxisLink {
    pub step_counter: StepCounter,
    pub segments: StreamQueue,
    pub run: Signal<CriticalSectionRawMutex, Motors>,
    pub start_barrier: StartBarrier,
    pub halt: Signal<CriticalSectionRawMutex, ()>,
    pub done: Signal<CriticalSectionRawMutex, Finish>,
    brake: Mutex<CriticalSectionRawMutex, Cell<Brake>>,
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
            brake: Mutex::new(Cell::new(|_engaged| {})),
        }
    }

    /// Takes over the brake of the axis's port.
    pub fn fit(&self, brake: Brake) {
        self.brake.lock(|fitted| fitted.set(brake));
    }

    pub fn brake(&self, engaged: bool) {
        self.brake.lock(Cell::get)(engaged);
    }
}
