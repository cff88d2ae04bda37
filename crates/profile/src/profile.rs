//! The profile of a move: accelerate, cruise, decelerate.
//!
//! Both ramps follow one [`SpeedProfile`]. A short move has no cruise. Entry and exit speeds are parameters: in Stoychitch
//! 2018 both equal the start speed v_s, in Forero 2023 both are zero.

use core::fmt;

use libm::floor;

use crate::fixed::is_zero;
use crate::limits::{LimitError, Limits};
use crate::ramp::{Ramp, RampLimits};
use crate::speed_profile::SpeedProfile;

/// Longest move that can be planned, s: 11 days.
pub const DURATION_MAX_S: f64 = 1e6;

/// Why a profile could not be planned.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ProfileError {
    /// The limits themselves do not work.
    Limits(LimitError),
    /// The distance is not a positive number, steps.
    Distance {
        /// The value that was asked for.
        asked: f64,
    },
    /// The entry speed is negative, above the top speed, or too high to brake from over the distance, steps/s.
    EntrySpeed {
        /// The value that was asked for.
        asked: f64,
        /// The highest that works.
        max: f64,
    },
    /// The exit speed is negative, above the top speed, or too high to reach over the distance, steps/s.
    ExitSpeed {
        /// The value that was asked for.
        asked: f64,
        /// The highest that works.
        max: f64,
    },
    /// A speed profile over displacement never leaves standstill: the entry or exit speed is too slow for it, steps/s.
    Standstill {
        /// The speed profile.
        speed_profile: SpeedProfile,
        /// The value that was asked for.
        asked: f64,
        /// The slowest that works.
        min: f64,
    },
    /// The move would last longer than [`DURATION_MAX_S`], s.
    TooLong {
        /// The time that it would last.
        asked: f64,
        /// The longest that works.
        max: f64,
    },
}

/// Steps of each phase. A step belongs to the phase in which its instant lies (Stoychitch 2018, eqs 5 and 8: N_a, N_v,
/// N_d).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepCounts {
    /// Steps that leave while accelerating.
    pub accel: u32,
    /// Steps that leave while cruising.
    pub cruise: u32,
    /// Steps that leave while decelerating.
    pub decel: u32,
}

/// Displacement of one axis over time: an accelerating ramp, a cruise and a decelerating ramp.
///
/// Displacement is continuous, from 0 to `distance_steps`. [`SyncMove`](crate::SyncMove) decides which instants become
/// steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    pub(crate) distance_steps: f64,
    pub(crate) cruise_steps_s: f64,
    pub(crate) cruise_s: f64,
    /// The accelerating ramp, from the entry on.
    pub(crate) accel: Ramp,
    /// The decelerating ramp, seen backwards in time from the exit.
    pub(crate) decel: Ramp,
    /// The place where the acceleration ends.
    pub(crate) accel_end_steps: f64,
    /// The place where the deceleration begins.
    pub(crate) cruise_end_steps: f64,
}

impl Profile {
    /// A profile of no distance.
    pub(crate) const NONE: Self = Self {
        distance_steps: 0.0,
        cruise_steps_s: 0.0,
        cruise_s: 0.0,
        accel: Ramp::NONE,
        decel: Ramp::NONE,
        accel_end_steps: 0.0,
        cruise_end_steps: 0.0,
    };

    /// True if the acceleration changes within a ramp.
    pub(crate) fn is_curved(&self) -> bool {
        self.accel.constant_accel_steps_s2().is_none() || self.decel.constant_accel_steps_s2().is_none()
    }

    /// A profile of constant accelerations from the first speed to the second and then to the third. The ramps are
    /// `ramps_steps` long at the accelerations of `limits`. Between them it cruises at the second speed.
    pub(crate) fn constant_accel(
        distance_steps: f64,
        speeds_steps_s: [f64; 3],
        ramps_steps: [f64; 2],
        limits: &Limits,
    ) -> Self {
        let ([entry, cruise, exit], [accel_steps, decel_steps]) = (speeds_steps_s, ramps_steps);
        let accel_steps = if accel_steps < distance_steps { accel_steps } else { distance_steps };
        let left_steps = distance_steps - accel_steps;
        let cruise_steps = left_steps - decel_steps;
        // A triangle leaves only a rounding error for the cruise.
        let has_cruise = cruise_steps > 0.0;
        let decel_steps = if has_cruise { decel_steps } else { left_steps };
        Self {
            distance_steps,
            cruise_steps_s: cruise,
            cruise_s: if has_cruise { cruise_steps / cruise } else { 0.0 },
            accel: Ramp::constant_accel_to(entry, cruise, limits.accel_steps_s2, accel_steps),
            decel: Ramp::constant_accel_to(exit, cruise, limits.decel_steps_s2, decel_steps),
            accel_end_steps: accel_steps,
            cruise_end_steps: if has_cruise { accel_steps + cruise_steps } else { accel_steps },
        }
    }

