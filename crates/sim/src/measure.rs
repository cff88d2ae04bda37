//! Measures the intervals of an axis from the instants of its own edges and nothing else.
//!
//! # Method
//! This is for constant acceleration from rest and to rest; all other lines, those between blends too, are fitted by the
//! shape of their ramps (`by_shape`). The k-th step of n is made at displacement x = k - 1/2. At constant acceleration from rest, its
//! instant is a linear function of the square root of x; at constant speed, of x; at constant deceleration to rest, of
//! the square root of n - x. So:
//!
//! 1. From the front, fit t = t_start + c sqrt(x) by least squares, and add edge after edge while the next lies close
//!    to the line. The acceleration is a = 2/c². The same from the back gives the deceleration d and the end, and so
//!    the total duration T.
//! 2. The edges in between are fitted by t = t_0 + x/v. A tenth at each end is left out, because these edges may belong
//!    to the ramps.
//! 3. t_accel = v/a, t_decel = v/d, and t_cruise is the rest of T.
//!
//! With few steps between the ramps, v is better computed from the distance: n = v T - v²/2 (1/a + 1/d), whose root is
//! t_cruise = sqrt(T² - 2 n (1/a + 1/d)). The method with the finer resolution is used.
//!
//! The resolution follows from the grain, the width of the band in which the instants lie about their line. The grain
//! shifts a line over a span s by a fraction of about grain/s. It is one tick, or the observed deviation of the edges
//! of the ramps if that is more. So a measurement comes with its resolution, and two that differ by less count as
//! equal.

pub mod across;
mod by_shape;
mod least_squares;
pub mod limits;
pub mod shaped;

use isostep_profile::Profile;

use crate::config::Port;

/// The next edge still belongs to a ramp if its distance from the line is at most this many times the tolerance of an
/// instant: a line through few points is itself off by several times the tolerance.
const STRAY_MAX: f64 = 6.0;
/// With fewer edges than this, a line is not reliable.
const EDGES_MIN: usize = 4;

/// Durations of acceleration, cruise and deceleration of an axis, s.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct Intervals {
    /// Acceleration.
    pub accel_s: f64,
    /// Constant speed.
    pub cruise_s: f64,
    /// Deceleration.
    pub decel_s: f64,
}

impl Intervals {
    /// The largest difference between corresponding intervals, s.
    pub fn apart_s(&self, other: &Self) -> f64 {
        let accel_s = (self.accel_s - other.accel_s).abs();
        accel_s.max((self.cruise_s - other.cruise_s).abs()).max((self.decel_s - other.decel_s).abs())
    }
}

/// Intervals and their resolution.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct Measured {
    /// The measured intervals.
    #[serde(flatten)]
    pub intervals: Intervals,
    /// The error that each of them may have, s.
    pub resolution_s: f64,
}

impl Measured {
    /// True if both may be the same intervals, within their resolution.
    pub fn agrees(&self, other: &Self) -> bool {
        self.intervals.apart_s(&other.intervals) <= self.resolution_s + other.resolution_s
    }
}

/// The largest distance of an edge made by `port` from its instant at which it can still be measured, ns.
pub fn stray_max_ns(port: Port) -> f64 {
    STRAY_MAX * port.tolerance_ns()
}

/// The distance of an axis, and where on this way its first edge is. Each edge is a step farther.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Way {
    /// Its distance, steps: beside a blend, not a whole number of them.
    pub steps: f64,
    /// From the beginning to the first edge, steps.
    pub to_first_steps: f64,
}

impl Way {
    /// The way of an axis that begins and ends at whole steps.
    pub fn whole(steps: usize) -> Self {
        Self { steps: steps as f64, to_first_steps: 0.5 }
    }
}

/// Measures an axis that goes this way with a line planned as `profile`; `times_s` are all its edges, made by `port`. `None`
/// if they are not sufficient.
pub fn intervals_of(profile: &Profile, way: &Way, times_s: &[f64], port: Port) -> Option<Measured> {
    let is_whole = *way == Way::whole(times_s.len());
    if is_whole && is_even_from_rest(profile) {
        intervals(times_s, port)
    } else {
        by_shape::intervals(times_s, way, profile, port)
    }
}

/// True if it is constant acceleration from rest to rest. Of all speed profiles, only this one begins without jerk.
fn is_even_from_rest(profile: &Profile) -> bool {
    let [begin, end] = [0.0, profile.duration_s()].map(|t_s| profile.jerk_at(t_s));
    profile.entry_speed_steps_s() == 0.0 && profile.exit_speed_steps_s() == 0.0 && begin == 0.0 && end == 0.0
}

