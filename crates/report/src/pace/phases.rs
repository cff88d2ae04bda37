//! A program over time: all its moves as planned, divided into phases in which the speed rises, stays constant or
//! falls.
//!
//! A move follows its plan until a replan replaces it, from the start of that plan on. Homing is left out.
//!
//! A blend belongs to the two moves that it joins, and is counted as if it were bent straight: along the lines to the
//! corner and from there. It enters at the speed p and leaves at q, between which its speed changes evenly, and it has as
//! much of either line as it leaves out. So distances and times add up as without blends, and no time is lost where a
//! corner is passed at the feed. It is at the corner after the fraction √p/(√p + √q) of its time, at the speed √(p q).

use isostep_motion::AXES;
use isostep_profile::{Profile, SyncMove};

use super::asked::{Asked, SAME};
use isostep_sim::MoveRecord;
use isostep_sim::Outcome;
use isostep_sim::lines_of_moves::Source;

/// The change of the speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// It rises.
    Up,
    /// It stays constant.
    Level,
    /// It falls.
    Down,
}

/// A time in which the speed of one move rises, stays constant or falls.
#[derive(Clone, Copy, Debug)]
pub struct Phase<'a> {
    /// Index of its move in [`Outcome::moves`].
    pub index: usize,
    /// The demands of its move.
    pub asked: Asked,
    /// The change of the speed.
    pub change: Change,
    /// When it begins, s from the start of the first move.
    pub begin_s: f64,
    /// Its duration, s: above 0.
    pub span_s: f64,
    /// The speeds along the path at its start and its end, mm/s.
    pub speeds_mm_s: [f64; 2],
    /// Its distance along the path, mm.
    pub distance_mm: f64,
    /// The places where it begins and ends, in steps of the longest axis from the beginning of the whole move.
    pub places_steps: [f64; 2],
    /// If it is in a blend, the index of the move to which that leads.
    pub bent_to: Option<usize>,
    way: Way<'a>,
}

/// The change of the speed in a phase.
#[derive(Clone, Copy, Debug)]
enum Way<'a> {
    /// By a profile, from this time and this step of it on.
    Profile { profile: &'a Profile, from_s: f64, from_steps: f64 },
    /// Evenly.
    Even,
}

impl Phase<'_> {
    /// When it ends, s from the start of the first move.
    pub fn end_s(&self) -> f64 {
        self.begin_s + self.span_s
    }

    /// The speed along the path at `t_s` from the start of the first move, mm/s. The instant must be within the phase.
    pub fn speed_mm_s(&self, t_s: f64) -> f64 {
        let [begin, end] = self.speeds_mm_s;
        if self.change == Change::Level || t_s <= self.begin_s {
            begin
        } else if t_s >= self.end_s() {
            end
        } else {
            match self.way {
                Way::Profile { profile, from_s, .. } => {
                    profile.speed_at(from_s + t_s - self.begin_s) * self.asked.mm_per_step
                }
                Way::Even => begin + (end - begin) * (t_s - self.begin_s) / self.span_s,
            }
        }
    }

    /// The distance made in this phase until `t_s` from the start of the first move, mm.
    pub fn made_mm(&self, t_s: f64) -> f64 {
        if t_s <= self.begin_s {
            0.0
        } else if t_s >= self.end_s() {
            self.distance_mm
        } else {
            match self.way {
                Way::Profile { profile, from_s, from_steps } => {
                    (profile.position_at(from_s + t_s - self.begin_s) - from_steps) * self.asked.mm_per_step
                }
                Way::Even => (self.speeds_mm_s[0] + self.speed_mm_s(t_s)) / 2.0 * (t_s - self.begin_s),
            }
        }
    }

    /// Position after the distance `made_mm` of this phase, mm.
    pub fn place_mm(&self, outcome: &Outcome, made_mm: f64) -> [f64; AXES] {
        let record = &outcome.moves[self.index];
        let (origin_steps, from_steps) =
            (record.corner_steps(), if record.blend.is_some() { 0.0 } else { record.plan.begin_steps() });
        let origin_mm = outcome.mm(origin_steps);
        let before_mm = (self.places_steps[0] - from_steps) * self.asked.mm_per_step;
        std::array::from_fn(|axis| origin_mm[axis] + (before_mm + made_mm) * self.asked.along[axis])
    }
}

