//! Where a move's ramps meet: how fast it can cruise.

use crate::law::SpeedLaw;
use crate::limits::{Limits, SPEED_MIN_STEPS_S};
use crate::newton::rising_root;
use crate::profile::{Profile, ProfileError};
use crate::ramp::{Bounds, Ramp};
use crate::root::sqrt;

/// The last step of the search for a cruise speed, as a fraction of the speed gained. What is left then is less than a
/// quarter of its square.
const PEAK_TOLERANCE: f64 = 1e-6;
/// The same for thirds of a law over displacement: they are slower than they might be by 1e-5 at most.
const THIRDS_TOLERANCE: f64 = 6e-3;
/// The same where the ends differ; what is left is far less.
const ROOT_TOLERANCE: f64 = 1e-10;
/// By how much a search by powers changes a gain at most, at a time.
const FACTOR_MAX: f64 = 10.0;
/// More than any search takes.
const ITERATIONS_MAX: u32 = 100;

/// How many steps a gain needs, and how many more for each step/s more.
type Needed<'a> = &'a dyn Fn(f64) -> (f64, f64);

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
        let bounds = |accel_steps_s2| Bounds::new(law, accel_steps_s2, limits.jerk_steps_s3);
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
        let rise = rising_root((0.0, room), room, ROOT_TOLERANCE, short);
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
        let ramp =
            |slow, bounds: &Bounds, steps| Ramp::constant_accel(slow, cruise - slow, bounds.accel_steps_s2, steps);
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
        let lengths = |delta_v2: f64| {
            let (accel, decel) = self.lengths(delta_v2);
            (accel.0 + decel.0, accel.1 + decel.1)
        };
        let room = self.top_steps_s - self.fast_end();
        let most = room.min(self.peak_of_triangle() - self.fast_end());
        let delta_v2 = if self.entry_steps_s != self.exit_steps_s {
            self.delta_v2_by_newton(most, most, ROOT_TOLERANCE, &lengths)
        } else if let Some(delta_v2) = self.delta_v2_by_quadratic() {
            delta_v2.min(most)
        } else {
            self.delta_v2_by_powers(most, most, PEAK_TOLERANCE, &lengths)
        };
        self.profile(delta_v2, self.ramps(delta_v2))
    }

    /// Paper 004, eqs 1-7: all three intervals last t1, so s = t1 (v_accel + v + v_decel) with the mean speeds of the
    /// ramps. The cruise speed v is the highest at which neither ramp exceeds its limits.
    pub(crate) fn thirds(&self) -> Result<Profile, ProfileError> {
        let delta_v2 = match self.law {
            SpeedLaw::Trapezoid => self.highest_of_thirds() - self.fast_end(),
            _ => self.delta_v2_by_thirds(),
        };
        let highest = self.fast_end() + delta_v2;
        if highest < self.entry_steps_s {
            return Err(ProfileError::EntrySpeed { asked: self.entry_steps_s, max: highest });
        }
        if highest < self.exit_steps_s {
            return Err(ProfileError::ExitSpeed { asked: self.exit_steps_s, max: highest });
        }
        let (accel_mean, decel_mean) = self.means(delta_v2);
        let third_s = self.distance_steps / (accel_mean + highest + decel_mean);
        let ramps = (
            self.accel.lasting(third_s, self.entry_steps_s, self.accel_rise(delta_v2), accel_mean),
            self.decel.lasting(third_s, self.exit_steps_s, self.decel_rise(delta_v2), decel_mean),
        );
        Ok(Profile { cruise_s: third_s, ..self.profile(delta_v2, ramps) })
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
        let decel = match self.decel_ratio() {
            Some(1.0) => accel,
            _ => highest(self.exit_steps_s, self.decel.accel_steps_s2),
        };
        self.top_steps_s.min(accel).min(decel)
    }

    /// By search; below 0 if the faster end is too fast for its own ramp.
    fn delta_v2_by_thirds(&self) -> f64 {
        let fast = self.fast_end();
        if self.entry_steps_s != self.exit_steps_s && self.needed_by_thirds(0.0).0 > self.distance_steps {
            let excess = |end| (self.with_fast_end(end).needed_by_thirds(0.0).0 - self.distance_steps, f64::NAN);
            let slow = self.entry_steps_s.min(self.exit_steps_s);
            return rising_root((slow, fast), fast, ROOT_TOLERANCE, excess) - fast;
        }
        let room = self.top_steps_s - fast;
        // By what a trapezoid has room for; between unequal ends that may be none.
        let from = self.accel.delta_v2_near(fast, self.highest_of_thirds() - fast);
        let from = if from > 0.0 { from.min(room) } else { room };
        let needed = |delta_v2| self.needed_by_thirds(delta_v2);
        if self.entry_steps_s == self.exit_steps_s {
            let tolerance = if self.law.is_over_displacement() { THIRDS_TOLERANCE } else { PEAK_TOLERANCE };
            return self.delta_v2_by_powers(from, room, tolerance, &needed);
        }
        let delta_v2 = self.delta_v2_by_newton(from, room, ROOT_TOLERANCE, &needed);
        // On the safe side of where the search ends.
        if delta_v2 < room { delta_v2 * (1.0 - 2.0 * ROOT_TOLERANCE) } else { room }
    }

    /// The gain over which both ramps are as long as the way, from equal ends, if their length is a quadratic in it.
    fn delta_v2_by_quadratic(&self) -> Option<f64> {
        let (constant, square) = self.accel.quadratic_length()?;
        let per_accel = 1.0 / self.accel.accel_steps_s2 + 1.0 / self.decel.accel_steps_s2;
        let (slow, way) = (self.entry_steps_s, self.distance_steps / (constant * per_accel));
        // slow r + square r² = way, without cancelling.
        Some(2.0 * way / (slow + sqrt(slow * slow + 4.0 * square * way)))
    }

    /// The gain, `most` at most, over which `needed` is the way. Begins at `from`.
    fn delta_v2_by_newton(&self, from: f64, most: f64, tolerance: f64, needed: Needed<'_>) -> f64 {
        let over = |delta_v2| {
            let (steps, growth) = needed(delta_v2);
            (steps - self.distance_steps, growth)
        };
        if over(most).0 <= 0.0 {
            return most;
        }
        rising_root((0.0, most), from, tolerance, over)
    }

    /// The same from equal ends.
    ///
    /// There what is needed is near a power of the gain, s^p, p being 1/2 to 2 or so. Hence by Newton's method on the
    /// logarithms of both, that is by (way/needed)^(1/p), for which a fraction of two lines is near enough. The result is
    /// on the safe side of where that ends.
    fn delta_v2_by_powers(&self, from: f64, most: f64, tolerance: f64, needed: Needed<'_>) -> f64 {
        if most <= 0.0 {
            return most;
        }
        let mut delta_v2 = from;
        for _ in 0..ITERATIONS_MAX {
            let (steps, slope) = needed(delta_v2);
            // (1 + h + h/p)/(1 + h - h/p) with h = (way/needed - 1)/2 and p = gain slope/needed, by one division.
            let (sum, difference) =
                ((self.distance_steps + steps) * slope * delta_v2, (self.distance_steps - steps) * steps);
            let factor = (sum + difference) / (sum - difference);
            // Where far too much or little is needed, the fraction is too small or large, or below 0.
            let (low, high) = if difference > 0.0 { (1.0, FACTOR_MAX) } else { (1.0 / FACTOR_MAX, 1.0) };
            let factor = if (low..=high).contains(&factor) { factor } else { low * high };
            // Not where a step leads there that is too long.
            if delta_v2 >= most && factor >= 1.0 {
                return most;
            }
            delta_v2 *= factor;
            let step = factor - 1.0;
            if step.abs() <= tolerance {
                return (delta_v2 * (1.0 - step * step / 4.0)).min(most);
            }
            delta_v2 = delta_v2.min(most);
        }
        delta_v2
    }

    /// A ramp of mean speed m that is x long at its shortest has its time if x/m <= t1. How long the way has to
    /// be for that, and how much longer for each step/s more.
    fn needed_by_thirds(&self, delta_v2: f64) -> (f64, f64) {
        let accel = self.accel.length_and_mean(self.entry_steps_s, self.accel_rise(delta_v2));
        let decel = match self.decel_ratio() {
            Some(ratio) => ((accel.0.0 * ratio, accel.0.1 * ratio), accel.1),
            None => self.decel.length_and_mean(self.exit_steps_s, self.decel_rise(delta_v2)),
        };
        let sum = accel.1.0 + self.fast_end() + delta_v2 + decel.1.0;
        let sum_growth = accel.1.1 + 1.0 + decel.1.1;
        let needed = |((steps, growth), (mean, mean_growth)): ((f64, f64), (f64, f64))| {
            let ratio = sum / mean;
            (steps * ratio, growth * ratio + steps * (sum_growth - ratio * mean_growth) / mean)
        };
        // Of ramps that differ by their length alone, the longer one.
        match self.decel_ratio() {
            Some(ratio) if ratio <= 1.0 => needed(accel),
            Some(_) => needed(decel),
            None => {
                let (accel, decel) = (needed(accel), needed(decel));
                if accel.0 > decel.0 { accel } else { decel }
            }
        }
    }

    /// The lengths of both ramps at their shortest, steps, and how much longer each is for each step/s more.
    fn lengths(&self, delta_v2: f64) -> ((f64, f64), (f64, f64)) {
        let accel = self.accel.length(self.entry_steps_s, self.accel_rise(delta_v2));
        match self.decel_ratio() {
            Some(ratio) => (accel, (accel.0 * ratio, accel.1 * ratio)),
            None => (accel, self.decel.length(self.exit_steps_s, self.decel_rise(delta_v2))),
        }
    }

    /// The mean speeds of both ramps.
    fn means(&self, delta_v2: f64) -> (f64, f64) {
        let accel = self.accel.mean_steps_s(self.entry_steps_s, self.accel_rise(delta_v2));
        match self.decel_ratio() {
            Some(_) => (accel, accel),
            None => (accel, self.decel.mean_steps_s(self.exit_steps_s, self.decel_rise(delta_v2))),
        }
    }

    /// Both ramps at their shortest.
    fn ramps(&self, delta_v2: f64) -> (Ramp, Ramp) {
        let accel = self.accel.shortest(self.entry_steps_s, self.accel_rise(delta_v2));
        match self.decel_ratio() {
            Some(ratio) => (accel, accel.shortened(ratio)),
            None => (accel, self.decel.shortest(self.exit_steps_s, self.decel_rise(delta_v2))),
        }
    }

    /// By what fraction the decelerating ramp is shorter than the other one, if nothing else differs.
    fn decel_ratio(&self) -> Option<f64> {
        let (a, d) = (self.accel.accel_steps_s2, self.decel.accel_steps_s2);
        let is_alike = self.entry_steps_s == self.exit_steps_s && (self.law != SpeedLaw::SCurve || a == d);
        is_alike.then(|| if a == d { 1.0 } else { a / d })
    }

    /// With ramps that gain so much over the faster end.
    fn profile(&self, delta_v2: f64, (accel, decel): (Ramp, Ramp)) -> Profile {
        let cruise_steps_s = self.fast_end() + delta_v2;
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

    fn accel_rise(&self, delta_v2: f64) -> f64 {
        self.fast_end() - self.entry_steps_s + delta_v2
    }

    fn decel_rise(&self, delta_v2: f64) -> f64 {
        self.fast_end() - self.exit_steps_s + delta_v2
    }
}
