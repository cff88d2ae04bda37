//! A ramp from a slow to a fast speed. A decelerating ramp is an accelerating one seen backwards in time.

mod logarithmic;
mod mean_speed;
mod over_displacement;
mod over_time;
mod trig;

use self::over_displacement::OverDisplacement;
use self::over_time::OverTime;
use crate::fixed::is_zero;
use crate::speed_profile::SpeedProfile;
use crate::square_root::sqrt;

/// An accelerating ramp. Times and displacements count from its slow end and are clamped to the ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ramp {
    shape: Shape,
    slow_steps_s: f64,
    rise_steps_s: f64,
    steps: f64,
    duration_s: f64,
}

/// The way in which the speed of a ramp rises.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    ConstantAccel { accel_steps_s2: f64 },
    OverTime(OverTime),
    OverDisplacement(OverDisplacement),
}

/// The place of an axis at an instant of a ramp, and its motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RampState {
    pub(crate) t_s: f64,
    pub(crate) steps: f64,
    pub(crate) speed_steps_s: f64,
    pub(crate) accel_steps_s2: f64,
}

/// The speed profile and the limits of a ramp.
#[derive(Clone, Copy)]
pub(crate) struct RampLimits {
    speed_profile: SpeedProfile,
    pub(crate) accel_steps_s2: f64,
    jerk_steps_s3: f64,
    // The inverses of both limits. A search for a speed uses them often, and a division costs as much as three
    // products.
    per_accel: f64,
    per_jerk: f64,
}

impl RampLimits {
    pub(crate) fn new(speed_profile: SpeedProfile, accel_steps_s2: f64, jerk_steps_s3: f64) -> Self {
        Self {
            speed_profile,
            accel_steps_s2,
            jerk_steps_s3,
            per_accel: 1.0 / accel_steps_s2,
            per_jerk: 1.0 / jerk_steps_s3,
        }
    }

    /// The shortest ramp that rises by `rise_steps_s`.
    #[cold]
    pub(crate) fn shortest(&self, slow_steps_s: f64, rise_steps_s: f64) -> Ramp {
        let (slow, rise) = (slow_steps_s, rise_steps_s);
        let (shape, accel) = self.shape(rise);
        match shape {
            Shape::ConstantAccel { .. } => Ramp::constant_accel(slow, rise, accel, rise * (slow + rise / 2.0) / accel),
            Shape::OverTime(speed_profile) => {
                let duration_s = rise * speed_profile.peak() / accel;
                Ramp { shape, slow_steps_s, rise_steps_s, steps: (slow + rise / 2.0) * duration_s, duration_s }
            }
            Shape::OverDisplacement(speed_profile) => {
                let steps = speed_profile.length(slow, rise).0 * self.per_accel;
                let duration_s = steps / rise * speed_profile.whole_time(slow / rise);
                Ramp { shape, slow_steps_s, rise_steps_s, steps, duration_s }
            }
        }
    }

    /// The length of the shortest ramp, steps, and how much longer it is for each step/s more.
    #[cold]
    pub(crate) fn length(&self, slow: f64, rise: f64) -> (f64, f64) {
        let trapezoid = (rise * (slow + rise / 2.0) * self.per_accel, (slow + rise) * self.per_accel);
        match self.shape_of_speed_profile() {
            Shape::OverTime(OverTime::Sine) => {
                (trapezoid.0 * OverTime::Sine.peak(), trapezoid.1 * OverTime::Sine.peak())
            }
            Shape::OverTime(OverTime::SCurve { .. }) => self.s_curve_length(slow, rise),
            Shape::OverDisplacement(speed_profile) if rise > 0.0 => {
                let (length, growth) = speed_profile.length(slow, rise);
                (length * self.per_accel, growth * self.per_accel)
            }
            // Without a rise the length is 0 by every speed profile.
            Shape::ConstantAccel { .. } | Shape::OverDisplacement(..) => trapezoid,
        }
    }

    /// c and e, if the length of the shortest ramp is c rise (slow + e rise)/a.
    pub(crate) fn quadratic_length(&self) -> Option<(f64, f64)> {
        match self.shape_of_speed_profile() {
            Shape::OverTime(OverTime::Sine) => Some((OverTime::Sine.peak(), 0.5)),
            Shape::OverDisplacement(OverDisplacement::Linear) => Some((1.0, 1.0)),
            Shape::OverDisplacement(OverDisplacement::Quadratic) => Some((2.0, 1.0)),
            _ => None,
        }
    }

