//! The linear speed profile: accelerate, cruise, decelerate (paper 002, section 2).
//!
//! A triangle is the trapezoid whose cruise is empty. Entry and exit speeds are parameters; paper 002 has both
//! equal to the start speed v_s, paper 004 both zero.

use core::fmt;

use libm::{floor, sqrt};

use crate::limits::{LimitError, Limits};

/// Longest move that can be planned, s: 11 days.
pub const DURATION_MAX_S: f64 = 1e6;

/// How a move's duration is split into its three intervals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum IntervalLaw {
    /// As fast as the limits allow: a trapezoid, or a triangle when the distance is short (paper 002, eqs 1-8).
    #[default]
    Fastest,
    /// Three equal intervals, as short as the limits allow (paper 004, eqs 1-7). From rest to rest a quarter of
    /// the way is spent accelerating, half cruising, a quarter decelerating.
    Thirds,
}

/// Why a profile could not be planned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProfileError {
    /// The limits themselves do not work.
    Limits(LimitError),
    /// The distance is not a positive number, steps.
    Distance {
        /// What was asked.
        asked: f64,
    },
    /// The entry speed is negative, above the top speed, or cannot be shed over the distance, steps/s.
    EntrySpeed {
        /// What was asked.
        asked: f64,
        /// The highest that works.
        max: f64,
    },
    /// The exit speed is negative, above the top speed, or cannot be reached over the distance, steps/s.
    ExitSpeed {
        /// What was asked.
        asked: f64,
        /// The highest that works.
        max: f64,
    },
    /// The move would last longer than [`DURATION_MAX_S`], s.
    TooLong {
        /// How long it would last.
        asked: f64,
        /// The longest that works.
        max: f64,
    },
}

/// Steps of each phase: those whose instants lie in it (paper 002, eqs 5 and 8: N_a, N_v, N_d).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepCounts {
    /// Steps that leave while accelerating.
    pub accel: u32,
    /// Steps that leave while cruising.
    pub cruise: u32,
    /// Steps that leave while decelerating.
    pub decel: u32,
}

/// Displacement of one axis over time, at constant acceleration, then constant speed, then constant deceleration.
///
/// Displacement is continuous: 0 to `distance_steps`. Which instants become steps is [`SyncMove`](crate::SyncMove)'s
/// affair.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Trapezoid {
    distance_steps: f64,
    entry_steps_s: f64,
    cruise_steps_s: f64,
    exit_steps_s: f64,
    accel_steps_s2: f64,
    decel_steps_s2: f64,
    accel_end_steps: f64,
    cruise_end_steps: f64,
    accel_s: f64,
    cruise_s: f64,
    decel_s: f64,
}

impl Trapezoid {
    /// Plans `distance_steps` from `entry_steps_s` to `exit_steps_s` within `limits`.
    ///
    /// # Errors
    /// Names the first parameter that cannot work and the bound it crossed.
    pub fn plan(
        distance_steps: f64,
        entry_steps_s: f64,
        exit_steps_s: f64,
        limits: &Limits,
        law: IntervalLaw,
    ) -> Result<Self, ProfileError> {
        limits.check().map_err(ProfileError::Limits)?;
        if !(distance_steps > 0.0 && distance_steps.is_finite()) {
            return Err(ProfileError::Distance { asked: distance_steps });
        }
        check_end_speeds(distance_steps, entry_steps_s, exit_steps_s, limits)?;
        let ends = Ends { distance_steps, entry_steps_s, exit_steps_s };
        let plan = match law {
            IntervalLaw::Fastest => ends.fastest(limits),
            IntervalLaw::Thirds => ends.thirds(limits)?,
        };
        if plan.duration_s() > DURATION_MAX_S {
            return Err(ProfileError::TooLong { asked: plan.duration_s(), max: DURATION_MAX_S });
        }
        Ok(plan)
    }

    /// The whole displacement, steps.
    #[must_use]
    pub fn distance_steps(&self) -> f64 {
        self.distance_steps
    }

    /// Speed at the start, steps/s.
    #[must_use]
    pub fn entry_speed_steps_s(&self) -> f64 {
        self.entry_steps_s
    }

    /// Highest speed, steps/s: the cruise's, or a triangle's peak.
    #[must_use]
    pub fn cruise_speed_steps_s(&self) -> f64 {
        self.cruise_steps_s
    }

    /// Speed at the end, steps/s.
    #[must_use]
    pub fn exit_speed_steps_s(&self) -> f64 {
        self.exit_steps_s
    }

    /// Duration of the acceleration, s (paper 002: t_a).
    #[must_use]
    pub fn t_accel_s(&self) -> f64 {
        self.accel_s
    }

    /// Duration of the cruise, s; 0 for a triangle (paper 002: t_v).
    #[must_use]
    pub fn t_cruise_s(&self) -> f64 {
        self.cruise_s
    }

