//! A machine's settings and the moves it makes: as a script for the board, and as plans in closed form.

use anyhow::{Context, Result};
use isostep_console::Settings;
use isostep_controller::config;
use isostep_profile::SyncMove;

pub const AXES: usize = 3;
/// The most that `$120` takes, mm/s2.
const ACCEL_MAX_MM_S2: f64 = 1e5;
/// The settings that make up a [`Machine`], in an order in which none contradicts those before it.
const NUMBERS: [u16; 10] = [0, 110, 111, 112, 120, 121, 122, 910, 911, 912];

/// How an axis comes to its top speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ramp {
    /// From rest in this time, s, or as much longer as the highest acceleration that can be set takes.
    FromRest(f64),
    /// It starts and ends at its top speed.
    None,
}

/// A machine whose axes are all alike.
#[derive(Clone, Debug)]
pub struct Machine {
    settings: Settings,
}

/// Some moves of a machine, from where it stands at power-up.
#[derive(Clone, Debug)]
pub struct Trial {
    machine: Machine,
    /// Signed steps of each move.
    moves: Vec<[i32; AXES]>,
}

impl Machine {
    /// All axes go at `rate_steps_s` at most, with the shortest pulses that the driver takes.
    pub fn new(rate_steps_s: u32, ramp: Ramp) -> Self {
        let settings = Settings::default();
        let mm_s = f64::from(rate_steps_s) / f64::from(settings.steps_per_mm[0]);
        let (accel_mm_s2, start_mm_s) = match ramp {
            Ramp::FromRest(ramp_s) => ((mm_s / ramp_s).min(ACCEL_MAX_MM_S2), 0.0),
            Ramp::None => (ACCEL_MAX_MM_S2, mm_s),
        };
        let mm_min = |mm_s: f64| [(mm_s * 60.0) as f32; AXES];
        Self {
            settings: Settings {
                pulse_us: 0,
                max_rate_mm_min: mm_min(mm_s),
                start_rate_mm_min: mm_min(start_mm_s),
                accel_mm_s2: [accel_mm_s2 as f32; AXES],
                ..settings
            },
        }
    }

    /// Steps of a move that cruises for `cruise_s` between its ramps: whole millimetres, which a float tells apart.
    pub fn steps_of(&self, cruise_s: f64) -> i32 {
        let limits = config(&self.settings).limits[0];
        let ramp_s = (limits.top_speed_steps_s - limits.start_speed_steps_s) / limits.accel_steps_s2;
        let steps_per_mm = f64::from(self.settings.steps_per_mm[0]);
        let mm = (limits.top_speed_steps_s * (ramp_s + cruise_s) / steps_per_mm).round();
        (mm.max(1.0) * steps_per_mm) as i32
    }

    /// The lines that set it, each answered `ok`.
    pub fn set_up(&self) -> String {
        let value = |number| self.settings.get(number).expect("the numbers are those of settings");
        let lines = NUMBERS.map(|number| format!("send ${number}={}\nexpect ok\n", value(number)));
        format!("expect Grbl\n{}", lines.concat())
    }

    /// The line that goes to `steps` as fast as it may.
    pub fn rapid(&self, steps: [i32; AXES]) -> String {
        let mm = |axis: usize| f64::from(steps[axis]) / f64::from(self.settings.steps_per_mm[axis]);
        format!("G0 X{} Y{} Z{}", mm(0), mm(1), mm(2))
    }
}

impl Trial {
    /// `steps` on each of the first `axes` axes, there and, if asked, back again.
    pub fn new(machine: Machine, axes: usize, steps: i32, and_back: bool) -> Self {
        let there = std::array::from_fn(|axis| if axis < axes { steps } else { 0 });
        let moves = if and_back { vec![there, there.map(|n| -n)] } else { vec![there] };
        Self { machine, moves }
    }

    /// What the sender does.
    pub fn script(&self) -> String {
        let mut at = [0; AXES];
        let mut script = self.machine.set_up();
        for steps in &self.moves {
            at = std::array::from_fn(|axis| at[axis] + steps[axis]);
            script += &format!("send {}\nexpect ok\n", self.machine.rapid(at));
        }
        script + "wait-idle\n"
    }

    /// What the firmware has to make of it.
    pub fn plans(&self) -> Result<Vec<SyncMove<AXES>>> {
        let config = config(&self.machine.settings);
        let plan = |&steps| SyncMove::plan(steps, &config.limits, config.law, None);
        self.moves.iter().map(plan).collect::<Result<_, _>>().context("the benchmark's move cannot be planned")
    }

    /// Machine time of the moves themselves, s.
    pub fn duration_s(&self) -> Result<f64> {
        Ok(self.plans()?.iter().map(|plan| plan.profile.duration_s()).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_is_the_same_to_the_board_and_to_the_closed_form() {
        let machine = Machine::new(30_000, Ramp::FromRest(0.2));
        let steps = machine.steps_of(0.3);
        assert_eq!(steps, 15_000, "0.2 s of ramps' worth and 0.3 s of cruise");
        let trial = Trial::new(machine, 2, steps, true);
        let script = trial.script();
        for line in ["send $110=36000", "send $121=3000", "send $912=0", "send G0 X300 Y300 Z0", "send G0 X0 Y0 Z0"] {
            assert!(script.lines().any(|each| each == line), "{line} in {script}");
        }
        let plans = trial.plans().unwrap();
        assert_eq!(
            plans.iter().map(|plan| plan.steps).collect::<Vec<_>>(),
            [[15_000, 15_000, 0], [-15_000, -15_000, 0]]
        );
        assert!((trial.duration_s().unwrap() - 1.4).abs() < 1e-9);
    }

    #[test]
    fn acceleration_stays_within_what_the_setting_takes() {
        let machine = Machine::new(4_000_000, Ramp::FromRest(0.2));
        assert!(machine.set_up().contains("$120=100000\n"));
        assert_eq!(machine.steps_of(0.2), 4_000_000, "0.8 s ramps");
    }

    #[test]
    fn without_ramps_all_the_way_is_cruised() {
        let machine = Machine::new(10_000, Ramp::None);
        assert_eq!(machine.steps_of(1.0), 10_000);
        let trial = Trial::new(machine, 3, 10_000, false);
        assert!((trial.duration_s().unwrap() - 1.0).abs() < 1e-9);
    }
}
