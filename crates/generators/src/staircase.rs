//! Forero's staircase (Forero, Ramírez and Blanco, 2023, section 3.2): each ramp in 20 intervals of constant speed.

use core::fmt;
use core::iter::once;

use super::TimerError;
use isostep_profile::{SPEED_MAX_STEPS_S, SPEED_MIN_STEPS_S};

/// Intervals of a ramp, and levels of speed (Forero 2023, section 3.2).
const INTERVALS: u32 = 20;
/// The cruise, in intervals of a ramp: t_vc = 21/20 t_1 (Forero 2023, eq 12).
const CRUISE_INTERVALS: u32 = 21;
/// The whole move, in units of the steps that one level makes in one interval: 2 (1 + 2 + ... + 19) + 20 * 21.
const UNITS: u32 = 800;

/// A ramp up, a cruise and a ramp down in stairs. A stair is a twentieth of the cruise speed high and, on the ramps, a
/// twentieth of t_1 long (Forero 2023, eqs 8-12).
///
/// The 20 intervals of a ramp follow from the sum of eq 10, which has 19 rectangles A_i = i t_1 V_c/400, i = 1 to 19.
/// The speeds are 0, 1/20, ..., 19/20 of V_c going up and 19/20, ..., 1/20, 0 coming down, so nothing moves in the
/// first and in the last interval. Both ramps together then have 19/20 t_1 V_c steps, the cruise of eq 12 has 21/20 t_1
/// V_c, and the sum is exactly the 2 t_1 V_c of eq 7. It is also what the paper's Table 1 measured: an acceleration
/// of 4.5 s before a cruise of 4.725 s.
///
/// The paper's text takes the speed of an interval at its end point while accelerating and at its start point while
/// decelerating. By that reading the 20 speeds are 1/20, ..., 20/20 of V_c, and the last of them is already that of the
/// cruise: eq 10 leaves it out of the sum, and eq 12 counts it as cruise. That is the same staircase with 19 intervals
/// a ramp, without the two intervals at standstill: 0.45 s shorter at t_1 = 4.5 s.
///
/// Displacement is continuous here. [`TimedStaircase`](super::TimedStaircase) is what a microcontroller's timers make
/// of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Staircase {
    steps: u32,
    t1_s: f64,
}

/// A part at constant speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tread {
    /// Speed in twentieths of V_c, 0 to 20.
    pub level: u32,
    /// Length in twentieths of t_1: 1, or the cruise's 21.
    pub intervals: u32,
    /// Its beginning, s.
    pub start_s: f64,
    /// Its length, s.
    pub duration_s: f64,
    /// Speed, steps/s.
    pub speed_steps_s: f64,
    /// The place of its beginning, steps.
    pub start_steps: f64,
    /// Its displacement, steps: eq 11's A_i.
    pub ideal_steps: f64,
}

/// Why a staircase could not be planned. A NaN is outside every range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StaircaseError {
    /// There are no steps.
    NoSteps,
    /// t_1 is not a positive number, or the cruise would be faster or slower than anything planned here, s.
    RampTime {
        /// The value that was asked for.
        asked: f64,
        /// The shortest that works for these steps.
        min: f64,
        /// The longest that works for these steps.
        max: f64,
    },
    /// The timers cannot make the staircase.
    Timer(TimerError),
}

impl Staircase {
    /// Plans `steps` steps with ramps of `t1_s`, s. The cruise speed, steps/(2 t_1), is [`SPEED_MIN_STEPS_S`] to
    /// [`SPEED_MAX_STEPS_S`].
    ///
    /// # Errors
    /// The value and the bound: no steps, or a t_1 out of range.
    pub fn plan(steps: u32, t1_s: f64) -> Result<Self, StaircaseError> {
        if steps == 0 {
            return Err(StaircaseError::NoSteps);
        }
        let (min, max) = (f64::from(steps) / (2.0 * SPEED_MAX_STEPS_S), f64::from(steps) / (2.0 * SPEED_MIN_STEPS_S));
        if !(min..=max).contains(&t1_s) {
            return Err(StaircaseError::RampTime { asked: t1_s, min, max });
        }
        Ok(Self { steps, t1_s })
    }

