//! Motors: an axis has one, and one axis may have a second, at the other side of the gantry.

use core::fmt;

use crate::axes::{AXES, Axis};

/// One of the ganged motors of an axis, each of which has a limit switch of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum GangedMotor {
    /// The one that every axis has.
    First,
    /// The second one.
    Second,
}

impl GangedMotor {
    /// The other one.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::First => Self::Second,
            Self::Second => Self::First,
        }
    }
}

/// A motor of an axis, with its limit switch. It displays as `Y`, or as `Y2` if it is the second.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Motor {
    /// The axis that it moves.
    pub axis: Axis,
    /// The ganged motor of that axis.
    pub ganged: GangedMotor,
}

impl Motor {
    /// The motor that every axis has.
    #[must_use]
    pub const fn first(axis: Axis) -> Self {
        Self { axis, ganged: GangedMotor::First }
    }

    /// The motor that one axis at most has besides.
    #[must_use]
    pub const fn second(axis: Axis) -> Self {
        Self { axis, ganged: GangedMotor::Second }
    }
}

/// The axis's first motor.
impl From<Axis> for Motor {
    fn from(axis: Axis) -> Self {
        Self::first(axis)
    }
}

impl fmt::Display for Motor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = if self.ganged == GangedMotor::Second { "2" } else { "" };
        write!(f, "{}{number}", self.axis)
    }
}

/// An input of a board that stops the machine at once: that of a limit switch, or of the alarm of drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitInput {
    /// The switch of an axis's first motor.
    Of(Axis),
    /// The switch of the second motor, whichever axis has one. Without a second motor this input has no meaning.
    Second,
    /// The alarm of an axis's drive; where one wire tells it of all drives, it is X's. Without a contact in the configuration
    /// this input has no meaning.
    Alarm(Axis),
}

impl LimitInput {
    /// How many there are at most, and the place of the first alarm.
    pub(crate) const COUNT: usize = 2 * AXES + 1;
    pub(crate) const ALARMS: usize = AXES + 1;

    /// Its place among all: the switches of the axes in their order, that of the second motor, the alarms of the axes in
    /// their order.
    pub(crate) const fn index(self) -> usize {
        match self {
            Self::Of(axis) => axis as usize,
            Self::Second => AXES,
            Self::Alarm(axis) => Self::ALARMS + axis as usize,
        }
    }
}

/// The second motor of an axis in a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SecondMotor {
    /// Its DIR has the other level than that of the first.
    pub direction_inverted: bool,
    /// The ganged motor that stands still: it makes none of the steps. The other makes all.
    pub held: Option<GangedMotor>,
}
