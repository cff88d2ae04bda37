//! How near an axis came to its limits, measured from its edges and nothing else.
//!
//! # Method
//! The edge of step k says that the axis is at k - 1/2 (of a step, and of a place) at that instant, give or take the way
//! that it makes in the time by which an edge may be off: off v. Of m + 1 edges, m! times the divided difference of their
//! places is a mean of the m-th derivative over the time between them, with weights that are all positive (a B-spline). So
//! while the speed, the acceleration or the jerk keeps within a limit, however it jumps, so does that mean: there is no
//! bias to allow for.
//!
//! What remains is how far edges are off. Edges that are h apart, or more, spoil the mean by at most 2^m off v/h^m, since
//! the sum of 1/((m - k)! k!) over k is 2^m/m!. Windows are as wide as makes that [`GRAIN`] of the limit: for the default
//! gantry at its top speed an acceleration is measured over twice 3 ms, or with ticks of 1 us over twice 16 ms, a jerk over
//! three times 12 or 36 ms; where steps are farther apart than that, over as many steps. So what keeps within its limits is
//! measured within 1 + [`GRAIN`] of them.
//!
//! Speed alone jumps: from rest to the start speed v_s, and back. The first edge is less than a step from where a run
//! begins, so that the speed at it is at most √(v_s² + 2 a), and the second comes no sooner than that and a let it.

use isostep_profile::{Limits, SpeedLaw};

/// By what fraction a measurement may be above a limit that is kept.
pub const GRAIN: f64 = 0.01;

/// Speed, acceleration and jerk.
const ORDERS: usize = 3;

/// The highest that was measured, each as a fraction of its limit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LimitRatios {
    /// Of the speed in force.
    pub speed: f64,
    /// Of the start speed, at either end of a run.
    pub ends: f64,
    /// Of the acceleration.
    pub accel: f64,
    /// Of the deceleration.
    pub decel: f64,
    /// Of the jerk, under a law that keeps to it.
    pub jerk: f64,
    /// Of the speed that a corner may be taken at; by its plan, and not measured here.
    pub corner: f64,
}

/// Whether a stretch begins, and ends, at rest.
#[derive(Clone, Copy, Debug)]
pub struct Ends {
    /// Each.
    pub at_rest: [bool; 2],
}

impl LimitRatios {
    /// The higher of both, each.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self {
            speed: self.speed.max(other.speed),
            ends: self.ends.max(other.ends),
            accel: self.accel.max(other.accel),
            decel: self.decel.max(other.decel),
            jerk: self.jerk.max(other.jerk),
            corner: self.corner.max(other.corner),
        }
    }

    /// Whether every limit was kept.
    #[must_use]
    pub fn are_within(&self) -> bool {
        [self.speed, self.ends, self.accel, self.decel, self.jerk, self.corner]
            .into_iter()
            .all(|ratio| ratio <= 1.0 + GRAIN)
    }
}

/// Measures one axis over one stretch in which it goes one way: `times_s` are all its edges, each off by `off_s` at most;
/// `speed_at` is the speed that holds for it at an instant, steps/s, which never falls.
pub fn ratios(
    times_s: &[f64],
    off_s: f64,
    limits: &Limits,
    law: SpeedLaw,
    ends: Ends,
    speed_at: impl Fn(f64) -> f64,
) -> LimitRatios {
    let (Some(&first_s), Some(&last_s)) = (times_s.first(), times_s.last()) else { return LimitRatios::default() };
    let top = speed_at(last_s);
    // How far apart edges must be for a derivative of that limit.
    let spacing_s = |order: i32, limit: f64| 2.0 * (off_s * top / (GRAIN * limit)).powf(1.0 / f64::from(order));
    let speed = means::<2>(times_s, 2.0 * off_s / GRAIN).map(|(t_s, mean)| mean / speed_at(t_s));
    let accels = |limit| means::<3>(times_s, spacing_s(2, limit)).map(|(_, mean)| mean);
    let start = |instant_s| limits.start_speed_steps_s.min(speed_at(instant_s));
    let jerk = match law {
        SpeedLaw::SCurve if limits.jerk_steps_s3.is_finite() => {
            highest(means::<4>(times_s, spacing_s(3, limits.jerk_steps_s3)).map(|(_, mean)| mean.abs()))
        }
        _ => 0.0,
    };
    LimitRatios {
        speed: highest(speed),
        ends: highest(
            [
                end(times_s.iter().copied(), start(first_s), limits.accel_steps_s2),
                end(times_s.iter().rev().map(|t_s| -t_s), start(last_s), limits.decel_steps_s2),
            ]
            .into_iter()
            .zip(ends.at_rest)
            .filter_map(|(ratio, is_at_rest)| ratio.filter(|_| is_at_rest)),
        ),
        accel: highest(accels(limits.accel_steps_s2)) / limits.accel_steps_s2,
        decel: highest(accels(limits.decel_steps_s2).map(|mean| -mean)) / limits.decel_steps_s2,
        jerk: jerk / limits.jerk_steps_s3,
        corner: 0.0,
    }
}