    /// The length of the shortest S-curve, and how much longer it is for each step/s more. The ramp lasts rise/a + a/j,
    /// or 2 √(rise/j) if the acceleration is not reached.
    fn s_curve_length(&self, slow: f64, rise: f64) -> (f64, f64) {
        let (duration_s, growth_s) = if self.reaches_accel(rise) {
            (rise * self.per_accel + self.accel_steps_s2 * self.per_jerk, self.per_accel)
        } else {
            let half_s = sqrt(rise * self.per_jerk);
            // Without a rise the growth has no bound, and no search asks for it.
            (2.0 * half_s, if rise > 0.0 { half_s / rise } else { 0.0 })
        };
        let mean = slow + rise / 2.0;
        (mean * duration_s, duration_s / 2.0 + mean * growth_s)
    }

    fn reaches_accel(&self, rise: f64) -> bool {
        rise > 0.0 && self.accel_steps_s2 * self.accel_steps_s2 <= self.jerk_steps_s3 * rise
    }

    /// The shape of the shortest ramp, and the acceleration it reaches.
    fn shape(&self, rise: f64) -> (Shape, f64) {
        match self.shape_of_speed_profile() {
            // A ramp without a rise may have any shape.
            _ if rise == 0.0 => (Shape::ConstantAccel { accel_steps_s2: self.accel_steps_s2 }, self.accel_steps_s2),
            Shape::OverTime(OverTime::SCurve { .. }) => self.s_curve(rise),
            shape => (shape, self.accel_steps_s2),
        }
    }

    fn shape_of_speed_profile(&self) -> Shape {
        shape(self.speed_profile, self.accel_steps_s2)
    }

    /// The shape of the shortest S-curve, and its highest acceleration. Each of its two jerks lasts a/j of rise/a +
    /// a/j, or half of the time if the acceleration a is not reached.
    fn s_curve(&self, rise: f64) -> (Shape, f64) {
        let (limit, per_time) = (self.accel_steps_s2, self.jerk_steps_s3 * rise);
        if !self.reaches_accel(rise) {
            return (Shape::OverTime(OverTime::SCurve { ratio: 0.5 }), sqrt(per_time));
        }
        let ratio = limit * limit / (per_time + limit * limit);
        // The jerk has no limit, or the limit does not matter.
        let shape = if ratio < REACH_RATIO_MIN {
            Shape::ConstantAccel { accel_steps_s2: limit }
        } else {
            Shape::OverTime(OverTime::SCurve { ratio })
        };
        (shape, limit)
    }
}

/// The shape of a speed profile's ramps; for an S-curve, that of jerk alone.
fn shape(speed_profile: SpeedProfile, accel_steps_s2: f64) -> Shape {
    match speed_profile {
        SpeedProfile::Trapezoid => Shape::ConstantAccel { accel_steps_s2 },
        SpeedProfile::SCurve => Shape::OverTime(OverTime::SCurve { ratio: 0.5 }),
        SpeedProfile::Sine => Shape::OverTime(OverTime::Sine),
        SpeedProfile::Linear => Shape::OverDisplacement(OverDisplacement::Linear),
        SpeedProfile::Quadratic => Shape::OverDisplacement(OverDisplacement::Quadratic),
        SpeedProfile::Sinusoidal => Shape::OverDisplacement(OverDisplacement::Sinusoidal),
        SpeedProfile::Logarithmic => Shape::OverDisplacement(OverDisplacement::Logarithmic),
    }
}

/// The delta v² that is possible over `steps` at this acceleration, from any speed, with speeds up to `top_steps_s`. It
/// is exact for the trapezoid, and a safe bound for the other speed profiles.
pub(crate) fn delta_v2(
    speed_profile: SpeedProfile,
    accel_steps_s2: f64,
    jerk_steps_s3: f64,
    steps: f64,
    top_steps_s: impl Fn() -> f64,
) -> f64 {
    // A sum takes a chip two thirds of the time of a product.
    let trapezoid = (accel_steps_s2 + accel_steps_s2) * steps;
    match speed_profile {
        SpeedProfile::Trapezoid => trapezoid,
        SpeedProfile::SCurve => s_curve_delta_v2(accel_steps_s2, jerk_steps_s3, steps, top_steps_s()),
        _ => curved_delta_v2(speed_profile, trapezoid),
    }
}

