//! The shortest time of a program on its path, planned offline: every move is known, none has a least time, and speed changes
//! within a blend as the axes allow.
//!
//! # Design
//! The path is that of each move by itself: lines, and at each corner a blend as the chain makes it, or none. Along it one number says
//! how fast the machine is: the square s of the parameter's speed. At a place where the axes go by f and bend by b for each unit of
//! the parameter, an axis has the acceleration f h + b s, where h is half the change of s. So every limit is linear in s and h: the
//! highest square from which the next one can be reached is the least of a few quotients, and a pass backwards finds it for each place.
//! A pass forwards then goes as far as the axes can, and never beyond (Pham and Pham, 2018, doi:10.1109/TRO.2018.2819195).

use isostep_motion::{AXES, Config, Finish, Move};
use isostep_profile::chain::FEED_RATIO_MAX;
use isostep_profile::{IntervalSplit, OFFSET_PARTS, SpeedProfile};
use isostep_sim::Outcome;

/// Into how many parts a blend is divided.
const PARTS: usize = 40;
/// As in the chain: a blend lasts this long at least, s, and leaves a line that lasts so long, or none, at half of the highest speed.
const BRIEF_S: f64 = 0.5e-3;
const LITTLE_S: f64 = 2e-3;
/// Two directions whose difference is shorter than this are the same.
const STRAIGHT: f64 = 1e-9;
/// An axis whose share of the path is less than this stands still.
const STILL: f64 = 1e-12;
/// Half the length of the sum of two directions below which the path goes back, as in Grbl.
const BACK: f64 = 7.071_068e-4;

type Vector = [f64; AXES];

/// The time of a run's motion if its moves were made as fast as the axes can, s. What lies between them stays: standstills, homing,
/// probing, what was held, and the time that shapers take at each. `None` where there are no blends: with a curved speed profile, in
/// thirds, or with a start speed.
#[must_use]
pub fn motion_s(outcome: &Outcome) -> Option<f64> {
    let runs = outcome.runs().filter(|(_, run)| {
        run.iter().all(|record| record.finish == Finish::Done && record.asked.len() > record.marks_steps.len())
    });
    let saved = runs.map(|(_, run)| {
        let config = outcome.config_of(&run[0]);
        let moves: Vec<Move> = run.iter().flat_map(|record| record.asked.iter().copied()).collect();
        let last = &run[run.len() - 1];
        let made_s = last.plan_s - last.lasts_s() - run[0].begin_s();
        blends(config).then(|| made_s - Path::new(config, run[0].origin_steps, &moves).fastest_s())
    });
    saved.into_iter().try_fold(outcome.motion_s, |motion_s, saved_s| Some(motion_s - saved_s?))
}

fn blends(config: &Config) -> bool {
    config.interval_split == IntervalSplit::Fastest
        && config.speed_profile == SpeedProfile::Trapezoid
        && config.limits.iter().all(|limits| limits.start_speed_steps_s == 0.0)
}

/// The lines and corners of moves from rest to rest.
#[derive(Clone, Debug)]
pub struct Path {
    limits: Limits,
    /// The moves.
    pub lines: Vec<Line>,
    /// The corner where each line begins, and the end of the last.
    pub corners: Vec<Corner>,
}

/// A move from corner to corner.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Its direction.
    pub unit: Vector,
    /// Its length, mm.
    pub length_mm: f64,
    /// The highest square of the speed that feed and axes allow, (mm/s)².
    pub nominal: f64,
    /// The same with the highest override, for which there are blends.
    overridden: f64,
    /// The lengths that are for the blends at its beginning and at its end, mm.
    rooms_mm: [f64; 2],
}

/// A corner.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    /// How far the blend reaches to both sides, mm; 0 if there is none.
    pub reach_mm: f64,
    /// The highest square of a constant speed there, (mm/s)².
    pub cap: f64,
}

/// The limits of the axes, mm/s and mm/s².
#[derive(Clone, Copy, Debug)]
struct Limits {
    top: Vector,
    accel: Vector,
    decel: Vector,
}

impl Limits {
    fn new(config: &Config) -> Self {
        let each = |of: fn(&isostep_profile::Limits) -> f64| {
            std::array::from_fn(|axis| of(&config.limits[axis]) / config.steps_per_mm[axis])
        };
        Self {
            top: each(|limits| limits.top_speed_steps_s),
            accel: each(|limits| limits.accel_steps_s2),
            decel: each(|limits| limits.decel_steps_s2),
        }
    }

    /// The lower of both accelerations of an axis.
    fn least(&self, axis: usize) -> f64 {
        self.accel[axis].min(self.decel[axis])
    }
}

/// The most of what each axis may do that there is along a direction.
fn along(limits: impl Fn(usize) -> f64, direction: &Vector) -> f64 {
    (0..AXES).map(|axis| limits(axis) / direction[axis].abs()).fold(f64::INFINITY, f64::min)
}

