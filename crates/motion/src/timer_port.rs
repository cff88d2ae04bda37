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
use isostep_profile::Segment;

use crate::TICK_HZ;
use crate::port::{Capabilities, Direction, DriverTiming, Odometer, PortFault, StepPort, Wiring};

/// A step later than this is a fault: half a step period at 2,400 steps/s, the default machine's top speed.
pub const LATE_MAX: Duration = Duration::from_micros(208);

/// STEP and DIR on two output pins, timed by Embassy's time driver.
#[derive(Debug)]
pub struct TimerPort<S, D, W> {
    step: S,
    dir: D,
    delay: W,
    timing: DriverTiming,
    direction: Direction,
    pulse_ns: u32,
    /// From one rise to the next, at least.
    cycle: Duration,
    /// When STEP may rise next.
    ready: Instant,
}

impl<S, D, W> TimerPort<S, D, W>
where
    S: OutputPin<Error = Infallible>,
    D: OutputPin<Error = Infallible>,
    W: DelayNs,
{
    /// Drives STEP low and DIR high. `delay` blocks for the width of a pulse.
    pub fn new(step: S, dir: D, delay: W, timing: DriverTiming) -> Self {
        let mut port = Self {
            step,
            dir,
            delay,
            timing,
            direction: Direction::Positive,
            pulse_ns: timing.step_high_ns,
            cycle: cycle(timing, timing.step_high_ns),
            ready: Instant::now(),
        };
        let Ok(()) = port.step.set_low();
        port.prepare(Direction::Positive, Wiring::default());
        port
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
        self.ready = now + self.cycle;
        Ok(())
    }
}

/// The fewest ticks sure to cover `ns`. One more than the quotient, because a reading of the clock may be almost a
/// tick old.
const fn ticks_covering(ns: u32) -> Duration {
    let ticks = (ns as u64 * TICK_HZ as u64).div_ceil(1_000_000_000);
    Duration::from_ticks(ticks + 1)
}

const fn cycle(timing: DriverTiming, pulse_ns: u32) -> Duration {
    ticks_covering(pulse_ns + timing.step_low_ns)
}

impl<S, D, W> StepPort for TimerPort<S, D, W>
where
    S: OutputPin<Error = Infallible>,
    D: OutputPin<Error = Infallible>,
    W: DelayNs,
{
    fn capabilities(&self) -> Capabilities {
        let cycle_ticks = cycle(self.timing, self.timing.step_high_ns).as_ticks() as u32;
        Capabilities { tick_hz: TICK_HZ, rate_max_steps_s: TICK_HZ / cycle_ticks }
    }

    fn prepare(&mut self, direction: Direction, wiring: Wiring) {
        self.direction = direction;
        self.pulse_ns = self.timing.step_high_ns.max(wiring.pulse_ns);
        self.cycle = cycle(self.timing, self.pulse_ns);
        // The last pulse is over, so DIR's hold time is too.
        let high = (direction == Direction::Positive) != wiring.direction_inverted;
        let Ok(()) = if high { self.dir.set_high() } else { self.dir.set_low() };
        self.ready = self.ready.max(Instant::now() + ticks_covering(self.timing.setup_ns));
    }

    async fn emit(&mut self, start: Instant, segment: Segment, odometer: &Odometer) -> Result<(), PortFault> {
        for ticks in segment.ticks() {
            self.step_at(start + Duration::from_ticks(ticks), odometer).await?;
        }
        Ok(())
    }
}
