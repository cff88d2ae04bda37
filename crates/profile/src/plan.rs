//! Plans a profile: how fast a move can cruise, and where its ramps end.

mod three_intervals;

use crate::limits::{Limits, SPEED_MIN_STEPS_S};
use crate::newton::rising_root;
use crate::profile::{DURATION_MAX_S, Profile, ProfileError};
use crate::ramp::{Ramp, RampLimits};
use crate::square_root::sqrt;
use crate::{IntervalSplit, SpeedProfile};

/// The search for a cruise speed ends with a step of this size, as a fraction of the rise over the faster end. The
/// error left is less than a quarter of the square of this fraction.
const PEAK_TOLERANCE: f64 = 1e-6;
/// The same for a move whose end speeds differ. Newton's method then leaves a far smaller error.
const ROOT_TOLERANCE: f64 = 1e-10;
/// A search by powers changes the rise by this factor at most in one iteration.
const FACTOR_MAX: f64 = 10.0;
/// More iterations than any search takes.
const ITERATIONS_MAX: u32 = 100;

/// The steps that a rise over the faster end needs, and how many more for each step/s more.
type Needed<'a> = &'a dyn Fn(f64) -> (f64, f64);

impl Profile {
    /// Plans `distance_steps` from `entry_steps_s` to `exit_steps_s` within `limits`.
    ///
    /// # Errors
    /// The first parameter that cannot work, and the bound that it crosses.
    pub fn plan(
        distance_steps: f64,
        entry_steps_s: f64,
        exit_steps_s: f64,
        limits: &Limits,
        interval_split: IntervalSplit,
        speed_profile: SpeedProfile,
    ) -> Result<Self, ProfileError> {
        limits.check().map_err(ProfileError::Limits)?;
        if !(distance_steps > 0.0 && distance_steps.is_finite()) {
            return Err(ProfileError::Distance { asked: distance_steps });
        }
        let input = PlanInput::new(distance_steps, entry_steps_s, exit_steps_s, limits, speed_profile);
        input.check()?;
        let plan = match interval_split {
            IntervalSplit::Fastest => input.fastest(),
            IntervalSplit::Thirds => input.thirds()?,
        };
        if !(0.0..=DURATION_MAX_S).contains(&plan.duration_s()) {
            return Err(ProfileError::TooLong { asked: plan.duration_s(), max: DURATION_MAX_S });
        }
        Ok(plan)
    }

    /// The profile between two speeds that are known to fit the distance. If thirds are asked for but impossible, it is
    /// the fastest profile.
    #[cold]
    pub(crate) fn between(
        distance_steps: f64,
        entry_steps_s: f64,
        exit_steps_s: f64,
        limits: &Limits,
        interval_split: IntervalSplit,
        speed_profile: SpeedProfile,
    ) -> Self {
        let input = PlanInput::new(distance_steps, entry_steps_s, exit_steps_s, limits, speed_profile);
        match interval_split {
            IntervalSplit::Fastest => input.fastest(),
            IntervalSplit::Thirds => input.thirds().unwrap_or_else(|_| input.fastest()),
        }
    }
}

/// The two end speeds of a profile, the distance between them, and the limits of its ramps.
struct PlanInput {
    distance_steps: f64,
    entry_steps_s: f64,
    exit_steps_s: f64,
    top_steps_s: f64,
    speed_profile: SpeedProfile,
    accel: RampLimits,
    decel: RampLimits,
}

impl PlanInput {
    fn new(
        distance_steps: f64,
        entry_steps_s: f64,
        exit_steps_s: f64,
        limits: &Limits,
        speed_profile: SpeedProfile,
    ) -> Self {
        let ramp_limits = |accel_steps_s2| RampLimits::new(speed_profile, accel_steps_s2, limits.jerk_steps_s3);
        Self {
            distance_steps,
            entry_steps_s,
            exit_steps_s,
            top_steps_s: limits.top_speed_steps_s,
            speed_profile,
            accel: ramp_limits(limits.accel_steps_s2),
            decel: ramp_limits(limits.decel_steps_s2),
        }
    }

    /// Refuses end speeds that are impossible by the speed profile or over the distance.
    fn check(&self) -> Result<(), ProfileError> {
        let (entry, exit) = (self.entry_steps_s, self.exit_steps_s);
        let max = if entry > exit { self.highest_from(exit, self.decel) } else { self.top_steps_s };
        if !(0.0..=max).contains(&entry) {
            return Err(ProfileError::EntrySpeed { asked: entry, max });
        }
        let max = if exit > entry { self.highest_from(entry, self.accel) } else { self.top_steps_s };
        if !(0.0..=max).contains(&exit) {
            return Err(ProfileError::ExitSpeed { asked: exit, max });
        }
        let slowest = entry.min(exit);
        if self.speed_profile.is_over_displacement() && slowest < SPEED_MIN_STEPS_S.min(self.top_steps_s) {
            return Err(ProfileError::Standstill {
                speed_profile: self.speed_profile,
                asked: slowest,
                min: SPEED_MIN_STEPS_S,
            });
        }
        Ok(())
    }