fn size(of: &Vector) -> f64 {
    of.iter().map(|each| each * each).sum::<f64>().sqrt()
}

/// A piece of the path: a line, or a part of a blend.
struct Place {
    first: Vector,
    second: Vector,
    /// The highest square of the parameter's speed.
    cap: f64,
    /// The change of the parameter to the next place.
    step: f64,
}

impl Path {
    /// The path of `moves` from a place, with each move by itself. Moves of no length are left out.
    #[must_use]
    pub fn new(config: &Config, from_steps: [i32; AXES], moves: &[Move]) -> Self {
        let limits = Limits::new(config);
        let place_mm = |steps: [i32; AXES], offsets: [i8; AXES]| -> Vector {
            let parts = |axis: usize| f64::from(offsets[axis]) / f64::from(OFFSET_PARTS);
            std::array::from_fn(|axis| (f64::from(steps[axis]) + parts(axis)) / config.steps_per_mm[axis])
        };
        let mut from_mm = place_mm(from_steps, [0; AXES]);
        let mut path = Self { limits, lines: Vec::new(), corners: Vec::new() };
        let mut before: Option<&Move> = None;
        for asked in moves {
            let to_mm = place_mm(asked.target_steps, asked.offsets);
            let way_mm: Vector = std::array::from_fn(|axis| to_mm[axis] - from_mm[axis]);
            let length_mm = size(&way_mm);
            if length_mm < STRAIGHT {
                continue;
            }
            let unit = way_mm.map(|mm| mm / length_mm);
            let [nominal, overridden] = [1.0, FEED_RATIO_MAX]
                .map(|ratio| (ratio * asked.feed_mm_s).min(along(|axis| limits.top[axis], &unit)).powi(2));
            let begin_mm = length_mm.min(asked.reach_mm.into());
            let rooms_mm = if begin_mm > 0.0 { [begin_mm, length_mm - begin_mm] } else { [0.5 * length_mm; 2] };
            let line = Line { unit, length_mm, nominal, overridden, rooms_mm };
            let stops = before.is_none_or(|before| before.exact_stop);
            let corner = path.lines.last().filter(|_| !stops);
            path.corners.push(corner.map_or(Corner::STOP, |last| Corner::new([last, &line], asked, &limits, config)));
            path.lines.push(line);
            (from_mm, before) = (to_mm, Some(asked));
        }
        path.corners.push(Corner::STOP);
        path
    }

    /// The shortest time from its beginning to its end, s.
    #[must_use]
    pub fn fastest_s(&self) -> f64 {
        let places = self.places();
        let mut most = vec![0.0; places.len() + 1];
        for (index, place) in places.iter().enumerate().rev() {
            most[index] = place.highest_before(most[index + 1], &self.limits);
        }
        let (mut square, mut total_s) = (0.0, 0.0);
        for (place, most) in places.iter().zip(&most[1..]) {
            let next = place.furthest(square, &self.limits).min(*most).max(0.0);
            total_s += place.takes_s([square, next], &self.limits);
            square = next;
        }
        total_s
    }

    fn places(&self) -> Vec<Place> {
        let mut places = Vec::new();
        for (index, line) in self.lines.iter().enumerate() {
            let [begin, end] = [self.corners[index], self.corners[index + 1]];
            let step = (line.length_mm - begin.reach_mm - end.reach_mm).max(0.0);
            places.push(Place::on_line(line, line.nominal, step));
            match self.lines.get(index + 1) {
                Some(next) if end.reach_mm > 0.0 => self.bend([line, next], end.reach_mm, &mut places),
                _ => places.push(Place::on_line(line, end.cap, 0.0)),
            }
        }
        places
    }

    /// The parts of the blend from one line to the next.
    fn bend(&self, lines: [&Line; 2], reach_mm: f64, places: &mut Vec<Place>) {
        let [before, after] = lines.map(|line| line.unit);
        let [before_mm_s, after_mm_s] = lines.map(|line| line.nominal.sqrt());
        let second = std::array::from_fn(|axis| (after[axis] - before[axis]) / (2.0 * reach_mm));
        for part in 0..PARTS {
            let share = (part as f64 + 0.5) / PARTS as f64;
            let first = std::array::from_fn(|axis| before[axis] * (1.0 - share) + after[axis] * share);
            // A feed is that along the lines, which a blend leaves.
            let asked_mm_s = before_mm_s * (1.0 - share) + after_mm_s * share;
            let cap = asked_mm_s.min(along(|axis| self.limits.top[axis], &first)).powi(2);
            places.push(Place { first, second, cap, step: 2.0 * reach_mm / PARTS as f64 });
        }
    }
}

impl Corner {
    /// The machine stops there.
    const STOP: Self = Self { reach_mm: 0.0, cap: 0.0 };