/// All phases of the program, in order; `sources` are those of all moves.
pub fn phases<'a>(outcome: &'a Outcome, sources: &'a [Option<Source>]) -> impl Iterator<Item = Phase<'a>> {
    let program = outcome.moves.iter().enumerate().filter(|(_, record)| !record.homing);
    let first = outcome.program_moves().next();
    program.flat_map(move |(index, record)| {
        let asked = Asked::new(outcome, record, sources.get(index).and_then(Option::as_ref));
        let run_s = first.map_or(0.0, |first| run_s(first, record));
        let sides = move |to: usize, side: Side| {
            let bent = outcome.moves.get(to).and_then(|record| Bent::new(outcome, record, to));
            bent.into_iter().flat_map(move |bent| bent.phases(side, (index, record), asked, run_s))
        };
        let line = pieces(record).flat_map(move |piece| piece.phases(index, asked, run_s));
        sides(index, Side::After).chain(line).chain(sides(index + 1, Side::Before))
    })
}

/// When the last move of the program ends, s from the start of the first one; `None` without a move.
#[cfg(feature = "pictures")]
pub fn end_s(outcome: &Outcome) -> Option<f64> {
    let mut program = outcome.program_moves();
    let first = program.next()?;
    let last = program.next_back().unwrap_or(first);
    pieces(last).last().map(|piece| run_s(first, last) + piece.to_s)
}

/// When the run of a move began, s from the start of the `first` move's plan, which may be later than the start of its
/// run.
fn run_s(first: &MoveRecord, record: &MoveRecord) -> f64 {
    (record.start_ns - first.start_ns) as f64 * 1e-9 - first.begin_s()
}

/// A plan and the time in which the move follows it.
#[derive(Clone, Copy)]
struct Piece<'a> {
    plan: &'a SyncMove<AXES>,
    /// Seconds from the start of the run.
    from_s: f64,
    to_s: f64,
}

fn pieces(record: &MoveRecord) -> impl Iterator<Item = Piece<'_>> {
    let mut plans = vec![(&record.plan, record.plan.begin_s())];
    for part in &record.parts {
        let begin_s = part.begin_s();
        while plans.last().is_some_and(|&(_, other_s)| other_s >= begin_s) {
            plans.pop();
        }
        plans.push((part, begin_s));
    }
    // The plan may end later than the blend begins.
    let stop_s = if record.ends_in_blend { record.plan_s } else { stop_s(record) };
    let ends_s: Vec<_> = plans.iter().skip(1).map(|&(_, begin_s)| begin_s).chain([stop_s]).collect();
    let pieces = plans.into_iter().zip(ends_s);
    pieces.map(move |((plan, from_s), to_s)| Piece { plan, from_s, to_s: to_s.min(plan.end_s()).min(stop_s) })
}

/// When a move was stopped abruptly, which so did not reach the end of its plan, s from the start of its run.
fn stop_s(record: &MoveRecord) -> f64 {
    if record.is_whole() { f64::INFINITY } else { (record.end_ns - record.start_ns) as f64 * 1e-9 }
}

/// The state of a profile at an instant.
#[derive(Clone, Copy)]
struct Boundary {
    t_s: f64,
    steps: f64,
    steps_s: f64,
}

impl<'a> Piece<'a> {
    fn phases(self, index: usize, asked: Asked, run_s: f64) -> impl Iterator<Item = Phase<'a>> {
        let profile = &self.plan.profile;
        let origin_s = self.plan.end_s() - profile.duration_s();
        let origin_steps = self.plan.end_steps() - profile.distance_steps();
        let at = |t_s: f64| Boundary { t_s, steps: profile.position_at(t_s), steps_s: profile.speed_at(t_s) };
        let boundaries = boundaries(profile);
        let (from_s, to_s) = (self.from_s - origin_s, self.to_s - origin_s);
        // For most pieces, both ends are boundaries of the profile.
        let from = if from_s > 0.0 { at(from_s) } else { boundaries[0] };
        let to = if to_s < boundaries[3].t_s { at(to_s) } else { boundaries[3] };
        let changes = [Change::Up, Change::Level, Change::Down];
        (0..changes.len()).filter_map(move |number| {
            let begin = if from.t_s > boundaries[number].t_s { from } else { boundaries[number] };
            let end = if to.t_s < boundaries[number + 1].t_s { to } else { boundaries[number + 1] };
            let phase = Phase {
                index,
                asked,
                change: changes[number],
                begin_s: run_s + origin_s + begin.t_s,
                span_s: end.t_s - begin.t_s,
                speeds_mm_s: [begin, end].map(|boundary| boundary.steps_s * asked.mm_per_step),
                distance_mm: (end.steps - begin.steps) * asked.mm_per_step,
                places_steps: [begin, end].map(|boundary| origin_steps + boundary.steps),
                bent_to: None,
                way: Way::Profile { profile, from_s: begin.t_s, from_steps: begin.steps },
            };
            (phase.span_s > 0.0).then_some(phase)
        })
    }
}

