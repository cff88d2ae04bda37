//! The parts of the machine that follow its settings: motors, resolution and end stops. Also its wiring, which does
//! not.

use isostep_motion::{AXES, Axis, Config, Direction, Kinematics};

use crate::drive::{Drive, Load, MotorData};

/// Distance from a limit switch to the end stop behind it, if its settings say no more (`$906`), and from the other end of the travel to the end stop there,
/// mm.
const END_STOP_MARGIN_MM: f64 = 3.0;
/// The place where an axis without an end is said to have its end stops, degrees: farther than programs go.
const NOWHERE_MM: f64 = 1e5;

/// The mechanics that follow the settings: whoever changes these settings has built another machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mechanics {
    /// Microsteps per millimetre.
    pub steps_per_mm: [f64; AXES],
    /// The motors and what they move.
    pub drives: [Drive; AXES],
    /// The end stops, steps from where the limit switch closes.
    pub end_stops_steps: [(i32, i32); AXES],
    /// One turn of an axis without an end, which has its switch at every turn.
    pub turn_steps: [Option<i32>; AXES],
}

impl Mechanics {
    /// The mechanics of a machine that `config` describes, with `motor` on every axis. Where no load is given, the axis
    /// has the usual one of its resolution.
    pub fn of(config: &Config, motor: MotorData, loads: [Option<Load>; AXES]) -> Self {
        let end_stops_mm = |axis: usize| {
            if config.is_endless[axis] {
                return (-NOWHERE_MM, NOWHERE_MM);
            }
            let squared = config.squared.filter(|squared| squared.axis as usize == axis);
            let offset_mm = squared.map_or(0.0, |squared| squared.offset_mm.abs());
            let far_mm = config.homing.pull_off_mm + offset_mm + config.travel_mm[axis];
            (-END_STOP_MARGIN_MM.max(config.homing.room_mm), far_mm + END_STOP_MARGIN_MM)
        };
        let steps = |axis: usize, mm: f64| (mm * config.steps_per_mm[axis]).round() as i32;
        Self {
            steps_per_mm: config.steps_per_mm,
            drives: std::array::from_fn(|axis| {
                let steps_per_mm = config.steps_per_mm[axis];
                let top_mm_s = config.limits[axis].top_speed_steps_s / steps_per_mm;
                let load = loads[axis].unwrap_or_else(|| Load::preset(steps_per_mm, top_mm_s));
                Drive::new(motor, load, steps_per_mm)
            }),
            end_stops_steps: std::array::from_fn(|axis| {
                let (low_mm, high_mm) = end_stops_mm(axis);
                (steps(axis, low_mm), steps(axis, high_mm))
            }),
            turn_steps: std::array::from_fn(|axis| {
                config.is_endless[axis].then(|| steps(axis, config.travel_mm[axis]))
            }),
        }
    }
}

/// The wiring of the machine, as in its settings at power-up. Changing these settings later does not change the wiring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wiring {
    /// What the motors do for the axes to move.
    pub kinematics: Kinematics,
    /// 1 where an axis moves in the positive direction while its DIR is high, otherwise -1.
    pub dir_high: [i32; AXES],
    /// The axis that has a second motor.
    pub second: Option<Axis>,
    /// 1 where that motor moves in the positive direction while its DIR is high, otherwise -1.
    pub second_dir_high: i32,
    /// 1 where the positive direction is away from an axis's limit switch, otherwise -1.
    pub away: [i32; AXES],
    /// The drivers are enabled while ENABLE is high.
    pub enable_high: bool,
    /// Limit switches are closed, and pull their wires low, until they are pressed.
    pub switches_open: bool,
    /// The probe's contact is closed, and pulls its wire low, until it touches.
    pub probe_opens: bool,
}

impl Wiring {
    /// The wiring of a machine that `config` describes.
    pub fn of(config: &Config) -> Self {
        let sign = |is_positive: bool| if is_positive { 1 } else { -1 };
        Self {
            kinematics: config.kinematics,
            dir_high: config.wiring.map(|wiring| sign(!wiring.direction_inverted)),
            second: config.squared.map(|squared| squared.axis),
            second_dir_high: config.squared.map_or(1, |squared| {
                sign(config.wiring[squared.axis as usize].direction_inverted == squared.direction_inverted)
            }),
            away: config.homing.towards.map(|towards| sign(towards == Direction::Negative)),
            enable_high: config.enable_inverted,
            switches_open: config.switches_inverted,
            probe_opens: config.probe_inverted,
        }
    }
}
