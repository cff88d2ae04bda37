//! A carriage that oscillates: one mass on a damped spring, whose foot follows a profile.
//!
//! # Model
//! The displacement x of the mass from its foot obeys x'' + 2 ζ ω x' + ω² x = -a(t), with the natural frequency ω/2π,
//! the damping ratio ζ, and the acceleration a of the foot. It has one mode, is linear and has no noise: it shows what
//! the profile alone excites in a structure. It does not model a particular machine.
//!
//! # Method
//! While a changes linearly, the solution is known in closed form: x follows a straight line with a damped oscillation
//! about it. [`Oscillator::advance`] uses this form from one bend of a to the next. So the instants may be any distance
//! apart, and the only error is rounding.

use std::f64::consts::{PI, TAU};

use thiserror::Error;

/// Natural frequency and damping.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Oscillator {
    natural_hz: f64,
    damping_ratio: f64,
}

/// The reason why an oscillator was refused.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum OscillatorError {
    /// The natural frequency is not a positive number, Hz.
    #[error("natural frequency {asked} Hz must be a number above 0")]
    NaturalFrequency {
        /// The value asked for.
        asked: f64,
    },
    /// The damping is negative, or so strong that nothing oscillates.
    #[error("damping ratio {asked} is outside 0 to below 1: from 1 on nothing oscillates")]
    DampingRatio {
        /// The value asked for.
        asked: f64,
    },
}

/// The state of the mass, in the units of its foot's profile; at rest by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ringing {
    /// Displacement from its rest position on the foot.
    pub displacement: f64,
    /// Relative to the foot, per s.
    pub speed: f64,
}

impl Oscillator {
    /// An oscillator with the frequency `natural_hz` (above 0) when undamped. `damping_ratio` (0 to below 1) is the
    /// damping as a fraction of that which just prevents oscillation.
    ///
    /// # Errors
    /// The value that is out of range, with the range.
    pub fn new(natural_hz: f64, damping_ratio: f64) -> Result<Self, OscillatorError> {
        if !(natural_hz > 0.0 && natural_hz.is_finite()) {
            return Err(OscillatorError::NaturalFrequency { asked: natural_hz });
        }
        if !(0.0..1.0).contains(&damping_ratio) {
            return Err(OscillatorError::DampingRatio { asked: damping_ratio });
        }
        Ok(Self { natural_hz, damping_ratio })
    }

    /// Frequency of the undamped oscillation, Hz.
    pub fn natural_hz(&self) -> f64 {
        self.natural_hz
    }

    /// Damping as a fraction of that which just prevents oscillation.
    pub fn damping_ratio(&self) -> f64 {
        self.damping_ratio
    }

    /// The state `from` after `duration_s`, while the foot's acceleration changes linearly from `accel` to `accel_end`,
    /// per s².
    #[must_use]
    pub fn advance(&self, from: Ringing, duration_s: f64, accel: f64, accel_end: f64) -> Ringing {
        if duration_s <= 0.0 {
            return from;
        }
        let (w, z) = (TAU * self.natural_hz, self.damping_ratio);
        // The linear solution of the equation: x = level + slope t.
        let slope = -(accel_end - accel) / duration_s / (w * w);
        let level = -accel / (w * w) - 2.0 * z / w * slope;
        // The oscillation about it.
        let (x, v) = (from.displacement - level, from.speed - slope);
        let damped = w * (1.0 - z * z).sqrt();
        let (sin, cos) = (damped * duration_s).sin_cos();
        let decay = (-z * w * duration_s).exp();
        let quadrature = (v + z * w * x) / damped;
        Ringing {
            displacement: level + slope * duration_s + decay * (x * cos + quadrature * sin),
            speed: slope + decay * (v * cos - (w * w * x + z * w * v) / damped * sin),
        }
    }

    /// The acceleration of the mass relative to its foot, per s², while the foot's acceleration is `accel`. A sensor
    /// that measures the oscillation alone reads this.
    fn relative_accel(&self, at: Ringing, accel: f64) -> f64 {
        let w = TAU * self.natural_hz;
        -accel - 2.0 * self.damping_ratio * w * at.speed - w * w * at.displacement
    }

