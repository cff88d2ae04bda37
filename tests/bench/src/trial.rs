//! A machine's settings and its moves, as a script for the board and as plans in closed form.

use anyhow::{Context, Result};
use isostep_console::Settings;
use isostep_controller::config;
use isostep_profile::SyncMove;

pub const AXES: usize = 3;
/// With this resolution millions of steps are within the 10 m that a target may be from zero, and a position in
/// thousandths of a mm is one of whole steps.
pub const STEPS_PER_MM: f64 = 1_000.0;
/// Acceleration of the fastest machines, steps/s2: 1,000,000 steps/s in 0.2 s.
pub const ACCEL_MAX_STEPS_S2: f64 = 5e6;
/// An eighth of a millimetre, which binary fractions hold exactly.
pub const UNIT_STEPS: i32 = 125;
/// The settings of a [`Machine`], in an order in which none contradicts an earlier one: the default top speed is valid
/// with any resolution once the pulse is short.
const NUMBERS: [u16; 10] = [0, 100, 101, 102, 110, 111, 112, 120, 121, 122];

/// A machine whose axes all have the same settings.
#[derive(Clone, Debug)]
pub struct Machine {
    settings: Settings,
}

/// Moves of a machine, starting where it stands at power-up.
#[derive(Clone, Debug)]
pub struct Trial {
    machine: Machine,
    /// Signed steps of each move.
    moves: Vec<[i32; AXES]>,
}

impl Machine {
    /// A machine whose axes reach `rate_steps_s` in `ramp_s`, or later if that would exceed [`ACCEL_MAX_STEPS_S2`]. The
    /// pulses are the shortest that the driver accepts.
    pub fn new(rate_steps_s: u32, ramp_s: f64) -> Self {
        let rate_steps_s = f64::from(rate_steps_s);
        let accel_steps_s2 = (rate_steps_s / ramp_s).min(ACCEL_MAX_STEPS_S2);
        Self {
            settings: Settings {
                pulse_us: 0,
                steps_per_mm: [STEPS_PER_MM as f32; AXES],
                max_rate_mm_min: [(rate_steps_s / STEPS_PER_MM * 60.0) as f32; AXES],
                accel_mm_s2: [(accel_steps_s2 / STEPS_PER_MM) as f32; AXES],
                ..Settings::default()
            },
        }
    }

    /// Steps of a move that cruises for about `cruise_s` between its ramps.
    pub fn steps_of(&self, cruise_s: f64) -> i32 {
        let limits = config(&self.settings).limits[0];
        let ramp_s = limits.top_speed_steps_s / limits.accel_steps_s2;
        let units = (limits.top_speed_steps_s * (ramp_s + cruise_s) / f64::from(UNIT_STEPS)).round();
        units.max(1.0) as i32 * UNIT_STEPS
    }

    /// Script commands that send the settings. Each is answered `ok`.
    pub fn set_up(&self) -> String {
        let value = |number| self.settings.get(number).expect("the numbers are those of settings");
        let lines = NUMBERS.map(|number| format!("send ${number}={}\nexpect ok\n", value(number)));
        format!("expect Grbl\n{}", lines.concat())
    }

    /// The line that moves to `steps` as fast as possible.
    pub fn rapid(&self, steps: [i32; AXES]) -> String {
        let mm = |axis: usize| f64::from(steps[axis]) / STEPS_PER_MM;
        format!("G0 X{} Y{} Z{}", mm(0), mm(1), mm(2))
    }
}

impl Trial {
    /// A move of `steps` on each of the first `axes` axes and, if `and_back`, the move back.
    pub fn new(machine: Machine, axes: usize, steps: i32, and_back: bool) -> Self {
        let there = std::array::from_fn(|axis| if axis < axes { steps } else { 0 });
        let moves = if and_back { vec![there, there.map(|n| -n)] } else { vec![there] };
        Self { machine, moves }
    }

    /// These moves, each in steps relative to the end of the previous one.
    pub fn of(machine: Machine, moves: Vec<[i32; AXES]>) -> Self {
        Self { machine, moves }
    }

    /// The script for the sender.
    pub fn script(&self) -> String {
        let mut at = [0; AXES];
        let mut script = self.machine.set_up();
        for steps in &self.moves {
            at = std::array::from_fn(|axis| at[axis] + steps[axis]);
            script += &format!("send {}\nexpect ok\n", self.machine.rapid(at));
        }
        script + "wait-idle\n"
    }

    /// The plans that the firmware should make of the script.
    pub fn plans(&self) -> Result<Vec<SyncMove<AXES>>> {
        let config = config(&self.machine.settings);
        let plan = |&steps| SyncMove::plan(steps, &config.limits, config.interval_law, config.speed_law, None);
        self.moves.iter().map(plan).collect::<Result<_, _>>().context("the benchmark's move cannot be planned")
    }

    /// Total machine time of the moves, s.
    pub fn duration_s(&self) -> Result<f64> {
        Ok(self.plans()?.iter().map(|plan| plan.profile.duration_s()).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_is_the_same_to_the_board_and_to_the_closed_form() {
        let machine = Machine::new(30_000, 0.2);
        let steps = machine.steps_of(0.3);
        assert_eq!(steps, 15_000, "0.2 s of ramps' worth and 0.3 s of cruise");
        let trial = Trial::new(machine, 2, steps, true);
        let script = trial.script();
        for line in ["send $110=1800", "send $121=150", "send G0 X15 Y15 Z0", "send G0 X0 Y0 Z0"] {
            assert!(script.lines().any(|each| each == line), "{line} in {script}");
        }
        let plans = trial.plans().unwrap();
        let steps: Vec<_> = plans.iter().map(|plan| plan.steps).collect();
        assert_eq!(steps, [[15_000, 15_000, 0], [-15_000, -15_000, 0]]);
        assert!((trial.duration_s().unwrap() - 1.4).abs() < 1e-9);
    }

    #[test]
    fn acceleration_is_bounded() {
        let machine = Machine::new(4_000_000, 0.2);
        assert!(machine.set_up().contains("$120=5000\n"));
        assert_eq!(machine.steps_of(0.2), 4_000_000, "0.8 s ramps");
    }

    #[test]
    fn a_long_move_is_within_reach() {
        let machine = Machine::new(1_000_000, 0.2);
        let mm = f64::from(machine.steps_of(9.6)) / STEPS_PER_MM;
        assert!(mm <= 10_000.0, "{mm}");
    }
}