    /// No distance, at this speed.
    pub(crate) fn passing(speed_steps_s: f64) -> Self {
        let ramp = Ramp::none(speed_steps_s);
        Self { cruise_steps_s: speed_steps_s, accel: ramp, decel: ramp, ..Self::NONE }
    }

    /// Brakes from one speed to a slower one as fast as `limits` allow. The distance follows from that.
    #[cold]
    pub(crate) fn braking(fast_steps_s: f64, slow_steps_s: f64, limits: &Limits, speed_profile: SpeedProfile) -> Self {
        let ramp_limits = RampLimits::new(speed_profile, limits.decel_steps_s2, limits.jerk_steps_s3);
        let decel = ramp_limits.shortest(slow_steps_s, fast_steps_s - slow_steps_s);
        Self {
            distance_steps: decel.steps(),
            cruise_steps_s: fast_steps_s,
            cruise_s: 0.0,
            accel: Ramp::none(fast_steps_s),
            decel,
            accel_end_steps: 0.0,
            cruise_end_steps: 0.0,
        }
    }

    /// A ramp of jerk alone: the acceleration rises from 0 and falls back to 0. In its middle the ramp has this speed
    /// and this acceleration, which is above 0.
    pub(crate) fn easing(speed_steps_s: f64, accel_steps_s2: f64, jerk_steps_s3: f64) -> Self {
        let half_rise_steps_s = accel_steps_s2 * accel_steps_s2 / (2.0 * jerk_steps_s3);
        // Rounding must not let a ramp from standstill begin backwards.
        let slow_steps_s = (speed_steps_s - half_rise_steps_s).max(0.0);
        let accel = Ramp::all_jerk(slow_steps_s, 2.0 * half_rise_steps_s, jerk_steps_s3);
        let cruise_steps_s = speed_steps_s + half_rise_steps_s;
        Self {
            distance_steps: accel.steps(),
            cruise_steps_s,
            cruise_s: 0.0,
            accel,
            decel: Ramp::none(cruise_steps_s),
            accel_end_steps: accel.steps(),
            cruise_end_steps: accel.steps(),
        }
    }

    /// The whole displacement, steps.
    #[must_use]
    pub fn distance_steps(&self) -> f64 {
        self.distance_steps
    }

    /// Speed at the start, steps/s.
    #[must_use]
    pub fn entry_speed_steps_s(&self) -> f64 {
        self.accel.slow_steps_s()
    }

    /// Highest speed, steps/s: the cruise's, or a triangle's peak.
    #[must_use]
    pub fn cruise_speed_steps_s(&self) -> f64 {
        self.cruise_steps_s
    }

    /// Speed at the end, steps/s.
    #[must_use]
    pub fn exit_speed_steps_s(&self) -> f64 {
        self.decel.slow_steps_s()
    }

    /// Duration of the acceleration, s (Stoychitch 2018: t_a).
    #[must_use]
    pub fn t_accel_s(&self) -> f64 {
        self.accel.duration_s()
    }

    /// Duration of the cruise, s; 0 for a triangle (Stoychitch 2018: t_v).
    #[must_use]
    pub fn t_cruise_s(&self) -> f64 {
        self.cruise_s
    }

    /// Duration of the deceleration, s (Stoychitch 2018: t_d).
    #[must_use]
    pub fn t_decel_s(&self) -> f64 {
        self.decel.duration_s()
    }

