//! A second computation, in floats, of what the moves of a chain may do: shared limits, corners, and the fastest speeds
//! between moves.

use isostep_profile::chain::{Effort, Request, SHAPED_STEPS_MAX};
use isostep_profile::{IntervalSplit, Limits, SPEED_MIN_STEPS_S, SpeedProfile};

use super::case::{AXES, Case};

/// The overrides of feeds and rapids, as ratios.
#[derive(Clone, Copy, Debug)]
pub struct OverrideRatios {
    pub feed: f64,
    pub rapid: f64,
}

impl OverrideRatios {
    pub const ALL: Self = Self { feed: 1.0, rapid: 1.0 };
}

/// A move in mm.
#[derive(Clone, Copy, Debug)]
pub struct Move {
    pub request: Request<AXES>,
    pub distance_steps: f64,
    pub mm_per_step: f64,
    pub length_mm: f64,
    pub direction: [f64; AXES],
    /// The limits along the path, from here on.
    pub top_mm_s: f64,
    /// The top speed without the time that is needed if no blend leads to it.
    pub bent_top_mm_s: f64,
    pub nominal_mm_s: f64,
    pub start_mm_s: f64,
    /// The start speed without the limit by the nominal speed.
    pub free_mm_s: f64,
    pub accel_mm_s2: f64,
    pub decel_mm_s2: f64,
    pub jerk_mm_s3: f64,
    /// The shortest time that it may last at constant speed, and if it changes its speed, s.
    pub least_s: [f64; 2],
}

impl Move {
    pub fn new(case: &Case, request: Request<AXES>, ratios: OverrideRatios) -> Self {
        let mm: [f64; AXES] = core::array::from_fn(|axis| f64::from(request.steps[axis]) * case.mm_per_step[axis]);
        let length_mm = mm.iter().map(|mm| mm * mm).sum::<f64>().sqrt();
        let direction = mm.map(|mm| mm / length_mm);
        let least = |limit: fn(&Limits) -> f64| {
            let axes = (0..AXES).filter(|&axis| request.steps[axis] != 0);
            axes.map(|axis| limit(&case.limits[axis]) * case.mm_per_step[axis] / direction[axis].abs())
                .fold(f64::INFINITY, f64::min)
        };
        let longest = request.steps.iter().map(|steps| steps.unsigned_abs()).max().unwrap();
        let steps_per_mm = f64::from(longest) / length_mm;
        let least_s = least_s(case, &request);
        // Two ramps from rest to rest last as long as their root takes.
        let steepest_mm_s2 = match case.effort.root_step_s {
            root_step_s if root_step_s > 0.0 && case.speed_profile != SpeedProfile::Trapezoid => {
                4.0 / root_step_s.powi(2) / steps_per_mm
            }
            _ => f64::INFINITY,
        };
        let bent_top_mm_s =
            least(|limits| limits.top_speed_steps_s).min(length_mm / (least_s[0] - case.effort.straight_s));
        let top_mm_s = bent_top_mm_s.min(length_mm / least_s[0]);
        let free_mm_s = least(|limits| limits.start_speed_steps_s);
        let distance_steps = f64::from(longest);
        let mm_per_step = length_mm / distance_steps;
        let (asked_mm_s, ratio) =
            request.feed_mm_s.map_or((top_mm_s, ratios.rapid), |feed_mm_s| (feed_mm_s, ratios.feed));
        // An override makes no move slower than can be planned.
        let slowest_mm_s = asked_mm_s.min(SPEED_MIN_STEPS_S * mm_per_step);
        let nominal_mm_s = (asked_mm_s * ratio).max(slowest_mm_s).min(top_mm_s);
        Self {
            request,
            distance_steps,
            mm_per_step,
            length_mm,
            direction,
            top_mm_s,
            bent_top_mm_s,
            nominal_mm_s,
            start_mm_s: free_mm_s.min(nominal_mm_s),
            free_mm_s,
            accel_mm_s2: least(|limits| limits.accel_steps_s2).min(steepest_mm_s2),
            decel_mm_s2: least(|limits| limits.decel_steps_s2).min(steepest_mm_s2),
            jerk_mm_s3: least(|limits| limits.jerk_steps_s3),
            least_s,
        }
    }

