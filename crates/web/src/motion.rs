//! The motion of the axes by their plans, in phases of time in each of which the acceleration of every axis changes evenly.
//!
//! So one row is enough to draw a place, a speed, an acceleration or a jerk anywhere within it. A ramp by a curved speed profile
//! is divided, and drawn to within what a screen shows. In a shaped run plans are what goes into the shapers.

use isostep_motion::AXES;
use isostep_profile::SyncMove;
use isostep_report::pace::asked_mm_s;
use isostep_sim::measure::across;
use isostep_sim::{MoveRecord, Outcome};

use crate::power::Power;

/// Numbers of one axis in a row: place, mm; speed, mm/s; acceleration, mm/s²; all at its beginning.
pub const COLUMNS: usize = 3;
/// Numbers of a row about its acceleration.
pub const LOADS: usize = 2;
/// They are shares of a limit, in so many parts of it: at most 256 times the limit, as a 16-bit number goes no farther.
pub const LOAD_PARTS: f64 = 256.0;
/// A phase that begins no later than this behind another goes on from it, s.
const SOON_S: f64 = 1e-6;
/// Phases of a ramp whose jerk changes all the time.
const PARTS_OF_RAMP: u32 = 16;
/// The jerk of an S-curve jumps no more often within a ramp; one more, as a ramp may have been cut short.
const JUMPS_MAX: usize = 3;
/// The number of halvings of the time in which the jerk jumps, to find the instant.
const HALVINGS: u32 = 40;
/// Just within a phase, as a fraction of its length.
const ASIDE: f64 = 1e-6;
/// A phase that is shorter than this cannot be seen, s.
const SHORTEST_S: f64 = 1e-9;

/// The kind of motion that a phase belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// A blend round a corner.
    Blend = 0,
    /// The first interval of a line, the same for every axis.
    Accelerate = 1,
    /// The second.
    Cruise = 2,
    /// The third.
    Decelerate = 3,
}

impl Kind {
    /// Added if the move is of homing.
    pub const HOMING: u8 = 8;
    /// Added if the run is shaped.
    pub const SHAPED: u8 = 16;
}

/// Phases, in order, as columns that a page takes as they are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// The beginning and the end of each, s since power-up.
    pub times_s: Vec<f64>,
    /// [`Kind`], and what is added to it.
    pub kinds: Vec<u8>,
    /// [`COLUMNS`] numbers of each axis.
    pub values: Vec<f32>,
    /// How much larger the acceleration of each axis is at its end, mm/s².
    pub changes_mm_s2: Vec<f32>,
    /// [`LOADS`] numbers of each: the acceleration as a share of its limit, of the axis where that is largest; and the same of
    /// the jump of speed where the phase begins, over the time in which a jump is measured. In [`LOAD_PARTS`].
    pub loads: Vec<u16>,
    /// The speed along the path that each would have without ramps, mm/s: see [`asked_mm_s`].
    pub asked_mm_s: Vec<f32>,
    /// The power that the tool was given meanwhile.
    pub power: Power,
    /// The place where the last phase ends, for the jump behind it.
    end: End,
    /// The end of the phase before the first, s since power-up, if there was one.
    pub(crate) before_s: Option<f64>,
}

/// The end of a phase.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct End {
    run: usize,
    at_s: f64,
    speeds_steps_s: [f64; AXES],
}

/// An interval of one plan, within which one formula holds.
struct Interval {
    /// From and to, s from the start of the run.
    span_s: [f64; 2],
    kind: Kind,
    /// The number of the plan that holds: 0 for the first, then those that replaced it.
    plan: usize,
}

impl Motion {
    /// The phases so far. What comes later goes on from them.
    pub(crate) fn take(&mut self) -> Self {
        let following = self.following();
        std::mem::replace(self, following)
    }

    /// No phases, behind these.
    pub(crate) fn following(&self) -> Self {
        let before_s = self.times_s.last().copied().or(self.before_s);
        Self { end: self.end, before_s, ..Self::default() }
    }

