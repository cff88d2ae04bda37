//! Hermite's quintic: the time over the displacement between two states of a ramp.

use libm::fabs;

use crate::ramp::State;

/// t = Σ c_i z^i, with z from 0 at one state to 1 at the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quintic {
    /// s.
    pub(super) coefficients: [f64; 6],
    /// Where z is 0, steps.
    pub(super) begin_steps: f64,
    /// What z counts, steps; below 0 if it counts backwards.
    pub(super) steps: f64,
}

impl Quintic {
    /// With the time, dt/dx = 1/v and d²t/dx² = -a/v³ of both states.
    pub(super) fn between(begin: &State, end: &State) -> Self {
        let steps = end.steps - begin.steps;
        let ((slope, bend), (end_slope, end_bend)) = (derivatives(begin, steps), derivatives(end, steps));
        // What the end has beyond the first three terms.
        let value = end.t_s - begin.t_s - slope - bend / 2.0;
        let more_slope = end_slope - slope - bend;
        let more_bend = end_bend - bend;
        let coefficients = [
            begin.t_s,
            slope,
            bend / 2.0,
            10.0 * value - 4.0 * more_slope + more_bend / 2.0,
            -15.0 * value + 7.0 * more_slope - more_bend,
            6.0 * value - 3.0 * more_slope + more_bend / 2.0,
        ];
        Self { coefficients, begin_steps: begin.steps, steps }
    }

    /// How far it strays from a ramp at most, s, if `middle` is the ramp's state about midway.
    ///
    /// It strays by (z - z²)³ d⁶t/dz⁶/720. If the sixth derivative is even about the middle, that is most there; if it is
    /// odd, nothing there, but its slope tells: the most is 0.12 of that.
    pub(super) fn stray_s(&self, middle: &State) -> f64 {
        let z = (middle.steps - self.begin_steps) / self.steps;
        let (mut time_s, mut slope) = (0.0, 0.0);
        for coefficient in self.coefficients.iter().rev() {
            slope = slope * z + time_s;
            time_s = time_s * z + coefficient;
        }
        fabs(time_s - middle.t_s) + fabs(slope - self.steps / middle.speed_steps_s) / 8.0
    }

    /// The greater dt/dz of the ends, without its sign.
    pub(super) fn slope_max(&self) -> f64 {
        let [_, c1, c2, c3, c4, c5] = self.coefficients;
        fabs(c1).max(fabs(c1 + 2.0 * c2 + 3.0 * c3 + 4.0 * c4 + 5.0 * c5))
    }

    /// The greatest d³t/dz³, without its sign; at most a little more.
    pub(super) fn third_derivative_max(&self) -> f64 {
        let [.., c3, c4, c5] = self.coefficients;
        let at = |z: f64| fabs(6.0 * c3 + z * (24.0 * c4 + z * (60.0 * c5)));
        // A parabola: a quarter beside the ends and the middle it may be 60 c5/4² beyond them.
        at(0.0).max(at(1.0)).max(at(0.5)) + fabs(3.75 * c5)
    }
}

/// dt/dz and d²t/dz².
fn derivatives(state: &State, steps: f64) -> (f64, f64) {
    let slope = steps / state.speed_steps_s;
    (slope, -slope * slope * state.accel_steps_s2 / state.speed_steps_s)
}
