//! A stepper motor whose rotor follows the microsteps as its torque allows, and loses steps where it does not.
//!
//! # Model
//! The state is the lag of the rotor behind the commanded microstep, and the rotor's speed. Between two edges the rotor
//! is integrated in short times ([`Drive`] has the physics). A lag of two full steps is where the torque changes its
//! sign: the rotor then falls into the next place in phase, and is four full steps from where it should be. That
//! happens when too much acceleration or speed is asked for. It also happens after an abrupt stop, when the rotor goes
//! on turning.
//!
//! The carriage is taken to be where the microsteps are, less the steps lost, and not where the rotor swings: a switch
//! closes at the same step each time.
//!
//! Not modelled: load that depends on position, such as gravity, and play.

use crate::drive::Drive;

/// Torque repeats after so many full steps.
const PERIOD_FULL: f64 = 4.0;
/// The lag from which the rotor is drawn to the next place in phase.
const SLIP_FULL: f64 = PERIOD_FULL / 2.0;
/// The longest time of one step of the integration, as a part of the radian of the natural frequency.
const PHASE_MAX: f64 = 0.1;
/// After a pause of this length an edge begins another motion, ns.
const PAUSE_NS: u64 = 2_500_000;
/// Edges have ceased, or were cut off, if the next one takes longer than so many intervals.
const CEASED_INTERVALS: u64 = 3;

/// The rotor left its place in phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slip {
    /// When, since power-up.
    pub t_ns: u64,
    /// The distance of the rotor from its place now, microsteps, signed by direction.
    pub steps: i32,
    /// The rate of the last edges.
    pub asked_steps_s: f64,
    /// True if edges had ceased and the rotor went on turning. Otherwise the edges asked for too much.
    pub has_overshot: bool,
}

/// One motor. It has no clock: callers pass the time, which never goes back.
#[derive(Debug)]
pub struct Motor {
    drive: Drive,
    rotor: Rotor,
    /// The time up to which the rotor has been followed.
    t_ns: u64,
    edge_ns: Option<u64>,
    interval_ns: u64,
    direction: i32,
}

/// The rotor, in full steps and full steps/s.
#[derive(Clone, Copy, Debug)]
struct Rotor {
    lag: f64,
    speed: f64,
    rests: bool,
    /// Acceleration by the whole torque, by friction, and by drag per speed; the corner speed; longest time of
    /// integration, s.
    pull: f64,
    friction: f64,
    drag: f64,
    corner: f64,
    step_max_s: f64,
}

impl Motor {
    /// A motor at standstill.
    pub fn new(drive: Drive) -> Self {
        Self { drive, rotor: Rotor::new(&drive), t_ns: 0, edge_ns: None, interval_ns: u64::MAX, direction: 1 }
    }

    /// Replaces it by another motor at standstill.
    pub fn replace(&mut self, drive: Drive) {
        *self = Self { t_ns: self.t_ns, ..Self::new(drive) };
    }

    /// True if an edge at `now_ns` begins another motion.
    pub fn has_paused(&self, now_ns: u64) -> bool {
        self.edge_ns.is_none_or(|edge_ns| now_ns.saturating_sub(edge_ns) >= PAUSE_NS)
    }

    /// Follows the rotor up to `now_ns`.
    pub fn advance(&mut self, now_ns: u64) -> Option<Slip> {
        let from_ns = self.t_ns;
        self.t_ns = now_ns.max(from_ns);
        if self.rotor.rests || self.drive.is_rigid() {
            return None;
        }
        let (periods, after_s) = self.rotor.advance((self.t_ns - from_ns) as f64 * 1e-9)?;
        let t_ns = from_ns + (after_s * 1e9) as u64;
        let ceased =
            self.edge_ns.is_some_and(|edge_ns| t_ns - edge_ns > self.interval_ns.saturating_mul(CEASED_INTERVALS));
        // The lag is measured in the direction of the edges.
        let is_ahead = periods * self.direction < 0;
        Some(Slip {
            t_ns,
            steps: -(f64::from(periods) * PERIOD_FULL * self.drive.microsteps()).round() as i32,
            asked_steps_s: if self.interval_ns == u64::MAX { 0.0 } else { 1e9 / self.interval_ns as f64 },
            has_overshot: ceased && is_ahead,
        })
    }

    /// Turns its field by a microstep in `direction` (1 or -1) at `t_ns`. Call [`advance`](Self::advance) first.
    pub fn step(&mut self, t_ns: u64, direction: i32) {
        self.interval_ns = self.edge_ns.map_or(u64::MAX, |edge_ns| (t_ns - edge_ns).max(1));
        self.edge_ns = Some(t_ns);
        self.direction = direction;
        self.rotor.lag += f64::from(direction) / self.drive.microsteps();
        self.rotor.rests = false;
    }

