//! The closeness of an axis to its limits, measured from its edges and nothing else. Corners of a run are checked by their
//! planned speeds; of shaped runs see [`shaped`].
//!
//! # Method
//! The edge of step k means that the axis is at k - 1/2 steps at that instant. The position is uncertain by off v, the
//! distance that the axis makes in the time `off` by which an edge may be off. For m + 1 edges, m! times the divided
//! difference of their positions is a mean of the m-th derivative over the time between them, with weights that are all
//! positive (a B-spline). So if the speed, the acceleration or the jerk stays within a limit, this mean does too, even
//! if the derivative jumps: the measurement has no bias.
//!
//! The remaining error comes from the uncertainty of the edges. If edges are at least h apart, the error of the mean is
//! at most 2^m off v/h^m, since the sum of 1/((m - k)! k!) over k is 2^m/m!. Windows are chosen so wide that this is
//! [`GRAIN`] of the limit. For the default gantry at its top speed, an acceleration is measured over twice 3 ms, or
//! with ticks of 1 us over twice 16 ms; a jerk is measured over three times 12 or 36 ms. If steps are farther apart
//! than that, the windows are two or three steps. So an axis that stays within its limits is measured within 1 +
//! [`GRAIN`] of them.
//!
//! Only the speed jumps: from rest to the start speed v_s, and back. The first edge is less than a step from the start
//! of a run, so the speed at this edge is at most √(v_s² + 2 a). The second edge comes no earlier than this speed and
//! the acceleration a allow.

use isostep_motion::{AXES, Config};
use isostep_profile::{Limits, SpeedProfile};

use super::shaped;
use crate::analysis::mean_derivative;
use crate::moves::MoveRecord;
use crate::outcome::Outcome;
use crate::verify;

/// By what fraction a measurement may exceed a limit that is kept.
pub const GRAIN: f64 = 0.01;

/// The measured derivatives: speed, acceleration and jerk.
const ORDERS: usize = 3;

/// The highest measured values, each as a fraction of its limit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct LimitRatios {
    /// Fraction of the speed limit in force.
    pub speed: f64,
    /// Fraction of the start speed, at either end of a run.
    pub ends: f64,
    /// Fraction of the acceleration limit.
    pub accel: f64,
    /// Fraction of the deceleration limit.
    pub decel: f64,
    /// Fraction of the jerk limit, for a speed profile that has one.
    pub jerk: f64,
    /// Fraction of the allowed speed at a corner. By the plan, not measured here.
    pub corner: f64,
}

/// True if a motion begins and ends at rest.
#[derive(Clone, Copy, Debug)]
pub struct Ends {
    /// Its start and its end.
    pub at_rest: [bool; 2],
}

impl LimitRatios {
    /// The higher value of both, for each limit.
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

    /// True if every limit was kept.
    #[must_use]
    pub fn are_within(&self) -> bool {
        [self.speed, self.ends, self.accel, self.decel, self.jerk, self.corner]
            .into_iter()
            .all(|ratio| ratio <= 1.0 + GRAIN)
    }
}

