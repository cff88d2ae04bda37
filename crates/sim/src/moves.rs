//! The moves of a program, each with its plan and its end, assembled from the coordinator's events.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;

use isostep_motion::{AXES, Config, Event, Finish, Move, Shaping, State};
use isostep_profile::{Blend, IntervalSplit, Limits, Profile, SpeedProfile, SyncMove};

use crate::measure::Way;

/// Instants with a smaller difference count as the same.
const SAME_S: f64 = 1e-9;
/// A move that began this long before an edge has begun for good, and the one before it is over. It is far more than what
/// edges may be out of order by.
const SETTLED_NS: u64 = 1_000_000;
/// Number of steps of a move that are checked.
const PROBES: u32 = 64;

/// One move, with its plan and its end.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MoveRecord {
    /// The instant the plan counts from: the start of its run, ns since power-up.
    pub start_ns: u64,
    /// When it ended.
    pub end_ns: u64,
    /// The number of its run, from 0: moves that follow each other without a pause.
    pub run: usize,
    /// The shaping of its run, if it is shaped. Its plans are what goes into the shapers.
    pub shaping: Option<Arc<Shaping>>,
    /// The blend round the corner at which it begins, if there is one.
    pub blend: Option<Blend<AXES>>,
    /// True if a blend follows, into which it ends.
    pub ends_in_blend: bool,
    /// The plan of its line; of no distance if all of it is in blends.
    pub plan: SyncMove<AXES>,
    /// The places where the program lines begin that it is made for beside the first, in steps of the longest axis from its
    /// beginning.
    pub marks_steps: Vec<u32>,
    /// The request: the move, and for each mark the one that begins there.
    pub asked: Vec<Move>,
    /// The replans of the move, in the order in which they were made.
    pub parts: Vec<SyncMove<AXES>>,
    /// Start position, steps.
    pub origin_steps: [i32; AXES],
    /// End position, steps.
    pub end_steps: [i32; AXES],
    /// Its end.
    pub finish: Finish,
    /// The place where it was held, if it was, in steps of the longest axis along the path.
    pub held_at_steps: f64,
    /// When its plan ended, s from the start of its run.
    pub plan_s: f64,
    /// True if it belongs to homing.
    pub homing: bool,
    /// Its edges, up to the beginning of the next move, as a range of [`Outcome::edges`](crate::Outcome::edges).
    pub edges: Range<usize>,
}

impl MoveRecord {
    /// True if it was made as planned, to its end or to where it was held, and not stopped abruptly.
    pub fn is_whole(&self) -> bool {
        matches!(self.finish, Finish::Done | Finish::Held)
    }

    /// The plan by which its line ends.
    pub fn last_part(&self) -> &SyncMove<AXES> {
        self.parts.last().unwrap_or(&self.plan)
    }

    /// The numbers of the steps that the axis with index `axis` should have made on its line.
    pub fn step_numbers(&self, axis: usize) -> Range<u32> {
        let last = match self.finish {
            Finish::Held => self.plan.steps_before(axis, self.held_at_steps),
            // The blend may begin before the plan ends.
            _ if self.ends_in_blend => {
                let moved = self.end_steps[axis] - self.origin_steps[axis] - self.blend_moves(axis);
                self.plan.step_numbers(axis).start - 1 + moved.unsigned_abs()
            }
            // The first plan may end before the end of the move.
            _ => self.plan.steps[axis].unsigned_abs(),
        };
        self.plan.step_numbers(axis).start..last + 1
    }

    /// The place where its line begins, steps: at the corner, if it begins with a blend, which does not come there.
    pub fn corner_steps(&self) -> [i32; AXES] {
        std::array::from_fn(|axis| self.origin_steps[axis] - self.blend.map_or(0, |blend| blend.ends_steps(axis)[0]))
    }

    /// The place where its line ends, steps: at the corner, if a blend follows, which does not come there.
    pub fn next_corner_steps(&self) -> [i32; AXES] {
        let corner_steps = self.corner_steps();
        let end_steps = |axis: usize| corner_steps[axis] + self.plan.steps[axis];
        if self.ends_in_blend { std::array::from_fn(end_steps) } else { self.end_steps }
    }

    /// The number of steps that the axis with index `axis` makes in its blend.
    pub fn blend_steps(&self, axis: usize) -> u32 {
        self.blend.map_or(0, |blend| blend.step_counts(axis).0)
    }

    /// By how many steps its blend moves the axis with index `axis`.
    fn blend_moves(&self, axis: usize) -> i32 {
        self.blend.map_or(0, |blend| blend.ends_steps(axis)[1] - blend.ends_steps(axis)[0])
    }