    /// Adds the moves of a piece of a run.
    pub(crate) fn add(&mut self, piece: &Outcome) {
        self.power.add(piece);
        for record in &piece.moves {
            let flags = [(record.homing, Kind::HOMING), (record.shaping.is_some(), Kind::SHAPED)];
            let flags = flags.iter().filter(|(is_so, _)| *is_so).map(|(_, flag)| flag).sum::<u8>();
            let (rows, asked_mm_s) = (self.kinds.len(), asked_mm_s(piece, record));
            for interval in intervals(record) {
                for bounds_s in bounds_s(record, &interval).windows(2) {
                    self.push(piece, record, &interval, [bounds_s[0], bounds_s[1]], flags);
                }
            }
            self.asked_mm_s.extend(std::iter::repeat_n(asked_mm_s as f32, self.kinds.len() - rows));
        }
    }

    fn push(&mut self, piece: &Outcome, record: &MoveRecord, interval: &Interval, [from_s, to_s]: [f64; 2], flags: u8) {
        let start_s = record.start_ns as f64 * 1e-9;
        self.times_s.extend([start_s + from_s, start_s + to_s]);
        self.kinds.push(interval.kind as u8 + flags);
        // Just within the phase, because at its ends other formulas may hold.
        let aside_s = (to_s - from_s) * ASIDE;
        let mm = |of_motor: &dyn Fn(usize) -> f64| piece.mm_of_move(record, std::array::from_fn(of_motor));
        let accels = |t_s: f64| mm(&|motor| motion_steps(record, interval, motor, t_s).1);
        let places_mm = mm(&|motor| record.place_steps(motor, from_s));
        let speeds_mm_s = mm(&|motor| motion_steps(record, interval, motor, from_s + aside_s).0);
        let [begins, ends] = [from_s + aside_s, to_s - aside_s].map(accels);
        for axis in 0..AXES {
            self.values.extend([places_mm[axis], speeds_mm_s[axis], begins[axis]].map(|value| value as f32));
            self.changes_mm_s2.push((ends[axis] - begins[axis]) as f32);
        }
        self.push_load(piece, record, interval, [from_s, to_s]);
    }

    fn push_load(&mut self, piece: &Outcome, record: &MoveRecord, interval: &Interval, [from_s, to_s]: [f64; 2]) {
        let (at_s, aside_s) = (record.start_ns as f64 * 1e-9, (to_s - from_s) * ASIDE);
        let mut next = End { run: record.run, at_s: at_s + to_s, speeds_steps_s: [0.0; AXES] };
        let follows = self.end.run == next.run && at_s + from_s - self.end.at_s < SOON_S;
        let before = if follows { self.end.speeds_steps_s } else { [0.0; AXES] };
        let (mut load, mut jump) = (0.0_f64, 0.0_f64);
        for (axis, limits) in piece.config_of(record).limits.iter().enumerate() {
            let [(speed, accel), (last_speed, last_accel)] =
                [from_s + aside_s, to_s - aside_s].map(|t_s| motion_steps(record, interval, axis, t_s));
            next.speeds_steps_s[axis] = last_speed;
            let either = limits.accel_steps_s2.max(limits.decel_steps_s2);
            // An axis that turns slows down, and then speeds up.
            let limit = match accel * speed + last_accel * last_speed {
                _ if speed * last_speed < 0.0 => either,
                along if along < 0.0 => limits.decel_steps_s2,
                _ => limits.accel_steps_s2,
            };
            load = load.max(accel.abs().max(last_accel.abs()) / limit);
            jump = jump.max((speed - before[axis]).abs() / (either * across::span_s(piece, limits)));
        }
        self.loads.extend([load, jump].map(|share| (share * LOAD_PARTS).round() as u16));
        self.end = next;
    }
}

/// The intervals of a move: its blend, and those of its line, by each plan for as long as it held.
fn intervals(record: &MoveRecord) -> Vec<Interval> {
    let line_s = record.plan.begin_s();
    let end_s = record.plan_s.min((record.end_ns - record.start_ns) as f64 * 1e-9 + SHORTEST_S);
    // An alarm may end it in its blend.
    let span_s = |begin_s: f64| [begin_s, line_s.min(end_s)];
    let blend = record.blend.map(|blend| Interval { span_s: span_s(blend.begin_s()), kind: Kind::Blend, plan: 0 });
    let mut found: Vec<_> = blend.into_iter().collect();
    let plans = || std::iter::once(&record.plan).chain(&record.parts);
    for (number, plan) in plans().enumerate().filter(|(_, plan)| plan.profile.distance_steps() > 0.0) {
        let until_s = plans().nth(number + 1).map_or(end_s, |next| next.begin_s().min(end_s));
        let accelerated_s = origin_s(plan) + plan.profile.t_accel_s();
        let braking_s = accelerated_s + plan.profile.t_cruise_s();
        let bounds = [f64::NEG_INFINITY, accelerated_s, braking_s, f64::INFINITY];
        for (kind, bounds_s) in [Kind::Accelerate, Kind::Cruise, Kind::Decelerate].into_iter().zip(bounds.windows(2)) {
            let span_s = [plan.begin_s().max(bounds_s[0]), until_s.min(bounds_s[1])];
            found.push(Interval { span_s, kind, plan: number });
        }
    }
    found.retain(|interval| interval.span_s[1] - interval.span_s[0] > SHORTEST_S);
    found
}

