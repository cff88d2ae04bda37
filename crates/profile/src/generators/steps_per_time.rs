//! "Steps per time" (paper 002, section 3.2): speed and position summed at a fixed rate.

use libm::round;

use super::{GeneratorError, check_start_speed, check_top_speed, profile};
use crate::limits::Limits;
use crate::trapezoid::StepCounts;

/// One step in Q2.62: two steps fit, which a sum of position and speed never reaches.
const ONE_STEP: i64 = 1 << 62;

/// The sums speed += acceleration, position += speed at every service, and a step whenever the position has gained one
/// (paper 002, eq 17). Yields the intervals from the first step to the last, ticks: whole numbers of service periods.
///
/// Step k of N is due at displacement k, on the first service after it: an interval is off by up to one service period
/// either way, however slow or fast the axis.
///
/// The sums are fixed-point: the section is after a method of additions alone. The paper's program keeps them in
/// floats, of 24 bits on its controller, which lose a slow axis's speed in a far position. Like that program this one
/// switches phase by the count of steps; the speed is also held between the start and the top speed, without which
/// rounding could leave the last step undone.
#[derive(Clone, Copy, Debug)]
pub struct StepsPerTime {
    service_ticks: u32,
    position: i64,
    speed: i64,
    /// Change of speed each service.
    accel: i64,
    decel: i64,
    start: i64,
    top: i64,
    /// Steps already made.
    made: u32,
    accel_end: u32,
    cruise_end: u32,
    steps: u32,
}

impl StepsPerTime {
    /// Plans `steps` steps in ticks of `tick_hz`, with a service every `service_ticks` (at least 1).
    ///
    /// # Errors
    /// Names the value that does not work and its limit. The top speed is at most a step each service. The start speed
    /// is above 0, and such that its interval fits 32 bits.
    pub fn plan(steps: u32, limits: &Limits, service_ticks: u32, tick_hz: u32) -> Result<Self, GeneratorError> {
        let StepCounts { accel, cruise, .. } = profile(steps, limits)?.step_counts();
        let service_hz = f64::from(tick_hz) / f64::from(service_ticks);
        // Without a period there are no services, and no speed is slow enough.
        check_top_speed(limits, if service_ticks == 0 { 0.0 } else { service_hz })?;
        check_start_speed(limits, f64::from(tick_hz) / (f64::from(u32::MAX) - f64::from(service_ticks)))?;
        // More than a step a service reaches any speed at once.
        let change = |accel: f64| fixed(accel / (service_hz * service_hz)).min(ONE_STEP - 1);
        let mut planned = Self {
            service_ticks,
            position: 0,
            speed: fixed(limits.start_speed_steps_s / service_hz),
            accel: change(limits.accel_steps_s2),
            decel: -change(limits.decel_steps_s2),
            start: fixed(limits.start_speed_steps_s / service_hz),
            top: fixed(limits.top_speed_steps_s / service_hz),
            made: 0,
            accel_end: accel,
            cruise_end: accel + cruise,
            steps,
        };
        planned.services_to_step();
        Ok(planned)
    }

    /// Serves until the next step is made; how many services that took.
    fn services_to_step(&mut self) -> u32 {
        let change = if self.made < self.accel_end {
            self.accel
        } else if self.made < self.cruise_end {
            0
        } else {
            self.decel
        };
        let mut services = 0;
        while self.position < ONE_STEP {
            self.speed = (self.speed + change).clamp(self.start, self.top);
            self.position += self.speed;
            services += 1;
        }
        self.position -= ONE_STEP;
        self.made += 1;
        services
    }
}

/// Q2.62, saturating.
fn fixed(steps: f64) -> i64 {
    round(steps * ONE_STEP as f64) as i64
}

impl Iterator for StepsPerTime {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        if self.made == self.steps {
            return None;
        }
        Some(self.services_to_step() * self.service_ticks)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = (self.steps - self.made) as usize;
        (left, Some(left))
    }
}

impl ExactSizeIterator for StepsPerTime {}
