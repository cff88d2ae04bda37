//! The machine's properties that the coordinator needs, checked as a whole.

use core::fmt;

use embassy_time::Duration;
use isostep_profile::shaper::{Shaper, ShaperError, ShaperKind};
use isostep_profile::{IntervalSplit, LimitError, Limits, OFFSET_PARTS, SpeedProfile};

use crate::axes::{AXES, Axis};
use crate::clock::seconds;
use crate::kinematics::Kinematics;
use crate::motor::LimitInput;
use crate::port::{Capabilities, Direction, Wiring};
use crate::run::COMMITTED_AT_CONTACT;
use crate::switch::Contact;
use crate::tool::spindle::ToolConfig;

/// Lengths that differ by no more than this part of them are the same, but for rounding.
const SAME: f64 = 1e-9;

/// The machine's properties, in steps, mm and s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// Each axis's limits.
    pub limits: [Limits; AXES],
    /// What the motors do for the axes to move.
    pub kinematics: Kinematics,
    /// Each axis's resolution, steps/mm; above 0. That of X and Y is the same with crossed belts.
    pub steps_per_mm: [f64; AXES],
    /// The distance that each axis travels from its zero, mm; above 0. One turn of an axis without an end.
    pub travel_mm: [f64; AXES],
    /// The axes that turn without an end, in degrees where others have mm.
    pub is_endless: [bool; AXES],
    /// Junction deviation, mm: a corner between moves is taken as fast as a circle that deviates from the corner by
    /// this much. 0 stops at every corner.
    pub junction_deviation_mm: f64,
    /// The split of a move's time into intervals.
    pub interval_split: IntervalSplit,
    /// The change of speed on the ramps of a move.
    pub speed_profile: SpeedProfile,
    /// Each axis's shaper, for programs and jogs. Only a trapezoid is shaped.
    pub shapers: [Shaper; AXES],
    /// A limit switch that closes outside homing stops the machine.
    pub hard_limits: bool,
    /// Each axis's driver.
    pub wiring: [Wiring; AXES],
    /// ENABLE is active high.
    pub enable_inverted: bool,
    /// Switches open, rather than close, to ground when pressed.
    pub switches_inverted: bool,
    /// The contacts of the axes' drives that tell an alarm; `None` without.
    pub drive_alarms: [Option<Contact>; AXES],
    /// The time for which the motors stay energised at rest; `None` is for ever.
    pub idle_delay: Option<Duration>,
    /// The tool's outputs.
    pub tool: ToolConfig,
    /// The probe's input is high, rather than low, while it touches.
    pub probe_inverted: bool,
    /// The board pulls the probe's input up; otherwise the probe drives both levels.
    pub probe_pulled_up: bool,
    /// The input of the feed hold is the safety door's switch, low while the door is open.
    pub hold_is_door: bool,
    /// The way to home.
    pub homing: HomingConfig,
    /// The axis with a second motor, if there is one.
    pub squared: Option<Squared>,
}

/// An axis that two motors move, one at each side of the gantry, and that homing squares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Squared {
    /// The axis.
    pub axis: Axis,
    /// The second motor's DIR has the other level than that of the first.
    pub direction_inverted: bool,
    /// The distance of the second motor from its switch less that of the first when the axis is square, mm. Below 0 it
    /// is the first that stands farther, by as much.
    pub offset_mm: f64,
    /// The distance that one motor may go alone to its switch, mm; above 0. Beyond that the gantry is too skewed.
    pub skew_max_mm: f64,
}

/// The way to find the machine's zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HomingConfig {
    /// The axes that home, first to last.
    pub order: [Option<Axis>; AXES],
    /// The places where each axis's switch is.
    pub towards: [Direction; AXES],
    /// Speed of the seek, mm/s; above 0. Without room behind the switch the stop there is abrupt, so keep it within what the
    /// motor stops from; a step lost there costs nothing, because the latch measures again.
    pub seek_mm_s: f64,
    /// The room behind each switch in which a seek brakes, and in which the switch stays pressed, mm; 0: it stops at the switch at
    /// once. An axis with two motors always does, because only one of them would be measured where it stands, and so does one
    /// that homes by stall.
    pub room_mm: f64,
    /// Speed of the latch, mm/s; above 0, slow enough that the motor stops without losing a step.
    pub latch_mm_s: f64,
    /// Distance from the switch to the axis's zero, mm; above 0, and below the travel of every axis. An axis moves off
    /// its switch by this distance before it has a zero, whichever end it homes to, and only the travel says how much
    /// room there is. A pull-off as long as the travel would end at the far end of the axis, where no travel is left,
    /// or beyond it.
    pub pull_off_mm: f64,
    /// A switch counts as changed once it has been steady this long.
    pub debounce: Duration,
    /// The axes that have no switch, but a driver that says when its motor stalls: its output, high then and also for an
    /// error of the driver, is on the axis's limit input. They latch at the speed of the seek, because slower motors are
    /// not measured. Such an axis may not have a second motor.
    pub by_stall: [bool; AXES],
}

