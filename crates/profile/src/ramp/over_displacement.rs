//! Ramps whose speed is a function of the displacement, in a unit square (Fonseca-Campos 2023). The speed is `slow` +
//! v, with v from 0 to 1 and `slow` above 0. The displacement u is from 0 to 1.

use core::f64::consts::PI;

use libm::{atan, log1p};

use super::logarithmic::{self, Pole};
use super::trig::sin_cos;
use crate::newton::rising_root;
use crate::square_root::sqrt;

/// The search for a displacement ends with a step this small. Newton's method doubles the digits, so the result is then
/// as good as floats are.
const TOLERANCE: f64 = 1e-8;

/// The speed profile of a ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum OverDisplacement {
    /// v = u (Fonseca-Campos 2023, eq 5).
    Linear,
    /// v = u² (eq 6).
    Quadratic,
    /// v = (1 - cos π u)/2 (eq 7).
    Sinusoidal,
    /// v = ln(1 + K u)/ln(1 + K) (eq 8).
    Logarithmic,
}

impl OverDisplacement {
    /// v(`u`).
    pub(super) fn speed(self, u: f64) -> f64 {
        match self {
            Self::Linear => u,
            Self::Quadratic => u * u,
            Self::Sinusoidal => {
                let (sine, _) = sin_cos(u);
                sine * sine
            }
            Self::Logarithmic => log1p(logarithmic::K * u) / logarithmic::LN_END,
        }
    }

    /// v'(`u`).
    pub(super) fn slope(self, u: f64) -> f64 {
        match self {
            Self::Linear => 1.0,
            Self::Quadratic => 2.0 * u,
            Self::Sinusoidal => {
                let (sine, cosine) = sin_cos(u);
                PI * sine * cosine
            }
            Self::Logarithmic => logarithmic::slope(u),
        }
    }

    /// v''(`u`).
    pub(super) fn bend(self, u: f64) -> f64 {
        match self {
            Self::Linear => 0.0,
            Self::Quadratic => 2.0,
            Self::Sinusoidal => PI * PI * (0.5 - self.speed(u)),
            Self::Logarithmic => -logarithmic::LN_END * logarithmic::slope(u) * logarithmic::slope(u),
        }
    }

    /// The length of a ramp of `rise` that just reaches an acceleration of 1, and how much longer it is for each step/s
    /// more: the maximum of (slow + rise v) rise v', and its derivative by `rise`.
    #[cold]
    pub(super) fn length(self, slow: f64, rise: f64) -> (f64, f64) {
        match self {
            Self::Linear => (rise * (slow + rise), slow + 2.0 * rise),
            Self::Quadratic => (2.0 * rise * (slow + rise), 2.0 * (slow + 2.0 * rise)),
            Self::Sinusoidal => {
                // The maximum is where d/du is 0. With m = slow/rise + 1/2 that is cos² πu - m cos πu - 1/2 = 0.
                let m = slow / rise + 0.5;
                let cosine = -1.0 / (m + sqrt(m * m + 2.0));
                let slope = PI / 2.0 * sqrt(1.0 - cosine * cosine);
                let peak = rise * (m - cosine / 2.0) * slope;
                // At the maximum, a small change of its place does not change the value.
                (rise * peak, 2.0 * peak - slow * slope)
            }
            Self::Logarithmic => logarithmic::length(Pole::new(slow / rise), slow, rise),
        }
    }

    /// The length of the longest ramp of any speeds, as a multiple of a ramp of constant acceleration. A ramp of the
    /// logarithmic speed profile is longest if it begins fast, one of the other speed profiles if it begins at standstill.
    pub(super) fn longest(self) -> f64 {
        match self {
            Self::Linear => 2.0,
            Self::Quadratic => 4.0,
            // (1 - cos πu) sin πu π/2 at cos πu = -1/2: √27 π/8.
            Self::Sinusoidal => 2.040_524_284_763_495,
            Self::Logarithmic => logarithmic::slope(0.0),
        }
    }

    /// The time to reach `u`: ∫ du/(slow + v).
    #[cold]
    pub(super) fn time(self, slow: f64, u: f64) -> f64 {
        match self {
            Self::Linear => log1p(u / slow),
            Self::Quadratic => {
                let root = sqrt(slow);
                atan(u / root) / root
            }
            Self::Sinusoidal => {
                let (low, high) = (sqrt(slow), sqrt(slow + 1.0));
                let (sine, cosine) = sin_cos(u);
                // At the end the tangent is infinite.
                atan(high * sine / (low * cosine)) / (PI / 2.0 * low * high)
            }
            Self::Logarithmic => logarithmic::time(slow, u),
        }
    }

