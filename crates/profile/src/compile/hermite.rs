//! Hermite's polynomial of the seventh degree: the time as a function of the displacement between two states of a ramp.

use libm::fabs;

use crate::ramp::RampState;

/// The distance by which a polynomial may deviate from the speed profile, ticks: a quarter of what a segment may.
pub(super) const ERROR_MAX_TICKS: f64 = 1.0 / 32.0;

/// t = Σ c_i z^i, with z from 0 at one state to 1 at the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hermite {
    /// In s.
    pub(super) coefficients: [f64; TERMS],
    /// The place where z is 0, steps.
    pub(super) begin_steps: f64,
    /// The displacement from z = 0 to z = 1, steps; negative if it goes backwards.
    pub(super) steps: f64,
}

/// The last segment reaches beyond the end of a span by a quarter of the span at most. This z is halfway there.
const REACH_MIDDLE: f64 = 1.125;

/// Number of terms of the polynomial.
pub(super) const TERMS: usize = 8;

/// A state and its jerk, steps/s³. At a corner of the ramp there are two jerks; this is the one inside the span.
pub(super) type End<'a> = (&'a RampState, f64);

impl Hermite {
    /// The polynomial of no span.
    pub(super) const NONE: Self = Self { coefficients: [0.0; TERMS], begin_steps: 0.0, steps: 0.0 };

    /// The polynomial that has the time and its first three derivatives by the displacement at both ends.
    pub(super) fn between(begin: End, end: End) -> Self {
        let steps = end.0.steps - begin.0.steps;
        let ([slope, bend, twist], [end_slope, end_bend, end_twist]) =
            (derivatives(begin, steps), derivatives(end, steps));
        // What the values at the end exceed the first four terms by.
        let value = end.0.t_s - begin.0.t_s - slope - bend / 2.0 - twist / 6.0;
        let more_slope = end_slope - slope - bend - twist / 2.0;
        let more_bend = (end_bend - bend - twist) / 2.0;
        let more_twist = (end_twist - twist) / 6.0;
        let coefficients = [
            begin.0.t_s,
            slope,
            bend / 2.0,
            twist / 6.0,
            35.0 * value - 15.0 * more_slope + 5.0 * more_bend - more_twist,
            -84.0 * value + 39.0 * more_slope - 14.0 * more_bend + 3.0 * more_twist,
            70.0 * value - 34.0 * more_slope + 13.0 * more_bend - 3.0 * more_twist,
            -20.0 * value + 10.0 * more_slope - 4.0 * more_bend + more_twist,
        ];
        Self { coefficients, begin_steps: begin.0.steps, steps }
    }

    /// The greatest deviation from a ramp, s. `middle` is the ramp's state about midway.
    ///
    /// It deviates by (z - z²)⁴ d⁸t/dz⁸/8!. If the eighth derivative is an even function about the middle, the
    /// deviation is largest there. If it is an odd function, the deviation is zero there, but its slope shows how large
    /// it is: at most 0.10 of the slope.
    pub(super) fn error_s(&self, middle: &RampState) -> f64 {
        let z = (middle.steps - self.begin_steps) / self.steps;
        let (mut time_s, mut slope) = (0.0, 0.0);
        for coefficient in self.coefficients.iter().rev() {
            slope = slope * z + time_s;
            time_s = time_s * z + coefficient;
        }
        fabs(time_s - middle.t_s) + fabs(slope - self.steps / middle.speed_steps_s) / 8.0
    }

    /// The larger absolute dt/dz of both ends.
    pub(super) fn slope_max(&self) -> f64 {
        let [_, c1, c2, c3, c4, c5, c6, c7] = self.coefficients;
        fabs(c1).max(fabs(c1 + 2.0 * c2 + 3.0 * c3 + 4.0 * c4 + 5.0 * c5 + 6.0 * c6 + 7.0 * c7))
    }

    /// The largest absolute d³t/dz³ of three places: the beginning, the middle, and halfway to where the last segment
    /// may reach beyond the end. Otherwise it changes little over a span.
    pub(super) fn third_derivative_max(&self) -> f64 {
        let [.., c3, c4, c5, c6, c7] = self.coefficients;
        let at = |z: f64| fabs(6.0 * c3 + z * (24.0 * c4 + z * (60.0 * c5 + z * (120.0 * c6 + z * (210.0 * c7)))));
        fabs(6.0 * c3).max(at(0.5)).max(at(REACH_MIDDLE))
    }
}

/// dt/dz, d²t/dz² and d³t/dz³. With z = x/h they are h/v, -h² a/v³ and h³ (3 a²/v⁵ - j/v⁴).
fn derivatives((state, jerk_steps_s3): End, steps: f64) -> [f64; 3] {
    let per_speed = 1.0 / state.speed_steps_s;
    let slope = steps * per_speed;
    let bend = slope * per_speed * state.accel_steps_s2;
    [slope, -slope * bend, slope * (3.0 * bend * bend - slope * slope * per_speed * jerk_steps_s3)]
}

#[cfg(test)]
mod tests {
    use super::derivatives;
    use crate::ramp::RampState;

    /// The motion x = t³, whose time is the cube root of x, in spans of 2 steps.
    #[test]
    fn derivatives_are_those_of_a_cube_root() {
        for x in [0.5, 1.0, 8.0, 1e6] {
            let t = f64::cbrt(x);
            let state = RampState { t_s: t, steps: x, speed_steps_s: 3.0 * t * t, accel_steps_s2: 6.0 * t };
            let [first, second, third] = derivatives((&state, 6.0), 2.0);
            let is_near = |value: f64, wanted: f64| (value / wanted - 1.0).abs() < 1e-12;
            assert!(is_near(first, 2.0 * t / (3.0 * x)), "{first} at {x}");
            assert!(is_near(second, -4.0 * 2.0 * t / (9.0 * x * x)), "{second} at {x}");
            assert!(is_near(third, 8.0 * 10.0 * t / (27.0 * x * x * x)), "{third} at {x}");
        }
    }
}