/// Why a configuration was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ConfigError {
    /// An axis's limits do not work.
    Limits {
        /// The axis.
        axis: Axis,
        /// The fault.
        error: LimitError,
    },
    /// An axis's top speed is above the step rate that its port can make with these pulses, steps/s.
    Rate {
        /// The axis.
        axis: Axis,
        /// The value that was asked for.
        asked: f64,
        /// The highest that works.
        max: f64,
        /// Width of the pulses, ns.
        pulse_ns: u32,
    },
    /// A length, resolution or homing speed is not a positive number.
    NotPositive {
        /// Name of the value, with its unit.
        what: &'static str,
        /// The value that was asked for.
        asked: f64,
    },
    /// A length is below 0, or not a number.
    Negative {
        /// Name of the value, with its unit.
        what: &'static str,
        /// The value that was asked for.
        asked: f64,
    },
    /// The homing pull-off, with the offset of a second motor, is as long as the travel of an axis, or longer, mm.
    PullOff {
        /// The axis.
        axis: Axis,
        /// The value that was asked for.
        asked_mm: f64,
        /// The travel, which it must be below.
        travel_mm: f64,
    },
    /// A seek of homing does not brake within the room behind the switch of an axis, mm.
    Room {
        /// The axis.
        axis: Axis,
        /// The room.
        room_mm: f64,
        /// The way on which it brakes.
        brakes_mm: f64,
    },
    /// The room behind the switches is not 0, and the speed profile is curved.
    RoomOfCurve,
    /// The homing order names an axis twice.
    HomingOrder,
    /// An axis's shaper does not work.
    Shaper {
        /// The axis.
        axis: Axis,
        /// The fault.
        error: ShaperError,
    },
    /// X and Y have crossed belts and different steps/mm.
    BeltSteps {
        /// Steps/mm of X.
        x: f64,
        /// Steps/mm of Y.
        y: f64,
    },
    /// An axis with crossed belts was to have a second motor.
    BeltSquared {
        /// The axis.
        axis: Axis,
    },
    /// An axis has a shaper, and the speed profile is curved.
    ShapedCurve {
        /// The axis.
        axis: Axis,
    },
}

impl Config {
    /// A machine of these axes without anything else: no tool, no shaper, no axis without an end, no second motor; moves are
    /// trapezoids, corners deviate by 0.01 mm, limit switches stop it, and its motors stay energised.
    #[must_use]
    pub fn new(
        limits: [Limits; AXES],
        steps_per_mm: [f64; AXES],
        travel_mm: [f64; AXES],
        homing: HomingConfig,
    ) -> Self {
        Self {
            limits,
            kinematics: Kinematics::Cartesian,
            steps_per_mm,
            travel_mm,
            is_endless: [false; AXES],
            junction_deviation_mm: 0.01,
            interval_split: IntervalSplit::Fastest,
            speed_profile: SpeedProfile::Trapezoid,
            shapers: [Shaper::default(); AXES],
            hard_limits: true,
            wiring: [Wiring::default(); AXES],
            enable_inverted: false,
            switches_inverted: false,
            drive_alarms: [None; AXES],
            idle_delay: None,
            tool: ToolConfig::default(),
            probe_inverted: false,
            probe_pulled_up: true,
            hold_is_door: false,
            homing,
            squared: None,
        }
    }

