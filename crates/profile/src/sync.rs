//! One profile for all axes of a move.

use core::fmt;

use crate::compile::Segments;
use crate::law::{IntervalLaw, SpeedLaw};
use crate::limits::{LimitError, Limits, SPEED_MAX_STEPS_S, SPEED_MIN_STEPS_S};
use crate::profile::{Profile, ProfileError};

/// A synchronised move of `N` axes: one profile over the longest axis's steps, and a signed step count per axis.
///
/// Step k of an axis with n steps is due when the profile has covered (k - 1/2)/n of its way. So every axis has the
/// profile's intervals, and the path keeps within half a step of the straight line on each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SyncMove<const N: usize> {
    /// Displacement of the longest axis.
    pub profile: Profile,
    /// Steps of each axis, signed by direction.
    pub steps: [i32; N],
}

/// Why a move could not be planned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlanError {
    /// No axis moves.
    NoSteps,
    /// The limits of the axis with this index do not work.
    Limits {
        /// Index of the axis.
        axis: usize,
        /// What is wrong with them.
        error: LimitError,
    },
    /// The asked speed along the path is too slow, too fast or not a number, steps/s of the longest axis.
    PathSpeed {
        /// What was asked.
        asked: f64,
        /// The slowest that works.
        min: f64,
        /// The fastest that works.
        max: f64,
    },
    /// The profile could not be planned.
    Profile(ProfileError),
}

impl<const N: usize> SyncMove<N> {
    /// Plans a move from rest to rest; it starts and ends at the start speed.
    ///
    /// Each axis's limits are scaled onto the longest axis and the tightest hold, so no axis exceeds its own.
    /// `path_speed_steps_s` lowers the top speed further: the feed rate, in steps/s of the longest axis.
    ///
    /// # Errors
    /// Names the limit that was crossed; an axis that does not move is not checked.
    pub fn plan(
        steps: [i32; N],
        limits: &[Limits; N],
        interval_law: IntervalLaw,
        speed_law: SpeedLaw,
        path_speed_steps_s: Option<f64>,
    ) -> Result<Self, PlanError> {
        let longest = steps.iter().map(|n| n.unsigned_abs()).max().unwrap_or(0);
        let mut shared: Option<Limits> = None;
        for (axis, (&n, own)) in steps.iter().zip(limits).enumerate() {
            if n == 0 {
                continue;
            }
            own.check().map_err(|error| PlanError::Limits { axis, error })?;
            let n = n.unsigned_abs();
            let seen = if n == longest { *own } else { own.scaled(f64::from(longest) / f64::from(n)) };
            shared = Some(shared.map_or(seen, |tightest| tightest.tighter(&seen)));
        }
        let mut shared = shared.ok_or(PlanError::NoSteps)?;
        if let Some(asked) = path_speed_steps_s {
            if !(SPEED_MIN_STEPS_S..=SPEED_MAX_STEPS_S).contains(&asked) {
                return Err(PlanError::PathSpeed { asked, min: SPEED_MIN_STEPS_S, max: SPEED_MAX_STEPS_S });
            }
            shared.top_speed_steps_s = shared.top_speed_steps_s.min(asked);
        }
        shared.start_speed_steps_s = shared.start_speed_steps_s.min(shared.top_speed_steps_s);
        let start = shared.start_speed_steps_s;
        let profile = Profile::plan(f64::from(longest), start, start, &shared, interval_law, speed_law)
            .map_err(PlanError::Profile)?;
        Ok(Self { profile, steps })
    }

    /// When the `k`-th step of the axis with index `axis` leaves, s from the start of the move: the closed form.
    /// `k` counts from 1 to the axis's steps.
    #[must_use]
    pub fn step_time_s(&self, axis: usize, k: u32) -> f64 {
        let share = (f64::from(k) - 0.5) / f64::from(self.steps[axis].unsigned_abs());
        self.profile.time_at(share * self.profile.distance_steps())
    }

    /// The steps of the axis with index `axis` as segments, in ticks of which a second has `tick_hz` (above 0). This
    /// is the last work with floats; each segment comes in whole numbers.
    #[must_use]
    pub fn segments(&self, axis: usize, tick_hz: u32) -> Segments<'_> {
        Segments::new(&self.profile, self.steps[axis].unsigned_abs(), tick_hz)
    }
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NoSteps => write!(f, "no axis moves"),
            Self::Limits { axis, error } => write!(f, "axis {axis}: {error}"),
            Self::PathSpeed { asked, min, max } => {
                write!(f, "path speed {asked} steps/s is outside {min} to {max} steps/s")
            }
            Self::Profile(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for PlanError {}
