//! Profiles in three equal intervals (Forero 2023).

use super::{PEAK_TOLERANCE, PlanInput, ROOT_TOLERANCE};
use crate::newton::rising_root;
use crate::profile::{Profile, ProfileError};
use crate::speed_profile::SpeedProfile;
use crate::square_root::sqrt;

/// The search for the cruise speed of a speed profile over displacement ends with a step of this size, as a fraction of the rise
/// over the faster end. The cruise found is slower than the optimum by 1e-5 at most.
const THIRDS_TOLERANCE: f64 = 6e-3;

impl PlanInput {
    /// Forero 2023, eqs 1-7: all three intervals last t1, so s = t1 (v_accel + v + v_decel), where v_accel and v_decel
    /// are the mean speeds of the ramps. The cruise speed v is the highest at which neither ramp exceeds its limits.
    #[cold]
    pub(super) fn thirds(&self) -> Result<Profile, ProfileError> {
        let speed_rise = match self.speed_profile {
            SpeedProfile::Trapezoid => self.highest_of_thirds() - self.fast_end(),
            _ => self.speed_rise_by_thirds(),
        };
        let highest = self.fast_end() + speed_rise;
        if highest < self.entry_steps_s {
            return Err(ProfileError::EntrySpeed { asked: self.entry_steps_s, max: highest });
        }
        if highest < self.exit_steps_s {
            return Err(ProfileError::ExitSpeed { asked: self.exit_steps_s, max: highest });
        }
        let (accel_mean, decel_mean) = self.means(speed_rise);
        let third_s = self.distance_steps / (accel_mean + highest + decel_mean);
        let ramps = (
            self.accel.lasting(third_s, self.entry_steps_s, self.accel_rise(speed_rise), accel_mean),
            self.decel.lasting(third_s, self.exit_steps_s, self.decel_rise(speed_rise), decel_mean),
        );
        Ok(Profile { cruise_s: third_s, ..self.profile(speed_rise, ramps) })
    }

    /// The highest cruise speed of a trapezoid in thirds. (v - v_end)/t1 <= a becomes (v - v_end)(2 v + k) <= a s with
    /// k = (v_entry + v_exit)/2.
    #[cold]
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

    /// The rise over the faster end in thirds, by search. It is below 0 if the faster end is too fast for its own ramp.
    #[cold]
    fn speed_rise_by_thirds(&self) -> f64 {
        let fast = self.fast_end();
        if self.entry_steps_s != self.exit_steps_s && self.needed_by_thirds(0.0).0 > self.distance_steps {
            let excess = |end| (self.with_fast_end(end).needed_by_thirds(0.0).0 - self.distance_steps, f64::NAN);
            let slow = self.entry_steps_s.min(self.exit_steps_s);
            return rising_root((slow, fast), fast, ROOT_TOLERANCE, excess) - fast;
        }
        let room = self.top_steps_s - fast;
        // The search begins near the rise that a trapezoid has room for. Between unequal ends that may not be above 0.
        let from = self.accel.speed_rise_near(fast, self.highest_of_thirds() - fast);
        let from = if from > 0.0 { from.min(room) } else { room };
        let needed = |speed_rise| self.needed_by_thirds(speed_rise);
        if self.entry_steps_s == self.exit_steps_s {
            let tolerance = if self.speed_profile.is_over_displacement() { THIRDS_TOLERANCE } else { PEAK_TOLERANCE };
            return self.speed_rise_by_powers(from, room, tolerance, &needed);
        }
        let speed_rise = self.speed_rise_by_newton(from, room, ROOT_TOLERANCE, &needed);
        // The search may end on either side of the root, so the result is lowered to the safe side.
        if speed_rise < room { speed_rise * (1.0 - 2.0 * ROOT_TOLERANCE) } else { room }
    }

    /// The distance that the move needs so that each ramp fits into a third of its duration, and how much longer it is
    /// for each step/s more. A ramp of mean speed m fits if its shortest length x satisfies x/m <= t1.
    #[cold]
    fn needed_by_thirds(&self, speed_rise: f64) -> (f64, f64) {
        let accel = self.accel.length_and_mean(self.entry_steps_s, self.accel_rise(speed_rise));
        let decel = match self.decel_ratio() {
            Some(ratio) => ((accel.0.0 * ratio, accel.0.1 * ratio), accel.1),
            None => self.decel.length_and_mean(self.exit_steps_s, self.decel_rise(speed_rise)),
        };
        let sum = accel.1.0 + self.fast_end() + speed_rise + decel.1.0;
        let sum_growth = accel.1.1 + 1.0 + decel.1.1;
        let needed = |((steps, growth), (mean, mean_growth)): ((f64, f64), (f64, f64))| {
            let ratio = sum / mean;
            (steps * ratio, growth * ratio + steps * (sum_growth - ratio * mean_growth) / mean)
        };
        // If the ramps differ in their length alone, the longer one decides.
        match self.decel_ratio() {
            Some(ratio) if ratio <= 1.0 => needed(accel),
            Some(_) => needed(decel),
            None => {
                let (accel, decel) = (needed(accel), needed(decel));
                if accel.0 > decel.0 { accel } else { decel }
            }
        }
    }

    /// The mean speeds of both ramps.
    #[cold]
    fn means(&self, speed_rise: f64) -> (f64, f64) {
        let accel = self.accel.mean_steps_s(self.entry_steps_s, self.accel_rise(speed_rise));
        match self.decel_ratio() {
            Some(_) => (accel, accel),
            None => (accel, self.decel.mean_steps_s(self.exit_steps_s, self.decel_rise(speed_rise))),
        }
    }

    /// The same move, with both end speeds limited to `speed_steps_s`.
    fn with_fast_end(&self, speed_steps_s: f64) -> Self {
        let (entry, exit) = (self.entry_steps_s, self.exit_steps_s);
        Self { entry_steps_s: entry.min(speed_steps_s), exit_steps_s: exit.min(speed_steps_s), ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::PlanInput;
    use crate::limits::Limits;
    use crate::speed_profile::SpeedProfile;

    /// A search takes the fewer evaluations the nearer it begins to its end. By the logarithmic speed profile, whose evaluations
    /// take the longest, it begins within 13 %, however fast the ends are.
    #[test]
    fn a_search_begins_near_its_end() {
        let limits = Limits {
            start_speed_steps_s: 0.0,
            top_speed_steps_s: 1e9,
            accel_steps_s2: 1e4,
            decel_steps_s2: 1e4,
            jerk_steps_s3: 1e7,
        };
        for speed_profile in SpeedProfile::ALL {
            let factor_max = if speed_profile == SpeedProfile::Logarithmic { 1.13 } else { 4.5 };
            for slow in [0.1, 1.0, 10.0, 100.0, 1e3, 1e4] {
                let input = PlanInput::new(10_000.0, slow, slow, &limits, speed_profile);
                let near = input.accel.speed_rise_near(slow, input.highest_of_thirds() - slow);
                let ratio = near / input.speed_rise_by_thirds();
                assert!((1.0 / factor_max..=factor_max).contains(&ratio), "{speed_profile}, from {slow}: {ratio}");
            }
        }
    }
}
