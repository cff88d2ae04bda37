//! "Steps per time" (Stoychitch 2018, section 3.2): speed and position summed at a fixed rate.

use super::{GeneratorError, check_start_speed, check_top_speed, profile};
use isostep_profile::Limits;
use isostep_profile::StepCounts;

/// Sums are fractions of a step, in units of 1/ONE_STEP: when the position overflows, the next step is due.
const ONE_STEP: f64 = 18_446_744_073_709_551_616.0;

/// Computes speed += acceleration and position += speed at every service, and makes a step whenever the position has
/// grown by one (Stoychitch 2018, eq 17). Yields the intervals from the first step to the last, ticks: whole numbers of
/// service periods.
///
/// Step k of N is due at displacement k, and is made at the first service after it. So an interval is off by up to one
/// service period in either direction, however slow or fast the axis is.
///
/// The sums are in fixed point, because the paper's section looks for a method of additions alone. The paper's program
/// keeps them in floats, which have 24 bits on its controller: if the position is far, they lose the speed of a slow
/// axis. Like that program, this one changes phase by the count of steps. It also keeps the speed between the start
/// speed and the top speed; otherwise rounding could prevent the last step.
#[derive(Clone, Copy, Debug)]
pub struct StepsPerTime {
    service_ticks: u32,
    /// Position since the last step, 2^-64 step.
    position: u64,
    /// Speed, 2^-64 step a service. The next fields are in this unit, too.
    speed: u64,
    start: u64,
    top: u64,
    /// Change of the speed at each service while accelerating.
    accel: u64,
    /// Change of the speed at each service while decelerating, as a positive number.
    decel: u64,
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
    /// The value that does not work, and its limit. The top speed must be at most a step each service. The start speed
    /// must be above 0, and its interval must fit 32 bits.
    pub fn plan(steps: u32, limits: &Limits, service_ticks: u32, tick_hz: u32) -> Result<Self, GeneratorError> {
        let StepCounts { accel, cruise, .. } = profile(steps, limits)?.step_counts();
        let service_hz = f64::from(tick_hz) / f64::from(service_ticks);
        // With a period of 0 there are no services, and every speed is too fast.
        check_top_speed(limits, if service_ticks == 0 { 0.0 } else { service_hz })?;
        check_start_speed(limits, f64::from(tick_hz) / (f64::from(u32::MAX) - f64::from(service_ticks)))?;
        let start = fixed(limits.start_speed_steps_s / service_hz);
        let mut planned = Self {
            service_ticks,
            position: 0,
            speed: start,
            start,
            top: fixed(limits.top_speed_steps_s / service_hz),
            accel: fixed(limits.accel_steps_s2 / (service_hz * service_hz)),
            decel: fixed(limits.decel_steps_s2 / (service_hz * service_hz)),
            made: 0,
            accel_end: accel,
            cruise_end: accel + cruise,
            steps,
        };
        planned.services_to_step();
        Ok(planned)
    }

    /// Runs services until the next step is made, and returns how many.
    fn services_to_step(&mut self) -> u32 {
        let Self { start, top, accel, decel, .. } = *self;
        let services = if self.made < self.accel_end {
            self.sum(|speed| speed.saturating_add(accel).min(top))
        } else if self.made < self.cruise_end {
            self.sum(|speed| speed)
        } else {
            self.sum(|speed| speed.saturating_sub(decel).max(start))
        };
        self.made += 1;
        services
    }

    /// Repeats Stoychitch 2018, eq 17, until the position overflows.
    #[inline(always)]
    fn sum(&mut self, change: impl Fn(u64) -> u64) -> u32 {
        let (mut speed, mut position, mut services) = (self.speed, self.position, 0_u32);
        loop {
            speed = change(speed);
            services = services.wrapping_add(1);
            let (sum, is_step) = position.overflowing_add(speed);
            position = sum;
            if is_step {
                (self.speed, self.position) = (speed, position);
                return services;
            }
        }
    }
}

/// Converts to units of 2^-64 step. It saturates: a step less 2^-64 stands for a whole step.
fn fixed(steps: f64) -> u64 {
    (steps * ONE_STEP) as u64
}

impl Iterator for StepsPerTime {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        if self.made == self.steps {
            return None;
        }
        // `plan` has checked that the longest interval, that of the start speed, fits.
        Some(self.services_to_step().wrapping_mul(self.service_ticks))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = (self.steps - self.made) as usize;
        (left, Some(left))
    }
}

impl ExactSizeIterator for StepsPerTime {}
