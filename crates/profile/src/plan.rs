//! Where a move's ramps meet: how fast it can cruise.

use libm::sqrt;

use crate::law::SpeedLaw;
use crate::limits::{Limits, SPEED_MIN_STEPS_S};
use crate::newton::rising_root;
use crate::profile::{Profile, ProfileError};
use crate::ramp::{Bounds, Ramp};

/// How near a cruise speed comes to the best one, as a share of the speed gained; the rest is made up by the cruise.
const PEAK_TOLERANCE: f64 = 1e-12;
/// The same for thirds, whose intervals are equal at any speed.
const THIRDS_TOLERANCE: f64 = 1e-9;

/// The two ends of a profile, the way between them, and what its ramps must keep to.
pub(crate) struct Ends {
    distance_steps: f64,
    entry_steps_s: f64,
    exit_steps_s: f64,
    top_steps_s: f64,
    law: SpeedLaw,
    accel: Bounds,
    decel: Bounds,
}

impl Ends {
    pub(crate) fn new(
        distance_steps: f64,
        entry_steps_s: f64,
        exit_steps_s: f64,
        limits: &Limits,
        law: SpeedLaw,
    ) -> Self {
        let bounds = |accel_steps_s2| Bounds { law, accel_steps_s2, jerk_steps_s3: limits.jerk_steps_s3 };
        Self {
            distance_steps,
            entry_steps_s,
            exit_steps_s,
            top_steps_s: limits.top_speed_steps_s,
            law,
            accel: bounds(limits.accel_steps_s2),
            decel: bounds(limits.decel_steps_s2),
        }
    }

    /// Refuses speeds at the ends that the law or the way between cannot do.
    pub(crate) fn check(&self) -> Result<(), ProfileError> {
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
        if self.law.is_over_displacement() && slowest < SPEED_MIN_STEPS_S.min(self.top_steps_s) {
            return Err(ProfileError::Standstill { law: self.law, asked: slowest, min: SPEED_MIN_STEPS_S });
        }
        Ok(())
    }

    /// The highest speed that one ramp from `slow` comes to over the whole way.
    fn highest_from(&self, slow: f64, bounds: Bounds) -> f64 {
        let room = self.top_steps_s - slow;
        let short = |rise: f64| {
            let (steps, growth) = bounds.length(slow, rise);
            (steps - self.distance_steps, growth)
        };
        if self.law == SpeedLaw::Trapezoid {
            return sqrt(slow * slow + 2.0 * bounds.accel_steps_s2 * self.distance_steps).min(self.top_steps_s);
        }
        if room <= 0.0 || short(room).0 <= 0.0 {
            return self.top_steps_s;
        }
        let rise = rising_root((0.0, room), room, PEAK_TOLERANCE, short);
        let highest = slow + rise;
        // Over a short way, an end too fast by its rounding is too fast by far.
        if highest - slow > rise { highest.next_down() } else { highest }
    }

    /// As fast as the limits allow.
    pub(crate) fn fastest(&self) -> Profile {
        match self.law {
            SpeedLaw::Trapezoid => self.fastest_trapezoid(),
            _ => self.fastest_by_search(),
        }
    }