/// The delta v² by a speed profile whose acceleration is not limited by a jerk, if it is that high by the trapezoid.
#[cold]
fn curved_delta_v2(speed_profile: SpeedProfile, trapezoid: f64) -> f64 {
    match shape(speed_profile, 0.0) {
        Shape::ConstantAccel { .. } => trapezoid,
        Shape::OverTime(speed_profile) => trapezoid / speed_profile.peak() * LESS,
        Shape::OverDisplacement(speed_profile) => trapezoid / speed_profile.longest() * LESS,
    }
}

/// A ramp with rise r and mean speed m has a delta v² of 2 m r. It is m (r/a + a/j) long, or 2 m √(r/j). For a given
/// delta v² it is longest at the highest m.
#[cold]
fn s_curve_delta_v2(accel_steps_s2: f64, jerk_steps_s3: f64, steps: f64, top_steps_s: f64) -> f64 {
    let eases_s = accel_steps_s2 / jerk_steps_s3;
    let constant = 2.0 * accel_steps_s2 * (steps - top_steps_s * eases_s);
    let delta_v2 = if constant >= 2.0 * top_steps_s * accel_steps_s2 * eases_s {
        constant
    } else {
        steps * steps * jerk_steps_s3 / (2.0 * top_steps_s)
    };
    delta_v2 * LESS
}

/// A little less than 1, so that rounding cannot make a ramp too long.
const LESS: f64 = 1.0 - 1e-9;

/// A smaller fraction of the time counts as none, because rounding errors are as large.
const REACH_RATIO_MIN: f64 = 1e-12;

impl Ramp {
    /// No ramp, all zeros in memory. Its shape is the first one of the largest kind, because that is stored as 0.
    pub(crate) const NONE: Self = Self {
        shape: Shape::OverTime(OverTime::SCurve { ratio: 0.0 }),
        slow_steps_s: 0.0,
        rise_steps_s: 0.0,
        steps: 0.0,
        duration_s: 0.0,
    };

    pub(crate) fn constant_accel(slow_steps_s: f64, rise_steps_s: f64, accel_steps_s2: f64, steps: f64) -> Self {
        let duration_s = constant_accel_time_s(steps, slow_steps_s, accel_steps_s2);
        Self { shape: Shape::ConstantAccel { accel_steps_s2 }, slow_steps_s, rise_steps_s, steps, duration_s }
    }

    /// No ramp: at this speed, without a rise and without a length.
    pub(crate) fn none(speed_steps_s: f64) -> Self {
        Self::constant_accel(speed_steps_s, 0.0, 0.0, 0.0)
    }

    /// The ramp of constant acceleration between these speeds. `steps` is the distance that it takes at this
    /// acceleration.
    pub(crate) fn constant_accel_to(slow_steps_s: f64, fast_steps_s: f64, accel_steps_s2: f64, steps: f64) -> Self {
        if is_zero(steps) {
            return Self::none(slow_steps_s);
        }
        let (rise_steps_s, duration_s) = (fast_steps_s - slow_steps_s, 2.0 * steps / (slow_steps_s + fast_steps_s));
        Self { shape: Shape::ConstantAccel { accel_steps_s2 }, slow_steps_s, rise_steps_s, steps, duration_s }
    }

    /// A ramp of jerk alone with this rise: the first half has this jerk, the second half the negative of it.
    pub(crate) fn all_jerk(slow_steps_s: f64, rise_steps_s: f64, jerk_steps_s3: f64) -> Self {
        let shape = Shape::OverTime(OverTime::SCurve { ratio: 0.5 });
        let duration_s = 2.0 * sqrt(rise_steps_s / jerk_steps_s3);
        Self { shape, slow_steps_s, rise_steps_s, steps: (slow_steps_s + rise_steps_s / 2.0) * duration_s, duration_s }
    }

    /// A ramp between the same speeds with `ratio` of the length, at an acceleration that is 1/`ratio` times as high.
    pub(crate) fn shortened(self, ratio: f64) -> Self {
        let shape = match self.shape {
            Shape::ConstantAccel { accel_steps_s2 } => Shape::ConstantAccel { accel_steps_s2: accel_steps_s2 / ratio },
            other => other,
        };
        Self { shape, steps: self.steps * ratio, duration_s: self.duration_s * ratio, ..self }
    }

    pub(crate) fn steps(&self) -> f64 {
        self.steps
    }

