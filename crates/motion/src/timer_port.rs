//! A step port that awaits `Timer::at` and toggles pins.
//!
//! # Design
//! A step costs one wake-up, at its instant. The pulse is made within it, by a blocking delay of the pulse width: at
//! 2 us that is cheaper than a second wake-up, and since nothing is awaited between the two edges, dropping `emit`
//! can neither cut a pulse short nor lose its count.
//!
//! # Deadline
//! A step is due at its tick. A late wake-up makes that step late by as much and no later one: the next instant
//! comes from the profile. Lateness beyond [`LATE_MAX`] is a fault, because the steps behind would be bunched.

use core::convert::Infallible;

use embassy_time::{Duration, Instant, Timer};
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;

use crate::TICK_HZ;
use crate::port::{
    Capabilities, Direction, DriverTiming, Odometer, PortFault, Run, SegmentQueue, StepPort, ticks_covering,
};

/// A step later than this is a fault: half a step period at 2,400 steps/s, the default machine's top speed.
pub const LATE_MAX: Duration = Duration::from_micros(208);

/// STEP and DIR on two output pins, timed by Embassy's time driver.
#[derive(Debug)]
pub struct TimerPort<S, D, W> {
    step: S,
    dir: D,
    delay: W,
    capabilities: Capabilities,
    direction: Direction,
    pulse_ns: u32,
    /// From one rise to the next, at least.
    period_min: Duration,
    /// When STEP may rise next.
    ready: Instant,
}

impl<S, D, W> TimerPort<S, D, W>
where
    S: OutputPin<Error = Infallible>,
    D: OutputPin<Error = Infallible>,
    W: DelayNs,
{
    /// Drives STEP and DIR low. `delay` blocks for the width of a pulse.
    pub fn new(mut step: S, mut dir: D, delay: W, timing: DriverTiming) -> Self {
        let Ok(()) = step.set_low();
        let Ok(()) = dir.set_low();
        // A reading of the clock may be almost a tick old.
        let capabilities = Capabilities { tick_hz: TICK_HZ, timing, margin_ticks: 1 };
        let pulse_ns = timing.step_high_ns;
        let (direction, period_min) = (Direction::Negative, Duration::MIN);
        Self { step, dir, delay, capabilities, direction, pulse_ns, period_min, ready: Instant::now() }
    }

    /// Sets DIR and takes over the pulse width; the next step waits for the set-up time.
    fn prepare(&mut self, run: &Run) {
        self.direction = run.direction;
        self.pulse_ns = self.capabilities.pulse_ns(run.wiring);
        self.period_min = Duration::from_ticks(self.capabilities.period_min_ticks(run.wiring).into());
        // The last pulse is over, so DIR's hold time is too.
        let high = (run.direction == Direction::Positive) != run.wiring.direction_inverted;
        let Ok(()) = if high { self.dir.set_high() } else { self.dir.set_low() };
        let setup = ticks_covering(self.capabilities.timing.setup_ns, TICK_HZ) + self.capabilities.margin_ticks;
        self.ready = self.ready.max(Instant::now() + Duration::from_ticks(setup.into()));
    }

    async fn step_at(&mut self, due: Instant, odometer: &Odometer) -> Result<(), PortFault> {
        Timer::at(due.max(self.ready)).await;
        let now = Instant::now();
        if now > due + LATE_MAX {
            return Err(PortFault::Late { late: now - due, max: LATE_MAX });
        }
        let Ok(()) = self.step.set_high();
        odometer.count(self.direction);
        self.delay.delay_ns(self.pulse_ns);
        let Ok(()) = self.step.set_low();
        self.ready = now + self.period_min;
        Ok(())
    }
}

impl<S, D, W> StepPort for TimerPort<S, D, W>
where
    S: OutputPin<Error = Infallible>,
    D: OutputPin<Error = Infallible>,
    W: DelayNs,
{
    fn capabilities(&self) -> Capabilities {
        self.capabilities
    }

    async fn run(&mut self, run: Run, segments: &SegmentQueue, odometer: &Odometer) -> Result<(), PortFault> {
        self.prepare(&run);
        let mut left = run.steps;
        while left > 0 {
            let segment = segments.receive().await;
            left -= segment.steps();
            for ticks in segment.ticks() {
                self.step_at(run.start + Duration::from_ticks(ticks), odometer).await?;
            }
        }
        Ok(())
    }
}