    /// Refuses a configuration that cannot work with step ports of these capabilities. A port whose capabilities are
    /// not known is assumed to carry every rate.
    ///
    /// # Errors
    /// Names the first value that does not work and the limit it crossed.
    pub fn check(&self, ports: [Option<Capabilities>; AXES]) -> Result<(), ConfigError> {
        for axis in Axis::ALL {
            let limits = self.limits[axis as usize];
            limits.check().map_err(|error| ConfigError::Limits { axis, error })?;
            if let Some(port) = ports[axis as usize] {
                self.check_rate(axis, port)?;
            }
            positive("steps/mm", self.steps_per_mm[axis as usize])?;
            positive("travel, mm", self.travel_mm[axis as usize])?;
            self.check_shaper(axis)?;
        }
        not_negative("junction deviation, mm", self.junction_deviation_mm)?;
        positive("PWM frequency, Hz", self.tool.pwm_hz.into())?;
        positive("homing seek, mm/s", self.homing.seek_mm_s)?;
        positive("homing latch, mm/s", self.homing.latch_mm_s)?;
        positive("homing pull-off, mm", self.homing.pull_off_mm)?;
        not_negative("room behind a switch, mm", self.homing.room_mm)?;
        if let Some(squared) = self.squared {
            positive("skew limit, mm", squared.skew_max_mm)?;
        }
        Axis::ALL.into_iter().try_for_each(|axis| self.check_homing(axis))?;
        self.check_kinematics()?;
        let times = |axis| self.homing.order.iter().flatten().filter(|&&homes| homes == axis).count();
        if Axis::ALL.into_iter().any(|axis| times(axis) > 1) {
            return Err(ConfigError::HomingOrder);
        }
        Ok(())
    }

    fn check_rate(&self, axis: Axis, port: Capabilities) -> Result<(), ConfigError> {
        let wiring = self.wiring[axis as usize];
        let (asked, max) = (self.limits[axis as usize].top_speed_steps_s, port.rate_max_steps_s(wiring).into());
        if asked > max {
            return Err(ConfigError::Rate { axis, asked, max, pulse_ns: port.pulse_ns(wiring) });
        }
        Ok(())
    }

    #[cold]
    fn check_kinematics(&self) -> Result<(), ConfigError> {
        let [x, y] = [Axis::X, Axis::Y].map(|axis| self.steps_per_mm[axis as usize]);
        let is_belt = |axis: Axis| axis == Axis::X || axis == Axis::Y;
        match self.kinematics {
            Kinematics::Cartesian => Ok(()),
            Kinematics::CoreXy if x != y => Err(ConfigError::BeltSteps { x, y }),
            Kinematics::CoreXy => match self.squared.map(|squared| squared.axis).filter(|axis| is_belt(*axis)) {
                Some(axis) => Err(ConfigError::BeltSquared { axis }),
                None => Ok(()),
            },
        }
    }

    fn check_shaper(&self, axis: Axis) -> Result<(), ConfigError> {
        let shaper = self.shapers[axis as usize];
        if shaper.kind == ShaperKind::None {
            return Ok(());
        }
        shaper.check().map_err(|error| ConfigError::Shaper { axis, error })?;
        if self.speed_profile == SpeedProfile::Trapezoid { Ok(()) } else { Err(ConfigError::ShapedCurve { axis }) }
    }

    /// True if a press at the limit input is heeded, and true if the input is low, rather than high, when it is pressed. There is no
    /// end behind that of an axis that turns, no switch of a second motor that there is not, and no alarm without a contact.
    #[inline(never)]
    pub(crate) fn press(&self, input: LimitInput) -> (bool, bool) {
        let has_end = |axis: Axis| self.hard_limits && !self.is_endless[axis as usize];
        match input {
            LimitInput::Of(axis) if self.homing.by_stall[axis as usize] => (true, false),
            LimitInput::Of(axis) => (has_end(axis), !self.switches_inverted),
            LimitInput::Second => (self.squared.is_some_and(|squared| has_end(squared.axis)), !self.switches_inverted),
            LimitInput::Alarm(axis) => {
                let contact = self.drive_alarms[axis as usize];
                (contact.is_some(), contact != Some(Contact::NormallyClosed))
            }
        }
    }

    /// True if the limit input is a driver's, which says that its motor stalls.
    pub(crate) fn is_stall(&self, input: LimitInput) -> bool {
        matches!(input, LimitInput::Of(axis) if self.homing.by_stall[axis as usize])
    }

    /// The way on which `axis` has surely reached the speed of the seek, no faster than it may, mm: twice that of a trapezoid.
    #[must_use]
    pub fn run_up_mm(&self, axis: Axis) -> f64 {
        let Limits { top_speed_steps_s, accel_steps_s2, .. } = self.limits[axis as usize];
        let steps_per_mm = self.steps_per_mm[axis as usize];
        let seek_steps_s = (self.homing.seek_mm_s * steps_per_mm).min(top_speed_steps_s);
        seek_steps_s * seek_steps_s / accel_steps_s2 / steps_per_mm
    }