    /// The limits of the longest axis, with that top speed, mm/s.
    pub fn limits(&self, top_mm_s: f64) -> Limits {
        Limits {
            start_speed_steps_s: (self.start_mm_s / self.mm_per_step).min(top_mm_s / self.mm_per_step),
            top_speed_steps_s: top_mm_s / self.mm_per_step,
            accel_steps_s2: self.accel_mm_s2 / self.mm_per_step,
            decel_steps_s2: self.decel_mm_s2 / self.mm_per_step,
            jerk_steps_s3: self.jerk_mm_s3 / self.mm_per_step,
        }
    }

    /// The delta v² that is possible over its length at that acceleration, (mm/s)².
    fn delta_v2(&self, speed_profile: SpeedProfile, accel_mm_s2: f64) -> f64 {
        let trapezoid = 2.0 * accel_mm_s2 * self.length_mm;
        trapezoid
            / match speed_profile {
                SpeedProfile::Trapezoid => 1.0,
                SpeedProfile::SCurve => return self.s_curve_delta_v2(accel_mm_s2),
                // The steepest slope of half a wave.
                SpeedProfile::Sine => core::f64::consts::FRAC_PI_2,
                // The largest acceleration on a ramp from standstill, divided by v²/2x. v v' is u, 2 u³, (1 - cos πu)
                // sin πu π/4.
                SpeedProfile::Linear => 2.0,
                SpeedProfile::Quadratic => 4.0,
                SpeedProfile::Sinusoidal => 27f64.sqrt() * core::f64::consts::PI / 8.0,
                // v'(0): K is 23.
                SpeedProfile::Logarithmic => 23.0 / 24f64.ln(),
                _ => unreachable!("there is no model of {speed_profile}"),
            }
    }

    /// The largest delta v² whose ramp fits the length at the highest possible mean speed, by bisection.
    fn s_curve_delta_v2(&self, accel_mm_s2: f64) -> f64 {
        let most_mm_s = self.request.feed_mm_s.map_or(f64::INFINITY, |feed_mm_s| 2.0 * feed_mm_s);
        let mean_mm_s = most_mm_s.min(self.bent_top_mm_s);
        let distance_mm = |delta_v2: f64| {
            let rise = delta_v2 / (2.0 * mean_mm_s);
            let eased = accel_mm_s2 / self.jerk_mm_s3;
            let duration_s = if rise >= accel_mm_s2 * eased {
                rise / accel_mm_s2 + eased
            } else {
                2.0 * (rise / self.jerk_mm_s3).sqrt()
            };
            mean_mm_s * duration_s
        };
        let (mut low, mut high) = (0.0, 2.0 * accel_mm_s2 * self.length_mm);
        for _ in 0..200 {
            let middle = (low + high) / 2.0;
            *if distance_mm(middle) <= self.length_mm { &mut low } else { &mut high } = middle;
        }
        low
    }

    /// The highest squared speed at one end, if that at the other end is `square` and the change at most `delta_v2`.
    fn at_other_end(&self, square: f64, delta_v2: f64) -> f64 {
        let changing_mm_s = self.length_mm / self.least_s[1];
        if square < changing_mm_s.powi(2) { (square + delta_v2).min(changing_mm_s.powi(2)) } else { square }
    }

    pub fn deltas_v2(&self, speed_profile: SpeedProfile) -> (f64, f64) {
        (self.delta_v2(speed_profile, self.accel_mm_s2), self.delta_v2(speed_profile, self.decel_mm_s2))
    }
}

/// The shortest time that a move may last at constant speed, and if it changes its speed, s.
fn least_s(case: &Case, request: &Request<AXES>) -> [f64; 2] {
    let Effort { step_s, move_s, straight_s, ramps_s, root_step_s, shaped_root_step_s, .. } = case.effort;
    let mut steps = request.steps.map(i32::unsigned_abs);
    steps.sort_unstable();
    let [low, middle, high] = steps.map(f64::from);
    let share = |own: f64, above: f64| own * if own == above { 0.1 } else { 1.0 };
    let shaped_s = shaped_root_step_s * (low + middle + high).min(SHAPED_STEPS_MAX).sqrt();
    let cruise_s = move_s.max(shaped_s) + step_s * (high + share(middle, high) + share(low, middle));
    let longest = high;
    let is_curved = case.speed_profile != SpeedProfile::Trapezoid;
    let change_s = if is_curved { ramps_s + root_step_s * longest.sqrt() } else { 0.0 };
    // For no time beside that at constant speed, a change of speed has no bound.
    [cruise_s + straight_s, if change_s > 0.0 { cruise_s + change_s } else { 0.0 }]
}

