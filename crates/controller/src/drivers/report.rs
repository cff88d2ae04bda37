//! The reports of drivers to consoles: M122, and news.

use core::fmt;

use isostep_console::Settings;
use isostep_motion::Motor;
use tmc2209::reg::DRV_STATUS;

use super::health::Health;
use super::{DRIVERS, DriverNews, Drivers, Known, is_watched, motor};
use crate::status;

impl Drivers {
    /// Line `index` of M122, which has one for each driver that has a motor; `None` after the last.
    pub fn line(&self, index: usize, settings: &Settings) -> Option<DriverLine> {
        let mut motors = (0..DRIVERS).filter_map(|driver| motor(driver, settings).map(|motor| (driver, motor)));
        let (driver, motor) = motors.nth(index)?;
        Some(DriverLine {
            motor,
            known: is_watched(motor, settings).then(|| self.known.borrow()[driver]),
            sense_milliohms: self.hardware.sense_milliohms,
        })
    }
}

/// A line of M122.
pub struct DriverLine {
    motor: Motor,
    /// `None` if it is not watched.
    known: Option<Known>,
    sense_milliohms: u16,
}

impl fmt::Display for DriverLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} driver: ", status::name(self.motor))?;
        let Some(known) = self.known else { return f.write_str("left out by $338") };
        f.write_str(known.health.words().0)?;
        let Some(set) = known.set else { return Ok(()) };
        let (microsteps, run_ma, hold_ma) = set.shown(self.sense_milliohms);
        write!(f, ", {microsteps} microsteps, {run_ma} mA, {hold_ma} mA at standstill, ")?;
        // The load is measured by StealthChop alone.
        if DRV_STATUS(known.status).stealth() {
            write!(f, "StealthChop, SG_RESULT {}", known.sg_result)
        } else {
            f.write_str("SpreadCycle")
        }
    }
}

/// Its first word is the motor's name.
impl fmt::Display for DriverNews {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, remedy) = self.health.words();
        let is = if matches!(self.health, Health::Well | Health::Hot) { "is " } else { "" };
        write!(f, "{} driver {is}{what}", status::name(self.motor))?;
        if remedy.is_empty() { Ok(()) } else { write!(f, ": {remedy}") }
    }
}
