//! `$STALL=X`: measures how near to a stall a motor is that turns freely, and proposes a threshold.

use core::fmt;

use embedded_storage_async::nor_flash::NorFlash;
use isostep_console::Error;
use isostep_motion::{Axis, Direction, Motion, Move};
use tmc2209::reg::{DRV_STATUS, SG_RESULT, TSTEP};

use super::exchange::{DriverOnWire, Failure};
use super::registers::clocks;
use super::stall::{obstacle, seek_mm_min};
use super::{Drivers, Wire};
use crate::controller::Controller;
use crate::output::Message;

/// The number of times that the axis goes there and back.
const RUNS: usize = 2;
/// The time for which it goes at full speed each time, s.
const CRUISE_S: f64 = 1.0;
/// A reading counts from this part of the speed on.
const STEADY: f32 = 0.95;
/// The number of times that the driver is asked before the others get their turn again.
const READINGS: usize = 16;
/// So many are needed.
const LEAST_READINGS: u16 = 16;
/// A motor of which SG_RESULT falls so low while it turns freely leaves no room for a threshold.
const LEAST_FREE: u16 = 40;

/// The values of SG_RESULT of a motor at steady speed.
#[derive(Clone, Copy)]
pub struct Readings {
    count: u16,
    least: u16,
    most: u16,
    sum: u32,
}

impl Readings {
    pub const NONE: Self = Self { count: 0, least: u16::MAX, most: 0, sum: 0 };

    fn take(&mut self, sg_result: u16) {
        self.count = self.count.saturating_add(1);
        self.least = self.least.min(sg_result);
        self.most = self.most.max(sg_result);
        self.sum = self.sum.saturating_add(sg_result.into());
    }
}

/// A driver is being measured, until this is dropped.
struct Measuring<'a>(&'a Drivers);

impl<'a> Measuring<'a> {
    fn new(drivers: &'a Drivers, driver: usize) -> Self {
        drivers.readings.set(Readings::NONE);
        drivers.measured.set(Some(driver));
        drivers.asked.signal(());
        Self(drivers)
    }
}

impl Drop for Measuring<'_> {
    fn drop(&mut self) {
        self.0.measured.set(None);
    }
}

impl<F: NorFlash> Controller<'_, F> {
    /// Moves `axis` to and fro at the speed of its seek, and proposes a threshold. It ends where it began.
    ///
    /// # Errors
    /// [`Error::UnknownStatement`] without UART drivers; [`Error::Unsupported`] if a stall could not be detected, or the axis
    /// has no room, with a message in `text`; [`Error::Locked`] if it is stopped.
    ///
    /// # Cancellation
    /// The driver is measured no more. A move that has begun goes on to its end.
    pub(crate) async fn measure_stall(&self, axis: Axis, text: &mut Message) -> Result<(), Error> {
        let Some(drivers) = &self.drivers else { return Err(Error::UnknownStatement) };
        self.closed_door()?;
        let obstacle = self.with(|program| obstacle(&program.settings, axis));
        if let Some(obstacle) = obstacle {
            text.say(obstacle);
            return Err(Error::Unsupported);
        }
        let (there_steps, feed_mm_s) = self.way(axis);
        let from_steps = self.machine.position_steps();
        let mut to_steps = from_steps;
        to_steps[axis as usize] += there_steps;
        if self.beyond_travel(to_steps).is_some() {
            text.say(format_args!("there is no room for {axis} to move: jog it to the middle of its travel"));
            return Err(Error::Unsupported);
        }
        let measuring = Measuring::new(drivers, axis as usize);
        for target_steps in [to_steps, from_steps].into_iter().cycle().take(2 * RUNS) {
            // No override slows a jog, and a jog cancel ends it.
            let source = self.source();
            self.submit(Motion::Jog(Move { feed_mm_s, source, ..Move::to(target_steps) })).await?;
        }
        self.settled().await?;
        self.follow_machine();
        drop(measuring);
        text.say(Free { axis, readings: drivers.readings.get() });
        Ok(())
    }

    /// The distance that the axis goes, away from its end, in steps, and its speed, mm/s.
    fn way(&self, axis: Axis) -> (i32, f64) {
        let config = self.machine.config();
        let feed_mm_s = self.with(|program| f64::from(seek_mm_min(&program.settings, axis as usize)) / 60.0);
        let most_mm = config.travel_mm[axis as usize] / 2.0;
        let steps = config.steps(axis, (config.run_up_mm(axis) + CRUISE_S * feed_mm_s).min(most_mm));
        (if config.homing.towards[axis as usize] == Direction::Positive { -steps } else { steps }, feed_mm_s)
    }

    /// Reads the driver that is being measured, if there is one, some times.
    pub(super) async fn measure<W: Wire>(&self, drivers: &Drivers, wire: &mut W) {
        let Some(driver) = drivers.measured.get() else { return };
        let steady_clocks = self.with(|program| {
            let steady_mm_min = STEADY * seek_mm_min(&program.settings, driver);
            clocks(&program.settings, driver, steady_mm_min)
        });
        let mut line = DriverOnWire { wire, address: drivers.hardware.addresses[driver] };
        for _ in 0..READINGS {
            // One that does not answer is reported by the next round.
            if drivers.measured.get() == Some(driver)
                && let Ok(Some(sg_result)) = line.reading(steady_clocks).await
            {
                let mut readings = drivers.readings.get();
                readings.take(sg_result);
                drivers.readings.set(readings);
            }
        }
    }
}

impl<W: Wire> DriverOnWire<'_, W> {
    /// SG_RESULT of a motor that turns at least as fast as so many clocks say, and chops by StealthChop.
    async fn reading(&mut self, steady_clocks: u32) -> Result<Option<u16>, Failure> {
        let sg_result: SG_RESULT = self.read().await?;
        let is_fast = self.read::<TSTEP>().await?.get() <= steady_clocks;
        Ok((is_fast && self.read::<DRV_STATUS>().await?.stealth()).then_some(sg_result.0 as u16))
    }
}

/// The report of a motor that has turned freely.
struct Free {
    axis: Axis,
    readings: Readings,
}

impl fmt::Display for Free {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { axis, readings: Readings { count, least, most, sum } } = *self;
        let number = 200 + axis as u16;
        if count < LEAST_READINGS {
            return write!(f, "{axis} was too short at full speed, {count} readings: raise ${}", 120 + axis as u16);
        }
        let mean = sum / u32::from(count);
        write!(f, "{axis} turns freely at SG_RESULT {least} to {most}, mean {mean}, {count} readings: ")?;
        if least < LEAST_FREE {
            return f.write_str("too low for a threshold. Seek faster ($25), or mend what brakes it");
        }
        // A driver tells a stall at twice the threshold: half-way down to 0.
        write!(f, "try ${number}={}, then $H{axis} with a hand on the power switch", least / 4)
    }
}