/// Measures an axis that moves from rest to rest; `times_s` are all its edges, made by `port`. `None` if a ramp has too
/// few of them.
pub fn intervals(times_s: &[f64], port: Port) -> Option<Measured> {
    let n = times_s.len();
    let stray_max_s = stray_max_ns(port) * 1e-9;
    let forward = Ramp::fit(times_s.iter().copied(), stray_max_s)?;
    let backward = Ramp::fit(times_s.iter().rev().map(|t| -t), stray_max_s)?;
    let grain_s = forward.grain_s.max(backward.grain_s).max(port.tick_ns() * 1e-9);
    let duration_s = -backward.line.offset - forward.line.offset;
    let between = forward.edges..(n - backward.edges).max(forward.edges);
    let by_distance = speed_by_distance(n as f64, duration_s, [&forward, &backward], grain_s);
    let by_line = speed_by_line(times_s, between, duration_s, grain_s);
    let speed = by_line.filter(|line| line.resolution_s < by_distance.resolution_s).unwrap_or(by_distance);
    let (accel_s, decel_s) = (speed.value / forward.accel, speed.value / backward.accel);
    let intervals = Intervals { accel_s, cruise_s: duration_s - accel_s - decel_s, decel_s };
    // The errors of the fits of two ramps and of the duration add up.
    Some(Measured { intervals, resolution_s: speed.resolution_s + 6.0 * grain_s })
}

/// A cruise speed, and the resolution of an interval that follows from it.
struct Speed {
    value: f64,
    resolution_s: f64,
}

/// A ramp is no longer than the total duration, and its relative error is that of the speed.
fn speed_by_line(times_s: &[f64], between: std::ops::Range<usize>, duration_s: f64, grain_s: f64) -> Option<Speed> {
    let margin = between.len().div_ceil(10);
    let inner = between.start + margin..between.end.saturating_sub(margin);
    if inner.len() < EDGES_MIN {
        return None;
    }
    let mut sums = Sums::default();
    for index in inner.clone() {
        sums.add(index as f64 + 0.5, times_s[index]);
    }
    let span_s = times_s[inner.end - 1] - times_s[inner.start];
    Some(Speed { value: 1.0 / sums.line().slope, resolution_s: duration_s * grain_s / span_s })
}

/// Near zero the root has a poor resolution: the relative error of the squared cruise is a few times grain/ramp
/// duration.
fn speed_by_distance(n: f64, duration_s: f64, ramps: [&Ramp; 2], grain_s: f64) -> Speed {
    let per_speed_s: f64 = ramps.iter().map(|ramp| 1.0 / ramp.accel).sum();
    let shortest_s = ramps[0].span_s().min(ramps[1].span_s());
    let squared = duration_s.powi(2) - 2.0 * n * per_speed_s;
    let off = duration_s.powi(2) * 8.0 * grain_s / shortest_s;
    let cruise_s = if squared < off { 0.0 } else { squared.sqrt() };
    let resolution_s = if cruise_s == 0.0 { off.sqrt() } else { off / (2.0 * cruise_s) };
    Speed { value: (duration_s - cruise_s) / per_speed_s, resolution_s }
}

/// A ramp from rest.
struct Ramp {
    accel: f64,
    line: Line,
    edges: usize,
    /// Width of the band about the line that holds its edges, if they are evenly distributed in it.
    grain_s: f64,
}

impl Ramp {
    /// The duration of the ramp.
    fn span_s(&self) -> f64 {
        self.line.slope * (self.edges as f64).sqrt()
    }

    fn fit(times_s: impl Iterator<Item = f64> + Clone, stray_max_s: f64) -> Option<Self> {
        let points = times_s.enumerate().map(|(index, t_s)| ((index as f64 + 0.5).sqrt(), t_s));
        let mut sums = Sums::default();
        for (root, t_s) in points.clone() {
            if sums.count >= EDGES_MIN && sums.line().stray_s(root, t_s) > stray_max_s {
                break;
            }
            sums.add(root, t_s);
        }
        let (line, edges) = (sums.line(), sums.count);
        let strays_s = points.take(edges).map(|(root, t_s)| line.stray_s(root, t_s));
        // Fewer points than the minimum are not a ramp, nor are points that are not on a line.
        if edges < EDGES_MIN || strays_s.clone().any(|stray_s| stray_s > stray_max_s) {
            return None;
        }
        // In such a band the mean distance from its middle is a quarter of its width.
        let grain_s = 4.0 * strays_s.sum::<f64>() / edges as f64;
        Some(Self { accel: 2.0 / line.slope.powi(2), line, edges, grain_s })
    }
}