/// The part of a blend that belongs to the move before the corner, or to that after it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Before,
    After,
}

/// A blend bent straight.
#[derive(Clone, Copy)]
struct Bent {
    /// Index of the move to which it leads.
    to: usize,
    /// When it begins, its corner begins, is passed, and ends, s from the start of the run.
    times_s: [f64; 4],
    /// The speeds then, mm/s.
    speeds_mm_s: [f64; 4],
    stop_s: f64,
}

impl Bent {
    fn new(outcome: &Outcome, record: &MoveRecord, to: usize) -> Option<Self> {
        let blend = record.blend.as_ref()?;
        let [begin_s, end_s] = [blend.corner_begins_s(), blend.end_s()];
        let [enters, leaves] = [begin_s, end_s].map(|t_s| outcome.blend_mm_s(blend, t_s));
        let before = enters.sqrt() / (enters.sqrt() + leaves.sqrt());
        Some(Self {
            to,
            times_s: [blend.begin_s(), begin_s, begin_s + before * blend.corner_s(), end_s],
            speeds_mm_s: [enters, enters, (enters * leaves).sqrt(), leaves],
            stop_s: stop_s(record),
        })
    }

    /// The phases on one side: of the move with this index, which asks for `asked`.
    fn phases<'a>(
        self,
        side: Side,
        (index, record): (usize, &MoveRecord),
        asked: Asked,
        run_s: f64,
    ) -> impl Iterator<Item = Phase<'a>> {
        let (parts, corner_steps) = match side {
            Side::Before => (0..2, record.plan.distance_steps()),
            Side::After => (2..3, 0.0),
        };
        parts.filter_map(move |part| {
            let [begin_s, end_s] = [self.times_s[part], self.times_s[part + 1]];
            let [begins, ends] = [self.speeds_mm_s[part], self.speeds_mm_s[part + 1]];
            let span_s = end_s.min(self.stop_s) - begin_s;
            let made_s = |t_s: f64| (t_s - begin_s) / (end_s - begin_s);
            let speed = |t_s: f64| begins + (ends - begins) * made_s(t_s);
            let speeds_mm_s = [begins, speed(begin_s + span_s)];
            let distance_mm = span_s * (speeds_mm_s[0] + speeds_mm_s[1]) / 2.0;
            // What is left to the corner when this part begins.
            let left_mm = (part..2).map(|part| self.part_mm(part)).sum::<f64>();
            let from_steps = corner_steps - left_mm / asked.mm_per_step;
            let phase = Phase {
                index,
                asked,
                change: change(speeds_mm_s),
                begin_s: run_s + begin_s,
                span_s,
                speeds_mm_s,
                distance_mm,
                places_steps: [from_steps, from_steps + distance_mm / asked.mm_per_step],
                bent_to: Some(self.to),
                way: Way::Even,
            };
            (span_s > 0.0).then_some(phase)
        })
    }

    fn part_mm(&self, part: usize) -> f64 {
        let span_s = self.times_s[part + 1] - self.times_s[part];
        span_s * (self.speeds_mm_s[part] + self.speeds_mm_s[part + 1]) / 2.0
    }
}

fn change([begin_mm_s, end_mm_s]: [f64; 2]) -> Change {
    let same_mm_s = SAME * begin_mm_s.max(end_mm_s);
    match end_mm_s - begin_mm_s {
        more if more > same_mm_s => Change::Up,
        more if more < -same_mm_s => Change::Down,
        _ => Change::Level,
    }
}

/// The instants at which the phases of a profile begin, and the end of the last phase.
fn boundaries(profile: &Profile) -> [Boundary; 4] {
    let cruise_steps_s = profile.cruise_speed_steps_s();
    let accel_s = profile.t_accel_s();
    [
        Boundary { t_s: 0.0, steps: 0.0, steps_s: profile.entry_speed_steps_s() },
        Boundary { t_s: accel_s, steps: profile.accel_end_steps(), steps_s: cruise_steps_s },
        Boundary { t_s: accel_s + profile.t_cruise_s(), steps: profile.cruise_end_steps(), steps_s: cruise_steps_s },
        Boundary { t_s: profile.duration_s(), steps: profile.distance_steps(), steps_s: profile.exit_speed_steps_s() },
    ]
}
