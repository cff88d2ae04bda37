//! One side of the gantry: a motor, with the driver, the carriage and the switch that belong to it.

use isostep_motion::{Axis, GangedMotor, Motor as Moving};

use crate::carriage::Carriage;
use crate::config::Config;
use crate::drive::Drive;
use crate::driver::DriverInputs;
use crate::mechanics::{Mechanics, Wiring};
use crate::motor::Motor;
use crate::plant::Switch;
use crate::record::LossCause;

/// A motor of an axis, from its driver to its switch.
pub(super) struct MotorWorld {
    /// The axis that it moves.
    pub(super) axis: Axis,
    pub(super) inputs: DriverInputs,
    /// 1 if the positive direction is away from the switch, otherwise -1.
    pub(super) away: i32,
    pub(super) motor: Motor,
    pub(super) carriage: Carriage,
    pub(super) switch: Switch,
    /// Steps made by this motor, from power-up or since its axis was homed.
    pub(super) counted_steps: i32,
    /// When it made the last one.
    pub(super) stepped_ns: Option<u64>,
    /// Position of the carriage where the count was zero.
    pub(super) zero_steps: i32,
    /// The same in half steps, for a carriage on belts that two motors share.
    pub(super) zero_half_steps: i32,
    pub(super) losing: bool,
    /// When its rotor last slipped.
    pub(super) slipped_ns: u64,
    /// The direction in which the rotor last fell back from an end stop, until it turns the other way; otherwise 0.
    pub(super) fell_back: i32,
    /// True if its motor is blocked.
    pub(super) is_stalled: bool,
}

impl MotorWorld {
    pub(super) fn new(motor: Moving, config: &Config, mechanics: &Mechanics, wiring: &Wiring) -> Self {
        let axis = motor.axis as usize;
        let ahead_mm =
            if motor.ganged == GangedMotor::Second { config.gantry.skew_mm + config.gantry.square_mm } else { 0.0 };
        let place_steps = config.start_steps(axis) + (ahead_mm * mechanics.steps_per_mm[axis]).round() as i32;
        let scatter_steps = (config.switch_scatter_mm * mechanics.steps_per_mm[axis]) as i32;
        let switch = Switch::new(place_steps, config.switches[axis], config.bounce_us * 1_000);
        let switch = switch.turning(mechanics.turn_steps[axis]);
        Self {
            axis: motor.axis,
            inputs: DriverInputs::new(axis, config.driver),
            away: wiring.away[axis],
            motor: Motor::new(mechanics.drives[axis]),
            carriage: Carriage::new(place_steps, mechanics.end_stops_steps[axis]),
            switch: switch.scattering(scatter_steps),
            counted_steps: 0,
            stepped_ns: None,
            zero_steps: place_steps,
            zero_half_steps: 2 * place_steps,
            losing: false,
            slipped_ns: 0,
            fell_back: 0,
            is_stalled: false,
        }
    }

    /// Distance of the carriage from its position by the count.
    pub(super) fn drift_steps(&self) -> i32 {
        self.away * (self.carriage.place_steps() - self.zero_steps) - self.counted_steps
    }

    /// Changes the resolution: a step becomes `scale` steps. The controller's count continues unchanged, so that lost
    /// steps stay lost.
    pub(super) fn refit(&mut self, scale: f64, drive: Drive, end_stops_steps: (i32, i32), turn_steps: Option<i32>) {
        let drift_steps = self.drift_steps();
        self.motor.replace(drive);
        self.carriage.rescale(scale, end_stops_steps);
        self.switch.rescale(scale, turn_steps);
        self.zero_steps = self.carriage.place_steps() - self.away * (self.counted_steps + drift_steps);
    }

    /// The obstacle that keeps the motor from making a step, if its driver `is_off` or the frame `binds`.
    pub(super) fn hindrance(&self, binds: bool, is_off: bool) -> Option<LossCause> {
        match self.inputs.is_enabled() {
            false => Some(LossCause::Disabled),
            true if is_off => Some(LossCause::DriverOff),
            true if self.is_stalled => Some(LossCause::Stalled),
            true => binds.then_some(LossCause::Bound),
        }
    }

    /// Makes one microstep of the motor and moves the carriage, unless something keeps it from that. Returns why steps were
    /// lost, and how many. The microsteps of a full step are known where the driver has a UART.
    pub(super) fn turn(
        &mut self,
        t_ns: u64,
        direction: i32,
        hindrance: Option<LossCause>,
        microsteps: Option<i32>,
    ) -> Option<(LossCause, u32)> {
        if let Some(cause) = hindrance {
            self.motor.hold();
            return Some((cause, 1));
        }
        let steps = self.away * direction;
        let lost = match microsteps {
            Some(microsteps) => self.carriage.turn(steps, microsteps),
            None => self.carriage.shift(steps),
        };
        if self.carriage.ahead_steps() == 0 {
            self.motor.step(t_ns, direction);
        } else {
            self.motor.hold();
        }
        if microsteps.is_some() && lost > 0 {
            self.losing = self.fell_back == steps;
            self.fell_back = steps;
        } else if self.fell_back != steps {
            self.fell_back = 0;
        }
        (lost > 0).then_some((LossCause::EndStop, lost))
    }
}
