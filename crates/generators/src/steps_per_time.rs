//! "Steps per time" (paper 002, section 3.2): speed and position summed at a fixed rate.

use super::{GeneratorError, check_start_speed, check_top_speed, profile};
use isostep_profile::Limits;
use isostep_profile::StepCounts;

/// Sums are fractions of a step: the position's overflow is the next step.
const ONE_STEP: f64 = 18_446_744_073_709_551_616.0;

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
    /// Since the last step, 2^-64 step.
    position: u64,
    /// 2^-64 step a service, as all that follow.
    speed: u64,
    start: u64,
    top: u64,
    /// Gain of speed each service.
    accel: u64,
    /// Loss of speed each service.
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
    /// Names the value that does not work and its limit. The top speed is at most a step each service. The start speed
    /// is above 0, and such that its interval fits 32 bits.
    pub fn plan(steps: u32, limits: &Limits, service_ticks: u32, tick_hz: u32) -> Result<Self, GeneratorError> {
        let StepCounts { accel, cruise, .. } = profile(steps, limits)?.step_counts();
        let service_hz = f64::from(tick_hz) / f64::from(service_ticks);
        // Without a period there are no services, and no speed is slow enough.
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

    /// Serves until the next step is made; how many services that took.
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

    /// Paper 002, eq 17, until the position overflows.
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

/// Saturates: a step less 2^-64 stands for a whole one.
fn fixed(steps: f64) -> u64 {
    (steps * ONE_STEP) as u64
}

impl Iterator for StepsPerTime {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        if self.made == self.steps {
            return None;
        }
        // `plan` has seen to it that the longest interval, the start speed's, fits.
        Some(self.services_to_step().wrapping_mul(self.service_ticks))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = (self.steps - self.made) as usize;
        (left, Some(left))
    }
}

impl ExactSizeIterator for StepsPerTime {}