/// The squared speed, (mm/s)², at which Grbl takes the corner between two moves; `None` if it stops.
pub fn corner(case: &Case, before: &Move, after: &Move) -> Option<f64> {
    if before.request.stops || case.interval_split == IntervalSplit::Thirds {
        return None;
    }
    let pairs = || before.direction.iter().zip(&after.direction);
    // The cosine of the angle between one direction and the reverse of the other: 1 for a move back.
    let cosine = -pairs().map(|(a, b)| a * b).sum::<f64>();
    let across: [f64; AXES] = core::array::from_fn(|axis| after.direction[axis] - before.direction[axis]);
    let length = across.iter().map(|ratio| ratio * ratio).sum::<f64>().sqrt();
    if length < 1e-9 {
        return Some(f64::INFINITY);
    }
    if cosine > 1.0 - 1e-6 || case.deviation_mm == 0.0 {
        return None;
    }
    let sine = ((1.0 - cosine) / 2.0).sqrt();
    let accel_mm_s2 = (0..AXES)
        .filter(|&axis| across[axis] != 0.0)
        .map(|axis| {
            let Limits { accel_steps_s2, decel_steps_s2, .. } = case.limits[axis];
            accel_steps_s2.min(decel_steps_s2) * case.mm_per_step[axis] * length / across[axis].abs()
        })
        .fold(f64::INFINITY, f64::min);
    // 1 - sine, in a form that does not cancel: (1 + cosine)/2 is the square of half the length.
    let rest = length * length / 4.0 / (1.0 + sine);
    Some(accel_mm_s2 * case.deviation_mm * sine / rest)
}

/// The highest squared speed at which `after` may begin; `None` if `before` ends at a stop.
pub fn cap(case: &Case, before: &Move, after: &Move) -> Option<f64> {
    let corner = corner(case, before, after)?;
    let nominal = before.nominal_mm_s.min(after.nominal_mm_s);
    let start = before.start_mm_s.min(after.start_mm_s);
    Some(corner.min(nominal * nominal).max(start * start))
}

/// The squared speeds at which a move begins and ends, (mm/s)².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ends {
    pub entry: f64,
    pub exit: f64,
    /// True if it begins at the speed at which the move before ends.
    pub flows: bool,
}

/// The fastest ends of the moves within all limits, from `entry` (or from rest) to rest at the end. It is found by
/// brute force: each end is computed from its neighbours until nothing changes. A move may always end at its start
/// speed; if that is too fast for the next move, it stops.
pub fn fastest(case: &Case, moves: &[Move], entry: Option<f64>) -> Vec<Ends> {
    let start = |index: usize| moves[index].start_mm_s * moves[index].start_mm_s;
    let deltas_v2: Vec<(f64, f64)> = moves.iter().map(|one| one.deltas_v2(case.speed_profile)).collect();
    let cap = |index: usize| index.checked_sub(1).and_then(|before| cap(case, &moves[before], &moves[index]));
    let caps: Vec<Option<f64>> = (0..moves.len()).map(cap).collect();
    let mut all = vec![Ends::default(); moves.len()];
    // First backwards, from which speeds it can brake; then forwards, which speeds it can reach.
    for is_forward in [false, true] {
        loop {
            let before = all.clone();
            for index in 0..moves.len() {
                let exit = match all.get(index + 1) {
                    Some(next) if next.flows => next.entry,
                    _ => start(index),
                };
                if is_forward {
                    all[index].exit = exit.min(moves[index].at_other_end(all[index].entry, deltas_v2[index].0));
                    if all[index].flows && index > 0 {
                        let most = moves[index - 1].at_other_end(all[index - 1].entry, deltas_v2[index - 1].0);
                        all[index].entry = all[index].entry.min(most);
                    }
                    continue;
                }
                let most = moves[index].at_other_end(exit, deltas_v2[index].1);
                all[index] = match caps[index] {
                    Some(cap) if cap.min(most) >= start(index - 1) => Ends { entry: cap.min(most), exit, flows: true },
                    _ => Ends { entry: most.min(start(index)), exit, flows: false },
                };
                if let (0, Some(entry)) = (index, entry) {
                    all[0].entry = entry;
                }
            }
            if all == before {
                break;
            }
        }
    }
    all
}