    /// Something holds it, or no current flows: its rotor stands still and in phase.
    pub fn hold(&mut self) {
        self.rotor = Rotor::new(&self.drive);
    }
}

impl Rotor {
    fn new(drive: &Drive) -> Self {
        Self {
            lag: 0.0,
            speed: 0.0,
            rests: true,
            pull: drive.pull_full_s2(),
            friction: drive.friction_full_s2(),
            drag: drive.drag_per_s(),
            corner: drive.corner_full_s(),
            step_max_s: PHASE_MAX / drive.natural_rad_s(),
        }
    }

    /// Follows it for `span_s`. Returns the periods of torque that it fell behind, if it slipped, and after which time
    /// it slipped first.
    fn advance(&mut self, span_s: f64) -> Option<(i32, f64)> {
        let (mut periods, mut first_s, mut rest_s) = (0, None, span_s);
        while rest_s > 0.0 && !self.rests {
            let step_s = rest_s.min(self.step_max_s);
            self.integrate(step_s);
            rest_s -= step_s;
            if self.lag.abs() > SLIP_FULL {
                let over = self.lag.signum();
                self.lag -= over * PERIOD_FULL;
                periods += over as i32;
                first_s.get_or_insert(span_s - rest_s);
            }
        }
        first_s.map(|first_s| (periods, first_s))
    }

    /// One step of a leapfrog: half of the way, the change of speed, half of the way.
    fn integrate(&mut self, step_s: f64) {
        self.lag -= self.speed * step_s / 2.0;
        let pull = self.pull * sine(self.lag) * (self.corner / self.speed.abs()).min(1.0);
        let free = (self.speed + pull * step_s) / (1.0 + self.drag * step_s);
        let braked = free.abs() - self.friction * step_s;
        self.speed = if braked > 0.0 { braked.copysign(free) } else { 0.0 };
        self.rests = self.speed == 0.0 && pull.abs() <= self.friction;
        self.lag -= self.speed * step_s / 2.0;
    }
}