    /// The highest speed that one ramp from `slow` reaches over the whole distance.
    fn highest_from(&self, slow: f64, ramp_limits: RampLimits) -> f64 {
        let room = self.top_steps_s - slow;
        let short = |rise: f64| {
            let (steps, growth) = ramp_limits.length(slow, rise);
            (steps - self.distance_steps, growth)
        };
        if self.speed_profile == SpeedProfile::Trapezoid {
            return sqrt(slow * slow + 2.0 * ramp_limits.accel_steps_s2 * self.distance_steps).min(self.top_steps_s);
        }
        if room <= 0.0 || short(room).0 <= 0.0 {
            return self.top_steps_s;
        }
        let rise = rising_root((0.0, room), room, ROOT_TOLERANCE, short);
        let highest = slow + rise;
        // Over a short distance the rise is so small beside the speed that rounding the sum up makes the end far too
        // fast.
        if highest - slow > rise { highest.next_down() } else { highest }
    }

    /// The fastest profile that the limits allow.
    #[cold]
    fn fastest(&self) -> Profile {
        match self.speed_profile {
            SpeedProfile::Trapezoid => self.fastest_trapezoid(),
            _ => self.fastest_by_search(),
        }
    }

    /// Stoychitch 2018, eqs 1-8, with separate entry and exit speeds. The triangle's peak v follows from (v² -
    /// v_entry²)/2a + (v² - v_exit²)/2d = s.
    #[cold]
    fn fastest_trapezoid(&self) -> Profile {
        let (a, d) = (self.accel.accel_steps_s2, self.decel.accel_steps_s2);
        let (entry, exit) = (self.entry_steps_s, self.exit_steps_s);
        let peak = self.peak_of_triangle();
        if peak <= self.top_steps_s {
            // The place where both ramps reach the same speed. Computed from the peak's square, it would lose digits by
            // cancellation.
            let meeting = (2.0 * d * self.distance_steps + exit * exit - entry * entry) / (2.0 * (a + d));
            let accel_steps = meeting.max(0.0).min(self.distance_steps);
            return self.trapezoid(peak, (accel_steps, accel_steps), 0.0);
        }
        let top = self.top_steps_s;
        let accel_steps = (top * top - entry * entry) / (2.0 * a);
        let decel_steps = (top * top - exit * exit) / (2.0 * d);
        let cruise_end = (self.distance_steps - decel_steps).max(accel_steps);
        self.trapezoid(top, (accel_steps, cruise_end), (cruise_end - accel_steps) / top)
    }

    fn peak_of_triangle(&self) -> f64 {
        let (a, d) = (self.accel.accel_steps_s2, self.decel.accel_steps_s2);
        let (entry, exit) = (self.entry_steps_s, self.exit_steps_s);
        let squared = (2.0 * a * d * self.distance_steps + d * entry * entry + a * exit * exit) / (a + d);
        sqrt(squared).max(entry).max(exit)
    }

    #[cold]
    fn trapezoid(&self, cruise: f64, ends: (f64, f64), cruise_s: f64) -> Profile {
        let (accel_end, cruise_end) = ends;
        let ramp = |slow, ramp_limits: &RampLimits, steps| {
            Ramp::constant_accel(slow, cruise - slow, ramp_limits.accel_steps_s2, steps)
        };
        Profile {
            distance_steps: self.distance_steps,
            cruise_steps_s: cruise,
            cruise_s,
            accel: ramp(self.entry_steps_s, &self.accel, accel_end),
            decel: ramp(self.exit_steps_s, &self.decel, self.distance_steps - cruise_end),
            accel_end_steps: accel_end,
            cruise_end_steps: cruise_end,
        }
    }

    /// The cruise speed is as far above the faster end as both ramps have room for. No speed profile is faster than the
    /// trapezoid, so the trapezoid's peak is an upper bound.
    #[cold]
    fn fastest_by_search(&self) -> Profile {
        let lengths = |speed_rise: f64| {
            let (accel, decel) = self.lengths(speed_rise);
            (accel.0 + decel.0, accel.1 + decel.1)
        };
        let room = self.top_steps_s - self.fast_end();
        let most = room.min(self.peak_of_triangle() - self.fast_end());
        let speed_rise = if self.entry_steps_s != self.exit_steps_s {
            self.speed_rise_by_newton(most, most, ROOT_TOLERANCE, &lengths)
        } else if let Some(speed_rise) = self.speed_rise_by_quadratic() {
            speed_rise.min(most)
        } else {
            self.speed_rise_by_powers(most, most, PEAK_TOLERANCE, &lengths)
        };
        self.profile(speed_rise, self.ramps(speed_rise))
    }

    /// The rise at which both ramps together are as long as the distance, for equal ends, if the length of a ramp is a
    /// quadratic in the rise.
    fn speed_rise_by_quadratic(&self) -> Option<f64> {
        let (constant, square) = self.accel.quadratic_length()?;
        let per_accel = 1.0 / self.accel.accel_steps_s2 + 1.0 / self.decel.accel_steps_s2;
        let (slow, way) = (self.entry_steps_s, self.distance_steps / (constant * per_accel));
        // Solves slow r + square r² = `way` for r, in a form that does not cancel.
        Some(2.0 * way / (slow + sqrt(slow * slow + 4.0 * square * way)))
    }

