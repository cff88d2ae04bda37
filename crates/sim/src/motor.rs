//! A stepper motor that loses steps when it is driven beyond its pull-out curve.
//!
//! # Model
//! - Up to the *pull-in* (start-stop) rate the rotor follows any edge, including jumps and reversals.
//! - Above it, the acceleration that the torque allows falls linearly from `accel_at_rest_steps_s2` at standstill to
//!   zero at `speed_max_steps_s`. If more is asked for, up or down, the rotor pulls out: it stalls and loses every step
//!   until the rate is again within the pull-in rate.
//! - If edges cease or reverse above the pull-in rate, the rotor continues to turn. It overshoots by the distance that
//!   its best deceleration needs down to the pull-in rate.
//!
//! Rates are averaged over one electrical period, four full steps. Within it, the rotor's inertia smooths the jitter of
//! microsteps, so one tick of a timer does not count as acceleration.
//!
//! Not modelled: resonance, load that depends on position, and that a real rotor slips by whole electrical periods.

use std::collections::VecDeque;

use isostep_profile::Limits;

/// The capability of a motor, in microsteps as the driver counts them.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct PullOutCurve {
    /// The rate up to which it starts, stops and reverses without a ramp.
    pub pull_in_steps_s: f64,
    /// The speed at which no torque is left.
    pub speed_max_steps_s: f64,
    /// The acceleration that it can produce at standstill.
    pub accel_at_rest_steps_s2: f64,
    /// Microsteps per full step.
    pub microsteps: usize,
}

impl Default for PullOutCurve {
    /// Drives the default machine (2,400 steps/s, 2,500 steps/s²) with a margin of more than four: at 2,400 steps/s it
    /// can accelerate at 20,000 (1 - 2,400/6,000) = 12,000 steps/s². Homing stops abruptly from 500 steps/s.
    fn default() -> Self {
        Self { pull_in_steps_s: 800.0, speed_max_steps_s: 6_000.0, accel_at_rest_steps_s2: 20_000.0, microsteps: 8 }
    }
}

/// The default machine's top speed and acceleration, steps/s and steps/s², and the seek speed from which its homing
/// stops abruptly, steps/s. [`PullOutCurve::default`] is a motor for these.
const DEFAULT_TOP_STEPS_S: f64 = 2_400.0;
const DEFAULT_ACCEL_STEPS_S2: f64 = 2_500.0;
const DEFAULT_SEEK_STEPS_S: f64 = 500.0;

impl PullOutCurve {
    /// A motor that has the same margins for `limits`, and for a homing seek at `seek_steps_s`, as the default motor
    /// has for the default machine. It has torque up to 2.5 times the top speed, at standstill for 8 times the
    /// acceleration or deceleration, whichever is higher. Its pull-in rate is at least a third of the top speed and 1.6
    /// times the seek speed and the start speed.
    pub fn fitting(limits: &Limits, seek_steps_s: f64) -> Self {
        let default = Self::default();
        let (top, accel) = (limits.top_speed_steps_s, limits.accel_steps_s2.max(limits.decel_steps_s2));
        // No move is faster than the top speed, not even in homing.
        let abrupt = seek_steps_s.max(limits.start_speed_steps_s).min(top);
        let times = (top / DEFAULT_TOP_STEPS_S).max(abrupt / DEFAULT_SEEK_STEPS_S);
        Self {
            pull_in_steps_s: default.pull_in_steps_s * times,
            speed_max_steps_s: default.speed_max_steps_s * (top / DEFAULT_TOP_STEPS_S),
            accel_at_rest_steps_s2: default.accel_at_rest_steps_s2 * (accel / DEFAULT_ACCEL_STEPS_S2),
            microsteps: default.microsteps,
        }
    }

    /// The possible acceleration at `speed_steps_s`, steps/s²; 0 from the maximum speed on.
    pub fn accel_at(&self, speed_steps_s: f64) -> f64 {
        self.accel_at_rest_steps_s2 * (1.0 - speed_steps_s / self.speed_max_steps_s).max(0.0)
    }

    /// Microsteps in an electrical period.
    fn period_steps(&self) -> usize {
        4 * self.microsteps
    }

    /// Edges farther apart than this belong to different motions: the interval at half the pull-in rate.
    fn standstill_ns(&self) -> u64 {
        (2e9 / self.pull_in_steps_s) as u64
    }
}

/// The result of one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Response {
    /// The rotor made it.
    Followed,
    /// The rotor has pulled out.
    Lost {
        /// The rate asked for.
        asked_steps_s: f64,
        /// The acceleration asked for.
        asked_steps_s2: f64,
    },
}