    /// The steps that every axis should have moved, signed by direction.
    pub fn planned_steps(&self) -> [i32; AXES] {
        std::array::from_fn(|axis| {
            self.blend_moves(axis) + self.plan.steps[axis].signum() * self.step_numbers(axis).len() as i32
        })
    }

    /// The number of edges that it should have made.
    pub(crate) fn planned_edges(&self) -> u64 {
        (0..AXES).map(|axis| u64::from(self.blend_steps(axis)) + self.step_numbers(axis).len() as u64).sum()
    }

    /// When each edge of the axis with index `axis` was due in closed form, s from the start of the run, and in which
    /// direction.
    pub fn due_s(&self, axis: usize) -> impl Iterator<Item = (f64, i32)> {
        let sign = self.plan.steps[axis].signum();
        let bent = self.blend.into_iter().flat_map(move |blend| {
            let (all, out) = blend.step_counts(axis);
            let first = blend.direction(axis);
            (1..=all).map(move |k| {
                let goes_back = k > out && out > 0;
                (blend.step_time_s(axis, k), if goes_back { -first } else { first })
            })
        });
        bent.chain(self.step_numbers(axis).map(move |k| (self.step_time_s(axis, k), sign)))
    }

    /// When the last edge of the axis with index `axis` was due in closed form, s from the start of the run.
    pub(crate) fn last_due_s(&self, axis: usize) -> Option<f64> {
        match (self.step_numbers(axis), self.blend) {
            (numbers, _) if !numbers.is_empty() => Some(self.step_time_s(axis, numbers.end - 1)),
            (_, Some(blend)) if blend.step_counts(axis).0 > 0 => {
                Some(blend.step_time_s(axis, blend.step_counts(axis).0))
            }
            _ => None,
        }
    }

    /// When it begins, s from the start of the run.
    pub fn begin_s(&self) -> f64 {
        self.blend.map_or_else(|| self.plan.begin_s(), |blend| blend.begin_s())
    }

    /// By how much the axes are late on its path, s; 0 if its run is not shaped.
    pub fn delay_s(&self) -> f64 {
        self.shaping.as_ref().map_or(0.0, |shaping| shaping.delay_s)
    }

    /// The time that its run takes longer because it is shaped, at the end, s.
    pub fn lasts_s(&self) -> f64 {
        self.shaping.as_ref().map_or(0.0, |shaping| shaping.lasts_s)
    }

    /// The time from its beginning to an instant after the start of its run, s; less by what the axes are late.
    pub fn passed_s(&self, t_ns: u64) -> f64 {
        (t_ns - self.start_ns) as f64 * 1e-9 - self.delay_s() - self.begin_s()
    }

    /// When the axes come to its beginning, rounded to ns since power-up: late, if its run is shaped.
    pub(crate) fn reached_ns(&self) -> u64 {
        self.start_ns + ((self.begin_s() + self.delay_s()) * 1e9).round() as u64
    }

    /// When step `k` of the axis with index `axis` was due in closed form, s from the start of the run.
    pub fn step_time_s(&self, axis: usize, k: u32) -> f64 {
        // The latest plan that contains the step applies.
        let part = self.parts.iter().rev().find(|part| part.step_numbers(axis).contains(&k));
        part.unwrap_or(&self.plan).step_time_s(axis, k)
    }

    /// When the longest axis is at `place_steps` from the beginning of the move in closed form, s from the start of the
    /// run.
    pub fn place_time_s(&self, place_steps: f64) -> f64 {
        let part = self.parts.iter().rev().find(|part| part.begin_steps() <= place_steps);
        part.unwrap_or(&self.plan).time_at(place_steps)
    }

    /// The position at a place on its path, steps.
    pub fn position_steps(&self, place_steps: f64) -> [i32; AXES] {
        std::array::from_fn(|axis| {
            let before =
                self.plan.steps_before(axis, place_steps) as i32 - self.plan.step_numbers(axis).start as i32 + 1;
            self.origin_steps[axis] + self.blend_moves(axis) + self.plan.steps[axis].signum() * before
        })
    }

    /// Time from the end of this move's plan to the beginning of the `next` move, ns; negative if this one was cut
    /// short.
    pub fn pause_ns(&self, next: &Self) -> f64 {
        // First the difference of the instants as integers, because they may be large.
        (next.start_ns - self.start_ns) as f64 + (next.begin_s() - self.plan_s) * 1e9
    }

    /// Duration as it was made, s.
    pub fn duration_s(&self) -> f64 {
        self.plan_s - self.begin_s()
    }

