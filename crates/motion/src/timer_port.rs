//! A step port that awaits `Timer::at` and toggles pins.
//!
//! # Design
//! A step costs two wake-ups: one at its instant to raise STEP, one after the pulse width to lower it. The pulse
//! in flight belongs to the port, not to the future that raised it, so dropping `emit` can neither cut a pulse
//! short nor lose its count.
//!
//! # Deadline
//! A step is due at its tick. A late wake-up makes that step late by as much and no later one: the next instant
//! comes from the profile. Lateness beyond [`LATE_MAX`] is a fault, because the steps behind would be bunched.

use core::convert::Infallible;

use embassy_time::{Duration, Instant, Timer};
use embedded_hal::digital::OutputPin;
use isostep_profile::Segment;

use crate::TICK_HZ;
use crate::port::{Capabilities, Direction, DriverTiming, Odometer, PortFault, StepPort, Wiring};

/// A step later than this is a fault: half a step period at 2,400 steps/s, the default machine's top speed.
pub const LATE_MAX: Duration = Duration::from_micros(208);

/// STEP and DIR on two output pins, timed by Embassy's time driver.
#[derive(Debug)]
pub struct TimerPort<S, D> {
    step: S,
    dir: D,
    direction: Direction,
    dir_high: bool,
    high: Duration,
    low: Duration,
    timing: DriverTiming,
    /// When the pulse in flight may end.
    falls: Option<Instant>,
    /// When STEP may rise next.
    ready: Instant,
}

impl<S, D> TimerPort<S, D>
where
    S: OutputPin<Error = Infallible>,
    D: OutputPin<Error = Infallible>,
{
    /// Drives STEP low and DIR high.
    pub fn new(step: S, dir: D, timing: DriverTiming) -> Self {
        let mut port = Self {
            step,
            dir,
            direction: Direction::Positive,
            dir_high: true,
            high: ticks_covering(timing.step_high_ns),
            low: ticks_covering(timing.step_low_ns),
            timing,
            falls: None,
            ready: Instant::now() + ticks_covering(timing.setup_ns),
        };
        let Ok(()) = port.step.set_low();
        let Ok(()) = port.dir.set_high();
        port
    }

    async fn step_at(&mut self, due: Instant, odometer: &Odometer) -> Result<(), PortFault> {
        self.settle().await;
        Timer::at(due.max(self.ready)).await;
        let now = Instant::now();
        if now > due + LATE_MAX {
            return Err(PortFault::Late { late: now - due, max: LATE_MAX });
        }
        let Ok(()) = self.step.set_high();
        odometer.count(self.direction);
        self.falls = Some(Instant::now() + self.high);
        Ok(())
    }
}

/// The fewest ticks sure to cover `ns`. One more than the quotient, because a reading of the clock may be almost a
/// tick old.
const fn ticks_covering(ns: u32) -> Duration {
    let ticks = (ns as u64 * TICK_HZ as u64).div_ceil(1_000_000_000);
    Duration::from_ticks(ticks + 1)
}

impl<S, D> StepPort for TimerPort<S, D>
where
    S: OutputPin<Error = Infallible>,
    D: OutputPin<Error = Infallible>,
{
    fn capabilities(&self) -> Capabilities {
        let period_ticks = (self.high + self.low).as_ticks() as u32;
        Capabilities { tick_hz: TICK_HZ, rate_max_steps_s: TICK_HZ / period_ticks }
    }

    async fn prepare(&mut self, direction: Direction, wiring: Wiring) {
        self.settle().await;
        self.direction = direction;
        self.high = ticks_covering(self.timing.step_high_ns.max(wiring.pulse_ns));
        let high = (direction == Direction::Positive) != wiring.direction_inverted;
        if high == self.dir_high {
            return;
        }
        // The low time since the last pulse is longer than DIR's hold time.
        Timer::at(self.ready).await;
        let Ok(()) = if high { self.dir.set_high() } else { self.dir.set_low() };
        self.dir_high = high;
        self.ready = Instant::now() + ticks_covering(self.timing.setup_ns);
    }

    async fn emit(&mut self, start: Instant, segment: Segment, odometer: &Odometer) -> Result<(), PortFault> {
        for ticks in segment.ticks() {
            self.step_at(start + Duration::from_ticks(ticks), odometer).await?;
        }
        Ok(())
    }

    async fn settle(&mut self) {
        if let Some(falls) = self.falls {
            Timer::at(falls).await;
            let Ok(()) = self.step.set_low();
            self.falls = None;
            self.ready = Instant::now() + self.low;
        }
    }
}