    /// True if a seek of `axis` brakes behind its switch.
    pub(crate) fn brakes_behind(&self, axis: Axis) -> bool {
        self.homing.room_mm > 0.0 && !self.homing.by_stall[axis as usize] && self.squared_axis(axis).is_none()
    }

    /// The way on which a seek of `axis` comes to rest behind its switch, at most, mm.
    #[cold]
    fn brakes_mm(&self, axis: Axis) -> f64 {
        let Limits { top_speed_steps_s, decel_steps_s2, .. } = self.limits[axis as usize];
        let steps_per_mm = self.steps_per_mm[axis as usize];
        let seek_mm_s = self.homing.seek_mm_s.min(top_speed_steps_s / steps_per_mm);
        let brakes_s = seek_mm_s * steps_per_mm / decel_steps_s2;
        seek_mm_s * (seconds(COMMITTED_AT_CONTACT) + brakes_s / 2.0)
    }

    #[cold]
    fn check_room(&self, axis: Axis) -> Result<(), ConfigError> {
        let (room_mm, brakes_mm) = (self.homing.room_mm, self.brakes_mm(axis));
        match () {
            () if room_mm > 0.0 && self.speed_profile != SpeedProfile::Trapezoid => Err(ConfigError::RoomOfCurve),
            () if !self.homing.order.contains(&Some(axis)) || !self.brakes_behind(axis) => Ok(()),
            () if brakes_mm * (1.0 - SAME) <= room_mm => Ok(()),
            () => Err(ConfigError::Room { axis, room_mm, brakes_mm }),
        }
    }

    #[cold]
    fn check_homing(&self, axis: Axis) -> Result<(), ConfigError> {
        self.check_pull_off(axis)?;
        self.check_room(axis)
    }

    #[cold]
    fn check_pull_off(&self, axis: Axis) -> Result<(), ConfigError> {
        let offset_mm = self.squared_axis(axis).map_or(0.0, |squared| squared.offset_mm);
        let (asked_mm, travel_mm) = (self.homing.pull_off_mm + offset_mm.abs(), self.travel_mm[axis as usize]);
        if asked_mm < travel_mm { Ok(()) } else { Err(ConfigError::PullOff { axis, asked_mm, travel_mm }) }
    }

    /// The way in which `axis` is squared, if it has a second motor.
    pub(crate) fn squared_axis(&self, axis: Axis) -> Option<Squared> {
        self.squared.filter(|squared| squared.axis == axis)
    }

    /// True if a position of `axis` means the same place as it does with `other`, if the zero stays where it was. It
    /// does if the motors that move it, the direction, the side of the switch, what the second motor does and the length of a
    /// step are the same.
    /// The travel and the pull-off do not matter: they only say how far the axis goes from that zero, and where the next
    /// homing will find one.
    pub(crate) fn has_places_of(&self, other: &Self, axis: Axis) -> bool {
        let i = axis as usize;
        // What the motors do that move it.
        let motors = self.kinematics.moves(axis);
        let directions = |config: &Self| {
            let inverted = |motor: usize| motors[motor] && config.wiring[motor].direction_inverted;
            core::array::from_fn::<_, AXES, _>(inverted)
        };
        motors == other.kinematics.moves(axis)
            && directions(self) == directions(other)
            && self.squared_axis(axis) == other.squared_axis(axis)
            && self.homing.towards[i] == other.homing.towards[i]
            && self.steps_per_mm[i] == other.steps_per_mm[i]
    }

    /// The positions that an axis may take once it is homed, steps: from zero to its travel, away from the switch; any
    /// if it has no end.
    #[must_use]
    #[cold]
    pub fn travel_steps(&self, axis: Axis) -> core::ops::RangeInclusive<i32> {
        let i = axis as usize;
        if self.is_endless[i] {
            return i32::MIN..=i32::MAX;
        }
        let far = libm::round(self.travel_mm[i] * self.steps_per_mm[i]) as i32;
        match self.homing.towards[i] {
            Direction::Negative => 0..=far,
            Direction::Positive => -far..=0,
        }
    }

    /// Length of `steps` steps of `axis`, mm.
    #[must_use]
    pub fn mm(&self, axis: Axis, steps: i32) -> f64 {
        f64::from(steps) / self.steps_per_mm[axis as usize]
    }

    /// `mm` along `axis` in whole steps, rounded to the nearest.
    #[must_use]
    pub fn steps(&self, axis: Axis, mm: f64) -> i32 {
        whole_steps(mm, self.steps_per_mm[axis as usize])
    }
}

