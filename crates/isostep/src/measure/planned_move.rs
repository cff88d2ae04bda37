//! The moves that are measured: the settings that a board gets for them, the lines that it is sent, and, computed here
//! from the same settings, when the closed form has each edge.

use std::cell::OnceCell;
use std::rc::Rc;

use anyhow::{Context, Result};
use isostep_console::{AXES, Settings};
use isostep_controller::config;
use isostep_profile::SyncMove;

use crate::chip::Chip;

/// The axes that are measured.
pub const PROVED: usize = 3;
/// Their names.
pub const NAMES: [&str; PROVED] = ["X", "Y", "Z"];
/// With this resolution a place in thousandths of a millimetre is a whole step.
pub const STEPS_PER_MM: f64 = 1_000.0;
/// Steps are multiples of this, an eighth of a millimetre, which binary fractions hold exactly.
pub const UNIT_STEPS: i32 = 125;

/// The ramps of a measurement's moves.
#[derive(Clone, Copy, Debug)]
pub struct Ramp {
    /// Time from rest to the rate, s. It is longer where it would need more than the highest acceleration.
    pub s: f64,
    /// The highest acceleration, steps/s2.
    pub accel_max_steps_s2: f64,
}

/// A machine whose three axes have the same limits.
#[derive(Clone, Debug)]
pub struct Machine {
    settings: Settings,
}

impl From<Settings> for Machine {
    fn from(settings: Settings) -> Self {
        Self { settings }
    }
}

impl Machine {
    /// A machine whose axes reach the rate by this ramp. Its pulses are as short as the image's driver takes.
    pub fn new(rate_steps_s: u32, ramp: Ramp) -> Self {
        let rate_steps_s = f64::from(rate_steps_s);
        let accel_steps_s2 = (rate_steps_s / ramp.s).min(ramp.accel_max_steps_s2);
        let settings = Settings {
            pulse_us: 0,
            soft_limits: false,
            hard_limits: true,
            steps_per_mm: [STEPS_PER_MM as f32; AXES],
            max_rate_mm_min: [(rate_steps_s / STEPS_PER_MM * 60.0) as f32; AXES],
            accel_mm_s2: [(accel_steps_s2 / STEPS_PER_MM) as f32; AXES],
            ..Settings::default()
        };
        Self { settings }
    }

    /// The lines that make the board this machine, in an order in which none contradicts an earlier one: the top speed
    /// is above what the pulse of the default driver allows, so the pulse comes first.
    pub fn lines(&self) -> Vec<String> {
        let per_axis = [100, 110, 120].into_iter().flat_map(|number| (number..).take(PROVED));
        let numbers = [0, 20, 21].into_iter().chain(per_axis);
        numbers.map(|number| format!("${number}={}", self.settings.get(number).unwrap_or_default())).collect()
    }

    /// Steps of a move that cruises for about so long between its ramps.
    pub fn steps_of(&self, cruise_s: f64) -> i32 {
        let limits = config(&self.settings).limits[0];
        let ramp_s = limits.top_speed_steps_s / limits.accel_steps_s2;
        let steps = limits.top_speed_steps_s * (ramp_s + cruise_s);
        (steps / f64::from(UNIT_STEPS)).round().max(1.0) as i32 * UNIT_STEPS
    }

    /// A move of the first `axes` axes by the same distance, which cruises for about so long between its ramps.
    ///
    /// # Errors
    /// When it cannot be planned.
    pub fn straight(&self, axes: usize, cruise_s: f64) -> Result<PlannedMove> {
        let steps = self.steps_of(cruise_s);
        self.planned(std::array::from_fn(|axis| if axis < axes { steps } else { 0 }))
    }

    /// A move of so many steps, from rest to rest.
    ///
    /// # Errors
    /// When it cannot be planned.
    pub fn planned(&self, steps: [i32; PROVED]) -> Result<PlannedMove> {
        let all = std::array::from_fn(|axis| steps.get(axis).copied().unwrap_or(0));
        let config = config(&self.settings);
        let plan = SyncMove::plan(all, &config.limits, config.interval_split, config.speed_profile, None);
        let plan = plan.with_context(|| format!("a move of {steps:?} steps cannot be planned"))?;
        Ok(PlannedMove { steps, compiled: Rc::default(), plan })
    }
}