    /// Duration of the deceleration, s (paper 002: t_d).
    #[must_use]
    pub fn t_decel_s(&self) -> f64 {
        self.decel_s
    }

    /// Duration of the whole, s (paper 002: T).
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.accel_s + self.cruise_s + self.decel_s
    }

    /// Where the acceleration ends, steps.
    #[must_use]
    pub fn accel_end_steps(&self) -> f64 {
        self.accel_end_steps
    }

    /// Where the cruise ends, steps.
    #[must_use]
    pub fn cruise_end_steps(&self) -> f64 {
        self.cruise_end_steps
    }

    /// Steps per phase. The k-th step leaves at displacement k - 1/2, so a phase boundary rounds to the nearest
    /// step, as the brackets of paper 002 (eqs 5 and 8) do.
    #[must_use]
    pub fn step_counts(&self) -> StepCounts {
        let nearest = |steps: f64| floor(steps + 0.5) as u32;
        let accel = nearest(self.accel_end_steps);
        let cruise_end = nearest(self.cruise_end_steps).max(accel);
        StepCounts { accel, cruise: cruise_end - accel, decel: nearest(self.distance_steps) - cruise_end }
    }

    /// When the displacement is `steps` (clamped to the move), s. The inverse of [`position_at`](Self::position_at).
    #[must_use]
    pub fn time_at(&self, steps: f64) -> f64 {
        if steps <= self.accel_end_steps {
            ramp_time_s(steps.max(0.0), self.entry_steps_s, self.accel_steps_s2)
        } else if steps <= self.cruise_end_steps {
            self.accel_s + (steps - self.accel_end_steps) / self.cruise_steps_s
        } else {
            let left = (self.distance_steps - steps).max(0.0);
            self.duration_s() - ramp_time_s(left, self.exit_steps_s, self.decel_steps_s2)
        }
    }

    /// Displacement at `t_s` (clamped to the move), steps.
    #[must_use]
    pub fn position_at(&self, t_s: f64) -> f64 {
        let t_left_s = (self.duration_s() - t_s).max(0.0);
        if t_s <= self.accel_s {
            ramp_steps(t_s.max(0.0), self.entry_steps_s, self.accel_steps_s2)
        } else if t_left_s > self.decel_s {
            self.accel_end_steps + (t_s - self.accel_s) * self.cruise_steps_s
        } else {
            self.distance_steps - ramp_steps(t_left_s, self.exit_steps_s, self.decel_steps_s2)
        }
    }

    /// Speed at `t_s`, steps/s; 0 outside the move.
    #[must_use]
    pub fn speed_at(&self, t_s: f64) -> f64 {
        let t_left_s = self.duration_s() - t_s;
        if t_s < 0.0 || t_left_s < 0.0 {
            0.0
        } else if t_s <= self.accel_s {
            self.entry_steps_s + self.accel_steps_s2 * t_s
        } else if t_left_s > self.decel_s {
            self.cruise_steps_s
        } else {
            self.exit_steps_s + self.decel_steps_s2 * t_left_s
        }
    }

    /// Signed acceleration at `t_s`, steps/s²; 0 in the cruise and outside the move.
    #[must_use]
    pub fn accel_at(&self, t_s: f64) -> f64 {
        let t_left_s = self.duration_s() - t_s;
        if t_s < 0.0 || t_left_s < 0.0 {
            0.0
        } else if t_s < self.accel_s {
            self.accel_steps_s2
        } else if t_left_s < self.decel_s {
            -self.decel_steps_s2
        } else {
            0.0
        }
    }

    pub(crate) fn accel_ramp(&self) -> EndRamp {
        EndRamp { slow_steps_s: self.entry_steps_s, accel_steps_s2: self.accel_steps_s2 }
    }

    pub(crate) fn decel_ramp(&self) -> EndRamp {
        EndRamp { slow_steps_s: self.exit_steps_s, accel_steps_s2: self.decel_steps_s2 }
    }
}

/// The ramp at one end of a profile, seen from there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EndRamp {
    pub(crate) slow_steps_s: f64,
    pub(crate) accel_steps_s2: f64,
}

/// The two ends of a profile and the way between them.
struct Ends {
    distance_steps: f64,
    entry_steps_s: f64,
    exit_steps_s: f64,
}

impl Ends {
    /// Paper 002, eqs 1-8, with entry and exit apart. The peak of the triangle follows from
    /// (v² - v_entry²)/2a + (v² - v_exit²)/2d = s.
    fn fastest(&self, limits: &Limits) -> Trapezoid {
        let (a, d) = (limits.accel_steps_s2, limits.decel_steps_s2);
        let (entry, exit) = (self.entry_steps_s, self.exit_steps_s);
        let peak_squared = (2.0 * a * d * self.distance_steps + d * entry * entry + a * exit * exit) / (a + d);
        let peak = sqrt(peak_squared).max(entry).max(exit);
        if peak <= limits.top_speed_steps_s {
            // Where both ramps have the same speed; as a difference of the peak's square it would cancel.
            let meeting = (2.0 * d * self.distance_steps + exit * exit - entry * entry) / (2.0 * (a + d));
            let accel_steps = meeting.clamp(0.0, self.distance_steps);
            return self.trapezoid(peak, (a, d), (accel_steps, accel_steps), 0.0);
        }
        let top = limits.top_speed_steps_s;
        let accel_steps = (top * top - entry * entry) / (2.0 * a);
        let decel_steps = (top * top - exit * exit) / (2.0 * d);
        let cruise_end = (self.distance_steps - decel_steps).max(accel_steps);
        self.trapezoid(top, (a, d), (accel_steps, cruise_end), (cruise_end - accel_steps) / top)
    }