    /// When its plan begins, rounded to ns since power-up.
    pub fn begin_ns(&self) -> u64 {
        self.start_ns + (self.begin_s() * 1e9).round() as u64
    }

    /// Notes that it ended when its plan did.
    fn end_as_planned(&mut self) {
        self.end_ns = self.start_ns + (self.plan_s * 1e9).round() as u64;
    }

    /// The single profile of the whole line, if there is one: of all that is made between the blends at its ends. This may
    /// be the first plan, or the first plan with its braking later or left out, because the moves after it became known
    /// only later.
    pub fn profile(&self) -> Option<Profile> {
        let first = self.plan.profile;
        let last = self.last_part();
        let is_cut = (last.end_s() - self.plan_s).abs() > SAME_S;
        let length_steps = last.end_steps() - self.plan.begin_steps();
        if self.finish != Finish::Done || !self.has_all_of_its_line() || is_cut || length_steps <= 0.0 {
            return None;
        }
        let (entry, exit) = (first.entry_speed_steps_s(), last.profile.exit_speed_steps_s());
        let limits = limits_of(&first, &last.profile);
        let longest = (0..AXES).max_by(|&a, &b| self.length_of(a).total_cmp(&self.length_of(b)))?;
        let (numbers, begin_s) = (self.step_numbers(longest), self.plan.begin_s());
        let ahead_steps = self.way_to_first(longest) - f64::from(numbers.start);
        let stride = (numbers.len() as u32 / PROBES).max(1) as usize;
        let is_it = |whole: &Profile| {
            numbers.clone().step_by(stride).all(|k| {
                let made_s = self.step_time_s(longest, k) - begin_s;
                (whole.time_at(f64::from(k) + ahead_steps) - made_s).abs() < SAME_S
            })
        };
        let by = |speed_profile| {
            Profile::plan(length_steps, entry, exit, &limits, IntervalSplit::Fastest, speed_profile).ok()
        };
        let is_planned = self.parts.is_empty() && length_steps == first.distance_steps();
        if is_planned { Some(first) } else { SpeedProfile::ALL.into_iter().filter_map(by).find(is_it) }
    }

    /// True if it begins where its blend ends, or at rest, and not where an earlier part of the move was held.
    fn has_all_of_its_line(&self) -> bool {
        self.blend.is_some() || (0..AXES).all(|axis| self.plan.step_numbers(axis).start == 1)
    }

    /// The distance of the axis with index `axis` on its line, and from the beginning of the line to its first step there.
    pub fn way(&self, axis: usize) -> Way {
        let end_steps = self.last_part().end_steps();
        let [begin, end] = [self.plan.begin_steps(), end_steps].map(|place| self.plan.axis_place(axis, place));
        Way { steps: (end - begin).abs(), to_first_steps: self.way_to_first(axis) }
    }

    /// The time from its beginning to that of its line, s.
    pub fn line_begins_s(&self) -> f64 {
        self.plan.begin_s() - self.begin_s()
    }

    fn way_to_first(&self, axis: usize) -> f64 {
        let begin_steps = self.plan.axis_place(axis, self.plan.begin_steps()) * self.plan.axis_steps(axis).signum();
        f64::from(self.plan.step_numbers(axis).start) - 0.5 - begin_steps
    }

    fn length_of(&self, axis: usize) -> f64 {
        self.plan.axis_steps(axis).abs()
    }
}

/// The limits that a line was planned with, as they show in its first plan and its last one.
fn limits_of(first: &Profile, last: &Profile) -> Limits {
    // For ramps over time, the acceleration is highest in the middle of the ramp.
    let accel_steps_s2 = first.accel_at(first.t_accel_s() / 2.0);
    let decel_steps_s2 = -last.accel_at(last.duration_s() - last.t_decel_s() / 2.0);
    let jerk_steps_s3 = first.jerk_at(0.0);
    // Without a ramp any will do.
    let or = |one: f64, other: f64| if one > 0.0 { one } else { other };
    Limits {
        start_speed_steps_s: 0.0,
        top_speed_steps_s: first.cruise_speed_steps_s(),
        accel_steps_s2: or(accel_steps_s2, decel_steps_s2),
        decel_steps_s2: or(decel_steps_s2, accel_steps_s2),
        jerk_steps_s3: if jerk_steps_s3 > 0.0 { jerk_steps_s3 } else { f64::INFINITY },
    }
}

/// Assembles moves from events.
#[derive(Clone, Debug, Default)]
pub struct Moves {
    /// The moves so far, in order. For a run in progress, what is known of its moves.
    records: Vec<MoveRecord>,
    /// Configurations that the moves were planned with; each applies from the run with that number on.
    configs: Vec<(usize, Config)>,
    open: Option<OpenRun>,
    taken: TakenMoves,
    runs: usize,
    homing: bool,
}