    /// The state after the foot has gone `distance` in no time: the mass stays where it is, and the damper gives it a push.
    #[must_use]
    pub fn shift(&self, from: Ringing, distance: f64) -> Ringing {
        let push = 2.0 * self.damping_ratio * TAU * self.natural_hz * distance;
        Ringing { displacement: from.displacement - distance, speed: from.speed + push }
    }

    /// The amplitude of the oscillation while the foot stands still: half the width of the band, narrowing from here on,
    /// that the mass swings in.
    pub fn amplitude(&self, at: Ringing) -> f64 {
        let (w, z) = (TAU * self.natural_hz, self.damping_ratio);
        let quadrature = (at.speed + z * w * at.displacement) / (w * (1.0 - z * z).sqrt());
        at.displacement.hypot(quadrature)
    }

    /// The least and the greatest displacement that the mass swings to on its own within `duration_s`, if it does: its
    /// first two turns. Each later one is nearer to rest.
    pub fn turns(&self, from: Ringing, duration_s: f64) -> impl Iterator<Item = f64> {
        let (w, z) = (TAU * self.natural_hz, self.damping_ratio);
        let damped = w * (1.0 - z * z).sqrt();
        // The speed is zero where tan of the damped angle is this.
        let angle = (from.speed * damped).atan2(w * w * from.displacement + z * w * from.speed).rem_euclid(PI);
        let turns_s = [angle / damped, (angle + PI) / damped];
        let (oscillator, is_within) = (*self, move |turn_s: &f64| *turn_s < duration_s);
        turns_s.into_iter().filter(is_within).map(move |turn_s| oscillator.advance(from, turn_s, 0.0, 0.0).displacement)
    }

    /// The relative acceleration at each of `instants_s`, which must not decrease. The foot's speed is linear between
    /// the corners `speeds`, (s, per s), and 0 before and after them. A speed above 0 at the first or the last corner
    /// is a jump, and so are two corners at the same instant.
    pub fn ring(&self, speeds: &[(f64, f64)], instants_s: &[f64]) -> Vec<f64> {
        let mut now = Driven { oscillator: self, mass: Ringing::default(), t_s: f64::NEG_INFINITY, foot: 0.0 };
        let mut left = speeds;
        let sample = |&t_s: &f64| {
            while let Some((&(corner_s, speed), rest)) = left.split_first().filter(|(corner, _)| corner.0 <= t_s) {
                now.move_to(corner_s, speed);
                left = rest;
                if rest.is_empty() {
                    now.jump(0.0);
                }
            }
            now.reading(t_s, left.first().copied())
        };
        instants_s.iter().map(sample).collect()
    }
}

/// A mass and its foot at one instant.
struct Driven<'a> {
    oscillator: &'a Oscillator,
    mass: Ringing,
    t_s: f64,
    /// The foot's speed.
    foot: f64,
}