/// The sine of a lag in full steps, of a period of four: a parabola and its correction, at most 0.001 off. Unlike the
/// library's sine it is the same on every computer.
fn sine(full: f64) -> f64 {
    let full = if full.abs() > SLIP_FULL { full - full.signum() * PERIOD_FULL } else { full };
    let parabola = full * (2.0 - full.abs());
    parabola + 0.225 * (parabola * parabola.abs() - parabola)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::drive::{Load, MotorData};

    #[test]
    fn the_sine_is_a_sine() {
        for hundredth in -300..=300 {
            let full = f64::from(hundredth) / 100.0;
            assert!((sine(full) - (full * FRAC_PI_2).sin()).abs() < 0.0012, "{full}");
        }
    }

    /// Drives as presets make them: steps/mm and top speed, mm/s.
    fn drives() -> impl Iterator<Item = (f64, Drive)> {
        [(80.0, 100.0), (50.0, 48.0), (20.0, 100.0), (25.0, 80.0), (160.0, 100.0), (400.0, 25.0), (800.0, 33.0)]
            .into_iter()
            .map(|(steps_per_mm, top)| {
                (steps_per_mm, Drive::new(MotorData::NEMA_17, Load::preset(steps_per_mm, top), steps_per_mm))
            })
    }

    /// The response of a motor to edges at the times that `time_s` gives for each place in mm, up to `end_mm`: the first
    /// slip, or where the rotor has come to rest after the last edge, which is an abrupt stop.
    fn first_slip(drive: Drive, steps_per_mm: f64, end_mm: f64, time_s: &dyn Fn(f64) -> f64) -> Option<Slip> {
        let mut motor = Motor::new(drive);
        let steps = (end_mm * steps_per_mm) as u32;
        let mut t_ns = 0;
        for k in 0..steps {
            t_ns = (time_s((f64::from(k) + 0.5) / steps_per_mm) * 1e9) as u64;
            if let Some(slip) = motor.advance(t_ns) {
                return Some(slip);
            }
            motor.step(t_ns, 1);
        }
        motor.advance(t_ns + 1_000_000_000)
    }

    /// The most that is followed of what `follows` tells, between 0 and `high`.
    fn most(high: f64, follows: impl Fn(f64) -> bool) -> f64 {
        let (mut low, mut high) = (0.0, high);
        for _ in 0..12 {
            let middle = (low + high) / 2.0;
            *(if follows(middle) { &mut low } else { &mut high }) = middle;
        }
        low
    }

    /// From rest at constant acceleration up to `top_mm_s`, then at that speed; and the ramp made backwards.
    fn ramp_s(accel: f64, top: f64) -> impl Fn(f64) -> f64 {
        let ramp = top * top / (2.0 * accel);
        move |x| if x < ramp { (2.0 * x / accel).sqrt() } else { top / accel + (x - ramp) / top }
    }

    fn assert_about(found: f64, expected: f64, tolerance: f64, what: &str) {
        assert!((found / expected - 1.0).abs() < tolerance, "{what}: {found} for {expected}");
    }

    /// The golden margins: what the integration follows and what the closed forms say.
    #[test]
    fn the_margins_are_those_of_the_physics() {
        for (steps_per_mm, drive) in drives() {
            let rev = drive.mm_per_rev();
            // The abrupt stop at the end is another matter.
            let follows = |end_mm: f64, time_s: &dyn Fn(f64) -> f64| {
                first_slip(drive, steps_per_mm, end_mm, time_s).is_none_or(|slip| slip.has_overshot)
            };
            let jump = most(10.0 * rev, |mm_s| follows(rev, &|x| x / mm_s));
            assert_about(jump, drive.jump_mm_s(), 0.02, "jump");
            let top = 8.0 * rev;
            // It is decided within half a swing, at some revolutions a second.
            let at_rest = drive.accel_mm_s2(1.5 * rev);
            let accel = most(3.0 * at_rest, |accel| follows(3.0 * top * top / accel, &ramp_s(accel, top)));
            // The ramp of a screw is over before the rotor has swung: it takes more.
            let is_belt = steps_per_mm < 200.0;
            assert_about(accel, at_rest, if is_belt { 0.02 } else { 0.3 }, "acceleration that begins at once");
            assert!(accel > 0.99 * at_rest, "{accel} for {at_rest}");
            // An abrupt stop, after a gentle ramp: friction helps.
            for (share, is_lost) in [(1.0, false), (1.5, true)] {
                let mm_s = share * drive.jump_mm_s();
                let ramp = ramp_s(at_rest / 10.0, mm_s);
                let slip = first_slip(drive, steps_per_mm, 6.0 * mm_s * mm_s / at_rest, &ramp);
                assert_eq!(slip.is_some(), is_lost, "{share} of {mm_s} mm/s: {slip:?}");
                assert!(slip.is_none_or(|slip| slip.has_overshot && slip.steps > 0), "{slip:?}");
            }
        }
    }

    /// Microsteps shake the rotor, most of all at its natural frequency. With a quarter step and finer it stays in phase.
    #[test]
    fn no_constant_speed_shakes_a_motor_out_of_phase() {
        for (steps_per_mm, drive) in drives() {
            let shaken = (1..60)
                .map(|percent| f64::from(percent) / 100.0 * drive.jump_mm_s())
                .find(|&mm_s| first_slip(drive, steps_per_mm, mm_s.max(2.0), &|x| x / mm_s).is_some());
            assert_eq!(shaken, None, "mm/s at {steps_per_mm} steps/mm");
        }
    }

    #[test]
    fn at_top_speed_it_pulls_out_and_follows_again_when_it_is_slow() {
        let (steps_per_mm, drive) = drives().next().unwrap();
        let top = 1.1 * drive.gone_mm_s();
        let slip = first_slip(drive, steps_per_mm, 1_000.0, &ramp_s(1_000.0, top)).unwrap();
        let mm_s = slip.asked_steps_s / steps_per_mm;
        // Where 1,000 mm/s² are all that it has to spare.
        assert!(drive.spare_mm_s2(1.05 * mm_s) < 1_000.0 && drive.spare_mm_s2(0.95 * mm_s) > 1_000.0, "{slip:?}");
        assert!(slip.steps < 0 && slip.steps % 64 == 0 && !slip.has_overshot, "{slip:?}");
        let mut motor = Motor::new(drive);
        let mut lost = |steps_s: u64, from_ns: u64| {
            let edges = (0..steps_s / 2).map(|k| from_ns + k * 1_000_000_000 / steps_s);
            edges
                .filter(|&t_ns| {
                    let slip = motor.advance(t_ns);
                    motor.step(t_ns, 1);
                    slip.is_some()
                })
                .count()
        };
        assert!(lost(20_000, 0) > 50, "an instant start at 250 mm/s");
        lost(2_000, 500_000_000);
        assert_eq!(lost(2_000, 1_000_000_000), 0, "it follows again");
    }

    /// In steps of a quarter the rate at the end of a ramp is far from the mean over a period: that is no stop.
    #[test]
    fn the_last_interval_of_a_ramp_is_no_abrupt_stop() {
        let (steps_per_mm, drive) = drives().nth(2).unwrap();
        let (accel, end) = (1_000.0_f64, 20.0_f64);
        let half_s = (end / accel).sqrt();
        let time_s = |x: f64| {
            if x < end / 2.0 { (2.0 * x / accel).sqrt() } else { 2.0 * half_s - (2.0 * (end - x) / accel).sqrt() }
        };
        assert_eq!(first_slip(drive, steps_per_mm, end, &time_s), None);
    }
}