/// The rotor continued to turn after the edges had ceased.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overshoot {
    /// Signed by direction.
    pub steps: i32,
    /// The rate at which the edges ceased.
    pub from_steps_s: f64,
}

/// One motor. It has no clock: callers pass the time.
#[derive(Debug)]
pub struct Motor {
    curve: PullOutCurve,
    /// Instants of the last two electrical periods since standstill, ns.
    edges_ns: VecDeque<u64>,
    direction: i32,
    stalled: bool,
}

impl Motor {
    /// A motor at standstill.
    pub fn new(curve: PullOutCurve) -> Self {
        Self { curve, edges_ns: VecDeque::new(), direction: 1, stalled: false }
    }

    /// Replaces it by another motor at standstill.
    pub fn replace(&mut self, curve: PullOutCurve) {
        *self = Self::new(curve);
    }

    /// Whether it stands still, as of the last [`settle`](Self::settle) or step.
    pub fn is_at_rest(&self) -> bool {
        self.edges_ns.is_empty()
    }

    /// Makes one step in `direction` (1 or -1) at `t_ns`. Call [`settle`](Self::settle) first.
    pub fn step(&mut self, t_ns: u64, direction: i32) -> Response {
        self.direction = direction;
        self.edges_ns.push_back(t_ns);
        if self.edges_ns.len() > 2 * self.curve.period_steps() + 1 {
            self.edges_ns.pop_front();
        }
        let (before, now, accel) = self.demand();
        let speed = before.max(now);
        if self.stalled {
            self.recover(now);
        } else {
            self.stalled = speed > self.curve.pull_in_steps_s && accel.abs() > self.curve.accel_at(speed);
        }
        if self.stalled { Response::Lost { asked_steps_s: now, asked_steps_s2: accel } } else { Response::Followed }
    }

    /// Ends the stall once the rate is within the pull-in rate.
    fn recover(&mut self, now_steps_s: f64) {
        self.stalled = now_steps_s > self.curve.pull_in_steps_s;
        if !self.stalled {
            let kept = self.edges_ns.len().min(self.curve.microsteps);
            self.edges_ns.drain(..self.edges_ns.len() - kept);
        }
    }

    /// Ends the motion so far if no edge has come for long, or if the next edge, if any, reverses it.
    pub fn settle(&mut self, now_ns: u64, next_direction: Option<i32>) -> Option<Overshoot> {
        let last_ns = *self.edges_ns.back()?;
        let reverses = next_direction.is_some_and(|next| next != self.direction);
        if now_ns - last_ns < self.curve.standstill_ns() && !reverses {
            return None;
        }
        let (_, from_steps_s, _) = self.demand();
        let coasts = from_steps_s > self.curve.pull_in_steps_s && !self.stalled;
        self.edges_ns.clear();
        self.stalled = false;
        coasts.then(|| Overshoot { steps: self.direction * self.coast_steps(from_steps_s), from_steps_s })
    }

    fn coast_steps(&self, from_steps_s: f64) -> i32 {
        let shed = from_steps_s.powi(2) - self.curve.pull_in_steps_s.powi(2);
        (shed / (2.0 * self.curve.accel_at_rest_steps_s2)).ceil() as i32
    }

