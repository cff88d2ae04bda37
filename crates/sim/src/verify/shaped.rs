//! Checks shaped runs, each as a whole.
//!
//! In a shaped run an axis may turn elsewhere than its moves do, and the edges of one move overlap with those of the next.
//! So the edges are compared with the closed form of the whole run ([`Places`]): each is due where the axis is half a step
//! from a whole one, and between two of them the axis is nowhere farther than that from its count.
//!
//! # What may be otherwise, and why
//! - Where an axis turns, an edge out and its edge back are left out if a driver at top speed would have them nearer than
//!   two of its steps. At an acceleration a and a top speed v the axis goes no farther beyond its half step than a/(8 v²).
//! - Where an axis turns from one piece of its motion to the next, the edge back waits until the driver's shortest period
//!   after the edge out is over: so it may be late, but not early.
//! - No edge is nearer than 1e-6 steps to where an axis stands, because rounding decides whether it gets there.

use isostep_motion::{AXES, Axis};

use crate::moves::MoveRecord;
use crate::outcome::Outcome;
use crate::places::Places;

/// The effect of rounding on a place, steps.
const ROUNDING_STEPS: f64 = 1e-8;
/// An edge is no nearer than this to where an axis stands, steps; a tenth more for rounding.
const NEAREST_STEPS: f64 = 1.1e-6;
/// An edge that is farther off than this has no instant, ns.
const OFF_MAX_NS: f64 = 1e9;
/// The number of times that an interval with the instant of such an edge is halved.
const HALVINGS: u32 = 10;

/// The results for one shaped run.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RunCheck {
    /// Index of its first move in [`Outcome::moves`].
    pub first: usize,
    /// Steps that were made, signed.
    pub emitted_steps: [i32; AXES],
    /// Steps that should have been made, signed; `None` if it was stopped before its end.
    pub planned_steps: Option<[i32; AXES]>,
    /// The place where an axis was first farther than half a step from its count, if anywhere.
    pub missing: Option<Place>,
    /// The edge that was farthest from its closed-form instant, and that distance, ns.
    pub worst: Option<(Place, f64)>,
}

/// A place.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The axis.
    pub axis: Axis,
    /// When, s since power-up.
    pub t_s: f64,
}

impl RunCheck {
    /// True if exactly the planned steps were made, and none was missing on the way.
    pub fn is_exact(&self) -> bool {
        self.missing.is_none() && self.planned_steps.is_none_or(|planned| planned == self.emitted_steps)
    }

    /// The largest distance of an edge from its closed-form instant, ns.
    pub fn error_max_ns(&self) -> f64 {
        self.worst.map_or(0.0, |(_, error_ns)| error_ns)
    }
}

/// The results for all shaped runs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Findings {
    /// Number of shaped runs.
    pub runs: usize,
    /// The number of them that are exact.
    pub exact: usize,
    /// The largest distance of an edge from its closed-form instant, ns.
    pub error_max_ns: f64,
    /// The place where the first step is missing, if one is.
    missing: Option<Place>,
}

impl Findings {
    /// The results for the shaped runs of a program.
    pub fn of(outcome: &Outcome) -> Self {
        runs(outcome).fold(Self::default(), |findings, check| Self {
            runs: findings.runs + 1,
            exact: findings.exact + usize::from(check.is_exact()),
            error_max_ns: findings.error_max_ns.max(check.error_max_ns()),
            missing: findings.missing.or(check.missing),
        })
    }

    /// These results, and then those.
    pub fn and(self, later: Self) -> Self {
        Self {
            runs: self.runs + later.runs,
            exact: self.exact + later.exact,
            error_max_ns: self.error_max_ns.max(later.error_max_ns),
            missing: self.missing.or(later.missing),
        }
    }

    /// The number of exact ones, in words; `None` if no run is shaped.
    pub fn words(&self) -> Option<String> {
        let Self { runs, exact, missing, .. } = self;
        let missing =
            missing.map_or(String::new(), |at| format!("; a step of {} is missing at {:.6} s", at.axis, at.t_s));
        (*runs > 0).then(|| format!("{exact} of {runs} shaped runs{missing}"))
    }
}