/// Measures one axis over one motion in one direction. `times_s` are all its edges, each off by `off_s` at most.
/// `speed_at` is its speed limit at an instant, steps/s, which never decreases.
pub fn ratios(
    times_s: &[f64],
    off_s: f64,
    limits: &Limits,
    speed_profile: SpeedProfile,
    ends: Ends,
    speed_at: impl Fn(f64) -> f64,
) -> LimitRatios {
    let (Some(&first_s), Some(&last_s)) = (times_s.first(), times_s.last()) else { return LimitRatios::default() };
    let top = speed_at(last_s);
    let spacing_s = |order: i32, limit: f64| spacing_s(order, off_s * top, limit);
    let speed = means::<2>(times_s, 2.0 * off_s / GRAIN).map(|(t_s, mean)| mean / speed_at(t_s));
    let accels = |limit| means::<3>(times_s, spacing_s(2, limit)).map(|(_, mean)| mean);
    let start = |instant_s| limits.start_speed_steps_s.min(speed_at(instant_s));
    let jerk = match speed_profile {
        SpeedProfile::SCurve if limits.jerk_steps_s3.is_finite() => {
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

/// The spacing of edges needed to measure the derivative of this order against this limit, s, if a position is uncertain
/// by `off_steps`.
fn spacing_s(order: i32, off_steps: f64, limit: f64) -> f64 {
    2.0 * (off_steps / (GRAIN * limit)).powf(1.0 / f64::from(order))
}

/// The spacing with which both accelerations of an axis are measured at any of its speeds, s.
pub(super) fn accel_span_s(limits: &Limits, off_s: f64) -> f64 {
    spacing_s(2, off_s * limits.top_speed_steps_s, limits.accel_steps_s2.min(limits.decel_steps_s2))
}

/// The mean acceleration over three samples of time and place.
pub(super) fn mean_accel(samples: [(f64, f64); 3]) -> f64 {
    mean_derivative(samples.map(|sample| sample.0), samples.map(|sample| sample.1))
}

/// Means of the derivative of order `N` - 1 over windows of `N` edges that are at least `spacing_s` apart, each with
/// the end of its window.
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
        Some((end_s, mean_derivative(edges.map(|edge| times_s[edge]), edges.map(|edge| edge as f64))))
    })
}

/// The fraction of the step after the first edge that cannot have been made by the second edge. The other end is
/// measured in reversed time.
fn end(mut times_s: impl Iterator<Item = f64>, start_steps_s: f64, accel_steps_s2: f64) -> Option<f64> {
    let between_s = -(times_s.next()? - times_s.next()?);
    let speed_steps_s = (start_steps_s * start_steps_s + 2.0 * accel_steps_s2).sqrt();
    Some(1.0 / (between_s * (speed_steps_s + accel_steps_s2 * between_s / 2.0)))
}

fn highest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, f64::max)
}

/// These limits, with the higher acceleration for both.
pub(super) fn either_way(limits: &Limits) -> Limits {
    let accel = limits.accel_steps_s2.max(limits.decel_steps_s2);
    Limits { accel_steps_s2: accel, decel_steps_s2: accel, ..*limits }
}

/// Tolerance for floating-point rounding.
const ROUNDING: f64 = 1e-6;

/// The closeness of all moves to their limits. `speed_limit` is the speed limit of an axis in a move at a time in s from
/// the start of its run, steps/s; it never decreases. Of a shaped run it is the top speed.
pub fn of_run(outcome: &Outcome, speed_limit: impl Fn(&MoveRecord, usize, f64) -> f64) -> LimitRatios {
    let off_s = outcome.config.port.tolerance_ns() * 1e-9;
    let mut highest = shaped::ratios(outcome).into_iter().fold(LimitRatios::default(), LimitRatios::max);
    for record in outcome.moves.iter().filter(|record| record.shaping.is_none()) {
        let config = outcome.config_of(record);
        let [begins, ends] = are_rests(record, config);
        // A stopped move ends abruptly, not at rest.
        let ends = Ends { at_rest: [begins, ends && record.is_whole()] };
        for (axis, times_s) in line_times_s(outcome, record).iter().enumerate() {
            let (own, speed_profile) = (&config.limits[axis], config.speed_profile);
            highest =
                highest.max(ratios(times_s, off_s, own, speed_profile, ends, |t_s| speed_limit(record, axis, t_s)));
        }
    }
    let corners = outcome.moves.windows(2).filter(|pair| pair[0].run == pair[1].run);
    let corner =
        corners.map(|pair| corner_ratio([&pair[0], &pair[1]], outcome.config_of(&pair[0]))).fold(0.0, f64::max);
    LimitRatios { corner, ..highest }
}