    /// Steps of the move.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// t_1, the duration of each ramp, s.
    #[must_use]
    pub fn t1_s(&self) -> f64 {
        self.t1_s
    }

    /// Length of an interval, s: t_1/20.
    #[must_use]
    pub fn interval_s(&self) -> f64 {
        self.t1_s / f64::from(INTERVALS)
    }

    /// V_c, steps/s (Forero 2023, eq 7).
    #[must_use]
    pub fn cruise_speed_steps_s(&self) -> f64 {
        f64::from(self.steps) / (2.0 * self.t1_s)
    }

    /// t_vc, the duration of the lengthened cruise, s (Forero 2023, eq 12).
    #[must_use]
    pub fn t_cruise_s(&self) -> f64 {
        self.t1_s * f64::from(CRUISE_INTERVALS) / f64::from(INTERVALS)
    }

    /// The duration of both ramps and the cruise, s, including the standstill at both ends.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        2.0 * self.t1_s + self.t_cruise_s()
    }

    /// The 20 intervals of the acceleration, the cruise, and the 20 of the deceleration.
    pub fn treads(&self) -> impl Iterator<Item = Tread> + use<> {
        let plan = *self;
        levels().scan((0, 0), move |(intervals_before, units_before), (level, intervals)| {
            let tread = plan.tread((*intervals_before, *units_before), (level, intervals));
            *intervals_before += intervals;
            *units_before += level * intervals;
            Some(tread)
        })
    }

    fn tread(&self, before: (u32, u32), stair: (u32, u32)) -> Tread {
        let (level, intervals) = stair;
        let time_s = |intervals: u32| self.t1_s * f64::from(intervals) / f64::from(INTERVALS);
        let displacement = |units: u32| f64::from(self.steps) * f64::from(units) / f64::from(UNITS);
        Tread {
            level,
            intervals,
            start_s: time_s(before.0),
            duration_s: time_s(intervals),
            speed_steps_s: self.cruise_speed_steps_s() * f64::from(level) / f64::from(INTERVALS),
            start_steps: displacement(before.1),
            ideal_steps: displacement(level * intervals),
        }
    }

    /// Speed at `t_s`, steps/s; 0 outside the move. On the edge between two stairs it is the later one's.
    #[must_use]
    pub fn speed_at(&self, t_s: f64) -> f64 {
        if t_s < 0.0 {
            return 0.0;
        }
        let ends_after = |tread: &Tread| t_s < tread.start_s + tread.duration_s;
        self.treads().find(ends_after).map_or(0.0, |tread| tread.speed_steps_s)
    }

    /// Displacement at `t_s` (clamped to the move), steps.
    #[must_use]
    pub fn position_at(&self, t_s: f64) -> f64 {
        let t_s = t_s.max(0.0);
        let ends_after = |tread: &Tread| t_s < tread.start_s + tread.duration_s;
        let at = |tread: Tread| tread.start_steps + tread.speed_steps_s * (t_s - tread.start_s);
        self.treads().find(ends_after).map_or(f64::from(self.steps), at)
    }
}

/// Level and length of each tread.
fn levels() -> impl Iterator<Item = (u32, u32)> {
    let ramp = |level| (level, 1);
    (0..INTERVALS).map(ramp).chain(once((INTERVALS, CRUISE_INTERVALS))).chain((0..INTERVALS).rev().map(ramp))
}

impl fmt::Display for StaircaseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NoSteps => write!(f, "0 steps: a staircase needs at least 1 step"),
            Self::RampTime { asked, min, max } => {
                write!(f, "t_1 of {asked} s is outside {min} to {max} s for these steps")
            }
            Self::Timer(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for StaircaseError {}