/// Means of a derivative over windows of `N` edges that are `spacing_s` apart or more, each with its end: the derivative of
/// order `N` - 1.
fn means<const N: usize>(times_s: &[f64], spacing_s: f64) -> impl Iterator<Item = (f64, f64)> {
    const { assert!(N >= 2 && N <= ORDERS + 1) };
    let mut next = 0;
    let after: Vec<_> = times_s
        .iter()
        .map(|t_s| {
            next += times_s[next..].iter().take_while(|later_s| **later_s < t_s + spacing_s).count();
            next
        })
        .collect();
    (0..times_s.len()).map_while(move |first| {
        let mut edges = [first; N];
        for k in 1..N {
            edges[k] = *after.get(edges[k - 1])?;
        }
        let end_s = *times_s.get(edges[N - 1])?;
        Some((end_s, derivative(edges.map(|edge| times_s[edge]), edges.map(|edge| edge as f64))))
    })
}

/// N! times the divided difference of the places.
fn derivative<const N: usize>(times_s: [f64; N], mut places: [f64; N]) -> f64 {
    for order in 1..N {
        for k in 0..N - order {
            places[k] = order as f64 * (places[k + 1] - places[k]) / (times_s[k + order] - times_s[k]);
        }
    }
    places[0]
}

/// What share of the step that follows the first edge could not have been made by then. Seen from either end.
fn end(mut times_s: impl Iterator<Item = f64>, start_steps_s: f64, accel_steps_s2: f64) -> Option<f64> {
    let between_s = -(times_s.next()? - times_s.next()?);
    let speed_steps_s = (start_steps_s * start_steps_s + 2.0 * accel_steps_s2).sqrt();
    Some(1.0 / (between_s * (speed_steps_s + accel_steps_s2 * between_s / 2.0)))
}

fn highest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use crate::config::Port;
    use isostep_profile::{IntervalLaw, SyncMove};

    use super::*;

    const LIMITS: Limits = Limits {
        start_speed_steps_s: 50.0,
        top_speed_steps_s: 2_400.0,
        accel_steps_s2: 2_500.0,
        decel_steps_s2: 2_000.0,
        jerk_steps_s3: 25_000.0,
    };

    /// Of a move planned within `limits`, its instants rounded to the port's tick.
    fn measured(limits: Limits, law: SpeedLaw, port: Port) -> LimitRatios {
        let plan = SyncMove::plan([30_000], &[limits], IntervalLaw::Fastest, law, None).unwrap();
        let tick_s = port.tick_ns() * 1e-9;
        let times_s: Vec<_> = (1..=30_000).map(|k| (plan.step_time_s(0, k) / tick_s).round() * tick_s).collect();
        ratios(&times_s, port.tolerance_ns() * 1e-9, &LIMITS, law, Ends { at_rest: [true; 2] }, |_| {
            LIMITS.top_speed_steps_s
        })
    }

    #[test]
    fn limits_that_are_kept_are_measured_so() {
        for (law, port) in SpeedLaw::ALL.into_iter().flat_map(|law| Port::ALL.map(|port| (law, port))) {
            let ratios = measured(LIMITS, law, port);
            assert!(ratios.are_within(), "{law}, {port}: {ratios:?}");
            assert!(ratios.speed > 0.99 && ratios.accel > 0.97 && ratios.decel > 0.97, "{law}, {port}: {ratios:?}");
            assert!(law != SpeedLaw::SCurve || ratios.jerk > 0.97, "{port}: {ratios:?}");
        }
    }

    /// By a twentieth, each alone.
    #[test]
    fn a_limit_that_is_exceeded_shows() {
        let exceeded = |change: fn(&mut Limits)| {
            let mut limits = LIMITS;
            change(&mut limits);
            limits
        };
        for port in Port::ALL {
            for (law, limits) in [
                (SpeedLaw::Trapezoid, exceeded(|limits| limits.top_speed_steps_s *= 1.05)),
                (SpeedLaw::Trapezoid, exceeded(|limits| limits.accel_steps_s2 *= 1.05)),
                (SpeedLaw::Trapezoid, exceeded(|limits| limits.decel_steps_s2 *= 1.05)),
                (SpeedLaw::Sine, exceeded(|limits| limits.decel_steps_s2 *= 1.05)),
                (SpeedLaw::SCurve, exceeded(|limits| limits.jerk_steps_s3 *= 1.05)),
                (SpeedLaw::Trapezoid, exceeded(|limits| limits.start_speed_steps_s *= 3.0)),
            ] {
                let ratios = measured(limits, law, port);
                assert!(!ratios.are_within(), "{law}, {port}, {limits:?}: {ratios:?}");
            }
        }
    }
}