/// Checks every shaped run of the program.
pub fn runs(outcome: &Outcome) -> impl Iterator<Item = RunCheck> {
    outcome.runs().filter(|(_, run)| run[0].shaping.is_some()).map(|(first, run)| check(outcome, first, run))
}

fn check(outcome: &Outcome, first: usize, run: &[MoveRecord]) -> RunCheck {
    let (places, last) = (Places::of(run, outcome.kinematics), &run[run.len() - 1]);
    let is_whole = last.is_whole();
    let axes = Axis::ALL.map(|axis| Track::of(outcome, run, &places, axis));
    let start_s = run[0].start_ns as f64 * 1e-9;
    let place = |(axis, t_s): (usize, f64)| Place { axis: Axis::ALL[axis], t_s: start_s + t_s };
    let worst = axes
        .iter()
        .enumerate()
        .flat_map(|(axis, track)| track.errors_ns().map(move |(t_s, error_ns)| ((axis, t_s), error_ns.abs())));
    let end_s = if is_whole { last.plan_s } else { axes.iter().filter_map(Track::last_s).fold(0.0, f64::max) };
    let missing = axes.iter().enumerate().filter_map(|(axis, track)| Some((axis, track.missing_s(end_s)?)));
    RunCheck {
        first,
        emitted_steps: std::array::from_fn(|axis| axes[axis].edges.iter().map(|edge| edge.direction).sum()),
        planned_steps: is_whole.then(|| {
            let planned = last.planned_steps();
            std::array::from_fn(|axis| last.origin_steps[axis] + planned[axis] - run[0].origin_steps[axis])
        }),
        missing: missing.min_by(|one, other| one.1.total_cmp(&other.1)).map(place),
        worst: worst.max_by(|one, other| one.1.total_cmp(&other.1)).map(|(at, error_ns)| (place(at), error_ns)),
    }
}

/// For each edge of an axis of a shaped run, its instant, s since power-up, and how much later than the closed form it was,
/// ns.
pub fn errors_ns(outcome: &Outcome, run: &[MoveRecord], axis: Axis) -> Vec<(f64, f64)> {
    let places = Places::of(run, outcome.kinematics);
    let track = Track::of(outcome, run, &places, axis);
    let start_s = run[0].start_ns as f64 * 1e-9;
    track.errors_ns().map(|(t_s, error_ns)| (start_s + t_s, error_ns)).collect()
}

/// The edges of one axis in a run, and where it should be.
struct Track<'a> {
    places: &'a Places<'a>,
    axis: usize,
    origin_steps: i32,
    edges: Vec<TrackEdge>,
    /// The error that an edge may have, ns.
    tolerance_ns: f64,
    /// Its highest acceleration, steps/s².
    accel_steps_s2: f64,
    top_steps_s: f64,
}

struct TrackEdge {
    /// s from the start of the run.
    t_s: f64,
    direction: i32,
    /// It follows one in the other direction as soon as the driver allows.
    is_kept_apart: bool,
}

impl<'a> Track<'a> {
    fn of(outcome: &Outcome, run: &[MoveRecord], places: &'a Places<'a>, axis: Axis) -> Self {
        let (first, config, port) = (&run[0], outcome.config_of(&run[0]), outcome.config.port);
        let axis = axis as usize;
        let period_ticks = outcome.capabilities[axis].map_or(0, |port| port.period_min_ticks(config.wiring[axis]));
        let period_s = (f64::from(period_ticks) + 1.0) * port.tick_ns() * 1e-9;
        let mut edges: Vec<TrackEdge> = Vec::new();
        for edge in outcome.edges_of_run(run) {
            if edge.axis == axis {
                let (t_s, direction) = ((edge.t_ns as f64 - first.start_ns as f64) * 1e-9, edge.direction);
                let turns_from = edges.last().filter(|before| before.direction != direction);
                let is_kept_apart = turns_from.is_some_and(|before| t_s - before.t_s <= period_s);
                edges.push(TrackEdge { t_s, direction, is_kept_apart });
            }
        }
        let limits = &config.limits[axis];
        Self {
            places,
            axis,
            origin_steps: first.origin_steps[axis],
            edges,
            tolerance_ns: port.tolerance_ns(),
            accel_steps_s2: limits.accel_steps_s2.max(limits.decel_steps_s2),
            top_steps_s: limits.top_speed_steps_s,
        }
    }

