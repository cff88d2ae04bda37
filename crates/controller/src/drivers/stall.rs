//! Homing by stall: what must be so that a driver can tell one, and the drivers that are set to tell it meanwhile.

use core::fmt;

use embedded_storage_async::nor_flash::NorFlash;
use isostep_console::{Error, Fixed, Settings};
use isostep_motion::{AXES, Axis, Motor};

use super::{DriverNews, Drivers};
use crate::config::config;
use crate::controller::Controller;
use crate::output::Message;

/// Slower motors induce too little to be measured, full steps/s: a quarter of a turn of most.
const LEAST_FULL_STEPS_S: f32 = 50.0;
/// A driver is told to look for stalls from this part of the seek's speed on: slower, a motor that speeds up seems stalled.
pub const LOOKS_FROM: f32 = 0.75;
/// The greatest distance of the field ahead of a motor that stalls, full steps.
const AHEAD_FULL_STEPS: f32 = 2.0;
/// The first drivers, whose DIAG a board can lead to a limit input. The fourth's would be on the emergency stop's.
const JUMPERS: usize = 3;
/// The factor by which StealthChop must reach beyond the seek: its end is not exact, and the driver's clock is not.
const STEALTH_SEEKS: f32 = 1.25;

/// The drivers look for stalls of these axes' motors, until this is dropped.
pub struct Looking<'a>(&'a Drivers);

impl<'a> Looking<'a> {
    fn new(drivers: &'a Drivers, mask: u16) -> Self {
        drivers.looks_mask.set(mask);
        drivers.settings_changed();
        Self(drivers)
    }
}

impl Drop for Looking<'_> {
    fn drop(&mut self) {
        self.0.looks_mask.set(0);
        self.0.settings_changed();
    }
}

impl<F: NorFlash> Controller<'_, F> {
    /// Has the drivers of those of `axes` that home by stall look for one. `None` if there is no such axis.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if a stall could not be detected, [`Error::Locked`] if a driver does not take it; `text` says why.
    ///
    /// # Cancellation
    /// The drivers no longer look. Nothing has moved.
    pub(crate) async fn look_for_stalls(
        &self,
        axes: [bool; AXES],
        text: &mut Message,
    ) -> Result<Option<Looking<'_>>, Error> {
        let Some(drivers) = &self.drivers else { return Ok(None) };
        let (mask, obstacle) = self.with(|program| by_stall(&program.settings, axes));
        if mask == 0 {
            return Ok(None);
        }
        let refuse = |text: &mut Message, obstacle: Obstacle| {
            text.say(obstacle);
            Err(Error::Unsupported)
        };
        if let Some(obstacle) = obstacle {
            return refuse(text, obstacle);
        }
        let looking = Looking::new(drivers, mask);
        self.drivers_set().await;
        for axis in axes_of(mask) {
            let health = drivers.known.borrow()[axis as usize].health;
            if health.stops() {
                text.say(DriverNews { motor: Motor::first(axis), health });
                return Err(Error::Locked);
            }
        }
        let pressed = self.machine.status().pressed;
        match axes_of(mask).find(|&axis| pressed[axis as usize]) {
            Some(axis) => refuse(text, Obstacle { axis, kind: ObstacleKind::High }),
            None => Ok(Some(looking)),
        }
    }

    /// Says how far the two stalls of each axis were apart.
    pub(crate) fn say_stalls(&self, axes: [bool; AXES], text: &mut Message) {
        let (mask, _) = self.with(|program| by_stall(&program.settings, axes));
        let apart_steps = self.machine.stalls_apart_steps();
        for axis in axes_of(mask) {
            let steps = apart_steps[axis as usize].unsigned_abs();
            text.say(format_args!("{axis} has stalled twice, {steps} steps apart"));
        }
    }
}

/// Those of `axes` that home by stall, and what first stands in the way of that.
fn by_stall(settings: &Settings, axes: [bool; AXES]) -> (u16, Option<Obstacle>) {
    let order = settings.homing_order();
    let homes = |axis: &Axis| axes[*axis as usize] && order.contains(&Some(*axis as usize));
    let mask = Axis::ALL.into_iter().filter(homes).fold(0, |mask, axis| mask | 1 << axis as u16);
    let mask = mask & settings.stall_homing_mask;
    let without_threshold = |axis: &Axis| settings.stall_threshold[*axis as usize] == 0;
    let obstacle = axes_of(mask).find_map(|axis| obstacle(settings, axis));
    let untried = || Some(Obstacle { axis: axes_of(mask).find(without_threshold)?, kind: ObstacleKind::NoThreshold });
    (mask, obstacle.or_else(untried))
}

fn axes_of(mask: u16) -> impl Iterator<Item = Axis> {
    Axis::ALL.into_iter().filter(move |&axis| mask & (1 << axis as u16) != 0)
}

/// The speed at which an axis seeks, mm/min: no faster than it may.
pub fn seek_mm_min(settings: &Settings, axis: usize) -> f32 {
    settings.homing_seek_mm_min.min(settings.max_rate_mm_min[axis])
}