    /// Duration of the whole, s (Stoychitch 2018: T).
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        sum(sum(self.accel.duration_s(), self.cruise_s), self.decel.duration_s())
    }

    /// The place where the acceleration ends, steps.
    #[must_use]
    pub fn accel_end_steps(&self) -> f64 {
        self.accel_end_steps
    }

    /// The place where the cruise ends, steps.
    #[must_use]
    pub fn cruise_end_steps(&self) -> f64 {
        self.cruise_end_steps
    }

    /// Steps per phase. The k-th step leaves at displacement k - 1/2, so a phase boundary rounds to the nearest
    /// step, as the brackets of Stoychitch 2018 (eqs 5 and 8) do.
    #[must_use]
    pub fn step_counts(&self) -> StepCounts {
        let nearest = |steps: f64| floor(steps + 0.5) as u32;
        let accel = nearest(self.accel_end_steps);
        let cruise_end = nearest(self.cruise_end_steps).max(accel);
        StepCounts { accel, cruise: cruise_end - accel, decel: nearest(self.distance_steps) - cruise_end }
    }

    /// The instant at which the displacement is `steps` (clamped to the move), s. The inverse of
    /// [`position_at`](Self::position_at).
    #[must_use]
    pub fn time_at(&self, steps: f64) -> f64 {
        if steps <= self.accel_end_steps {
            self.accel.time_at(steps)
        } else if steps <= self.cruise_end_steps {
            self.t_accel_s() + (steps - self.accel_end_steps) / self.cruise_steps_s
        } else {
            self.duration_s() - self.decel.time_at(self.distance_steps - steps)
        }
    }

    /// Displacement at `t_s` (clamped to the move), steps.
    #[must_use]
    pub fn position_at(&self, t_s: f64) -> f64 {
        if t_s >= self.duration_s() {
            return self.distance_steps;
        }
        match self.interval_at(t_s.max(0.0)) {
            Interval::Accel(t_s) => self.accel.at_time(t_s).steps,
            Interval::Cruise(t_s) => self.accel_end_steps + t_s * self.cruise_steps_s,
            Interval::Decel(left_s) => self.distance_steps - self.decel.at_time(left_s).steps,
            Interval::Outside => 0.0,
        }
    }

    /// Speed at `t_s`, steps/s; 0 outside the move.
    #[must_use]
    pub fn speed_at(&self, t_s: f64) -> f64 {
        match self.interval_at(t_s) {
            Interval::Accel(t_s) => self.accel.at_time(t_s).speed_steps_s,
            Interval::Cruise(_) => self.cruise_steps_s,
            Interval::Decel(left_s) => self.decel.at_time(left_s).speed_steps_s,
            Interval::Outside => 0.0,
        }
    }

    /// Signed acceleration at `t_s`, steps/s²; 0 in the cruise and outside the move.
    #[must_use]
    pub fn accel_at(&self, t_s: f64) -> f64 {
        match self.interval_at(t_s) {
            Interval::Accel(t_s) => self.accel.at_time(t_s).accel_steps_s2,
            Interval::Decel(left_s) => -self.decel.at_time(left_s).accel_steps_s2,
            Interval::Cruise(_) | Interval::Outside => 0.0,
        }
    }

    /// Displacement, speed and acceleration at `t_s` within the move. All three together cost as much as one of them.
    /// For a speed profile over displacement that is milliseconds on a small chip, because the speed profile has to be inverted.
    pub(crate) fn motion_at(&self, t_s: f64) -> (f64, f64, f64) {
        match self.interval_at(t_s) {
            Interval::Accel(t_s) => {
                let state = self.accel.at_time(t_s);
                (state.steps, state.speed_steps_s, state.accel_steps_s2)
            }
            Interval::Cruise(t_s) => (self.accel_end_steps + t_s * self.cruise_steps_s, self.cruise_steps_s, 0.0),
            Interval::Decel(left_s) => {
                let state = self.decel.at_time(left_s);
                (self.distance_steps - state.steps, state.speed_steps_s, -state.accel_steps_s2)
            }
            Interval::Outside => (self.position_at(t_s), 0.0, 0.0),
        }
    }

    /// Signed jerk at `t_s`, steps/s³; 0 in the cruise and outside the move. Where the acceleration jumps, it is the
    /// jerk on one side of the jump.
    #[must_use]
    pub fn jerk_at(&self, t_s: f64) -> f64 {
        match self.interval_at(t_s) {
            Interval::Accel(t_s) => self.accel.jerk_at(t_s),
            // Seen backwards in time, speed and jerk keep their signs.
            Interval::Decel(left_s) => self.decel.jerk_at(left_s),
            Interval::Cruise(_) | Interval::Outside => 0.0,
        }
    }

    fn interval_at(&self, t_s: f64) -> Interval {
        let left_s = self.duration_s() - t_s;
        if t_s < 0.0 || left_s < 0.0 {
            Interval::Outside
        } else if t_s < self.t_accel_s() {
            Interval::Accel(t_s)
        } else if left_s <= self.t_decel_s() && self.t_decel_s() > 0.0 {
            Interval::Decel(left_s)
        } else {
            Interval::Cruise(t_s - self.t_accel_s())
        }
    }
}