    /// The time to reach the end.
    #[cold]
    pub(super) fn whole_time(self, slow: f64) -> f64 {
        match self {
            Self::Sinusoidal => 1.0 / sqrt(slow * (slow + 1.0)),
            Self::Logarithmic => logarithmic::whole_time(Pole::new(slow)),
            _ => self.time(slow, 1.0),
        }
    }

    /// Length and time, each with its derivative. What both need is computed once.
    pub(super) fn whole(self, slow: f64, rise: f64) -> ((f64, f64), (f64, f64)) {
        let ratio = slow / rise;
        let (length, time) = if let Self::Logarithmic = self {
            let pole = Pole::new(ratio);
            (logarithmic::length(pole, slow, rise), logarithmic::whole_time(pole))
        } else {
            (self.length(slow, rise), self.whole_time(ratio))
        };
        (length, (time, self.whole_time_growth(ratio, time)))
    }

    /// The relative derivative of the whole time: `slow` times the derivative of `whole_time` by `slow`, which is
    /// negative. `time` is `whole_time` at `slow`.
    pub(super) fn whole_time_growth(self, slow: f64, time: f64) -> f64 {
        let ratio = 1.0 / (slow + 1.0);
        match self {
            Self::Linear => -ratio,
            Self::Quadratic => -(ratio + time) / 2.0,
            Self::Sinusoidal => time * (ratio / 2.0 - 1.0),
            Self::Logarithmic => logarithmic::whole_time_growth(slow, time),
        }
    }

    /// The displacement at `time`.
    #[cold]
    pub(super) fn displacement(self, slow: f64, time: f64) -> f64 {
        self.place(slow, time, |u| self.time(slow, u))
    }

    fn place(self, slow: f64, time: f64, time_of: impl Fn(f64) -> f64) -> f64 {
        // The speed is nowhere lower than at the start, so the displacement is at least this.
        let least = (slow * time).min(1.0);
        rising_root((least, 1.0), least, TOLERANCE, |u| (time_of(u) - time, 1.0 / (slow + self.speed(u))))
    }
}

#[cfg(test)]
mod tests {
    use core::cell::Cell;

    use super::OverDisplacement;

    /// A status report searches for a displacement, and on the chip an evaluation takes up to 0.2 ms.
    #[test]
    fn displacements_are_found_soon_and_well() {
        use OverDisplacement::{Linear, Logarithmic, Quadratic, Sinusoidal};
        for speed_profile in [Linear, Quadratic, Sinusoidal, Logarithmic] {
            for i in -40..10 {
                let slow = f64::from(i).mul_add(0.25, 0.1).exp2();
                for k in 1..200 {
                    let time = speed_profile.whole_time(slow) * f64::from(k) / 200.0;
                    let evaluations = Cell::new(0);
                    let u = speed_profile.place(slow, time, |u| {
                        evaluations.set(evaluations.get() + 1);
                        speed_profile.time(slow, u)
                    });
                    let off = (speed_profile.time(slow, u) / time - 1.0).abs();
                    assert!(
                        evaluations.get() <= 10,
                        "{speed_profile:?} {slow} {time}: {} evaluations",
                        evaluations.get()
                    );
                    assert!(off <= 3e-14, "{speed_profile:?} {slow} {time}: {off}");
                }
            }
        }
    }

    #[test]
    fn whole_times_grow_as_differences_do() {
        use OverDisplacement::{Linear, Logarithmic, Quadratic, Sinusoidal};
        for speed_profile in [Linear, Quadratic, Sinusoidal, Logarithmic] {
            for i in -40..40 {
                let slow = f64::from(i).mul_add(0.25, 0.1).exp2();
                let (step, time) = (1e-5, speed_profile.whole_time(slow));
                let beside = |ratio: f64| speed_profile.whole_time(slow * ratio);
                let difference = (beside(1.0 + step) - beside(1.0 - step)) / (2.0 * step);
                let growth = speed_profile.whole_time_growth(slow, time);
                assert!(
                    (growth - difference).abs() <= 1e-6 * time,
                    "{speed_profile:?} {slow}: {growth} and {difference}"
                );
            }
        }
    }
}
