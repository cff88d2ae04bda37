//! Measures the intervals of an axis whose ramps have the same shape as a plan's.
//!
//! # Method
//! Of the plan, only the shape of the ramps is used: which fraction of a ramp's distance takes which fraction of its
//! time. The durations of the three intervals and the start of the move are four unknowns. The distance gives the
//! cruise speed, v = n/(m_a t_a + t_v + m_d t_d), where m is the mean speed of a ramp as a fraction of v. The unknowns
//! are fitted to the axis's own edges by least squares (Gauss-Newton). An unknown is then a weighted sum of the edges'
//! instants. If the instants are off by at most e, an unknown is off by at most e times the sum of the weights'
//! magnitudes: that is its resolution.

use isostep_profile::Profile;

use super::least_squares::{self, UNKNOWNS};
use super::{EDGES_MIN, Intervals, Measured, Way, stray_max_ns};
use crate::config::Port;

/// If there are more edges, about this many evenly distributed ones are used, which give the same information.
const EDGES_MAX: usize = 2_000;
/// More than enough: from the plan as start, each iteration removes most of the remaining error.
const ITERATIONS: usize = 8;
/// Step for numerical derivatives, as a fraction of the duration. The errors by rounding and by curvature are then
/// 1e-10 of the derivatives.
const NUDGE: f64 = 1e-5;
/// The coarsest resolution that is accepted, as a fraction of the duration. It is exceeded without a cruise, where a
/// short cruise and ramps shorter by the same amount change the instants very little.
const RESOLUTION_MAX: f64 = 0.01;

/// When the move begins, and the durations of acceleration, cruise and deceleration, s.
type Unknowns = [f64; UNKNOWNS];

/// Measures an axis by all its edges, made by `port` on this way with the plan `profile`. `None` if they do not resolve its
/// intervals or do not lie on such a curve.
pub(super) fn intervals(times_s: &[f64], way: &Way, profile: &Profile, port: Port) -> Option<Measured> {
    if times_s.len() < UNKNOWNS {
        return None;
    }
    let curve = Curve::new(profile, way.steps)?;
    let points = points(times_s, way);
    let (unknowns, weights_sum, stray_s) = fit(&curve, &points)?;
    let grain_s = stray_s.max(port.tolerance_ns() * 1e-9);
    let resolution_s = weights_sum * grain_s;
    let is_on_curve = stray_s <= stray_max_ns(port) * 1e-9;
    let [_, accel_s, cruise_s, decel_s] = unknowns;
    (is_on_curve && resolution_s <= RESOLUTION_MAX * profile.duration_s())
        .then_some(Measured { intervals: Intervals { accel_s, cruise_s, decel_s }, resolution_s })
}

/// Displacements, in steps of the axis, and instants, s.
fn points(times_s: &[f64], way: &Way) -> Vec<(f64, f64)> {
    let stride = times_s.len().div_ceil(EDGES_MAX);
    let points = times_s.iter().enumerate().step_by(stride);
    points.map(|(index, &t_s)| (index as f64 + way.to_first_steps, t_s)).collect()
}

/// The unknowns, the largest sum of the weights of an interval, and the largest distance of an instant from the curve,
/// s.
fn fit(curve: &Curve, points: &[(f64, f64)]) -> Option<(Unknowns, f64, f64)> {
    let mut unknowns = curve.planned();
    unknowns[0] = points[0].1 - curve.instant_s(&unknowns, points[0].0);
    for _ in 0..ITERATIONS {
        let rows: Vec<_> = points.iter().map(|point| curve.slopes(&unknowns, point.0)).collect();
        let weights = least_squares::weights(&rows)?;
        let strays_s: Vec<_> = points.iter().map(|&(way, t_s)| t_s - curve.instant_s(&unknowns, way)).collect();
        let change = weights.each_ref().map(|of_edges| of_edges.iter().zip(&strays_s).map(|(w, s)| w * s).sum::<f64>());
        unknowns.iter_mut().zip(change).for_each(|(unknown, change)| *unknown += change);
        if change.iter().all(|change| change.abs() < 1e-12 * curve.profile.duration_s()) {
            let sums = weights[1..].iter().map(|of_edges| of_edges.iter().map(|weight| weight.abs()).sum::<f64>());
            return Some((unknowns, sums.fold(0.0, f64::max), strays_s.iter().fold(0.0, |most, s| s.abs().max(most))));
        }
    }
    None
}