    /// Paper 002, eqs 1-8, with entry and exit apart. The peak of the triangle follows from
    /// (v² - v_entry²)/2a + (v² - v_exit²)/2d = s.
    fn fastest_trapezoid(&self) -> Profile {
        let (a, d) = (self.accel.accel_steps_s2, self.decel.accel_steps_s2);
        let (entry, exit) = (self.entry_steps_s, self.exit_steps_s);
        let peak = self.peak_of_triangle();
        if peak <= self.top_steps_s {
            // Where both ramps have the same speed; as a difference of the peak's square it would cancel.
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

    fn trapezoid(&self, cruise: f64, ends: (f64, f64), cruise_s: f64) -> Profile {
        let (accel_end, cruise_end) = ends;
        let ramp = |slow, bounds: &Bounds, steps| Ramp::even(slow, cruise - slow, bounds.accel_steps_s2, steps);
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

    /// Gains as much over the faster end as both ramps have room for. No law is faster than the trapezoid.
    fn fastest_by_search(&self) -> Profile {
        let over = |gain: f64| {
            let (accel, accel_growth) = self.accel.length(self.entry_steps_s, self.accel_rise(gain));
            let (decel, decel_growth) = self.decel.length(self.exit_steps_s, self.decel_rise(gain));
            (accel + decel - self.distance_steps, accel_growth + decel_growth)
        };
        let room = self.top_steps_s - self.fast_end();
        let most = room.min(self.peak_of_triangle() - self.fast_end());
        let gain = if over(most).0 <= 0.0 { most } else { rising_root((0.0, most), most, PEAK_TOLERANCE, over) };
        self.profile(gain, |ramp| ramp)
    }

    /// Paper 004, eqs 1-7: all three intervals last t1, so s = t1 (v_accel + v + v_decel) with the mean speeds of the
    /// ramps. The cruise speed v is the highest at which neither ramp exceeds its limits.
    pub(crate) fn thirds(&self) -> Result<Profile, ProfileError> {
        let gain = match self.law {
            SpeedLaw::Trapezoid => self.highest_of_thirds() - self.fast_end(),
            _ => self.gain_of_thirds(),
        };
        let highest = self.fast_end() + gain;
        if highest < self.entry_steps_s {
            return Err(ProfileError::EntrySpeed { asked: self.entry_steps_s, max: highest });
        }
        if highest < self.exit_steps_s {
            return Err(ProfileError::ExitSpeed { asked: self.exit_steps_s, max: highest });
        }
        let (accel, decel) = self.means(gain);
        let third_s = self.distance_steps / (accel + highest + decel);
        Ok(Profile { cruise_s: third_s, ..self.profile(gain, |ramp| ramp.stretched(third_s)) })
    }

    /// With k = (v_entry + v_exit)/2, (v - v_end)/t1 <= a is (v - v_end)(2 v + k) <= a s.
    fn highest_of_thirds(&self) -> f64 {
        let k = (self.entry_steps_s + self.exit_steps_s) / 2.0;
        let highest = |end: f64, accel: f64| {
            let b = k - 2.0 * end;
            let c = -(k * end + accel * self.distance_steps);
            (sqrt(b * b - 8.0 * c) - b) / 4.0
        };
        let accel = highest(self.entry_steps_s, self.accel.accel_steps_s2);
        let decel = highest(self.exit_steps_s, self.decel.accel_steps_s2);
        self.top_steps_s.min(accel).min(decel)
    }

    /// By search; below 0 if the faster end is too fast for its own ramp.
    fn gain_of_thirds(&self) -> f64 {
        let fast = self.fast_end();
        let room = self.top_steps_s - fast;
        if self.excess_of_thirds(room).0 <= 0.0 {
            return room;
        }
        if self.excess_of_thirds(0.0).0 > 0.0 {
            let excess = |end| (self.with_fast_end(end).excess_of_thirds(0.0).0, f64::NAN);
            let slow = self.entry_steps_s.min(self.exit_steps_s);
            return rising_root((slow, fast), fast, THIRDS_TOLERANCE, excess) - fast;
        }
        let gain = rising_root((0.0, room), room, THIRDS_TOLERANCE, |gain| self.excess_of_thirds(gain));
        // On the safe side of where the search ends.
        gain * (1.0 - 2.0 * THIRDS_TOLERANCE)
    }

    /// A ramp of mean speed m that is x long at its shortest has its time if x/m <= t1. How much longer the way would
    /// have to be for that, and how much for each step/s more, about.
    fn excess_of_thirds(&self, gain: f64) -> (f64, f64) {
        let means = self.means(gain);
        let sum = means.0 + self.fast_end() + gain + means.1;
        let accel = self.accel.length(self.entry_steps_s, self.accel_rise(gain));
        let decel = self.decel.length(self.exit_steps_s, self.decel_rise(gain));
        let needed = |(steps, growth): (f64, f64), mean: f64| (steps * sum / mean, growth * sum / mean);
        let (accel, decel) = (needed(accel, means.0), needed(decel, means.1));
        let (steps, growth) = if accel.0 > decel.0 { accel } else { decel };
        (steps - self.distance_steps, growth)
    }

    /// The mean speeds of both ramps.
    fn means(&self, gain: f64) -> (f64, f64) {
        let accel = self.accel.mean_steps_s(self.entry_steps_s, self.accel_rise(gain));
        (accel, self.decel.mean_steps_s(self.exit_steps_s, self.decel_rise(gain)))
    }

    /// With ramps that gain so much over the faster end, each changed by `shape`.
    fn profile(&self, gain: f64, shape: impl Fn(Ramp) -> Ramp) -> Profile {
        let accel = shape(self.accel.shortest(self.entry_steps_s, self.accel_rise(gain)));
        let decel = shape(self.decel.shortest(self.exit_steps_s, self.decel_rise(gain)));
        let cruise_steps_s = self.fast_end() + gain;
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

    /// The same, but that neither end is faster than `speed_steps_s`.
    fn with_fast_end(&self, speed_steps_s: f64) -> Self {
        let (entry, exit) = (self.entry_steps_s, self.exit_steps_s);
        Self { entry_steps_s: entry.min(speed_steps_s), exit_steps_s: exit.min(speed_steps_s), ..*self }
    }

    // As sums, in which a small gain is not lost.

    fn accel_rise(&self, gain: f64) -> f64 {
        self.fast_end() - self.entry_steps_s + gain
    }

    fn decel_rise(&self, gain: f64) -> f64 {
        self.fast_end() - self.exit_steps_s + gain
    }
}