/// The moves that have been taken into the look-ahead, from the one that was begun last on.
#[derive(Clone, Debug, Default)]
struct TakenMoves {
    /// The number of the first.
    first: u16,
    asked: VecDeque<Move>,
}

impl TakenMoves {
    fn take(&mut self, number: u16, asked: Move) {
        if usize::from(number.wrapping_sub(self.first)) != self.asked.len() {
            (self.asked, self.first) = (VecDeque::new(), number);
        }
        self.asked.push_back(asked);
    }

    /// The move with this number; those before it have been made, or are forgotten.
    fn begin(&mut self, number: u16) -> Option<Move> {
        let passed = usize::from(number.wrapping_sub(self.first)).min(self.asked.len());
        self.asked.drain(..passed);
        self.first = number;
        self.asked.front().copied()
    }

    /// The move with this number, which is made together with the one that was begun last.
    fn get(&self, number: u16) -> Option<Move> {
        self.asked.get(usize::from(number.wrapping_sub(self.first))).copied()
    }
}

/// A run in progress.
#[derive(Clone, Debug)]
struct OpenRun {
    start_ns: u64,
    number: usize,
    shaping: Option<Arc<Shaping>>,
    /// Start position of the next move, steps.
    place_steps: [i32; AXES],
    /// Index of its first move.
    first: usize,
}

impl Moves {
    /// Number of runs that have begun.
    pub fn runs(&self) -> usize {
        self.runs
    }

    /// Processes an event. The last edge before it was at `edge_ns`.
    pub fn take(&mut self, t_ns: u64, edge_ns: u64, event: Event) {
        match (event, &mut self.open) {
            (Event::State(state), _) => self.homing = state == State::Home,
            (Event::Run { start, origin_steps, shaping }, _) => {
                let (start_ns, number, first) = (crate::time::ns(start), self.runs, self.records.len());
                let shaping = shaping.map(Arc::new);
                self.open = Some(OpenRun { start_ns, number, shaping, place_steps: origin_steps, first });
                self.runs += 1;
            }
            (Event::Taken { number, asked }, _) => self.taken.take(number, asked),
            (Event::Move { plan, number }, Some(run)) => {
                let asked = self.taken.begin(number).into_iter().collect();
                self.records.push(MoveRecord { asked, ..run.begin(plan, self.homing) });
            }
            (Event::Blend { blend, end_steps, number }, Some(run)) => {
                run.turn(&blend);
                if let Some(record) = self.records.last_mut() {
                    (record.ends_in_blend, record.end_steps, record.plan_s) = (true, run.place_steps, blend.begin_s());
                }
                let asked = self.taken.begin(number).into_iter().collect();
                self.records.push(MoveRecord { asked, ..run.begin_bent(blend, end_steps, self.homing) });
            }
            (Event::Mark { place_steps, number }, Some(_)) => {
                if let Some(record) = self.records.last_mut() {
                    record.marks_steps.push(place_steps);
                    record.asked.extend(self.taken.get(number));
                }
            }
            (Event::Replan { plan }, Some(_)) => {
                if let Some(record) = self.records.last_mut() {
                    if record.plan.profile.distance_steps() == 0.0 {
                        // The line after a blend.
                        (record.plan, record.plan_s) = (plan, plan.end_s());
                        return;
                    }
                    // Most moves with a replan have only one: exact capacity saves memory with 200,000 moves.
                    record.parts.reserve_exact(1);
                    record.parts.push(plan);
                    record.plan_s = plan.end_s();
                }
            }
            (Event::RunEnd { finish, held_at_steps, plan_s, position_steps }, open) => {
                let Some(run) = open.take() else { return };
                if finish != Finish::Done && finish != Finish::Held {
                    // A run starts on a whole tick of the clock, and may be stopped before that. The coordinator may learn of
                    // a stop late: no move began after the last edge, except the first one of the run.
                    let after_start_s = |t_ns: u64| (t_ns as f64 - run.start_ns as f64) * 1e-9;
                    self.forget_begun_after(run.first, after_start_s(t_ns).min(after_start_s(edge_ns).max(0.0)));
                }
                end(&mut self.records[run.first..], finish, (held_at_steps, plan_s), position_steps, t_ns);
            }
            _ => {}
        }
    }

    /// Discards moves that were planned but did not begin.
    fn forget_begun_after(&mut self, first: usize, stopped_s: f64) {
        let begun = self.records[first..].iter().filter(|record| record.begin_s() <= stopped_s).count();
        self.records.truncate(first + begun);
    }