impl Driven<'_> {
    /// Advances to a corner of the foot's speed: linearly, or by a jump from standstill or between corners at the same
    /// instant.
    fn move_to(&mut self, corner_s: f64, speed: f64) {
        if self.t_s == f64::NEG_INFINITY || corner_s <= self.t_s {
            self.jump(speed);
        } else {
            let accel = (speed - self.foot) / (corner_s - self.t_s);
            self.mass = self.oscillator.advance(self.mass, corner_s - self.t_s, accel, accel);
            self.foot = speed;
        }
        self.t_s = corner_s;
    }

    /// Changes the foot's speed in an instant. The speed of the mass relative to it changes by the opposite.
    fn jump(&mut self, speed: f64) {
        self.mass.speed -= speed - self.foot;
        self.foot = speed;
    }

    /// The relative acceleration at `t_s`, between the last corner and `next`.
    fn reading(&self, t_s: f64, next: Option<(f64, f64)>) -> f64 {
        if self.t_s == f64::NEG_INFINITY {
            return 0.0;
        }
        let accel = next.map_or(0.0, |(corner_s, speed)| (speed - self.foot) / (corner_s - self.t_s));
        let mass = self.oscillator.advance(self.mass, t_s - self.t_s, accel, accel);
        self.oscillator.relative_accel(mass, accel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(got: f64, wanted: f64, tolerance: f64) {
        assert!((got - wanted).abs() <= tolerance, "{got} is not {wanted} within {tolerance}");
    }

    /// From rest, undamped, with a constant acceleration a: x = -a/ω² (1 - cos ωt).
    #[test]
    fn a_step_of_acceleration_rings_about_its_place() {
        let oscillator = Oscillator::new(1.0 / TAU, 0.0).unwrap();
        for t_s in [0.5, 1.0, 3.0, 100.0] {
            let mass = oscillator.advance(Ringing::default(), t_s, 2.0, 2.0);
            close(mass.displacement, -2.0 * (1.0 - t_s.cos()), 1e-13);
            close(mass.speed, -2.0 * t_s.sin(), 1e-13);
            close(oscillator.relative_accel(mass, 2.0), -2.0 * t_s.cos(), 1e-13);
        }
    }

    /// After n periods, a free oscillation has decreased by exp(-2 pi n ζ/sqrt(1 - ζ²)): the logarithmic decrement.
    #[test]
    fn a_free_oscillation_decays_by_its_logarithmic_decrement() {
        let oscillator = Oscillator::new(45.0, 0.02).unwrap();
        let period_s = 1.0 / (45.0 * (1.0_f64 - 0.0004).sqrt());
        let after = oscillator.advance(Ringing { displacement: 1.0, speed: 0.0 }, 10.0 * period_s, 0.0, 0.0);
        close(after.displacement, (-TAU * 10.0 * 0.02 / (1.0_f64 - 0.0004).sqrt()).exp(), 1e-12);
        close(after.speed, 0.0, 1e-10);
    }

    /// One long step and a thousand short ones give the same result: no error accumulates.
    #[test]
    fn steps_may_be_of_any_length() {
        let oscillator = Oscillator::new(45.0, 0.02).unwrap();
        let whole = oscillator.advance(Ringing::default(), 0.7, 1.0, 8.0);
        let ramp = |k: u32| 1.0 + 7.0 * f64::from(k) / 1000.0;
        let parts = (0..1000).fold(Ringing::default(), |at, k| oscillator.advance(at, 0.7e-3, ramp(k), ramp(k + 1)));
        close(parts.displacement, whole.displacement, 1e-15);
        close(parts.speed, whole.speed, 1e-13);
    }

    /// Compared with the Runge-Kutta method in small steps.
    #[test]
    fn a_ramp_of_acceleration_solves_the_equation() {
        let (oscillator, accel) = (Oscillator::new(3.0, 0.3).unwrap(), |t_s: f64| 5.0 - 20.0 * t_s);
        let w = TAU * 3.0;
        let change = |t: f64, x: f64, v: f64| (v, -accel(t) - 0.6 * w * v - w * w * x);
        let (mut x, mut v, h) = (0.1, -0.2, 1e-4);
        for n in 0..5000 {
            let t = h * f64::from(n);
            let (x1, v1) = change(t, x, v);
            let (x2, v2) = change(t + h / 2.0, x + h / 2.0 * x1, v + h / 2.0 * v1);
            let (x3, v3) = change(t + h / 2.0, x + h / 2.0 * x2, v + h / 2.0 * v2);
            let (x4, v4) = change(t + h, x + h * x3, v + h * v3);
            x += h / 6.0 * (x1 + 2.0 * x2 + 2.0 * x3 + x4);
            v += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
        }
        let mass = oscillator.advance(Ringing { displacement: 0.1, speed: -0.2 }, 0.5, accel(0.0), accel(0.5));
        close(mass.displacement, x, 1e-11);
        close(mass.speed, v, 1e-10);
    }

    /// With a jump of the speed from 0 to v: x = -v/ω sin ωt, so x'' = v ω sin ωt.
    #[test]
    fn a_start_at_speed_rings_by_the_speed_times_the_frequency() {
        let oscillator = Oscillator::new(1.0 / TAU, 0.0).unwrap();
        let instants_s = [-1.0, 0.0, 0.5, 2.0, 3.0, 7.0];
        let readings = oscillator.ring(&[(0.0, 3.0), (3.0, 3.0)], &instants_s);
        let after = |t: f64| 3.0 * (t.sin() - (t - 3.0).sin());
        let wanted = [0.0, 0.0, 3.0 * 0.5_f64.sin(), 3.0 * 2.0_f64.sin(), after(3.0), after(7.0)];
        for (got, wanted) in readings.iter().zip(wanted) {
            close(*got, wanted, 1e-14);
        }
    }

    /// A ramp of one period leaves no oscillation: its end cancels what its start excites.
    #[test]
    fn a_ramp_of_one_period_leaves_nothing() {
        let oscillator = Oscillator::new(10.0, 0.0).unwrap();
        let readings = oscillator.ring(&[(0.0, 0.0), (0.1, 5.0), (1.0, 5.0), (1.05, 0.0)], &[0.05, 0.5, 0.9, 2.0]);
        close(readings[0], 50.0, 1e-9);
        close(readings[1], 0.0, 1e-9);
        close(readings[2], 0.0, 1e-9);
        assert!(readings[3].abs() > 1.0, "half a period rings most: {}", readings[3]);
    }

    /// A shift is the limit of a move with speed up and down again.
    #[test]
    fn a_shift_is_a_move_that_takes_no_time() {
        let oscillator = Oscillator::new(20.0, 0.1).unwrap();
        let from = Ringing { displacement: 0.3, speed: -7.0 };
        let (distance, half_s) = (0.02, 1e-7);
        let accel = distance / (half_s * half_s);
        let top = oscillator.advance(from, half_s, accel, accel);
        let moved = oscillator.advance(top, half_s, -accel, -accel);
        let shifted = oscillator.shift(from, distance);
        close(shifted.displacement, moved.displacement, 1e-5);
        close(shifted.speed, moved.speed, 1e-3);
    }

    /// The turns and the amplitude hold what a thousand instants of the swing show.
    #[test]
    fn no_instant_of_a_swing_is_beyond_its_turns_or_its_amplitude() {
        let oscillator = Oscillator::new(12.0, 0.08).unwrap();
        for (displacement, speed) in [(1.0, 0.0), (0.0, 90.0), (-0.4, 50.0), (0.7, 30.0), (-0.5, -60.0), (0.2, -80.0)] {
            for duration_s in [0.01, 0.03, 0.2] {
                let from = Ringing { displacement, speed };
                let at = |k: u32| oscillator.advance(from, duration_s * f64::from(k) / 1_000.0, 0.0, 0.0).displacement;
                let (low, high) =
                    (0..=1_000).map(at).fold((0.0_f64, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
                let found = oscillator.turns(from, duration_s).chain([displacement, at(1_000)]);
                let (least, most) = found.fold((0.0_f64, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
                close(least, low, 1e-4);
                close(most, high, 1e-4);
                assert!(high.max(-low) <= oscillator.amplitude(from) + 1e-12);
            }
        }
        let half_period_s = 0.5 / (12.0 * (1.0_f64 - 0.0064).sqrt());
        let turns: Vec<f64> = oscillator.turns(Ringing { displacement: 0.0, speed: 1.0 }, 1.0).collect();
        close(turns[1] / turns[0], -(-0.08 * TAU * 12.0 * half_period_s).exp(), 1e-12);
    }

    #[test]
    fn what_does_not_oscillate_is_refused() {
        for (natural_hz, damping_ratio, words) in [
            (0.0, 0.1, "above 0"),
            (f64::NAN, 0.1, "NaN Hz"),
            (f64::INFINITY, 0.1, "inf Hz"),
            (45.0, 1.0, "below 1"),
            (45.0, -0.1, "-0.1"),
            (45.0, f64::NAN, "NaN"),
        ] {
            let error = Oscillator::new(natural_hz, damping_ratio).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