/// A move, as a line for the board and as instants in closed form.
#[derive(Clone, Debug)]
pub struct PlannedMove {
    /// Signed steps of each axis.
    pub steps: [i32; PROVED],
    plan: SyncMove<AXES>,
    /// The cycle of each step of each axis, from the start of the move, as each chip compiles them: once somebody asks.
    compiled: Rc<[[OnceCell<Vec<u64>>; PROVED]; Chip::ALL.len()]>,
}

impl PlannedMove {
    /// The line that makes the move from where the machine stands.
    pub fn line(&self) -> String {
        let words = NAMES.iter().zip(self.steps).filter(|(_, steps)| *steps != 0);
        words.fold("G91 G0".to_owned(), |line, (name, steps)| {
            line + &format!(" {name}{}", f64::from(steps) / STEPS_PER_MM)
        })
    }

    /// The same move back.
    pub fn back(&self) -> Self {
        // A move and the same move back mirror each other, so every step has its instant.
        let mut plan = self.plan;
        plan.steps = plan.steps.map(|steps| -steps);
        Self { steps: self.steps.map(|steps| -steps), plan, compiled: self.compiled.clone() }
    }

    /// Edges of all axes.
    pub fn edges(&self) -> u64 {
        self.steps.iter().map(|steps| u64::from(steps.unsigned_abs())).sum()
    }

    /// Steps of an axis, in either direction.
    pub fn count(&self, axis: usize) -> u32 {
        self.steps[axis].unsigned_abs()
    }

    /// When step `number` of an axis, counted from 1, is due, ns from the start of the move.
    pub fn due_ns(&self, axis: usize, number: u32) -> f64 {
        self.plan.step_time_s(axis, number) * 1e9
    }

    /// When step `number` of an axis, counted from 1, leaves, ns from the start of the move, as this chip compiles it: a
    /// few quadratics that are at most 24 ns off the closed form, on whole cycles of its clock.
    pub fn compiled_ns(&self, chip: Chip, axis: usize, number: u32) -> f64 {
        let cycles = || self.plan.segments(axis, chip.clock_hz()).flat_map(|segment| segment.ticks()).collect();
        let cycle = self.compiled[chip as usize][axis].get_or_init(cycles).get(number as usize - 1);
        cycle.map_or_else(|| self.due_ns(axis, number), |cycle| *cycle as f64 * chip.cycle_ns())
    }

    /// The duration of the move, s.
    pub fn duration_s(&self) -> f64 {
        self.plan.profile.duration_s()
    }

    /// The number of steps of an axis that are due in the first `t_s`.
    pub fn steps_by(&self, axis: usize, t_s: f64) -> u32 {
        self.plan.steps_before(axis, self.plan.place_at(t_s.clamp(0.0, self.duration_s())))
    }

    /// The profile that all axes share.
    pub fn profile(&self) -> &isostep_profile::Profile {
        &self.plan.profile
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_move_is_the_same_to_the_board_and_to_the_closed_form() {
        let machine = Machine::new(100_000, Ramp { s: 0.02, accel_max_steps_s2: 2e7 });
        let lines = machine.lines();
        for line in ["$0=0", "$21=1", "$102=1000", "$110=6000", "$121=5000"] {
            assert!(lines.iter().any(|each| each == line), "{line} in {lines:?}");
        }
        let steps = machine.steps_of(0.01);
        assert_eq!(steps, 3_000);
        let planned = machine.planned([steps, -steps, 0]).unwrap();
        assert_eq!((planned.line(), planned.back().line()), ("G91 G0 X3 Y-3".to_owned(), "G91 G0 X-3 Y3".to_owned()));
        // Half a step from rest at 5,000,000 steps/s2.
        assert!((planned.due_ns(1, 1) - (1.0 / 5e6_f64).sqrt() * 1e9).abs() < 0.01);
        assert!((planned.duration_s() - 0.05).abs() < 1e-9);
        assert_eq!((planned.steps_by(0, 0.02), planned.steps_by(0, 1.0)), (1_000, 3_000));
    }

    #[test]
    fn acceleration_is_bounded_and_a_long_move_is_within_reach() {
        let fast = |rate| Machine::new(rate, Ramp { s: 0.2, accel_max_steps_s2: 5e6 });
        assert!(fast(4_000_000).lines().contains(&"$120=5000".to_owned()));
        assert_eq!(fast(4_000_000).steps_of(0.2), 4_000_000, "0.8 s ramps");
        let mm = f64::from(fast(1_000_000).steps_of(9.6)) / STEPS_PER_MM;
        assert!(mm <= 10_000.0, "{mm}");
    }
}