/// The beginnings and ends of the phases of an interval, s from the start of the run: where the jerk jumps, or, where it changes
/// all the time, at equal distances.
fn bounds_s(record: &MoveRecord, interval: &Interval) -> Vec<f64> {
    let [from_s, to_s] = interval.span_s;
    if matches!(interval.kind, Kind::Blend | Kind::Cruise) {
        return vec![from_s, to_s];
    }
    let at_s = |share: f64| from_s + (to_s - from_s) * share;
    let equal = |part: u32| f64::from(part) / f64::from(PARTS_OF_RAMP);
    let middles = (0..PARTS_OF_RAMP).map(|part| equal(part) + 0.5 * equal(1));
    let probes: Vec<_> = [ASIDE].into_iter().chain(middles).chain([1.0 - ASIDE]).map(at_s).collect();
    let is_same = |one_s: f64, other_s: f64| {
        let [one, other] = [one_s, other_s].map(|t_s| jerk(record, interval, t_s));
        (one - other).abs() <= 1e-6 * one.abs().max(other.abs())
    };
    let jumps: Vec<_> = probes.windows(2).filter(|pair| !is_same(pair[0], pair[1])).collect();
    if jumps.len() > JUMPS_MAX {
        return (0..=PARTS_OF_RAMP).map(|part| at_s(equal(part))).collect();
    }
    let jumps_s = jumps.into_iter().map(|pair| {
        let (mut before_s, mut behind_s) = (pair[0], pair[1]);
        for _ in 0..HALVINGS {
            let middle_s = 0.5 * (before_s + behind_s);
            if is_same(pair[0], middle_s) { before_s = middle_s } else { behind_s = middle_s }
        }
        behind_s
    });
    [from_s].into_iter().chain(jumps_s).chain([to_s]).collect()
}

/// The jerk of the longest axis on the line, steps/s³.
fn jerk(record: &MoveRecord, interval: &Interval, t_s: f64) -> f64 {
    let plan = plan(record, interval);
    plan.profile.jerk_at(t_s - origin_s(plan))
}

fn plan<'a>(record: &'a MoveRecord, interval: &Interval) -> &'a SyncMove<AXES> {
    interval.plan.checked_sub(1).map_or(&record.plan, |replan| &record.parts[replan])
}

/// The beginning of the profile of a plan, s from the start of the run.
fn origin_s(plan: &SyncMove<AXES>) -> f64 {
    plan.end_s() - plan.profile.duration_s()
}

/// Speed and acceleration of the longest axis on the line, steps.
fn master(record: &MoveRecord, interval: &Interval, t_s: f64) -> (f64, f64) {
    let plan = plan(record, interval);
    let passed_s = t_s - origin_s(plan);
    (plan.profile.speed_at(passed_s), plan.profile.accel_at(passed_s))
}

/// Speed and acceleration of an axis at `t_s` from the start of the run, steps/s and steps/s².
fn motion_steps(record: &MoveRecord, interval: &Interval, axis: usize, t_s: f64) -> (f64, f64) {
    match record.blend {
        Some(blend) if interval.kind == Kind::Blend => (blend.speed_at(axis, t_s), blend.accel_steps_s2(axis)),
        _ => {
            let share = record.plan.axis_steps(axis) / record.plan.distance_steps();
            let (speed, accel) = master(record, interval, t_s);
            (speed * share, accel * share)
        }
    }
}

/// The rows of one axis are as many as this.
const _: () = assert!(AXES >= 3, "a plane has two axes, and the page shows a third");
