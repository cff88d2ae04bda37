//! Finds the slow places of a program.
//!
//! A ramp belongs to the slow place that it leads to or comes from. A place is a corner, a whole arc, or a standstill.
//! A ramp from or to a phase at the speed asked for belongs to whatever limits the speed of the slower phase. The
//! chain plans as fast as corners, feeds, ends and its look-ahead allow. So a slow place that the first three do not
//! explain is assigned to the look-ahead. With a curved speed profile it is assigned to the speed profile instead, because the
//! speed profile has separate ramps in each move.

use isostep_motion::AXES;
use isostep_profile::SpeedProfile;
use isostep_profile::chain::SHAPED_STEPS_MAX;

use super::asked::{Asked, Limit, SAME};
use super::corner::{Corner, CornerLimit};
use super::phases::{Change, Phase};
use super::slow::{SlowPlace, SlowPlaces, Why};
use isostep_sim::Outcome;
use isostep_sim::lines_of_moves::Source;

/// Speeds up to this count as standstill, mm/s.
const REST_MM_S: f64 = 1e-6;
/// A move is as brief as the board plans any if it lasts no longer than this, times that.
const BRIEF: f64 = 1.02;
/// A pause between two runs that is longer than this was asked for, s.
const PAUSE_S: f64 = 0.01;

/// True if the machine is at standstill at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stand {
    /// It does not stop.
    Flows,
    /// It is at standstill for this time, s.
    Stood(f64),
    /// It has not moved before or does not move afterwards, except for homing.
    Ends,
}

/// A place that is not complete yet.
#[derive(Clone, Copy, Debug)]
struct Open {
    at_s: f64,
    place_mm: [f64; AXES],
    /// The move before and the move after, and what they ask for.
    before: Option<(usize, Asked)>,
    after: Option<(usize, Asked)>,
    taken_mm_s: f64,
    stand: Stand,
    /// As in [`SlowKind`].
    ramps_s: f64,
    lost_s: f64,
}

/// A finder of how the time of a program is spent.
pub struct Found {
    /// Its slow places.
    pub places: SlowPlaces,
    /// Time at the feed asked for, and on ramps between such phases, s.
    pub feed_s: f64,
    /// Time at the top speed of each axis, with such ramps, s.
    pub top_speed_s: [f64; AXES],
    /// Time that shapers add at the ends of runs, s.
    pub shaping_s: f64,
    /// Time at standstill, s.
    pub standing_s: f64,
}

/// Finds the slow places from phases that come in order.
pub struct Finder<'a> {
    outcome: &'a Outcome,
    sources: &'a [Option<Source>],
    open: Option<Open>,
    /// The speed has fallen towards the open place, and has not risen since.
    falls: bool,
    /// The limit of the last phase that was as fast as asked for.
    level: Limit,
    last: Option<Phase<'a>>,
    /// The place of the current arc so far, and the time of its ramps.
    arc: Option<(SlowPlace, f64)>,
    found: Found,
}

impl<'a> Finder<'a> {
    /// A finder that has found nothing yet.
    pub fn new(outcome: &'a Outcome, sources: &'a [Option<Source>]) -> Self {
        Self {
            outcome,
            sources,
            open: None,
            falls: false,
            level: Limit::Feed,
            last: None,
            arc: None,
            found: Found {
                places: SlowPlaces::new(),
                feed_s: 0.0,
                top_speed_s: [0.0; AXES],
                shaping_s: 0.0,
                standing_s: 0.0,
            },
        }
    }

    /// Processes the next phase.
    pub fn take(&mut self, phase: &Phase<'a>) {
        match self.last {
            None => self.begin_run(phase, None),
            Some(last) if self.outcome.moves[last.index].run != self.outcome.moves[phase.index].run => {
                let homed = self.outcome.moves[last.index..phase.index].iter().any(|record| record.homing);
                let shaping_s = self.shaping_s(&last);
                let stood_s = (!homed).then(|| (phase.begin_s - last.end_s() - shaping_s).max(0.0));
                self.found.standing_s += stood_s.unwrap_or(0.0);
                self.end_run(&last);
                self.begin_run(phase, stood_s);
            }
            Some(_) => {}
        }
        match phase.change {
            Change::Up => self.rise(phase),
            Change::Down => self.fall(phase),
            Change::Level if phase.asked.is_reached(phase.speeds_mm_s[0]) => self.cruise(phase),
            Change::Level => self.crawl(phase),
        }
        self.last = Some(*phase);
    }