    /// The rise, `most` at most, at which `needed` equals the distance. The search begins at `from`.
    #[cold]
    fn speed_rise_by_newton(&self, from: f64, most: f64, tolerance: f64, needed: Needed<'_>) -> f64 {
        let over = |speed_rise| {
            let (steps, growth) = needed(speed_rise);
            (steps - self.distance_steps, growth)
        };
        if over(most).0 <= 0.0 {
            return most;
        }
        rising_root((0.0, most), from, tolerance, over)
    }

    /// The same for equal ends.
    ///
    /// For equal ends, the needed distance is nearly a power of the rise, rise^p, with p from 1/2 to 2 or so. So the
    /// search is Newton's method on the logarithms of both: each iteration multiplies the rise by
    /// (distance/needed)^(1/p), for which a quotient of two linear functions is accurate enough. The result is lowered
    /// to the safe side.
    #[cold]
    fn speed_rise_by_powers(&self, from: f64, most: f64, tolerance: f64, needed: Needed<'_>) -> f64 {
        if most <= 0.0 {
            return most;
        }
        let mut speed_rise = from;
        for _ in 0..ITERATIONS_MAX {
            let (steps, slope) = needed(speed_rise);
            // (1 + h + h/p)/(1 + h - h/p) with h = (distance/needed - 1)/2 and p = rise slope/needed, by one division.
            let (sum, difference) =
                ((self.distance_steps + steps) * slope * speed_rise, (self.distance_steps - steps) * steps);
            let factor = (sum + difference) / (sum - difference);
            // If the needed distance is far off, the quotient is too small, too large or negative.
            let (low, high) = if difference > 0.0 { (1.0, FACTOR_MAX) } else { (1.0 / FACTOR_MAX, 1.0) };
            let factor = if (low..=high).contains(&factor) { factor } else { low * high };
            // The search ends at `most` only if the rise would still grow there: a step that was too long may also have
            // led to `most`.
            if speed_rise >= most && factor >= 1.0 {
                return most;
            }
            speed_rise *= factor;
            let step = factor - 1.0;
            if step.abs() <= tolerance {
                return (speed_rise * (1.0 - step * step / 4.0)).min(most);
            }
            speed_rise = speed_rise.min(most);
        }
        speed_rise
    }

    /// The lengths of the shortest ramps, steps, and how much longer each is for each step/s more.
    #[cold]
    fn lengths(&self, speed_rise: f64) -> ((f64, f64), (f64, f64)) {
        let accel = self.accel.length(self.entry_steps_s, self.accel_rise(speed_rise));
        match self.decel_ratio() {
            Some(ratio) => (accel, (accel.0 * ratio, accel.1 * ratio)),
            None => (accel, self.decel.length(self.exit_steps_s, self.decel_rise(speed_rise))),
        }
    }

    /// The shortest ramps.
    #[cold]
    fn ramps(&self, speed_rise: f64) -> (Ramp, Ramp) {
        let accel = self.accel.shortest(self.entry_steps_s, self.accel_rise(speed_rise));
        match self.decel_ratio() {
            Some(ratio) => (accel, accel.shortened(ratio)),
            None => (accel, self.decel.shortest(self.exit_steps_s, self.decel_rise(speed_rise))),
        }
    }

    /// The ratio of the decelerating ramp's length to that of the accelerating ramp, if nothing else differs.
    fn decel_ratio(&self) -> Option<f64> {
        let (a, d) = (self.accel.accel_steps_s2, self.decel.accel_steps_s2);
        let is_alike =
            self.entry_steps_s == self.exit_steps_s && (self.speed_profile != SpeedProfile::SCurve || a == d);
        is_alike.then(|| if a == d { 1.0 } else { a / d })
    }

    /// The profile with these ramps, whose cruise speed is `speed_rise` above the faster end.
    fn profile(&self, speed_rise: f64, (accel, decel): (Ramp, Ramp)) -> Profile {
        let cruise_steps_s = self.fast_end() + speed_rise;
        let accel_end_steps = accel.steps().min(self.distance_steps);
        let cruise_end_steps = (self.distance_steps - decel.steps()).max(accel_end_steps);
        Profile {
            distance_steps: self.distance_steps,
            cruise_steps_s,
            cruise_s: (cruise_end_steps - accel_end_steps) / cruise_steps_s,
            accel,
            decel,
            accel_end_steps,
            cruise_end_steps,
        }
    }

    fn fast_end(&self) -> f64 {
        self.entry_steps_s.max(self.exit_steps_s)
    }

    // The rises of the ramps are computed as sums, so that a small `speed_rise` keeps its digits.

    fn accel_rise(&self, speed_rise: f64) -> f64 {
        self.fast_end() - self.entry_steps_s + speed_rise
    }

    fn decel_rise(&self, speed_rise: f64) -> f64 {
        self.fast_end() - self.exit_steps_s + speed_rise
    }
}
