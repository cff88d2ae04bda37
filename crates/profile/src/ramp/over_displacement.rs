//! Ramps whose speed is a function of the displacement, in a unit square (paper 000): speed v from 0 to 1 above `slow`,
//! which is above 0, displacement u from 0 to 1.

use core::f64::consts::PI;

use libm::{atan, log1p};

use super::logarithmic::{self, Pole};
use super::trig::sin_cos;
use crate::newton::rising_root;
use crate::root::sqrt;

/// Of a search for a displacement: Newton's method doubles the digits, so that the result is as good as floats are.
const TOLERANCE: f64 = 1e-8;

/// The law of a ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum OverDisplacement {
    /// v = u (paper 000, eq 5).
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

    /// The length of a ramp of `rise` that just reaches an acceleration of 1, and how much longer for each step/s more: the
    /// most that (slow + rise v) rise v' becomes, and its slope over `rise`.
    pub(super) fn length(self, slow: f64, rise: f64) -> (f64, f64) {
        match self {
            Self::Linear => (rise * (slow + rise), slow + 2.0 * rise),
            Self::Quadratic => (2.0 * rise * (slow + rise), 2.0 * (slow + 2.0 * rise)),
            Self::Sinusoidal => {
                // Where d/du is 0, with m = slow/rise + 1/2: cos² πu - m cos πu - 1/2 = 0.
                let m = slow / rise + 0.5;
                let cosine = -1.0 / (m + sqrt(m * m + 2.0));
                let slope = PI / 2.0 * sqrt(1.0 - cosine * cosine);
                let peak = rise * (m - cosine / 2.0) * slope;
                // The peak's place does not move it.
                (rise * peak, 2.0 * peak - slow * slope)
            }
            Self::Logarithmic => logarithmic::length(Pole::new(slow / rise), slow, rise),
        }
    }

    /// How many times as long as one of constant acceleration a ramp is at most, whatever its speeds: of the logarithm where
    /// it begins fast, of the others where it begins at standstill.
    pub(super) fn longest(self) -> f64 {
        match self {
            Self::Linear => 2.0,
            Self::Quadratic => 4.0,
            // (1 - cos πu) sin πu π/2 at cos πu = -1/2: √27 π/8.
            Self::Sinusoidal => 2.040_524_284_763_495,
            Self::Logarithmic => logarithmic::slope(0.0),
        }
    }

    /// How long it takes to `u`: ∫ du/(slow + v).
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

    /// How long it takes to the end.
    pub(super) fn whole_time(self, slow: f64) -> f64 {
        match self {
            Self::Sinusoidal => 1.0 / sqrt(slow * (slow + 1.0)),
            Self::Logarithmic => logarithmic::whole_time(Pole::new(slow)),
            _ => self.time(slow, 1.0),
        }
    }

    /// Length and time, each with its slope: what a law computes for both it computes once.
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

    /// By what it shrinks for each share that `slow` grows by: `slow` times the slope of `whole_time`, which is
    /// `time` there, over `slow`.
    pub(super) fn whole_time_growth(self, slow: f64, time: f64) -> f64 {
        let ratio = 1.0 / (slow + 1.0);
        match self {
            Self::Linear => -ratio,
            Self::Quadratic => -(ratio + time) / 2.0,
            Self::Sinusoidal => time * (ratio / 2.0 - 1.0),
            Self::Logarithmic => logarithmic::whole_time_growth(slow, time),
        }
    }

    /// Where it is at `time`.
    pub(super) fn displacement(self, slow: f64, time: f64) -> f64 {
        self.place(slow, time, |u| self.time(slow, u))
    }

    fn place(self, slow: f64, time: f64, time_of: impl Fn(f64) -> f64) -> f64 {
        // No slower than at the start.
        let least = (slow * time).min(1.0);
        rising_root((least, 1.0), least, TOLERANCE, |u| (time_of(u) - time, 1.0 / (slow + self.speed(u))))
    }
}

#[cfg(test)]
mod tests {
    use core::cell::Cell;

    use super::OverDisplacement;

    /// A status report looks for one: on the chip an evaluation takes up to 0.2 ms.
    #[test]
    fn displacements_are_found_soon_and_well() {
        use OverDisplacement::{Linear, Logarithmic, Quadratic, Sinusoidal};
        for law in [Linear, Quadratic, Sinusoidal, Logarithmic] {
            for i in -40..10 {
                let slow = f64::from(i).mul_add(0.25, 0.1).exp2();
                for k in 1..200 {
                    let time = law.whole_time(slow) * f64::from(k) / 200.0;
                    let evaluations = Cell::new(0);
                    let u = law.place(slow, time, |u| {
                        evaluations.set(evaluations.get() + 1);
                        law.time(slow, u)
                    });
                    let off = (law.time(slow, u) / time - 1.0).abs();
                    assert!(evaluations.get() <= 10, "{law:?} {slow} {time}: {} evaluations", evaluations.get());
                    assert!(off <= 3e-14, "{law:?} {slow} {time}: {off}");
                }
            }
        }
    }

    #[test]
    fn whole_times_grow_as_differences_do() {
        use OverDisplacement::{Linear, Logarithmic, Quadratic, Sinusoidal};
        for law in [Linear, Quadratic, Sinusoidal, Logarithmic] {
            for i in -40..40 {
                let slow = f64::from(i).mul_add(0.25, 0.1).exp2();
                let (step, time) = (1e-5, law.whole_time(slow));
                let beside = |ratio: f64| law.whole_time(slow * ratio);
                let difference = (beside(1.0 + step) - beside(1.0 - step)) / (2.0 * step);
                let growth = law.whole_time_growth(slow, time);
                assert!((growth - difference).abs() <= 1e-6 * time, "{law:?} {slow}: {growth} and {difference}");
            }
        }
    }
}