/// Why a stall of an axis could not be detected. Displays as the text of a `[MSG:...]`.
pub struct Obstacle {
    axis: Axis,
    kind: ObstacleKind,
}

enum ObstacleKind {
    /// The driver is not set and watched.
    LeftOut,
    /// Its driver's DIAG is not connected to the input of a limit switch, or one of two motors would have to be detected.
    Unwired,
    /// It chops by SpreadCycle at the speed of the seek.
    SpreadCycle { stealth_mm_min: f32, least_mm_min: f32 },
    /// The seek is too slow.
    Slow { seek_mm_min: f32, least_mm_min: f32 },
    /// The way of the run-up does not fit into the travel.
    LongRunUp { way_mm: f32, travel_mm: f32 },
    /// The field of a motor that stalls is ahead of it by up to two full steps, and would not come back to it.
    ShortPullOff { pull_off_mm: f32, least_mm: f32 },
    /// Nobody has found the threshold.
    NoThreshold,
    /// The input is high although the motor stands.
    High,
}

/// The obstacle to telling a stall, apart from the threshold.
pub fn obstacle(settings: &Settings, axis: Axis) -> Option<Obstacle> {
    let index = axis as usize;
    let seek_mm_min = seek_mm_min(settings, index);
    let full_steps_mm = settings.steps_per_mm[index] / f32::from(settings.microsteps[index]);
    let slowest_mm_min = LEAST_FULL_STEPS_S / LOOKS_FROM * 60.0 / full_steps_mm;
    let (stealth_mm_min, least_mm_min) = (settings.stealth_mm_min[index], STEALTH_SEEKS * seek_mm_min);
    let (way_mm, travel_mm) = (way_mm(settings, axis) as f32, settings.reach_mm(index));
    let (pull_off_mm, least_mm) = (settings.homing_pull_off_mm, AHEAD_FULL_STEPS / full_steps_mm);
    let kind = if settings.trinamic_mask & (1 << index) == 0 {
        ObstacleKind::LeftOut
    } else if index >= JUMPERS || settings.second_motor() == Some(index) {
        ObstacleKind::Unwired
    } else if seek_mm_min < slowest_mm_min {
        ObstacleKind::Slow { seek_mm_min, least_mm_min: slowest_mm_min }
    } else if stealth_mm_min < least_mm_min {
        ObstacleKind::SpreadCycle { stealth_mm_min, least_mm_min }
    } else if way_mm >= travel_mm {
        ObstacleKind::LongRunUp { way_mm, travel_mm }
    } else if pull_off_mm < least_mm {
        ObstacleKind::ShortPullOff { pull_off_mm, least_mm }
    } else {
        return None;
    };
    Some(Obstacle { axis, kind })
}

/// The distance that an axis backs off from its end, and from which it comes again, mm.
fn way_mm(settings: &Settings, axis: Axis) -> f64 {
    config(settings).run_up_mm(axis) + f64::from(settings.homing_pull_off_mm)
}

impl fmt::Display for Obstacle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { axis, ref kind } = *self;
        let number = |first: usize| first + axis as usize;
        let whole = |value| Fixed { value, decimals: 0 };
        // Rounded up, so that the value in the message is itself accepted.
        let least = |mm_min: f32| mm_min as u32 + u32::from(mm_min % 1.0 > 0.0);
        write!(f, "a stall of {axis} cannot be detected: ")?;
        match *kind {
            ObstacleKind::LeftOut => f.write_str("$338 leaves its driver out. Take it in, or out of $339"),
            ObstacleKind::Unwired => f.write_str(
                "only X, Y and Z with one motor each have a driver whose DIAG can be wired. Take it out of $339",
            ),
            ObstacleKind::SpreadCycle { stealth_mm_min, least_mm_min } => {
                let (setting, is, most) = (number(980), whole(stealth_mm_min), least(least_mm_min));
                write!(f, "it seeks by SpreadCycle, ${setting}={is}. Set ${setting}={most}, or more")
            }
            ObstacleKind::Slow { seek_mm_min, least_mm_min } => {
                let (is, most, top) = (whole(seek_mm_min), least(least_mm_min), number(110));
                write!(f, "it seeks at {is} mm/min, which is too slow. Set $25={most}, or more, and ${top}")
            }
            ObstacleKind::LongRunUp { way_mm, travel_mm } => {
                let (way, travel, accel) = (whole(way_mm), whole(travel_mm), number(120));
                write!(f, "its run-up is {way} mm long, its travel {travel}. Raise ${accel}, or lower $25")
            }
            ObstacleKind::ShortPullOff { pull_off_mm, least_mm } => {
                let exact = |value| Fixed { value, decimals: 3 };
                let (is, most) = (exact(pull_off_mm), exact(least(1_000.0 * least_mm) as f32 / 1_000.0));
                write!(f, "it pulls off by less than two full steps, $27={is}. Set $27={most}, or more")
            }
            ObstacleKind::NoThreshold => {
                write!(f, "${}=0. With {axis} in the middle of its travel send $STALL={axis}", number(200))
            }
            ObstacleKind::High => f.write_str(
                "its limit input is high while the motor stands. Set the jumper from its driver's DIAG, unplug the switch",
            ),
        }
    }
}