    fn last_s(&self) -> Option<f64> {
        self.edges.last().map(|edge| edge.t_s)
    }

    /// For each edge, its instant, s, and how much later than the closed form it was, ns.
    fn errors_ns(&self) -> impl Iterator<Item = (f64, f64)> {
        let mut count = self.origin_steps;
        self.edges.iter().map(move |edge| {
            let half_steps = f64::from(count) + 0.5 * f64::from(edge.direction);
            count += edge.direction;
            (edge.t_s, self.error_ns(edge, half_steps))
        })
    }

    /// The time by which an edge was later than the axis passed this place in its direction, ns.
    fn error_ns(&self, edge: &TrackEdge, half_steps: f64) -> f64 {
        let beyond = |t_s: f64| f64::from(edge.direction) * (self.places.steps(self.axis, t_s) - half_steps);
        let error_ns = nearest_ns(&beyond, edge, self.tolerance_ns, ROUNDING_STEPS);
        let speed_steps_s = (beyond(edge.t_s + 1e-6) - beyond(edge.t_s - 1e-6)).abs() / 2e-6;
        let slow_steps_s = 1.5 * (2.0 * self.accel_steps_s2 * NEAREST_STEPS).sqrt();
        if error_ns.abs() > self.tolerance_ns && speed_steps_s < slow_steps_s {
            return nearest_ns(&beyond, edge, self.tolerance_ns, NEAREST_STEPS);
        }
        error_ns
    }

    /// When the axis is first farther than half a step from its count, up to `end_s`; all s from the start of the run.
    fn missing_s(&self, end_s: f64) -> Option<f64> {
        let left_out_steps = self.accel_steps_s2 / (8.0 * self.top_steps_s * self.top_steps_s);
        let allowed = 0.5 + left_out_steps + self.top_steps_s * self.tolerance_ns * 1e-9 + NEAREST_STEPS;
        let (mut made, mut count) = (0, self.origin_steps);
        self.turns().take_while(|(t_s, _)| *t_s <= end_s).find_map(|(t_s, steps)| {
            while let Some(edge) = self.edges.get(made).filter(|edge| edge.t_s <= t_s) {
                (made, count) = (made + 1, count + edge.direction);
            }
            let waits = self.edges.get(made).is_some_and(|next| next.is_kept_apart);
            ((steps - f64::from(count)).abs() > allowed && !waits).then_some(t_s)
        })
    }

    /// Everywhere that the axis may be farthest, in order: where it turns, and where its acceleration changes; each is an
    /// instant and a place.
    fn turns(&self) -> impl Iterator<Item = (f64, f64)> {
        let steps = |t_s: f64| self.places.steps(self.axis, t_s);
        let mut from = (0.0, steps(0.0));
        self.places.bends_s(self.axis).flat_map(move |to_s| {
            let begin = std::mem::replace(&mut from, (to_s, steps(to_s)));
            let at_s = move |share: f64| begin.0 + share * (to_s - begin.0);
            let turns = turns_of_cubic([begin.1, steps(at_s(1.0 / 3.0)), steps(at_s(2.0 / 3.0)), from.1]);
            turns.into_iter().flatten().map(move |share| (at_s(share), steps(at_s(share)))).chain([from])
        })
    }
}

