//! Random moves, each of which follows from its number.

use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::thread;

use isostep_profile::{IntervalSplit, Limits, Profile, ProfileError, SpeedProfile};
use isostep_trials::{cases, window};
use oorandom::Rand64;

/// The environment variable that names a single case to try.
const CASE_VARIABLE: &str = "S_CURVE_CASE";
/// The number of threads over which the cases are split.
const THREADS: u64 = 4;

/// A move to plan.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    pub distance_steps: f64,
    pub entry_steps_s: f64,
    pub exit_steps_s: f64,
    pub limits: Limits,
}

impl Case {
    /// A move that can be planned.
    pub fn random(number: u64) -> Self {
        let mut random = Random(Rand64::new(number.into()));
        let limits = random.limits();
        let case = Self {
            distance_steps: random.distance_steps(&limits),
            entry_steps_s: random.speed_up_to(limits.top_speed_steps_s),
            exit_steps_s: random.speed_up_to(limits.top_speed_steps_s),
            limits,
        };
        let alike = Self { exit_steps_s: case.entry_steps_s, ..case };
        let case = if random.is_one_in(8) { alike } else { case };
        case.made_possible(&mut random)
    }

    pub fn plan(&self, speed_profile: SpeedProfile) -> Result<Profile, ProfileError> {
        Profile::plan(
            self.distance_steps,
            self.entry_steps_s,
            self.exit_steps_s,
            &self.limits,
            IntervalSplit::Fastest,
            speed_profile,
        )
    }

    pub fn s_curve(&self) -> Profile {
        self.plan(SpeedProfile::SCurve).expect("a random move can be planned")
    }

    /// Replaces a speed that is too high for the distance by the highest that works, or by a lower one.
    fn made_possible(self, random: &mut Random) -> Self {
        match self.plan(SpeedProfile::SCurve) {
            Err(ProfileError::EntrySpeed { max, .. }) => {
                Self { entry_steps_s: random.speed_between(self.exit_steps_s, max), ..self }
            }
            Err(ProfileError::ExitSpeed { max, .. }) => {
                Self { exit_steps_s: random.speed_between(self.entry_steps_s, max), ..self }
            }
            _ => self,
        }
    }
}

struct Random(Rand64);

impl Random {
    fn is_one_in(&mut self, count: u64) -> bool {
        self.0.rand_range(0..count) == 0
    }

    fn log(&mut self, range: Range<f64>) -> f64 {
        (range.start.ln() + self.0.rand_float() * (range.end / range.start).ln()).exp()
    }

    /// Reaching the top speed takes 2 ms to 10 s at constant acceleration. Reaching the acceleration takes a millionth
    /// of that to ten thousand times that.
    fn limits(&mut self) -> Limits {
        let top_speed_steps_s = self.log(1.0..1e4);
        let accel_s = self.log(2e-3..10.0);
        let decel_s = accel_s * self.log(0.01..1.0);
        let (accel, decel) = (top_speed_steps_s / accel_s, top_speed_steps_s / decel_s);
        let (accel_steps_s2, decel_steps_s2) = if self.is_one_in(2) { (accel, decel) } else { (decel, accel) };
        let jerk_steps_s3 = accel / (accel_s * self.log(1e-6..1e4));
        Limits { start_speed_steps_s: 0.0, top_speed_steps_s, accel_steps_s2, decel_steps_s2, jerk_steps_s3 }
    }

    /// From a ten-millionth of the distance in which the top speed is about reached, to a thousand times that distance.
    fn distance_steps(&mut self, limits: &Limits) -> f64 {
        let top = limits.top_speed_steps_s;
        let gained_s = top / limits.accel_steps_s2 + (top / limits.jerk_steps_s3).sqrt();
        top * gained_s * self.log(1e-7..1e3)
    }

    /// None, little, any, almost all or all of `top`.
    fn speed_up_to(&mut self, top: f64) -> f64 {
        match self.0.rand_range(0..8) {
            0 | 1 => 0.0,
            2 => top * self.log(1e-9..1.0),
            3 => top * (1.0 - self.log(1e-15..1.0)),
            4 => top,
            _ => top * self.0.rand_float(),
        }
    }

    /// The higher speed, almost the higher speed, or any speed between.
    fn speed_between(&mut self, low: f64, high: f64) -> f64 {
        match self.0.rand_range(0..4) {
            0 => high,
            1 => (high - (high - low) * self.log(1e-15..1.0)).max(low),
            _ => low + (high - low) * self.0.rand_float(),
        }
    }
}

/// All moves.
pub const ALL: u64 = 1_000_000;

/// The number of moves that are tried.
pub fn count() -> u64 {
    cases(50_000, ALL as u32).into()
}

/// Runs `check` on the cases, or on the single one that is asked for. Returns what it gathers, for each thread.
pub fn over_cases<T: Default + Send>(count: u64, check: impl Fn(&mut T, &Case) + Sync) -> Vec<T> {
    let gather = |numbers: &mut dyn Iterator<Item = u64>| {
        let mut gathered = T::default();
        numbers.for_each(|number| explained(number, |case| check(&mut gathered, case)));
        gathered
    };
    if let Some(number) = asked_case() {
        return vec![gather(&mut std::iter::once(number))];
    }
    thread::scope(|scope| {
        let worker =
            |first| scope.spawn(move || gather(&mut window(count).skip(first as usize).step_by(THREADS as usize)));
        let threads: Vec<_> = (0..THREADS).map(worker).collect();
        threads.into_iter().map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic))).collect()
    })
}

/// True if a single case is tried. Then what is expected of all cases together does not hold.
pub fn is_one_case() -> bool {
    asked_case().is_some()
}

fn asked_case() -> Option<u64> {
    let number = std::env::var(CASE_VARIABLE).ok()?;
    Some(number.parse().unwrap_or_else(|_| panic!("{CASE_VARIABLE} is {number}: give the number of a case")))
}

fn explained(number: u64, check: impl FnOnce(&Case)) {
    let case = Case::random(number);
    if let Err(panic) = catch_unwind(AssertUnwindSafe(|| check(&case))) {
        eprintln!("{case:?}\n{CASE_VARIABLE}={number} cargo test -p isostep-profile s_curve");
        resume_unwind(panic);
    }
}