/// Instants as a function of displacement.
struct Curve<'a> {
    profile: &'a Profile,
    /// Steps of this axis.
    steps: f64,
    /// Mean speed of the ramps as a fraction of the cruise speed: m_a and m_d.
    means: [f64; 2],
}

impl<'a> Curve<'a> {
    /// Over a distance of `steps`; `None` if a ramp has too few of them.
    fn new(profile: &'a Profile, steps: f64) -> Option<Self> {
        let decel_steps = profile.distance_steps() - profile.cruise_end_steps();
        let ratio = steps / profile.distance_steps();
        let is_known = |ramp_steps: f64| ramp_steps * ratio >= EDGES_MIN as f64;
        let mean = |steps: f64, duration_s: f64| steps / (duration_s * profile.cruise_speed_steps_s());
        let means = [mean(profile.accel_end_steps(), profile.t_accel_s()), mean(decel_steps, profile.t_decel_s())];
        (is_known(profile.accel_end_steps()) && is_known(decel_steps)).then_some(Self { profile, steps, means })
    }

    fn planned(&self) -> Unknowns {
        [0.0, self.profile.t_accel_s(), self.profile.t_cruise_s(), self.profile.t_decel_s()]
    }

    /// When the axis is at the displacement `way`, steps.
    fn instant_s(&self, &[start_s, accel_s, cruise_s, decel_s]: &Unknowns, way: f64) -> f64 {
        let [mean_accel, mean_decel] = self.means;
        let speed = self.steps / (mean_accel * accel_s + cruise_s + mean_decel * decel_s);
        let (accel_way, decel_way, left) =
            (speed * mean_accel * accel_s, speed * mean_decel * decel_s, self.steps - way);
        if way <= accel_way {
            start_s + accel_s * self.accel_ratio(way / accel_way)
        } else if left <= decel_way {
            start_s + accel_s + cruise_s + decel_s * (1.0 - self.decel_ratio(left / decel_way))
        } else {
            start_s + accel_s + (way - accel_way) / speed
        }
    }

    /// The fraction of its time in which the accelerating ramp covers the fraction `way` of its distance.
    fn accel_ratio(&self, way: f64) -> f64 {
        self.profile.time_at(way * self.profile.accel_end_steps()) / self.profile.t_accel_s()
    }

    /// The same for the decelerating ramp, with both fractions counted from its end.
    fn decel_ratio(&self, left: f64) -> f64 {
        let (distance, cruise_end) = (self.profile.distance_steps(), self.profile.cruise_end_steps());
        let t_s = self.profile.time_at(distance - left * (distance - cruise_end));
        (self.profile.duration_s() - t_s) / self.profile.t_decel_s()
    }

    /// The derivatives of the instant at `way` with respect to the unknowns.
    fn slopes(&self, unknowns: &Unknowns, way: f64) -> [f64; UNKNOWNS] {
        let nudge_s = NUDGE * self.profile.duration_s();
        std::array::from_fn(|index| {
            let [before, after] = [-nudge_s, nudge_s].map(|nudge_s| {
                let mut nudged = *unknowns;
                nudged[index] += nudge_s;
                self.instant_s(&nudged, way)
            });
            (after - before) / (2.0 * nudge_s)
        })
    }
}

#[cfg(test)]
mod tests {
    use isostep_profile::{IntervalSplit, Limits, SpeedProfile, SyncMove};

    use super::*;