/// Instants of each axis's edges on the line of a move, s from the beginning of the move. In a blend an axis may turn.
pub fn line_times_s(outcome: &Outcome, record: &MoveRecord) -> [Vec<f64>; AXES] {
    let mut times_s = verify::axis_times_s(record, outcome.edges_of(record));
    for (axis, times_s) in times_s.iter_mut().enumerate() {
        times_s.drain(..times_s.len().min(record.blend_steps(axis) as usize));
    }
    times_s
}

/// The length of a path of these steps, mm.
pub fn path_mm(steps: [i32; AXES], config: &Config) -> f64 {
    length_mm(std::array::from_fn(|axis| f64::from(steps[axis]) / config.steps_per_mm[axis]))
}

/// The speed of a move at its start and its end, along its path.
pub fn speeds_mm_s(record: &MoveRecord, config: &Config) -> [f64; 2] {
    let mm_per_step = length_mm(way_mm(record, config)) / record.plan.distance_steps();
    [record.plan.speed_at(record.plan.begin_s()), record.last_part().profile.exit_speed_steps_s()]
        .map(|steps| steps * mm_per_step)
}

/// True if a move begins and ends at the start speed or slower.
pub fn are_rests(record: &MoveRecord, config: &Config) -> [bool; 2] {
    let start_mm_s = start_mm_s(record, config);
    let [begins, ends] = speeds_mm_s(record, config).map(|speed_mm_s| speed_mm_s <= start_mm_s * (1.0 + ROUNDING));
    [begins && record.blend.is_none(), ends && !record.ends_in_blend]
}

/// The distance of a move along each axis, mm.
pub fn way_mm(record: &MoveRecord, config: &Config) -> [f64; AXES] {
    std::array::from_fn(|axis| record.plan.axis_steps(axis) / config.steps_per_mm[axis])
}

fn length_mm(way_mm: [f64; AXES]) -> f64 {
    way_mm.into_iter().map(|mm| mm * mm).sum::<f64>().sqrt()
}

/// The start speed along a path.
fn start_mm_s(record: &MoveRecord, config: &Config) -> f64 {
    let path_mm = length_mm(way_mm(record, config));
    let steps = |axis: usize| record.plan.axis_steps(axis).abs();
    let moving = (0..AXES).filter(|axis| steps(*axis) > 0.0);
    let starts = moving.map(|axis| config.limits[axis].start_speed_steps_s * path_mm / steps(axis));
    starts.fold(f64::INFINITY, f64::min)
}

/// The speed at a corner as a fraction of that allowed by Grbl's rule. Both moves must have the same speed there, or
/// both must be at rest. Otherwise the result is infinite.
fn corner_ratio(moves: [&MoveRecord; 2], config: &Config) -> f64 {
    if moves[0].ends_in_blend {
        return 0.0;
    }
    let [[_, out_mm_s], [in_mm_s, _]] = moves.map(|record| speeds_mm_s(record, config));
    let [[_, stops], [starts, _]] = moves.map(|record| are_rests(record, config));
    if stops && starts {
        return 0.0;
    }
    let is_one = (out_mm_s / in_mm_s - 1.0).abs() < ROUNDING;
    if is_one { in_mm_s / corner_mm_s(moves, config) } else { f64::INFINITY }
}

