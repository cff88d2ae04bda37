//! The limits of an axis.

use core::fmt;

/// Slowest top speed and slowest feed that can be planned, steps/s: one step every 2,000 s. A feed of 1 mm/min at 0.1
/// steps/mm, along the diagonal of three axes, is still twice as fast.
pub const SPEED_MIN_STEPS_S: f64 = 5e-4;
/// Fastest speed that can be planned, steps/s: four times what the fastest known port on an RP2040 can make.
pub const SPEED_MAX_STEPS_S: f64 = 1e7;
/// Largest acceleration or deceleration that can be planned, steps/s².
pub const ACCEL_MAX_STEPS_S2: f64 = 1e9;

/// Limits of one axis. Acceleration and deceleration are separate: Stoychitch 2018 calls their ratio m = a/d.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Speed to which the motor can jump from rest, steps/s; 0 to `top_speed_steps_s` (Stoychitch 2018: v_s).
    pub start_speed_steps_s: f64,
    /// Speed never exceeded, steps/s; [`SPEED_MIN_STEPS_S`] to [`SPEED_MAX_STEPS_S`] (Stoychitch 2018: v_M).
    pub top_speed_steps_s: f64,
    /// Acceleration never exceeded, steps/s²; above 0, to [`ACCEL_MAX_STEPS_S2`] (Stoychitch 2018: a_M).
    pub accel_steps_s2: f64,
    /// Deceleration never exceeded, steps/s², as a positive number; above 0, to [`ACCEL_MAX_STEPS_S2`].
    pub decel_steps_s2: f64,
    /// Jerk never exceeded by the S-curve, steps/s³; above 0, [`f64::INFINITY`] for no limit. The other speed profiles ignore it.
    pub jerk_steps_s3: f64,
}

/// Why limits were refused. A NaN is outside every range.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum LimitError {
    /// The top speed is outside its range, steps/s.
    TopSpeed {
        /// The value that was asked for.
        asked: f64,
        /// The slowest that works.
        min: f64,
        /// The fastest that works.
        max: f64,
    },
    /// The start speed is negative or above the top speed, steps/s.
    StartSpeed {
        /// The value that was asked for.
        asked: f64,
        /// The top speed.
        max: f64,
    },
    /// The acceleration is zero, negative or too large, steps/s².
    Accel {
        /// The value that was asked for.
        asked: f64,
        /// The largest that works.
        max: f64,
    },
    /// The deceleration is zero, negative or too large, steps/s².
    Decel {
        /// The value that was asked for.
        asked: f64,
        /// The largest that works.
        max: f64,
    },
    /// The jerk is zero or negative, steps/s³.
    Jerk {
        /// The value that was asked for.
        asked: f64,
    },
}

impl Limits {
    /// Limits of zero, which [`check`](Self::check) refuses.
    pub(crate) const NONE: Self = Self {
        start_speed_steps_s: 0.0,
        top_speed_steps_s: 0.0,
        accel_steps_s2: 0.0,
        decel_steps_s2: 0.0,
        jerk_steps_s3: 0.0,
    };

    /// Refuses limits that cannot be planned with.
    ///
    /// # Errors
    /// The first limit out of range, with the range.
    pub fn check(&self) -> Result<(), LimitError> {
        let top = self.top_speed_steps_s;
        if !(SPEED_MIN_STEPS_S..=SPEED_MAX_STEPS_S).contains(&top) {
            return Err(LimitError::TopSpeed { asked: top, min: SPEED_MIN_STEPS_S, max: SPEED_MAX_STEPS_S });
        }
        if !(0.0..=top).contains(&self.start_speed_steps_s) {
            return Err(LimitError::StartSpeed { asked: self.start_speed_steps_s, max: top });
        }
        let fits = |accel: f64| accel > 0.0 && accel <= ACCEL_MAX_STEPS_S2;
        if !fits(self.accel_steps_s2) {
            return Err(LimitError::Accel { asked: self.accel_steps_s2, max: ACCEL_MAX_STEPS_S2 });
        }
        if !fits(self.decel_steps_s2) {
            return Err(LimitError::Decel { asked: self.decel_steps_s2, max: ACCEL_MAX_STEPS_S2 });
        }
        if self.jerk_steps_s3.is_nan() || self.jerk_steps_s3 <= 0.0 {
            return Err(LimitError::Jerk { asked: self.jerk_steps_s3 });
        }
        Ok(())
    }

    /// The limits as seen from an axis that moves `ratio` times as far in the same time.
    #[must_use]
    pub(crate) fn scaled(&self, ratio: f64) -> Self {
        Self {
            start_speed_steps_s: self.start_speed_steps_s * ratio,
            top_speed_steps_s: self.top_speed_steps_s * ratio,
            accel_steps_s2: self.accel_steps_s2 * ratio,
            decel_steps_s2: self.decel_steps_s2 * ratio,
            jerk_steps_s3: self.jerk_steps_s3 * ratio,
        }
    }

    /// True if no limit is lower than that of `other`.
    #[must_use]
    #[cold]
    pub(crate) fn is_looser(&self, other: &Self) -> bool {
        self.tighter(other) == *other
    }

    /// The tighter of both, limit by limit.
    #[must_use]
    pub(crate) fn tighter(&self, other: &Self) -> Self {
        // No limit is NaN. `f64::min` checks for NaN, and takes three times as long.
        let lower = |a: f64, b: f64| if a < b { a } else { b };
        Self {
            start_speed_steps_s: lower(self.start_speed_steps_s, other.start_speed_steps_s),
            top_speed_steps_s: lower(self.top_speed_steps_s, other.top_speed_steps_s),
            accel_steps_s2: lower(self.accel_steps_s2, other.accel_steps_s2),
            decel_steps_s2: lower(self.decel_steps_s2, other.decel_steps_s2),
            jerk_steps_s3: lower(self.jerk_steps_s3, other.jerk_steps_s3),
        }
    }
}

impl fmt::Display for LimitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::TopSpeed { asked, min, max } => {
                write!(f, "top speed {asked} steps/s is outside {min} to {max} steps/s")
            }
            Self::StartSpeed { asked, max } => {
                write!(f, "start speed {asked} steps/s is outside 0 to the top speed, {max} steps/s")
            }
            Self::Accel { asked, max } => {
                write!(f, "acceleration {asked} steps/s2 must be above 0 and at most {max} steps/s2")
            }
            Self::Decel { asked, max } => {
                write!(f, "deceleration {asked} steps/s2 must be above 0 and at most {max} steps/s2")
            }
            Self::Jerk { asked } => write!(f, "jerk {asked} steps/s3 must be above 0"),
        }
    }
}

impl core::error::Error for LimitError {}