    /// Notes that the next run is planned with `config`.
    pub(crate) fn plan_by(&mut self, config: Config) {
        if self.configs.last().is_none_or(|(_, last)| *last != config) {
            self.configs.push((self.runs, config));
        }
    }

    /// The moves so far, in order.
    pub(crate) fn records(&self) -> &[MoveRecord] {
        &self.records
    }

    /// The number of moves that nothing can change any more, if any: those before one that began well before the last edge,
    /// which was at `edge_ns`. A shaped run is judged as a whole, and stays together.
    pub(crate) fn settled(&self, edge_ns: u64) -> Option<usize> {
        let has_begun = |record: &MoveRecord| record.begin_ns() + SETTLED_NS <= edge_ns;
        let may_part = |index: usize| {
            let [before, record] = [&self.records[index - 1], &self.records[index]];
            record.shaping.is_none() || before.run != record.run
        };
        let begun = self.records.iter().rposition(has_begun)?;
        (1..=begun).rev().find(|&index| may_part(index))
    }

    /// Takes the first moves, with the configurations that all moves so far were planned with.
    pub(crate) fn take_first(&mut self, count: usize) -> Self {
        let later = self.records.split_off(count);
        let mut taken = self.none();
        taken.records = std::mem::replace(&mut self.records, later);
        if let Some(run) = &mut self.open {
            taken.records.iter_mut().skip(run.first).for_each(MoveRecord::end_as_planned);
            run.first = run.first.saturating_sub(count);
        }
        taken
    }

    /// No moves, with the configurations that all moves so far were planned with.
    pub(crate) fn none(&self) -> Self {
        Self { configs: self.configs.clone(), ..Self::default() }
    }

    /// All moves, without their edges, and the configurations they were planned with, each from the run with that
    /// number on.
    pub(crate) fn into_records(self) -> (Vec<MoveRecord>, Vec<(usize, Config)>) {
        (self.records, self.configs)
    }
}

impl OpenRun {
    /// Goes from the end of the last move back to where the blend begins.
    fn turn(&mut self, blend: &Blend<AXES>) {
        self.place_steps = std::array::from_fn(|axis| self.place_steps[axis] + blend.ends_steps(axis)[0]);
    }

    /// Begins a move with a blend, which ends at `end_steps` of its longest axis.
    fn begin_bent(&mut self, blend: Blend<AXES>, end_steps: f64, homing: bool) -> MoveRecord {
        let origin_steps = self.place_steps;
        self.place_steps =
            std::array::from_fn(|axis| origin_steps[axis] + blend.ends_steps(axis)[1] - blend.ends_steps(axis)[0]);
        MoveRecord { blend: Some(blend), origin_steps, ..self.begin(blend.landing(end_steps), homing) }
    }

    fn begin(&mut self, plan: SyncMove<AXES>, homing: bool) -> MoveRecord {
        let origin_steps = self.place_steps;
        let before = |axis: usize| plan.steps[axis].signum() * (plan.step_numbers(axis).start - 1) as i32;
        self.place_steps = std::array::from_fn(|axis| origin_steps[axis] + plan.steps[axis] - before(axis));
        MoveRecord {
            start_ns: self.start_ns,
            end_ns: 0,
            run: self.number,
            shaping: self.shaping.clone(),
            blend: None,
            ends_in_blend: false,
            plan,
            marks_steps: Vec::new(),
            asked: Vec::new(),
            parts: Vec::new(),
            origin_steps,
            end_steps: self.place_steps,
            finish: Finish::Done,
            held_at_steps: plan.distance_steps(),
            plan_s: plan.end_s(),
            homing,
            edges: 0..0,
        }
    }
}

/// Ends the moves of a run. All but the last end where the next begins.
fn end(moves: &mut [MoveRecord], finish: Finish, (held_at_steps, plan_s): (f64, f64), place: [i32; AXES], t_ns: u64) {
    moves.iter_mut().for_each(MoveRecord::end_as_planned);
    if let Some(last) = moves.last_mut() {
        (last.finish, last.held_at_steps, last.plan_s) = (finish, held_at_steps, plan_s);
        (last.end_steps, last.end_ns) = (place, t_ns);
        // The lines behind the place where it ended have not begun.
        let made = (0..AXES).map(|axis| place[axis].abs_diff(last.origin_steps[axis])).max().unwrap_or(0);
        let end_steps = if last.blend.is_some() { 0.0 } else { last.plan.begin_steps() } + f64::from(made);
        last.marks_steps.retain(|place_steps| f64::from(*place_steps) + 0.5 < end_steps);
    }
}