    /// The results, after the last phase.
    pub fn finish(mut self) -> Found {
        if let Some(last) = self.last {
            self.end_run(&last);
            self.close();
        }
        self.close_arc();
        for at in 0..self.found.places.worst.len() {
            let place = self.found.places.worst[at];
            if place.why == Why::Arc {
                self.found.places.worst[at].turn_deg = self.turned_deg(&place);
            }
        }
        self.found
    }

    /// Processes the start of a run after a standstill of `stood_s`. This is `None` at the beginning of the program and
    /// after homing, where the time does not count.
    fn begin_run(&mut self, phase: &Phase<'a>, stood_s: Option<f64>) {
        if stood_s.is_none() {
            self.close();
        }
        let open = self.open.get_or_insert_with(|| Open::at_begin(self.outcome, phase));
        open.after = Some((phase.index, phase.asked));
        open.stand = stood_s.map_or(Stand::Ends, Stand::Stood);
        self.falls = false;
    }

    /// Processes the end of a run with this phase.
    fn end_run(&mut self, last: &Phase<'a>) {
        self.found.shaping_s += self.shaping_s(last);
        if !self.falls {
            self.close();
        }
        let open = self.open.get_or_insert_with(|| Open::at_end(self.outcome, last));
        open.stand = Stand::Ends;
    }

    /// The time that the run of this phase takes longer at its end because it is shaped, s.
    fn shaping_s(&self, last: &Phase<'a>) -> f64 {
        let record = &self.outcome.moves[last.index];
        if record.is_whole() { record.lasts_s() } else { 0.0 }
    }

    fn rise(&mut self, phase: &Phase<'a>) {
        let bent = self.bent(phase);
        match &mut self.open {
            None => self.spend(self.level, phase.span_s),
            Some(open) => {
                open.add(phase);
                if self.falls && open.after.is_none() {
                    match bent {
                        Some([before, after]) => (open.before, open.after) = (Some(before), Some(after)),
                        None => open.after = Some((phase.index, phase.asked)),
                    }
                }
            }
        }
        self.falls = false;
    }

    fn fall(&mut self, phase: &Phase<'a>) {
        if !self.falls {
            self.close();
        }
        self.sink(phase);
    }

    /// Moves the open place to the end of this phase; it may move on with later phases. It does not move on from a corner
    /// that explains its speed to where the path is as slow.
    fn sink(&mut self, phase: &Phase<'a>) {
        if let Some(open) = &self.open
            && self.falls
            && phase.speeds_mm_s[1] >= open.taken_mm_s * (1.0 - SAME)
            && self.is_explained(open)
        {
            self.open.iter_mut().for_each(|open| open.add(phase));
            return;
        }
        let end = Open::at_end(self.outcome, phase);
        let end = match self.bent(phase) {
            Some([before, after]) => {
                let corner_steps = self.outcome.moves[after.0].corner_steps();
                let place_mm = self.outcome.mm(corner_steps);
                Open { before: Some(before), after: Some(after), place_mm, ..end }
            }
            None => end,
        };
        let open = self.open.get_or_insert(end);
        *open = Open { ramps_s: open.ramps_s, lost_s: open.lost_s, ..end };
        open.add(phase);
        self.falls = true;
    }

    /// Processes a phase at the speed asked for.
    fn cruise(&mut self, phase: &Phase<'a>) {
        if self.falls
            && let Some(open) = self.open.take()
        {
            self.spend(phase.asked.limit, open.ramps_s);
        }
        self.close();
        (self.falls, self.level) = (false, phase.asked.limit);
        self.spend(phase.asked.limit, phase.span_s);
    }

    /// Processes a phase at a constant lower speed, which is at the peak between two ramps, or due to an override.
    fn crawl(&mut self, phase: &Phase<'a>) {
        match &mut self.open {
            Some(open) if !self.falls => open.add(phase),
            _ => self.sink(phase),
        }
    }

    /// The moves that the blend of a phase joins, and what they ask for.
    fn bent(&self, phase: &Phase<'a>) -> Option<[(usize, Asked); 2]> {
        phase.bent_to.map(|to| [to - 1, to].map(|index| (index, self.asked(index))))
    }

    fn source(&self, index: usize) -> Option<&Source> {
        self.sources.get(index).and_then(Option::as_ref)
    }

