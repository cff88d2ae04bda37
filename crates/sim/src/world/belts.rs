//! Crossed belts: two motors move the carriage along X and along Y together.
//!
//! A step of either motor moves both axes by half a step. An end stop of either axis keeps the whole step back, because the other belt
//! holds the carriage: then the motor loses it.

use isostep_motion::{Axis, Kinematics};

use super::World;
use crate::record::LossCause;

/// The axes that the belts move.
const AXES: [usize; 2] = [Axis::X as usize, Axis::Y as usize];

impl World {
    /// True if a motor is at a belt that moves two axes.
    pub(super) fn is_crossed(&self, index: usize) -> bool {
        self.wiring.kinematics == Kinematics::CoreXy && AXES.contains(&index)
    }

    /// Makes a microstep of a motor at a belt, unless something keeps it from that. Returns why steps were lost, and how many.
    pub(super) fn turn_belt(
        &mut self,
        t_ns: u64,
        index: usize,
        direction: i32,
        hindrance: Option<LossCause>,
    ) -> Option<(LossCause, u32)> {
        let hindrance = hindrance.or((!self.shift_belt(t_ns, index, direction)).then_some(LossCause::EndStop));
        let motor = &mut self.motors[index].motor;
        match hindrance {
            Some(_) => motor.hold(),
            None => motor.step(t_ns, direction),
        }
        hindrance.map(|cause| (cause, 1))
    }

    /// Moves the carriage as a motor that turns by so many steps does. False if an end stop keeps it where it is.
    pub(super) fn shift_belt(&mut self, t_ns: u64, index: usize, steps: i32) -> bool {
        let half_steps = AXES.map(|axis| {
            // The motor of Y makes X - Y.
            let along = if [axis, index] == [AXES[1]; 2] { -steps } else { steps };
            self.motors[axis].away * along
        });
        let is_free = |(axis, half_steps): (usize, i32)| self.motors[axis].carriage.may_shift_half(half_steps);
        if !AXES.into_iter().zip(half_steps).all(is_free) {
            return false;
        }
        for (axis, half_steps) in AXES.into_iter().zip(half_steps) {
            if self.motors[axis].carriage.shift_half(half_steps) {
                self.carriage_moved(t_ns, axis);
            }
        }
        true
    }

    /// Twice the distance of a carriage from its position by the count of its motors.
    pub(super) fn belt_drift_half_steps(&self, axis: usize) -> i32 {
        let this = &self.motors[axis];
        let [x, y] = AXES.map(|motor| self.motors[motor].counted_steps);
        let counted = if axis == AXES[0] { x + y } else { x - y };
        this.away * (this.carriage.half_steps() - this.zero_half_steps) - counted
    }

    /// Notes that an axis has homed: the count of its motors is that of the machine.
    pub(super) fn zero_belt(&mut self, axis: Axis) {
        self.counted_steps = Kinematics::CoreXy.with_zero(self.counted_steps, axis);
        for motor in AXES {
            self.motors[motor].counted_steps = self.counted_steps[motor];
        }
        let this = &mut self.motors[axis as usize];
        this.zero_half_steps = this.carriage.half_steps();
    }
}
