//! Speed profiles side by side: their steps, from which table, CSV and picture are made, and their figures as `isostep profile`
//! prints them.

mod derivatives;
mod exact;
mod table;

use isostep_profile::{Profile, StepCounts};
use isostep_sim::analysis::{gradient, mean_derivative};

pub use self::derivatives::Derivatives;
pub use self::exact::Exact;
pub use self::table::{Row, rows};

/// The largest number of steps of a move. It is bounded because every step is kept for table, file and picture.
pub const STEPS_MAX: u32 = 1_000_000;

/// A speed profile planned with given parameters.
pub struct Curve {
    /// The name of the speed profile, and of the step generator if it is not the exact one.
    pub name: String,
    /// All steps in order.
    pub steps: Vec<Step>,
    /// Number of steps of each phase.
    pub counts: StepCounts,
    /// Duration of each phase, s.
    pub phases_s: [f64; 3],
    /// Duration of the whole move, s. `None` for a step generator, which ends with its last step.
    pub duration_s: Option<f64>,
    /// Highest speed, steps/s.
    pub top_hz: f64,
    /// Instants, s, and displacements, steps. Derivatives by differences are taken from these.
    pub samples: Vec<(f64, f64)>,
    /// The closed form, where the speed profile has one.
    pub exact: Option<Exact>,
}

/// One step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Instant of its rising edge, us after the first step's.
    pub t_us: f64,
    /// Time to the next rising edge, us; the last step may have none.
    pub period_us: Option<f64>,
    /// Its speed, Hz; the last step may have none.
    pub frequency_hz: Option<f64>,
}

impl Curve {
    /// A speed profile of which only the steps are known. A phase lasts as long as the sum of its steps' periods. The
    /// displacement grows by one step at each rising edge and is complete at the end.
    pub fn of_steps(name: &str, steps: Vec<Step>, counts: StepCounts, duration_s: Option<f64>) -> Self {
        let (accel, cruise) = (counts.accel as usize, counts.cruise as usize);
        let sum_s =
            |steps: &[Step]| steps.iter().filter_map(|step| step.period_us).fold(0.0, |sum, us| sum + us) * 1e-6;
        let made = steps.iter().zip(0_u32..).map(|(step, made)| (step.t_us * 1e-6, f64::from(made)));
        let end = duration_s.map(|duration_s| (duration_s, steps.len() as f64));
        Self {
            name: name.to_owned(),
            counts,
            phases_s: [&steps[..accel], &steps[accel..accel + cruise], &steps[accel + cruise..]].map(sum_s),
            duration_s,
            top_hz: steps.iter().filter_map(|step| step.frequency_hz).fold(0.0, f64::max),
            samples: made.chain(end).collect(),
            steps,
            exact: None,
        }
    }

    /// The exact steps of a profile. Step k of the machine leaves at displacement k - 1/2.
    pub fn exact(name: &str, profile: Profile, steps: u32) -> Self {
        let displacement = |k: u32| f64::from(k) - 0.5;
        let edges_s: Vec<f64> = (1..=steps).map(|k| profile.time_at(displacement(k))).collect();
        let edges_us: Vec<f64> = edges_s.iter().map(|edge_s| edge_s * 1e6).collect();
        Self {
            name: name.to_owned(),
            steps: steps_at(&edges_us),
            counts: profile.step_counts(),
            phases_s: [profile.t_accel_s(), profile.t_cruise_s(), profile.t_decel_s()],
            duration_s: Some(profile.duration_s()),
            top_hz: profile.cruise_speed_steps_s(),
            samples: edges_s.into_iter().zip((1..=steps).map(displacement)).collect(),
            exact: Some(Exact(profile)),
        }
    }

    /// Time from the first step to the last, s.
    pub fn first_to_last_s(&self) -> f64 {
        self.steps.last().map_or(0.0, |step| step.t_us * 1e-6)
    }
}

/// Steps at `edges_us`, with the periods between them; the last one has none.
pub fn steps_at(edges_us: &[f64]) -> Vec<Step> {
    let next = edges_us.iter().skip(1).map(Some).chain([None]);
    let step = |(&t_us, next): (&f64, Option<&f64>)| {
        let period_us = next.map(|next| next - t_us);
        Step { t_us: t_us - edges_us[0], period_us, frequency_hz: period_us.map(|us| 1e6 / us) }
    };
    edges_us.iter().zip(next).map(step).collect()
}

/// Speed, acceleration and jerk, each by differences of the quantity before it (Fonseca-Campos 2023, section VI.A).
pub fn differences(curve: &Curve) -> Derivatives {
    let (t_s, position): (Vec<f64>, Vec<f64>) = curve.samples.iter().copied().unzip();
    by_differences(&curve.name, &t_s, position)
}

/// The same of the positions at these instants, s.
pub fn by_differences(name: &str, t_s: &[f64], position: Vec<f64>) -> Derivatives {
    let speed = gradient(t_s, &position);
    let accel = gradient(t_s, &speed);
    let jerk = gradient(t_s, &accel);
    let [position, speed, accel, jerk] =
        [position, speed, accel, jerk].map(|values| t_s.iter().copied().zip(values).collect());
    Derivatives { name: name.to_owned(), position, speed, accel, jerk }
}

/// The largest magnitude.
pub fn peak(points: &[(f64, f64)]) -> f64 {
    points.iter().map(|point| point.1.abs()).fold(0.0, f64::max)
}

/// The largest magnitude of a mean derivative. The derivative has order `N` - 1, and the mean is over `N` consecutive
/// steps.
///
/// Near standstill, steps are far apart. Repeated differences may then be half as large again as the speed profile's own
/// derivative. A mean over steps never exceeds the speed profile's peak.
pub fn peak_mean<const N: usize>(curve: &Curve) -> f64 {
    let means = curve.samples.windows(N).map(|samples| {
        let sample = |index: usize| samples[index];
        mean_derivative(std::array::from_fn::<_, N, _>(|k| sample(k).0), std::array::from_fn(|k| sample(k).1))
    });
    means.map(f64::abs).fold(0.0, f64::max)
}