    pub(crate) fn duration_s(&self) -> f64 {
        self.duration_s
    }

    pub(crate) fn slow_steps_s(&self) -> f64 {
        self.slow_steps_s
    }

    /// Its acceleration, if that is constant.
    pub(crate) fn constant_accel_steps_s2(&self) -> Option<f64> {
        match self.shape {
            Shape::ConstantAccel { accel_steps_s2 } => Some(accel_steps_s2),
            _ => None,
        }
    }

    /// The distance of its slow end from the place where it would stand still at its acceleration, steps; 0 for a curved ramp.
    pub(crate) fn lead_steps(&self) -> f64 {
        match self.shape {
            Shape::ConstantAccel { accel_steps_s2 } if accel_steps_s2 > 0.0 => {
                self.slow_steps_s * self.slow_steps_s / (2.0 * accel_steps_s2)
            }
            _ => 0.0,
        }
    }

    /// The instant at which it is at `steps`, s.
    pub(crate) fn time_at(&self, steps: f64) -> f64 {
        match self.shape {
            Shape::ConstantAccel { accel_steps_s2 } => {
                constant_accel_time_s(steps.max(0.0), self.slow_steps_s, accel_steps_s2)
            }
            _ => self.curved_time_at(steps),
        }
    }

    #[cold]
    fn curved_time_at(&self, steps: f64) -> f64 {
        match self.shape {
            _ if steps <= 0.0 => 0.0,
            _ if steps >= self.steps => self.duration_s,
            Shape::OverTime(speed_profile) => {
                let displacement = steps / (self.rise_steps_s * self.duration_s);
                self.duration_s * speed_profile.time(self.slow_steps_s / self.rise_steps_s, displacement)
            }
            Shape::OverDisplacement(speed_profile) => {
                let slow = self.slow_steps_s / self.rise_steps_s;
                self.displacement_s() * speed_profile.time(slow, steps / self.steps)
            }
            Shape::ConstantAccel { .. } => self.time_at(steps),
        }
    }

    /// The parameter of its speed profile, which is time, s, or displacement, steps, at `steps` or a little before. It counts
    /// from 0.
    pub(crate) fn parameter_before(&self, steps: f64) -> f64 {
        match self.shape {
            Shape::OverTime(speed_profile) => {
                let displacement = steps / (self.rise_steps_s * self.duration_s);
                self.duration_s * speed_profile.time_before(self.slow_steps_s / self.rise_steps_s, displacement)
            }
            _ => steps.min(self.steps),
        }
    }

    /// The parameter at the fast end.
    pub(crate) fn parameter_end(&self) -> f64 {
        if self.is_over_displacement() { self.steps } else { self.duration_s }
    }

    /// The parameter at which the jerk jumps next. The jumps are symmetrical, so this holds for a parameter counted
    /// from the fast end, too.
    pub(crate) fn next_corner(&self, parameter: f64) -> f64 {
        match self.shape {
            Shape::OverTime(speed_profile) => self.duration_s * speed_profile.next_corner(parameter / self.duration_s),
            _ => self.parameter_end(),
        }
    }

    /// The range of the parameter over which the speed would double, from `state` on and at the acceleration there.
    pub(crate) fn doubling(&self, state: &RampState) -> f64 {
        let doubling_s = state.speed_steps_s / state.accel_steps_s2;
        if self.is_over_displacement() { doubling_s * state.speed_steps_s } else { doubling_s }
    }

    /// Its state at a parameter.
    pub(crate) fn at_parameter(&self, parameter: f64) -> RampState {
        match self.shape {
            Shape::OverDisplacement(speed_profile) => self.over_displacement(speed_profile, parameter / self.steps),
            _ => self.at_time(parameter),
        }
    }

    fn is_over_displacement(&self) -> bool {
        matches!(self.shape, Shape::OverDisplacement(..))
    }

    /// Its state at `t_s`.
    pub(crate) fn at_time(&self, t_s: f64) -> RampState {
        let t_s = t_s.max(0.0).min(self.duration_s);
        match self.shape {
            Shape::ConstantAccel { accel_steps_s2 } => RampState {
                t_s,
                steps: t_s * (self.slow_steps_s + accel_steps_s2 * t_s / 2.0),
                speed_steps_s: self.slow_steps_s + accel_steps_s2 * t_s,
                accel_steps_s2,
            },
            Shape::OverTime(speed_profile) => self.over_time(speed_profile, t_s),
            Shape::OverDisplacement(speed_profile) => {
                let slow = self.slow_steps_s / self.rise_steps_s;
                let u = speed_profile.displacement(slow, t_s / self.displacement_s());
                RampState { t_s, ..self.over_displacement(speed_profile, u) }
            }
        }
    }

