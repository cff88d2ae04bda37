//! Measures the repeatability of homing: homes one axis many times, each time from another position.

use isostep_console::Settings;
use isostep_motion::Axis;
use oorandom::Rand32;

use crate::config::Config;
use crate::executor::RunError;
use crate::sim::Sim;

/// Largest distance of a carriage from its zero before it homes, mm.
const AWAY_MAX_MM: f32 = 5.0;

/// The result of one homing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Latch {
    /// The place where the switch closed, steps from the switch's nominal position; negative is beyond it.
    pub closed_steps: i32,
    /// The place where the latch ended, steps from the switch's nominal position. The pull-off to zero counts from there.
    pub set_steps: i32,
}

impl Latch {
    /// Distance from the closing of the switch to the end of the latch, steps. The controller's reaction adds this.
    pub fn late_steps(&self) -> i32 {
        self.closed_steps - self.set_steps
    }
}

/// The reason why there are no results.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HomingError {
    /// The machine did not come to rest.
    #[error(transparent)]
    Run(#[from] RunError),
    /// It gave another answer than ok.
    #[error("latch {latch} of {axis}: the machine says `{reply}`")]
    Refused {
        /// Number of the latch, from 1.
        latch: u32,
        /// The axis.
        axis: Axis,
        /// The answer.
        reply: String,
    },
}

/// A copy of `config` with every switch at the low end of its axis if `negative`, otherwise at the high end (`$23`).
pub fn towards(config: &Config, negative: bool) -> Config {
    let homing_direction_mask = if negative { 0b111 } else { 0 };
    Config { settings: Settings { homing_direction_mask, ..config.settings }, ..config.clone() }
}

/// Homes `axis` `count` times on the machine of `config`.
///
/// # Errors
/// [`HomingError`].
pub fn latches(config: &Config, axis: Axis, count: u32) -> Result<Vec<Latch>, HomingError> {
    let mut sim = Sim::new(&Config { keep_record: false, ..config.clone() });
    let mut random = Rand32::new(config.seed);
    let homing = isostep_controller::config(&config.settings);
    let pull_off_steps = homing.steps(axis, homing.homing.pull_off_mm);
    let away = if homing.travel_steps(axis).start() < &0 { "-" } else { "" };
    sim.run_until_idle()?;
    sim.replies();
    let mut latches = Vec::new();
    for latch in 1..=count {
        if latch > 1 {
            let away_mm = random.rand_float() * AWAY_MAX_MM;
            sim.send(format!("G91 G0 {axis}{away}{away_mm:.3}\n").as_bytes());
            // Homing begins at rest.
            sim.run_until_idle()?;
        }
        sim.send(format!("$H{axis}\n").as_bytes());
        sim.run_until_idle()?;
        if let Some(reply) = sim.replies().into_iter().find(|reply| reply != "ok") {
            return Err(HomingError::Refused { latch, axis, reply });
        }
        let index = axis as usize;
        latches.push(Latch {
            closed_steps: sim.closed_at_steps()[index],
            set_steps: sim.places_steps()[index] - pull_off_steps,
        });
    }
    Ok(latches)
}