/// Logs only distance and duration, because a log has no room for more.
#[cfg(feature = "defmt")]
impl defmt::Format for Profile {
    fn format(&self, f: defmt::Formatter) {
        defmt::write!(f, "{} steps in {} s", self.distance_steps, self.duration_s());
    }
}

/// The interval in which an instant lies. The value is the time since the interval began; for the deceleration it is
/// the time left to the end of the move.
enum Interval {
    Accel(f64),
    Cruise(f64),
    Decel(f64),
    Outside,
}

impl fmt::Display for ProfileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Limits(error) => error.fmt(f),
            Self::Distance { asked } => write!(f, "distance {asked} steps must be above 0"),
            Self::EntrySpeed { asked, max } => {
                write!(f, "entry speed {asked} steps/s must be 0 to {max} steps/s over this distance")
            }
            Self::ExitSpeed { asked, max } => {
                write!(f, "exit speed {asked} steps/s must be 0 to {max} steps/s over this distance")
            }
            Self::Standstill { speed_profile, asked, min } => write!(
                f,
                "the {speed_profile} speed profile cannot start or end at {asked} steps/s, it never leaves standstill: set a start speed of at \
                 least {min} steps/s, or take another speed profile"
            ),
            Self::TooLong { asked, max } => write!(f, "the move would last {asked} s, more than {max} s"),
        }
    }
}

impl core::error::Error for ProfileError {}
/// a + b. Most moves lack a phase or two, and adding 0 would be as slow as adding any number.
#[inline(never)]
pub(crate) fn sum(a: f64, b: f64) -> f64 {
    if is_zero(a) {
        b
    } else if is_zero(b) {
        a
    } else {
        a + b
    }
}

#[cfg(test)]
mod tests {
    use super::Profile;
    use crate::limits::Limits;
    use crate::{IntervalSplit, SpeedProfile};

    /// A hold leaves an S-curve from standstill by an easing, whose first half is what the S-curve has made. Wherever it
    /// does so, the easing never goes backwards, and an instant and the place at that instant agree.
    #[test]
    fn an_easing_from_standstill_has_the_instants_of_its_places() {
        let limits = Limits {
            start_speed_steps_s: 0.0,
            top_speed_steps_s: 1e4,
            accel_steps_s2: 1e6,
            decel_steps_s2: 1e6,
            jerk_steps_s3: 0.0,
        };
        for hundreds in 1..500_u32 {
            let jerk_steps_s3 = 700.0 * f64::from(hundreds);
            let limits = Limits { jerk_steps_s3, ..limits };
            let whole =
                Profile::plan(400.0, 0.0, 0.0, &limits, IntervalSplit::Fastest, SpeedProfile::SCurve).expect("it fits");
            for tenth in 1..5 {
                let (_, speed, accel) = whole.motion_at(whole.t_accel_s() * f64::from(tenth) / 10.0);
                let easing = Profile::easing(speed, accel, jerk_steps_s3);
                let entry = easing.entry_speed_steps_s();
                assert!(entry >= 0.0, "jerk {jerk_steps_s3}, after {tenth} tenths: begins at {entry}");
                for place in 1..=100 {
                    let steps = easing.distance_steps() * f64::from(place) / 100.0;
                    let t_s = easing.time_at(steps);
                    let there = easing.position_at(t_s);
                    let is_it = (there - steps).abs() < 1e-9 * easing.distance_steps();
                    assert!(is_it, "jerk {jerk_steps_s3}, after {tenth} tenths: at {there}, not {steps}");
                }
            }
        }
    }
}