    fn spend(&mut self, limit: Limit, span_s: f64) {
        match limit {
            Limit::Feed => self.found.feed_s += span_s,
            Limit::Axis(axis) => self.found.top_speed_s[axis] += span_s,
        }
    }

    /// Completes the open place.
    fn close(&mut self) {
        self.falls = false;
        let Some(open) = self.open.take() else { return };
        let sides = [open.before.or(open.after), open.after.or(open.before)];
        let [Some((before, from)), Some((after, to))] = sides else { return };
        let slower = if from.mm_s <= to.mm_s { from } else { to };
        let limit = self.corner_limit(&open, [&from, &to], after);
        let Some(why) = self.why(&open, [(before, &from), (after, &to)], limit.is_some()) else {
            self.spend(slower.limit, open.ramps_s);
            return;
        };
        let place = SlowPlace {
            why,
            at_s: open.at_s,
            place_mm: open.place_mm,
            moves: [before, after],
            lines: [before, after].map(|index| self.source(index).map(|source| source.line)),
            taken_mm_s: open.taken_mm_s,
            asked_mm_s: slower.mm_s,
            turn_deg: from.turn_deg(&to),
            limit: limit.filter(|_| matches!(why, Why::Corner | Why::Arc)),
            standing_s: if let Stand::Stood(stood_s) = open.stand { stood_s } else { 0.0 },
            lost_s: open.lost_s,
        };
        self.put(place, open.ramps_s);
    }

    /// True if a place is a corner that allows no higher speed. The corner that leads into an arc belongs to the arc, if that
    /// is as slow.
    fn is_explained(&self, open: &Open) -> bool {
        let (Some((_, from)), Some((after, to))) = (open.before, open.after) else { return false };
        let leads_into_arc = self.source(after).is_some_and(|source| source.in_arc);
        !leads_into_arc && self.corner_limit(open, [&from, &to], after).is_some()
    }

    /// The limit of the speed at a place as a corner; `None` if it is none, or would allow more.
    fn corner_limit(&self, open: &Open, sides: [&Asked; 2], after: usize) -> Option<CornerLimit> {
        let is_rest = open.stand != Stand::Flows || open.taken_mm_s <= self.start_mm_s(sides[0]).max(REST_MM_S);
        let deviation_mm = self.source(after).map_or(0.0, |source| source.deviation_mm);
        let taken_mm_s = open.taken_mm_s;
        Corner { outcome: self.outcome, sides, after, deviation_mm, taken_mm_s, is_rest }.limit()
    }

    /// The reason for a place; `None` if it is as fast as one of its moves asks for.
    fn why(&self, open: &Open, [(before, from), (after, to)]: [(usize, &Asked); 2], is_corner: bool) -> Option<Why> {
        let exact_stop = self.source(before).is_some_and(|source| source.exact_stop);
        let thirds = self.outcome.config.settings.interval_thirds;
        let stops = |other: Why| match () {
            () if exact_stop => Why::ExactStop,
            () if thirds => Why::Thirds,
            () => other,
        };
        match open.stand {
            Stand::Ends => return Some(Why::Ends),
            Stand::Stood(stood_s) if stood_s > PAUSE_S => return Some(Why::Stop),
            // A reversal needs a stop in any case. The next move was not known when the run ended.
            Stand::Stood(_) if from.is_back(to) => return Some(stops(Why::Corner)),
            Stand::Stood(_) => return Some(stops(Why::Stop)),
            Stand::Flows => {}
        }
        if from.is_reached(open.taken_mm_s) || to.is_reached(open.taken_mm_s) {
            return None;
        }
        let start_mm_s = self.start_mm_s(from).max(REST_MM_S);
        if open.taken_mm_s <= start_mm_s && (exact_stop || thirds) {
            return Some(stops(Why::Corner));
        }
        let in_arc = self.source(before).is_some_and(|source| source.in_arc);
        let one_line = self.source(before).map(|source| source.line) == self.source(after).map(|source| source.line);
        Some(match () {
            () if [(before, from), (after, to)].iter().any(|side| self.is_brief(*side, open.taken_mm_s)) => {
                Why::ShortMoves
            }
            () if is_corner && in_arc && one_line => Why::Arc,
            () if is_corner => Why::Corner,
            () if self.outcome.speed_profile != SpeedProfile::Trapezoid => Why::SpeedProfile,
            () => Why::LookAhead,
        })
    }