/// The turning points of a cubic within an interval, as shares of it, in order. Its values are those at the beginning, after a
/// third, after two thirds and at the end. A parabola is one, too.
fn turns_of_cubic([begin, third, two_thirds, end]: [f64; 4]) -> [Option<f64>; 2] {
    // The coefficients of its slope, times 2: a share² + b share + c.
    let a = 27.0 * (end - begin + 3.0 * (third - two_thirds));
    let b = 18.0 * (2.0 * begin - 5.0 * third + 4.0 * two_thirds - end);
    let c = -11.0 * begin + 18.0 * third - 9.0 * two_thirds + 2.0 * end;
    let half = -0.5 * (b + (b * b - 4.0 * a * c).sqrt().copysign(b));
    let within = |share: f64| (share > 0.0 && share < 1.0).then_some(share);
    let (one, other) = (within(half / a), within(c / half));
    if one < other { [one, other] } else { [other, one] }
}

/// The time by which an edge was later than a place was passed, to which `beyond` is negative before and positive behind, ns. A
/// place so near that it is within `slack_steps` counts as passed. Positive if it was late. What is within the tolerance is at
/// most the tolerance itself, to the last digit.
fn nearest_ns(beyond: &impl Fn(f64) -> f64, edge: &TrackEdge, tolerance_ns: f64, slack_steps: f64) -> f64 {
    let around = |off_ns: f64| [beyond(edge.t_s - off_ns * 1e-9), beyond(edge.t_s + off_ns * 1e-9)];
    let is_off = |[before, after]: [f64; 2]| after < -slack_steps || !edge.is_kept_apart && before > slack_steps;
    let [before, after] = around(tolerance_ns);
    if !is_off([before, after]) {
        // So near that the axis has one speed.
        let is_passed = edge.is_kept_apart && before > 0.0 || after - before <= 2.0 * slack_steps;
        let late = if is_passed { 0.0 } else { (before + after) / (after - before) };
        return tolerance_ns * late.clamp(-1.0, 1.0);
    }
    let sign = if after < -slack_steps { -1.0 } else { 1.0 };
    let (mut least_ns, mut most_ns) = (tolerance_ns, 2.0 * tolerance_ns);
    while is_off(around(most_ns)) {
        if most_ns > OFF_MAX_NS {
            return sign * most_ns;
        }
        (least_ns, most_ns) = (most_ns, 2.0 * most_ns);
    }
    for _ in 0..HALVINGS {
        let middle_ns = 0.5 * (least_ns + most_ns);
        if is_off(around(middle_ns)) { least_ns = middle_ns } else { most_ns = middle_ns }
    }
    sign * most_ns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_turns_where_its_slope_is_zero() {
        let turns = |of: fn(f64) -> f64| {
            turns_of_cubic([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(of))
                .map(|turn| turn.map(|share| (share * 1e9).round() / 1e9))
        };
        assert_eq!(turns(|x| 2.0 * x * x * x - 3.0 * 0.7 * x * x + 6.0 * 0.1 * x + 5.0), [Some(0.2), Some(0.5)]);
        assert_eq!(turns(|x| (x - 0.25) * (x - 0.25)), [None, Some(0.25)], "a parabola");
        assert_eq!(turns(|x| 3.0 * x), [None, None], "a line");
        assert_eq!(turns(|_| 3.0), [None, None], "a rest");
    }

    /// The tolerance of a port is 24 ns, which is a bit more in seconds and back.
    #[test]
    fn an_edge_within_the_tolerance_is_off_by_no_more_than_the_tolerance() {
        let edge = TrackEdge { t_s: 0.1, direction: 1, is_kept_apart: false };
        let beyond = |t_s: f64| 1_000.0 * (t_s - 0.1 - 24e-9) - 1e-9;
        assert_eq!(nearest_ns(&beyond, &edge, 24.0, ROUNDING_STEPS), -24.0);
        let beyond = |t_s: f64| 1_000.0 * (t_s - 0.1 - 48e-9);
        let early_ns = nearest_ns(&beyond, &edge, 24.0, ROUNDING_STEPS);
        assert!((-48.1..-47.9).contains(&early_ns), "{early_ns}");
    }
}