/// The highest speed at which the corner between two moves may be taken.
fn corner_mm_s(moves: [&MoveRecord; 2], config: &Config) -> f64 {
    let [before, after] = moves.map(|record| {
        let way_mm = way_mm(record, config);
        way_mm.map(|mm| mm / length_mm(way_mm))
    });
    let across: [f64; AXES] = std::array::from_fn(|axis| after[axis] - before[axis]);
    let length = across.iter().map(|part| part * part).sum::<f64>().sqrt();
    if length < 1e-9 {
        return f64::INFINITY;
    }
    let moving = (0..AXES).filter(|axis| across[*axis] != 0.0);
    let accels = moving.map(|axis| {
        let limits = &config.limits[axis];
        limits.accel_steps_s2.min(limits.decel_steps_s2) / config.steps_per_mm[axis] * length / across[axis].abs()
    });
    let accel_mm_s2 = accels.fold(f64::INFINITY, f64::min);
    // The sine of half the angle between the reversed first path and the second path.
    let sine = (1.0 - length * length / 4.0).max(0.0).sqrt();
    // A corner may always be taken at the start speed.
    let start_mm_s = moves.map(|record| start_mm_s(record, config)).into_iter().fold(f64::INFINITY, f64::min);
    (accel_mm_s2 * config.junction_deviation_mm * sine / (1.0 - sine)).sqrt().max(start_mm_s)
}

#[cfg(test)]
mod tests {
    use crate::config::Port;
    use isostep_profile::{IntervalSplit, SyncMove};

    use super::*;

    const LIMITS: Limits = Limits {
        start_speed_steps_s: 50.0,
        top_speed_steps_s: 2_400.0,
        accel_steps_s2: 2_500.0,
        decel_steps_s2: 2_000.0,
        jerk_steps_s3: 25_000.0,
    };

    /// Measures a move planned within `limits`, with its instants rounded to the port's tick.
    fn measured(limits: Limits, speed_profile: SpeedProfile, port: Port) -> LimitRatios {
        let plan = SyncMove::plan([30_000], &[limits], IntervalSplit::Fastest, speed_profile, None).unwrap();
        let tick_s = port.tick_ns() * 1e-9;
        let times_s: Vec<_> = (1..=30_000).map(|k| (plan.step_time_s(0, k) / tick_s).round() * tick_s).collect();
        ratios(&times_s, port.tolerance_ns() * 1e-9, &LIMITS, speed_profile, Ends { at_rest: [true; 2] }, |_| {
            LIMITS.top_speed_steps_s
        })
    }

    #[test]
    fn limits_that_are_kept_are_measured_so() {
        for (speed_profile, port) in
            SpeedProfile::ALL.into_iter().flat_map(|speed_profile| Port::ALL.map(|port| (speed_profile, port)))
        {
            let ratios = measured(LIMITS, speed_profile, port);
            assert!(ratios.are_within(), "{speed_profile}, {port}: {ratios:?}");
            assert!(
                ratios.speed > 0.99 && ratios.accel > 0.97 && ratios.decel > 0.97,
                "{speed_profile}, {port}: {ratios:?}"
            );
            assert!(speed_profile != SpeedProfile::SCurve || ratios.jerk > 0.97, "{port}: {ratios:?}");
        }
    }

    /// Each limit alone is exceeded by a twentieth.
    #[test]
    fn a_limit_that_is_exceeded_shows() {
        let exceeded = |change: fn(&mut Limits)| {
            let mut limits = LIMITS;
            change(&mut limits);
            limits
        };
        for port in Port::ALL {
            for (speed_profile, limits) in [
                (SpeedProfile::Trapezoid, exceeded(|limits| limits.top_speed_steps_s *= 1.05)),
                (SpeedProfile::Trapezoid, exceeded(|limits| limits.accel_steps_s2 *= 1.05)),
                (SpeedProfile::Trapezoid, exceeded(|limits| limits.decel_steps_s2 *= 1.05)),
                (SpeedProfile::Sine, exceeded(|limits| limits.decel_steps_s2 *= 1.05)),
                (SpeedProfile::SCurve, exceeded(|limits| limits.jerk_steps_s3 *= 1.05)),
                (SpeedProfile::Trapezoid, exceeded(|limits| limits.start_speed_steps_s *= 3.0)),
            ] {
                let ratios = measured(limits, speed_profile, port);
                assert!(!ratios.are_within(), "{speed_profile}, {port}, {limits:?}: {ratios:?}");
            }
        }
    }
}
