//! Ramps whose speed is a function of time, in a unit square: speed and time from 0 to 1.

use core::f64::consts::PI;

use super::trig::sin_cos;
use crate::newton::{rising_root, rough_root};

/// The speed profile of a ramp. It is steepest in the middle, and symmetrical: s(1 - t) = 1 - s(t).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum OverTime {
    /// The jerk is constant for `ratio` of the time, then 0, and then the negative constant for `ratio` of the time.
    SCurve {
        /// Above 0, up to 1/2.
        ratio: f64,
    },
    /// s(t) = (1 - cos π t)/2.
    Sine,
}

/// A time this close before a corner, as a fraction, counts as the corner.
const CORNER_TOLERANCE: f64 = 1e-12;

impl OverTime {
    /// The steepest slope.
    pub(super) fn peak(self) -> f64 {
        match self {
            Self::SCurve { ratio } => 1.0 / (1.0 - ratio),
            Self::Sine => PI / 2.0,
        }
    }

    /// Travel, speed and slope at `t`.
    #[cold]
    pub(super) fn at(self, t: f64) -> At {
        match self {
            Self::SCurve { ratio } => s_curve_at(ratio, t),
            Self::Sine => sine_at(t),
        }
    }

    /// s''(`t`). Where it jumps, it is the value on the side of `beside`.
    pub(super) fn bend(self, t: f64, beside: f64) -> f64 {
        match self {
            Self::SCurve { ratio } if beside < ratio => 1.0 / (ratio * (1.0 - ratio)),
            Self::SCurve { ratio } if 1.0 - beside < ratio => -1.0 / (ratio * (1.0 - ratio)),
            Self::SCurve { .. } => 0.0,
            Self::Sine => {
                let (sine, _) = sin_cos(t);
                PI * PI * (0.5 - sine * sine)
            }
        }
    }

    /// The place of the next jump of s'', after `t`.
    pub(super) fn next_corner(self, t: f64) -> f64 {
        // Rounding may leave a `t` that stands for a corner a little before that corner.
        let is_ahead = |corner: &f64| t < corner * (1.0 - CORNER_TOLERANCE);
        match self {
            Self::SCurve { ratio } => [ratio, 1.0 - ratio].into_iter().find(is_ahead).unwrap_or(1.0),
            Self::Sine => 1.0,
        }
    }

    /// The time t at which `slow` t + travel(t) is `displacement`.
    pub(super) fn time(self, slow: f64, displacement: f64) -> f64 {
        self.search(slow, displacement, 1e-8)
    }

    /// That time or a little earlier; much faster to compute.
    pub(super) fn time_before(self, slow: f64, displacement: f64) -> f64 {
        // By Newton's method, the error is then within the square of the tolerance.
        self.search(slow, displacement, 0.03) * 0.99
    }

    #[cold]
    fn search(self, slow: f64, displacement: f64, tolerance: f64) -> f64 {
        rising_root((0.0, 1.0), self.time_near(slow, displacement), tolerance, |t| {
            let At { travel, speed, .. } = self.at(t);
            (slow * t + travel - displacement, slow + speed)
        })
    }

    /// Roughly that time. A search begins with it.
    fn time_near(self, slow: f64, displacement: f64) -> f64 {
        // While the jerk is that of the beginning, the travel is proportional to t³.
        let cube = match self {
            Self::SCurve { ratio } => 6.0 * ratio * (1.0 - ratio) * displacement,
            Self::Sine => 12.0 / (PI * PI) * displacement,
        };
        rough_root(cube, 3).min(displacement / slow).min(1.0)
    }
}

/// The travel ∫ s dt from 0 (1/2 at t = 1), the speed s, and its slope s'.
pub(super) struct At {
    pub(super) travel: f64,
    pub(super) speed: f64,
    pub(super) slope: f64,
}

fn s_curve_at(ratio: f64, t: f64) -> At {
    let left = 1.0 - t;
    let steepest = 1.0 / (1.0 - ratio);
    if t > ratio && left > ratio {
        let travel = steepest * (t * (t - ratio) + ratio * ratio / 3.0) / 2.0;
        return At { travel, speed: steepest * (t - ratio / 2.0), slope: steepest };
    }
    let from_end = t.min(left);
    let slope = steepest * from_end / ratio;
    let speed = slope * from_end / 2.0;
    let travel = speed * from_end / 3.0;
    if t <= ratio { At { travel, speed, slope } } else { At { travel: 0.5 - left + travel, speed: 1.0 - speed, slope } }
}

/// The speed is s = sin² (π t/2), because (1 - cos π t)/2 cancels near standstill. The travel (t - sin(π t)/π)/2
/// cancels there, too; with x = π t it is computed there by the series x² t/12 (1 - x²/20 (1 - x²/42 (1 - ...))).
#[cold]
fn sine_at(t: f64) -> At {
    let (sine, cosine) = sin_cos(t);
    let product = sine * cosine;
    let travel = if t > SERIES_END {
        t / 2.0 - product / PI
    } else {
        let square = PI * PI * t * t;
        let factors = SERIES_FACTORS.iter().rev();
        square * t / 12.0 * factors.fold(1.0, |sum, factor| 1.0 - sum * square * factor)
    };
    At { travel, speed: sine * sine, slope: PI * product }
}

/// The series is used up to this time. Beyond it, cancellation costs less than two digits.
const SERIES_END: f64 = 0.25;
/// 1/(4 5), 1/(6 7) and so on. At the end of the series' range, the first term left out is 2^-57 of the sum.
const SERIES_FACTORS: [f64; 7] =
    [1.0 / 20.0, 1.0 / 42.0, 1.0 / 72.0, 1.0 / 110.0, 1.0 / 156.0, 1.0 / 210.0, 1.0 / 272.0];

#[cfg(test)]
mod tests {
    use super::OverTime;

    /// A search takes the fewer evaluations the nearer it begins to its end.
    #[test]
    fn a_search_begins_near_its_end() {
        for speed_profile in [OverTime::Sine, OverTime::SCurve { ratio: 0.5 }] {
            for slow in [0.0, 1e-3, 0.1, 1.0, 10.0] {
                for k in 1..100 {
                    let t = f64::from(k) / 100.0;
                    let ratio = speed_profile.time_near(slow, slow * t + speed_profile.at(t).travel) / t;
                    assert!((0.87..=1.5).contains(&ratio), "{speed_profile:?}, from {slow}, at {t}: {ratio}");
                }
            }
        }
    }
}
