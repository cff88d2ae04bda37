//! What of the machine is as its settings say: its motors, its resolution, its end stops and its wiring.

use isostep_motion::{AXES, Config, Direction};

use crate::motor::PullOutCurve;

/// From a limit switch to the end stop behind it, and from the far end of the travel to the one there, mm.
const END_STOP_MARGIN_MM: f64 = 3.0;

/// What follows the settings when they change: whoever changes them has built another machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mechanics {
    /// Microsteps that move a carriage by a millimetre.
    pub steps_per_mm: [f64; AXES],
    /// The motors.
    pub motors: [PullOutCurve; AXES],
    /// The end stops, steps from where the limit switch closes.
    pub end_stops_steps: [(i32, i32); AXES],
}

impl Mechanics {
    /// Those of a machine that `config` describes, with `motor` for every axis; without one, each axis has one that fits.
    pub fn of(config: &Config, motor: Option<PullOutCurve>) -> Self {
        let end_stops_mm = |axis: usize| {
            let far_mm = config.homing.pull_off_mm + config.travel_mm[axis];
            (-END_STOP_MARGIN_MM, far_mm + END_STOP_MARGIN_MM)
        };
        let steps = |axis: usize, mm: f64| (mm * config.steps_per_mm[axis]).round() as i32;
        Self {
            steps_per_mm: config.steps_per_mm,
            motors: std::array::from_fn(|axis| motor.unwrap_or_else(|| fitting(config, axis))),
            end_stops_steps: std::array::from_fn(|axis| {
                let (low_mm, high_mm) = end_stops_mm(axis);
                (steps(axis, low_mm), steps(axis, high_mm))
            }),
        }
    }
}

/// The motor of `axis` that fits `config`.
pub fn fitting(config: &Config, axis: usize) -> PullOutCurve {
    PullOutCurve::fitting(&config.limits[axis], config.homing.seek_mm_s * config.steps_per_mm[axis])
}

/// How the machine is wired: as its settings are at power-up. To set them otherwise later does not move a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wiring {
    /// 1 where an axis moves towards positive while its DIR is high, otherwise -1.
    pub dir_high: [i32; AXES],
    /// 1 where positive is away from an axis's limit switch, otherwise -1.
    pub away: [i32; AXES],
    /// The drivers are enabled while ENABLE is high.
    pub enable_high: bool,
    /// Limit switches are closed, and pull their wires low, until they are pressed.
    pub switches_open: bool,
    /// The probe's contact is closed, and pulls its wire low, until it touches.
    pub probe_opens: bool,
}

impl Wiring {
    /// Those of a machine that `config` describes.
    pub fn of(config: &Config) -> Self {
        let sign = |is_positive: bool| if is_positive { 1 } else { -1 };
        Self {
            dir_high: config.wiring.map(|wiring| sign(!wiring.direction_inverted)),
            away: config.homing.towards.map(|towards| sign(towards == Direction::Negative)),
            enable_high: config.enable_inverted,
            switches_open: config.switches_inverted,
            probe_opens: config.probe_inverted,
        }
    }
}