    /// True if a move lasts as briefly at that speed as the board plans any like it.
    fn is_brief(&self, (index, asked): (usize, &Asked), mm_s: f64) -> bool {
        let record = &self.outcome.moves[index];
        let length_mm = record.plan.distance_steps() * asked.mm_per_step;
        let times = &self.outcome.config.least_times;
        let plain_s = record.blend.map_or(times.straight_s, |_| times.blend_s);
        let together_s = match record.marks_steps.len() {
            0 => 0.0,
            marks => times.together_s + marks as f64 * times.join_s,
        };
        let [shaped_s, root_step_s] = times.of_shaping_s(record.shaping.as_deref(), self.outcome.kinematics);
        let steps: u32 = record.plan.steps.iter().map(|steps| steps.unsigned_abs()).sum();
        let shaped_s = shaped_s.max(root_step_s * f64::from(steps).min(SHAPED_STEPS_MAX).sqrt());
        length_mm <= mm_s * (plain_s.max(shaped_s) + together_s) * BRIEF
    }

    /// The speed at which such a move may start and stop without a ramp, mm/s.
    fn start_mm_s(&self, asked: &Asked) -> f64 {
        let own = |axis: usize| {
            let start_mm_s = self.outcome.limits[axis].start_speed_steps_s / self.outcome.steps_per_mm[axis];
            start_mm_s / asked.direction[axis].abs()
        };
        let slowest_mm_s = (0..AXES).filter(|&axis| asked.direction[axis] != 0.0).map(own);
        slowest_mm_s.fold(f64::INFINITY, f64::min) * (1.0 + 1e-6)
    }

    /// Adds a place. Places on one arc are combined.
    fn put(&mut self, place: SlowPlace, ramps_s: f64) {
        if place.why != Why::Arc {
            self.close_arc();
            self.found.places.add(place, ramps_s);
            return;
        }
        if self.arc.is_some_and(|(arc, _)| arc.lines != place.lines || place.moves[0] < arc.moves[1]) {
            self.close_arc();
        }
        let (arc, arc_ramps_s) = self.arc.get_or_insert((SlowPlace { lost_s: 0.0, ..place }, 0.0));
        if place.taken_mm_s < arc.taken_mm_s {
            (arc.taken_mm_s, arc.at_s, arc.place_mm) = (place.taken_mm_s, place.at_s, place.place_mm);
        }
        arc.moves[1] = place.moves[1];
        arc.lost_s += place.lost_s;
        *arc_ramps_s += ramps_s;
    }

    fn close_arc(&mut self) {
        if let Some((arc, ramps_s)) = self.arc.take() {
            self.found.places.add(arc, ramps_s);
        }
    }

    /// The angle by which the path turns within the whole arc of `place`, degrees.
    fn turned_deg(&self, place: &SlowPlace) -> f64 {
        let goes_on = |index: usize| {
            self.source(index).is_some_and(|source| source.in_arc && Some(source.line) == place.lines[0])
        };
        let first = (0..=place.moves[0]).rev().take_while(|&index| goes_on(index)).last().unwrap_or(place.moves[0]);
        let chords = (first..self.outcome.moves.len() - 1).take_while(|&index| goes_on(index));
        chords.map(|index| self.asked(index).turn_deg(&self.asked(index + 1))).sum()
    }

    fn asked(&self, index: usize) -> Asked {
        Asked::new(self.outcome, &self.outcome.moves[index], self.source(index))
    }
}

impl Open {
    fn at_begin(outcome: &Outcome, phase: &Phase) -> Self {
        Self {
            at_s: phase.begin_s,
            place_mm: phase.place_mm(outcome, 0.0),
            before: None,
            after: Some((phase.index, phase.asked)),
            taken_mm_s: phase.speeds_mm_s[0],
            stand: Stand::Flows,
            ramps_s: 0.0,
            lost_s: 0.0,
        }
    }

    fn at_end(outcome: &Outcome, phase: &Phase) -> Self {
        Self {
            at_s: phase.end_s(),
            place_mm: phase.place_mm(outcome, phase.distance_mm),
            before: Some((phase.index, phase.asked)),
            after: None,
            taken_mm_s: phase.speeds_mm_s[1],
            stand: Stand::Flows,
            ramps_s: 0.0,
            lost_s: 0.0,
        }
    }

    fn add(&mut self, phase: &Phase) {
        self.ramps_s += phase.span_s;
        self.lost_s += phase.span_s - phase.distance_mm / phase.asked.mm_s;
    }
}