    /// The corner between two lines, the second of which is `asked` for, as the chain takes it.
    fn new([before, after]: [&Line; 2], asked: &Move, limits: &Limits, config: &Config) -> Self {
        let change: Vector = std::array::from_fn(|axis| after.unit[axis] - before.unit[axis]);
        let length = size(&change);
        // The sine of half the angle between the directions back and onward.
        let sine = 0.5 * size(&std::array::from_fn(|axis| after.unit[axis] + before.unit[axis]));
        if length < STRAIGHT {
            return Self { reach_mm: 0.0, cap: f64::INFINITY };
        }
        if sine < BACK {
            return Self::STOP;
        }
        let across = along(|axis| limits.least(axis), &change);
        if asked.deviation_mm == 0.0 {
            let cap = config.junction_deviation_mm * 2.0 * across * sine * (1.0 + sine) / (0.5 * length);
            return Self { reach_mm: 0.0, cap };
        }
        let room_mm = before.rooms_mm[1].min(after.rooms_mm[0]);
        let reach_mm = (4.0 * f64::from(asked.deviation_mm) / length).min(room_mm);
        let cap = 2.0 * reach_mm * across;
        // No blend is longer than the highest speed needs, if it is not a side of a curve.
        let fastest = before.overridden.max(after.overridden);
        let half_mm_s = 0.5 * fastest.sqrt();
        let needed = (fastest / cap).max(BRIEF_S * half_mm_s / reach_mm);
        let is_whole = asked.reach_mm > 0.0 || needed > 1.0 || room_mm * (1.0 - needed) < LITTLE_S * half_mm_s;
        let share = if fastest >= cap || is_whole { 1.0 } else { needed };
        Self { reach_mm: reach_mm * share, cap: cap * share }
    }
}

/// What an axis allows at a place: half the change of the square is from -`lowest` - `bend` times the square to `highest` - that.
struct Room {
    lowest: f64,
    highest: f64,
    bend: f64,
}

impl Place {
    fn on_line(line: &Line, cap: f64, step: f64) -> Self {
        Self { first: line.unit, second: [0.0; AXES], cap, step }
    }

    /// What the axes allow that move there.
    fn rooms(&self, limits: &Limits) -> impl Iterator<Item = Room> {
        let moving = (0..AXES).filter(|&axis| self.first[axis].abs() > STILL);
        moving.map(|axis| {
            let first = self.first[axis].abs();
            let bend = self.second[axis] / self.first[axis];
            Room { lowest: limits.decel[axis] / first, highest: limits.accel[axis] / first, bend }
        })
    }

    /// The highest square there from which one of at most `next` can follow.
    fn highest_before(&self, next: f64, limits: &Limits) -> f64 {
        let mut highest = self.cap;
        let mut bound = |factor: f64, most: f64| {
            if factor > 0.0 {
                highest = highest.min(most / factor);
            }
        };
        let rooms: Vec<_> = self.rooms(limits).collect();
        for one in &rooms {
            bound(1.0 - 2.0 * self.step * one.bend, next + 2.0 * self.step * one.lowest);
            rooms.iter().for_each(|other| bound(other.bend - one.bend, other.highest + one.lowest));
        }
        for axis in (0..AXES).filter(|&axis| self.first[axis].abs() <= STILL) {
            bound(self.second[axis].abs(), limits.least(axis));
        }
        highest
    }

    /// The highest square at its end.
    fn furthest(&self, square: f64, limits: &Limits) -> f64 {
        let most = self.rooms(limits).map(|room| room.highest - room.bend * square).fold(f64::INFINITY, f64::min);
        let furthest = square + 2.0 * self.step * most;
        if self.is_on_line() { furthest.min(self.cap) } else { furthest }
    }

    fn is_on_line(&self) -> bool {
        self.second == [0.0; AXES]
    }

    /// The time from its beginning to its end, of which the squares are given, s. On a line the speed may rise and fall.
    fn takes_s(&self, [begin, end]: [f64; 2], limits: &Limits) -> f64 {
        if self.step == 0.0 {
            return 0.0;
        }
        let [begin_mm_s, end_mm_s] = [begin, end].map(f64::sqrt);
        if !self.is_on_line() {
            return 2.0 * self.step / (begin_mm_s + end_mm_s);
        }
        let [accel, decel] = [&limits.accel, &limits.decel].map(|limits| along(|axis| limits[axis], &self.first));
        let met = (2.0 * accel * decel * self.step + decel * begin + accel * end) / (accel + decel);
        let peak = met.min(self.cap);
        let ramps_mm = (peak - begin) / (2.0 * accel) + (peak - end) / (2.0 * decel);
        let ramps_s = (peak.sqrt() - begin_mm_s) / accel + (peak.sqrt() - end_mm_s) / decel;
        ramps_s + (self.step - ramps_mm).max(0.0) / peak.sqrt()
    }
}