    #[cold]
    fn over_time(&self, speed_profile: OverTime, t_s: f64) -> RampState {
        let rise = self.rise_steps_s;
        let at = speed_profile.at(t_s / self.duration_s);
        RampState {
            t_s,
            steps: self.slow_steps_s * t_s + rise * self.duration_s * at.travel,
            speed_steps_s: self.slow_steps_s + rise * at.speed,
            accel_steps_s2: rise / self.duration_s * at.slope,
        }
    }

    #[cold]
    fn over_displacement(&self, speed_profile: OverDisplacement, u: f64) -> RampState {
        let rise = self.rise_steps_s;
        let speed_steps_s = self.slow_steps_s + rise * speed_profile.speed(u);
        RampState {
            t_s: self.displacement_s() * speed_profile.time(self.slow_steps_s / rise, u),
            steps: u * self.steps,
            speed_steps_s,
            // a = v dv/dx.
            accel_steps_s2: speed_steps_s * rise / self.steps * speed_profile.slope(u),
        }
    }

    /// Its jerk at `t_s`, steps/s³.
    pub(crate) fn jerk_at(&self, t_s: f64) -> f64 {
        let state = self.at_time(t_s);
        self.jerk(&state, if self.is_over_displacement() { state.steps } else { t_s })
    }

    /// Its jerk in `state`, steps/s³. Where the jerk jumps, it is the one on the side of `parameter`.
    #[cold]
    pub(crate) fn jerk(&self, state: &RampState, parameter: f64) -> f64 {
        match self.shape {
            Shape::ConstantAccel { .. } => 0.0,
            Shape::OverTime(speed_profile) => {
                let per_s = 1.0 / self.duration_s;
                self.rise_steps_s * per_s * per_s * speed_profile.bend(state.t_s * per_s, parameter * per_s)
            }
            Shape::OverDisplacement(speed_profile) => {
                let (speed, per_step) = (state.speed_steps_s, 1.0 / self.steps);
                let slope = state.accel_steps_s2 / speed;
                let bend = self.rise_steps_s * per_step * per_step * speed_profile.bend(state.steps * per_step);
                // a = v v', so da/dt = v (v'² + v v'').
                speed * (slope * slope + speed * bend)
            }
        }
    }

    /// The unit of time of a speed profile over displacement, s.
    fn displacement_s(&self) -> f64 {
        self.steps / self.rise_steps_s
    }
}

/// Time to cover `steps` from speed `v` at acceleration `a`: (sqrt(v² + 2 a x) - v)/a, written so that nothing
/// cancels and a = 0 is a plain cruise.
pub(crate) fn constant_accel_time_s(steps: f64, speed_steps_s: f64, accel_steps_s2: f64) -> f64 {
    if steps == 0.0 {
        return 0.0;
    }
    let end = sqrt(speed_steps_s * speed_steps_s + 2.0 * accel_steps_s2 * steps);
    2.0 * steps / (speed_steps_s + end)
}

#[cfg(test)]
mod tests {
    use super::RampLimits;
    use crate::speed_profile::SpeedProfile;

    /// By these speed profiles the peak of a short move is solved and not searched.
    #[test]
    fn lengths_of_some_speed_profiles_are_quadratics() {
        for speed_profile in SpeedProfile::ALL {
            let ramp_limits = RampLimits::new(speed_profile, 2e4, 1e6);
            let quadratic = ramp_limits.quadratic_length();
            assert_eq!(
                quadratic.is_some(),
                matches!(speed_profile.name(), "sine" | "linear" | "quadratic"),
                "{speed_profile}"
            );
            let Some((constant, square)) = quadratic else { continue };
            for (slow, rise) in [(0.0, 1e3), (1.0, 1e5), (1e4, 10.0)] {
                let wanted = constant * rise * (slow + square * rise) / 2e4;
                let (length, _) = ramp_limits.length(slow, rise);
                assert!((length / wanted - 1.0).abs() < 1e-12, "{speed_profile}, from {slow} up by {rise}: {length}");
            }
        }
    }
}