    fn plan(
        speed_profile: SpeedProfile,
        interval_split: IntervalSplit,
        steps: [i32; 2],
        accel_steps_s2: f64,
    ) -> SyncMove<2> {
        let limits = Limits {
            start_speed_steps_s: if speed_profile.is_over_displacement() { 100.0 } else { 0.0 },
            top_speed_steps_s: 2_400.0,
            accel_steps_s2,
            decel_steps_s2: accel_steps_s2,
            jerk_steps_s3: 25_000.0,
        };
        SyncMove::plan(steps, &[limits; 2], interval_split, speed_profile, None).unwrap()
    }

    /// Instants of an axis that begins at an arbitrary instant, rounded to the port's tick as in the simulator.
    fn ticked(plan: &SyncMove<2>, axis: usize, port: Port) -> Vec<f64> {
        let tick_s = port.tick_ns() * 1e-9;
        (1..=plan.steps[axis].unsigned_abs())
            .map(|k| 0.123 + (plan.step_time_s(axis, k) / tick_s).round() * tick_s)
            .collect()
    }

    fn planned(profile: &Profile) -> Intervals {
        Intervals { accel_s: profile.t_accel_s(), cruise_s: profile.t_cruise_s(), decel_s: profile.t_decel_s() }
    }

    fn found(times_s: &[f64], profile: &Profile, port: Port) -> Option<Measured> {
        intervals(times_s, &Way::whole(times_s.len()), profile, port)
    }

    #[test]
    fn every_speed_profile_is_measured_to_ticks() {
        for speed_profile in SpeedProfile::ALL {
            for interval_split in [IntervalSplit::Fastest, IntervalSplit::Thirds] {
                let plan = plan(speed_profile, interval_split, [20_000, 3_000], 2_500.0);
                for (port, axis) in [(Port::Pio, 0), (Port::Pio, 1), (Port::Timer, 0), (Port::Timer, 1)] {
                    let found = found(&ticked(&plan, axis, port), &plan.profile, port).unwrap();
                    let apart_s = found.intervals.apart_s(&planned(&plan.profile));
                    let resolution_ticks = found.resolution_s * 1e9 / port.tick_ns();
                    assert!(
                        apart_s <= found.resolution_s,
                        "{speed_profile}, {interval_split:?}: {apart_s} of {found:?}"
                    );
                    assert!(
                        resolution_ticks < 100.0,
                        "{speed_profile}, {interval_split:?}, {port}: {resolution_ticks}"
                    );
                }
            }
        }
    }

    #[test]
    fn short_moves_are_measured_right_or_not_at_all() {
        for speed_profile in SpeedProfile::ALL {
            for long in [10, 60, 200, 900, 2_300, 4_000] {
                let plan = plan(speed_profile, IntervalSplit::Fastest, [long, long / 2], 2_500.0);
                for axis in [0, 1] {
                    let Some(found) = found(&ticked(&plan, axis, Port::Pio), &plan.profile, Port::Pio) else {
                        continue;
                    };
                    let apart_s = found.intervals.apart_s(&planned(&plan.profile));
                    assert!(apart_s <= found.resolution_s, "{speed_profile}, {long}: {apart_s} of {found:?}");
                }
            }
        }
    }

    /// The durations of the plan have no influence.
    #[test]
    fn another_acceleration_than_planned_shows() {
        for speed_profile in SpeedProfile::ALL {
            let [asked, made] =
                [2_500.0, 2_475.0].map(|accel| plan(speed_profile, IntervalSplit::Fastest, [20_000, 3_000], accel));
            // The shape of an S-curve depends on its acceleration, so the edges do not lie on the planned curve.
            let Some(found) = found(&ticked(&made, 1, Port::Pio), &asked.profile, Port::Pio) else {
                assert_eq!(speed_profile, SpeedProfile::SCurve);
                continue;
            };
            assert!(
                found.intervals.apart_s(&planned(&made.profile)) <= found.resolution_s,
                "{speed_profile}: {found:?}"
            );
            assert!(found.intervals.apart_s(&planned(&asked.profile)) > 1e-3, "{speed_profile}: {found:?}");
        }
    }
}