#[derive(Clone, Copy)]
struct Line {
    offset: f64,
    slope: f64,
}

impl Line {
    fn at(&self, x: f64) -> f64 {
        self.offset + self.slope * x
    }

    /// Distance of a point from the line.
    fn stray_s(&self, x: f64, t_s: f64) -> f64 {
        (self.at(x) - t_s).abs()
    }
}

/// Running sums of a least-squares line, relative to the first point to reduce cancellation.
#[derive(Default)]
struct Sums {
    count: usize,
    first: (f64, f64),
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
}

impl Sums {
    fn add(&mut self, x: f64, y: f64) {
        if self.count == 0 {
            self.first = (x, y);
        }
        let (x, y) = (x - self.first.0, y - self.first.1);
        self.count += 1;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
    }

    fn line(&self) -> Line {
        let n = self.count as f64;
        let slope = (n * self.xy - self.x * self.y) / (n * self.xx - self.x * self.x);
        let offset = (self.y - slope * self.x) / n;
        Line { offset: self.first.1 + offset - slope * self.first.0, slope }
    }
}

#[cfg(test)]
mod tests {
    use isostep_profile::{IntervalSplit, Limits, SpeedProfile, SyncMove};

    use super::*;

    /// Instants of an axis, rounded to the port's tick as in the simulator.
    fn ticked(plan: &SyncMove<2>, axis: usize, port: Port) -> Vec<f64> {
        let tick_s = port.tick_ns() * 1e-9;
        (1..=plan.steps[axis].unsigned_abs()).map(|k| (plan.step_time_s(axis, k) / tick_s).round() * tick_s).collect()
    }

    /// For each axis that can be measured: its difference from the plan and the tolerance, both in ticks.
    fn apart_ticks(steps: [i32; 2], accels: (f64, f64), speed_profile: IntervalSplit, port: Port) -> Vec<(f64, f64)> {
        let limits = Limits {
            start_speed_steps_s: 0.0,
            top_speed_steps_s: 2_400.0,
            accel_steps_s2: accels.0,
            decel_steps_s2: accels.1,
            jerk_steps_s3: f64::INFINITY,
        };
        let plan = SyncMove::plan(steps, &[limits; 2], speed_profile, SpeedProfile::Trapezoid, None).unwrap();
        let profile = plan.profile;
        let planned =
            Intervals { accel_s: profile.t_accel_s(), cruise_s: profile.t_cruise_s(), decel_s: profile.t_decel_s() };
        let measured = [0, 1].into_iter().filter_map(|axis| intervals(&ticked(&plan, axis, port), port));
        let ticks = |s: f64| s * 1e9 / port.tick_ns();
        measured.map(|found| (ticks(found.intervals.apart_s(&planned)), ticks(found.resolution_s))).collect()
    }

    #[test]
    fn trapezoids_are_measured_to_ticks() {
        for port in Port::ALL {
            for steps in [[20_000, 3_000], [8_000, -7_777], [6_000, 250]] {
                for accels in [(2_500.0, 2_500.0), (2_500.0, 5_000.0)] {
                    let found = apart_ticks(steps, accels, IntervalSplit::Fastest, port);
                    assert_eq!(found.len(), 2);
                    for (apart, resolution) in found {
                        assert!(apart <= resolution && resolution < 20.0, "{steps:?}, {port}: {apart} of {resolution}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_measured_is_right_within_its_resolution() {
        // Triangles, cruises of a few steps, and moves of few steps.
        for long in [14, 150, 1_000, 2_304, 2_310, 2_330, 2_400, 2_500, 3_000] {
            for short in [12, 100, long / 2, long] {
                for speed_profile in [IntervalSplit::Fastest, IntervalSplit::Thirds] {
                    for port in Port::ALL {
                        let found = apart_ticks([long, short.min(long)], (2_500.0, 2_500.0), speed_profile, port);
                        for (apart, resolution) in found {
                            assert!(
                                apart <= resolution,
                                "{long}, {short}, {speed_profile:?}, {port}: {apart} of {resolution}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn too_few_edges_are_not_measured() {
        for port in Port::ALL {
            assert_eq!(intervals(&[0.1, 0.2, 0.3], port), None);
            assert_eq!(intervals(&[], port), None);
            let constant: Vec<_> = (0..100).map(|k| f64::from(k) * 0.02).collect();
            assert_eq!(intervals(&constant, port), None);
        }
    }
}
