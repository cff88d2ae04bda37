//! The simulator's step port: edges to the nanosecond, as hardware-timed ports make them.
//!
//! # Design
//! Virtual time goes on in Embassy's ticks of a microsecond. Within one, the port spends the rest up to the instant
//! of its edge in a blocking delay, which takes nobody else's time. It stands for the board's `PioPort`: the same tick
//! rate, so the same plans compile into the same segments.

use embassy_time::{Instant, Timer};
use embedded_hal::digital::OutputPin;
use isostep_motion::{
    Axis, Capabilities, Direction, DriverTiming, Odometer, PortFault, Run, SegmentQueue, StepPort, ticks_covering,
};

use crate::pin::Output;
use crate::record::Wire;
use crate::time::{self, Clock};
use crate::world::Shared;

/// The clock of an RP2040.
const TICK_HZ: u32 = 125_000_000;
const NS_PER_TICK: u64 = 1_000_000_000 / TICK_HZ as u64;
/// An interval may be shorter than planned by its rounding and by the fit of its segment.
const MARGIN_TICKS: u32 = 4;

/// STEP and DIR of one axis of the [`World`](crate::world::World).
pub struct SimPort {
    clock: Clock,
    step: Output,
    dir: Output,
    capabilities: Capabilities,
    /// When STEP may rise next, ns since power-up.
    ready_ns: u64,
}

impl SimPort {
    /// The port of `axis`, in the time of `clock`, for drivers that need `timing`.
    pub fn new(world: &Shared, clock: &Clock, axis: Axis, timing: DriverTiming) -> Self {
        Self {
            clock: clock.clone(),
            step: Output::new(world, Wire::Step(axis)),
            dir: Output::new(world, Wire::Dir(axis)),
            capabilities: Capabilities { tick_hz: TICK_HZ, timing, margin_ticks: MARGIN_TICKS },
            ready_ns: 0,
        }
    }

    fn turn(&mut self, run: &Run) {
        let high = (run.direction == Direction::Positive) != run.wiring.direction_inverted;
        let Ok(()) = if high { self.dir.set_high() } else { self.dir.set_low() };
        let setup_ticks = ticks_covering(self.capabilities.timing.setup_ns, TICK_HZ);
        self.ready_ns = self.ready_ns.max(self.clock.now_ns() + u64::from(setup_ticks) * NS_PER_TICK);
    }

    /// A step at `due_ns`, or as soon after as the driver allows; then the pulse.
    async fn step_at(&mut self, due_ns: u64, run: &Run, odometer: &Odometer) {
        let rise_ns = due_ns.max(self.ready_ns);
        Timer::at(Instant::from_micros(rise_ns / 1_000)).await;
        self.clock.spend(rise_ns.saturating_sub(self.clock.now_ns()));
        self.ready_ns = self.clock.now_ns() + u64::from(self.capabilities.period_min_ticks(run.wiring)) * NS_PER_TICK;
        let Ok(()) = self.step.set_high();
        odometer.count(run.direction);
        self.clock.spend(self.capabilities.pulse_ns(run.wiring).into());
        let Ok(()) = self.step.set_low();
    }
}

impl StepPort for SimPort {
    fn capabilities(&self) -> Capabilities {
        self.capabilities
    }

    async fn run(&mut self, run: Run, segments: &SegmentQueue, odometer: &Odometer) -> Result<(), PortFault> {
        self.turn(&run);
        let start_ns = time::ns(run.start);
        let mut left = run.steps;
        while left > 0 {
            let segment = segments.receive().await;
            left -= segment.steps();
            for ticks in segment.ticks() {
                self.step_at(start_ns + ticks * NS_PER_TICK, &run, odometer).await;
            }
        }
        Ok(())
    }
}