/// `mm` in whole steps, rounded to the nearest.
#[must_use]
pub fn whole_steps(mm: f64, steps_per_mm: f64) -> i32 {
    nearest(mm * steps_per_mm)
}

/// The distance of `mm` from those whole steps, in [`OFFSET_PARTS`](isostep_profile::OFFSET_PARTS) of a step.
#[must_use]
pub fn beside_steps(mm: f64, steps_per_mm: f64) -> i8 {
    let steps = mm * steps_per_mm;
    let bits = steps.to_bits();
    let exponent = ((bits >> 52) & 0x7FF) as i32 - 1023;
    let whole = nearest(steps).unsigned_abs().wrapping_mul(OFFSET_PARTS as u32);
    let mantissa = 1 << 52 | bits << 12 >> 12;
    // The mantissa has 52 digits after its point, and half a part has one digit more than a part.
    let parts = match 51 - OFFSET_PARTS.ilog2() as i32 - exponent {
        shift @ 0..64 => ((mantissa >> shift) as u32).wrapping_add(1) >> 1,
        // Less than half a part, or so large that it is whole.
        _ => whole,
    };
    let beside = parts.wrapping_sub(whole) as i8;
    if steps.is_sign_negative() { -beside } else { beside }
}

/// Two roundings make a product of decimals smaller by at most this many units of its last place.
const ROUNDED_ULPS: u64 = 4;

/// The nearest whole number, halves rounded away from zero. A number that is no more than [`ROUNDED_ULPS`] below a half
/// is a half, so that decimals which make one do not end up on either side of it by chance. Otherwise the result is
/// that of [`libm::round`] and a cast, but without the sum and the comparisons of doubles, which are function calls on
/// small chips.
fn nearest(value: f64) -> i32 {
    let bits = value.to_bits().wrapping_add(ROUNDED_ULPS);
    let exponent = ((bits >> 52) & 0x7FF) as i32 - 1023;
    // The leading 32 bits of the mantissa, which is in [1, 2).
    let leading = 1 << 31 | (bits >> 21) as u32;
    match 30 - exponent {
        shift @ 1..32 => {
            let magnitude = (leading >> shift).div_ceil(2) as i32;
            if value.is_sign_negative() { -magnitude } else { magnitude }
        }
        32.. => 0,
        // Too large, or not a number.
        _ => libm::round(value) as i32,
    }
}

fn positive(what: &'static str, asked: f64) -> Result<(), ConfigError> {
    if asked > 0.0 && asked.is_finite() { Ok(()) } else { Err(ConfigError::NotPositive { what, asked }) }
}

fn not_negative(what: &'static str, asked: f64) -> Result<(), ConfigError> {
    if asked >= 0.0 && asked.is_finite() { Ok(()) } else { Err(ConfigError::Negative { what, asked }) }
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Limits { axis, error } => write!(f, "{axis}: {error}"),
            Self::Rate { axis, asked, max, pulse_ns } => write!(
                f,
                "{axis}: {asked} steps/s is above the {max} steps/s its step port carries with pulses of {pulse_ns} ns"
            ),
            Self::NotPositive { what, asked } => write!(f, "{what}: {asked} must be above 0"),
            Self::Negative { what, asked } => write!(f, "{what}: {asked} must be 0 or more"),
            Self::PullOff { axis, asked_mm, travel_mm } => write!(
                f,
                "{axis}: a homing pull-off of {asked_mm} mm is not below the travel of {travel_mm} mm: lower it, or raise the travel"
            ),
            Self::Room { axis, room_mm, brakes_mm } => write!(
                f,
                "{axis}: a homing seek brakes within {brakes_mm} mm, and the room behind the switch is {room_mm} mm: lower the speed of the seek, or raise the room"
            ),
            Self::RoomOfCurve => {
                write!(f, "only the trapezoid brakes within a room behind a switch: choose no room, or the trapezoid")
            }
            Self::BeltSteps { x, y } => {
                write!(f, "with crossed belts X and Y have the same steps/mm, not {x} and {y}: make them the same")
            }
            Self::BeltSquared { axis } => {
                write!(
                    f,
                    "with crossed belts {axis} has both motors already: choose no second motor, or one for another axis"
                )
            }
            Self::HomingOrder => write!(f, "the homing order must not name an axis twice"),
            Self::Shaper { axis, error } => write!(f, "{axis}: {error}"),
            Self::ShapedCurve { axis } => {
                write!(f, "{axis} has a shaper, which shapes the trapezoid only: choose no shaper, or the trapezoid")
            }
        }
    }
}

impl core::error::Error for ConfigError {}