    /// The rate over the electrical period before the last one, the rate over the last one, and the acceleration
    /// between them.
    fn demand(&self) -> (f64, f64, f64) {
        let last = self.edges_ns.len() - 1;
        let middle = last.saturating_sub(self.curve.period_steps());
        let span_s = |from: usize, to: usize| (self.edges_ns[to] - self.edges_ns[from]) as f64 * 1e-9;
        let rate =
            |from: usize, to: usize| if to > from { (to - from) as f64 / span_s(from, to).max(1e-9) } else { 0.0 };
        let (before, now) = (rate(0, middle), rate(middle, last));
        // The time from the middle of one average to the middle of the other.
        let apart_s = (span_s(0, last) / 2.0).max(1e-9);
        (before, now, (now - before) / apart_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps lost over a ramp from rest at `accel` up to `top`, with instants rounded to whole microseconds.
    fn lost_on_ramp(accel: f64, top: f64, steps: u32) -> u32 {
        let mut motor = Motor::new(PullOutCurve::default());
        let ramp_steps = top * top / (2.0 * accel);
        let mut lost = 0;
        for k in 0..steps {
            let x = f64::from(k) + 0.5;
            let t_s = if x < ramp_steps { (2.0 * x / accel).sqrt() } else { top / accel + (x - ramp_steps) / top };
            let t_ns = (t_s * 1e6).round() as u64 * 1000;
            motor.settle(t_ns, Some(1));
            lost += u32::from(motor.step(t_ns, 1) != Response::Followed);
        }
        lost
    }

    #[test]
    fn the_default_machine_is_followed() {
        assert_eq!(lost_on_ramp(2_500.0, 2_400.0, 5_000), 0);
        assert_eq!(lost_on_ramp(10_000.0, 2_400.0, 5_000), 0);
    }

    #[test]
    fn the_motor_that_fits_the_default_machine_is_the_default_motor() {
        let limits = |speeds: f64, accels: f64| Limits {
            start_speed_steps_s: 0.0,
            top_speed_steps_s: DEFAULT_TOP_STEPS_S * speeds,
            accel_steps_s2: DEFAULT_ACCEL_STEPS_S2 * accels,
            decel_steps_s2: DEFAULT_ACCEL_STEPS_S2,
            jerk_steps_s3: f64::INFINITY,
        };
        let default = PullOutCurve::default();
        assert_eq!(PullOutCurve::fitting(&limits(1.0, 1.0), 500.0), default);
        let faster = PullOutCurve { pull_in_steps_s: 1_600.0, speed_max_steps_s: 12_000.0, ..default };
        assert_eq!(PullOutCurve::fitting(&limits(2.0, 0.5), 500.0), faster);
        let seeking = PullOutCurve { pull_in_steps_s: 1_600.0, accel_at_rest_steps_s2: 80_000.0, ..default };
        assert_eq!(PullOutCurve::fitting(&limits(1.0, 4.0), 1_000.0), seeking);
    }

    #[test]
    fn too_much_acceleration_or_speed_pulls_out() {
        let rest = lost_on_ramp(30_000.0, 2_400.0, 5_000);
        assert!((4_900..5_000).contains(&rest), "{rest}");
        // At 2,500 steps/s² the curve is crossed where 20,000 (1 - v/6,000) = 2,500: v = 5,250 steps/s, x = 5,512.
        let lost = lost_on_ramp(2_500.0, 7_000.0, 8_000);
        assert!((2_400..2_650).contains(&lost), "{lost}");
    }

    #[test]
    fn the_pull_in_rate_starts_and_stops_at_once() {
        for (rate_steps_s, overshoot) in [(790_u64, false), (1_600, true)] {
            let mut motor = Motor::new(PullOutCurve { accel_at_rest_steps_s2: 1e9, ..PullOutCurve::default() });
            for k in 0..100 {
                let t_ns = k * 1_000_000_000 / rate_steps_s;
                assert_eq!(motor.settle(t_ns, Some(1)), None);
                assert_eq!(motor.step(t_ns, 1), Response::Followed, "{rate_steps_s} steps/s, step {k}");
            }
            let settled = motor.settle(1_000_000_000, None);
            assert_eq!(settled.is_some(), overshoot, "{rate_steps_s} steps/s");
        }
    }

    #[test]
    fn a_stalled_motor_recovers_within_the_pull_in_rate() {
        let mut motor = Motor::new(PullOutCurve::default());
        let mut t_ns = 0;
        let mut run = |motor: &mut Motor, rate_steps_s: u64, steps: u32| {
            let mut lost = 0;
            for _ in 0..steps {
                t_ns += 1_000_000_000 / rate_steps_s;
                motor.settle(t_ns, Some(1));
                lost += u32::from(motor.step(t_ns, 1) != Response::Followed);
            }
            lost
        };
        assert_eq!(run(&mut motor, 2_000, 50), 49, "the first edge has no rate yet");
        let lost = run(&mut motor, 700, 50);
        assert!((1..=32).contains(&lost), "{lost} lost until the average over a period is slow");
    }

    #[test]
    fn a_reversal_at_speed_overshoots() {
        let mut motor = Motor::new(PullOutCurve { accel_at_rest_steps_s2: 40_000.0, ..PullOutCurve::default() });
        for x in 0..400_u32 {
            let t_ns = ((2.0 * (f64::from(x) + 0.5) / 5_000.0).sqrt() * 1e9) as u64;
            motor.settle(t_ns, Some(-1));
            motor.step(t_ns, -1);
        }
        let Some(Overshoot { steps, from_steps_s }) = motor.settle(400_500_000, Some(1)) else {
            panic!("no overshoot")
        };
        // (1,960² - 800²)/(2 x 40,000) = 40.0
        assert!((1_940.0..2_000.0).contains(&from_steps_s), "{from_steps_s}");
        assert!((-42..=-38).contains(&steps), "{steps}");
    }
}