    /// Paper 004, eqs 1-7: all three intervals last t1, so s = t1 (2 v + (v_entry + v_exit)/2). The cruise speed is
    /// the highest within the top speed at which neither ramp exceeds its limit: with k = (v_entry + v_exit)/2,
    /// (v - v_end)/t1 <= a is (v - v_end)(2 v + k) <= a s.
    fn thirds(&self, limits: &Limits) -> Result<Trapezoid, ProfileError> {
        let (entry, exit) = (self.entry_steps_s, self.exit_steps_s);
        let k = (entry + exit) / 2.0;
        let highest = |end: f64, accel: f64| {
            let b = k - 2.0 * end;
            let c = -(k * end + accel * self.distance_steps);
            (sqrt(b * b - 8.0 * c) - b) / 4.0
        };
        let cruise = limits
            .top_speed_steps_s
            .min(highest(entry, limits.accel_steps_s2))
            .min(highest(exit, limits.decel_steps_s2));
        if cruise < entry {
            return Err(ProfileError::EntrySpeed { asked: entry, max: cruise });
        }
        if cruise < exit {
            return Err(ProfileError::ExitSpeed { asked: exit, max: cruise });
        }
        let third_s = self.distance_steps / (2.0 * cruise + k);
        let accel_steps = (entry + cruise) / 2.0 * third_s;
        // Over a short ramp the difference of speeds cancels: rounding must not lift it above its limit.
        let accel = ((cruise - entry) / third_s).min(limits.accel_steps_s2);
        let decel = ((cruise - exit) / third_s).min(limits.decel_steps_s2);
        let mut plan = self.trapezoid(cruise, (accel, decel), (accel_steps, accel_steps + cruise * third_s), third_s);
        (plan.accel_s, plan.decel_s) = (third_s, third_s);
        Ok(plan)
    }

    fn trapezoid(&self, cruise: f64, ramps: (f64, f64), ends: (f64, f64), cruise_s: f64) -> Trapezoid {
        let (accel, decel) = ramps;
        let (accel_end, cruise_end) = ends;
        Trapezoid {
            distance_steps: self.distance_steps,
            entry_steps_s: self.entry_steps_s,
            cruise_steps_s: cruise,
            exit_steps_s: self.exit_steps_s,
            accel_steps_s2: accel,
            decel_steps_s2: decel,
            accel_end_steps: accel_end,
            cruise_end_steps: cruise_end,
            accel_s: ramp_time_s(accel_end, self.entry_steps_s, accel),
            cruise_s,
            decel_s: ramp_time_s(self.distance_steps - cruise_end, self.exit_steps_s, decel),
        }
    }
}

/// Time to cover `steps` from speed `v` at acceleration `a`: (sqrt(v² + 2 a x) - v)/a, written so that nothing
/// cancels and a = 0 is a plain cruise.
pub(crate) fn ramp_time_s(steps: f64, speed_steps_s: f64, accel_steps_s2: f64) -> f64 {
    if steps == 0.0 {
        return 0.0;
    }
    let end = sqrt(speed_steps_s * speed_steps_s + 2.0 * accel_steps_s2 * steps);
    2.0 * steps / (speed_steps_s + end)
}

fn ramp_steps(t_s: f64, speed_steps_s: f64, accel_steps_s2: f64) -> f64 {
    t_s * (speed_steps_s + accel_steps_s2 * t_s / 2.0)
}

fn check_end_speeds(distance: f64, entry: f64, exit: f64, limits: &Limits) -> Result<(), ProfileError> {
    let top = limits.top_speed_steps_s;
    let max = sqrt(exit * exit + 2.0 * limits.decel_steps_s2 * distance).min(top);
    if !(0.0..=max).contains(&entry) {
        return Err(ProfileError::EntrySpeed { asked: entry, max });
    }
    let max = sqrt(entry * entry + 2.0 * limits.accel_steps_s2 * distance).min(top);
    if !(0.0..=max).contains(&exit) {
        return Err(ProfileError::ExitSpeed { asked: exit, max });
    }
    Ok(())
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
            Self::TooLong { asked, max } => write!(f, "the move would last {asked} s, more than {max} s"),
        }
    }
}

impl core::error::Error for ProfileError {}
