//! The motion of one axis, shaped: what it does next.
//!
//! # Design
//! The motion comes as phases. Each impulse of the shaper stands on one of them, as late as its delay says. Until the next
//! impulse goes on to another phase, the weighted sum of all is again a phase at constant acceleration: a shaped phase. Its state
//! is computed where it begins, from the phases' own states, so no error accumulates from one to the next.
//!
//! A box is the mean over a time. Its speed is by how much the motion differs at its two ends, which stand on phases as impulses do,
//! so its acceleration changes evenly while they stand on different phases. Where it is follows from one shaped phase to the next, and anew
//! from all the phases in it after [`ADDED_MAX`] of them.
//!
//! A step is due where the axis is half a step from a whole one, as everywhere. The count of the steps goes on from shaped phase
//! to shaped phase, and where the axis comes to rest it is that of the motion, not what rounding makes of the sum. So the end of a phase
//! is passed only when it is known whether a rest follows.

use crate::chain::ring::Ring;
use crate::fixed::{is_negative, is_zero};
use crate::phase::{AxisPhase, CountedPhase, SAME_S};
use crate::shaper::phase_counter::PhaseCounter;
use crate::shaper::sum::{AT_ONCE_S, Sum};
use crate::shaper::{IMPULSES_MAX, Impulses};

/// A phase that lasts less than this, s, can be done without if each step comes by half of this later or earlier then, or if the
/// axis is by half of this farther beside.
const BRIEF_S: f64 = 20e-6;
const AS_GOOD_S: f64 = 1e-9;
const AS_GOOD_STEPS: f64 = 2e-8;
/// The part of a phase that waits until it is known whether a rest follows, s.
const LAST_S: f64 = 0.5e-3;
/// For so many shaped phases the mean of a box is added up. Then it is computed anew, so that rounding errors stay where they are.
const ADDED_MAX: u8 = 32;
/// Places are kept below this, steps, so that they keep their digits.
const FAR_STEPS: u32 = 1 << 15;

/// One impulse on its way over the phases.
#[derive(Clone, Copy, Debug)]
struct Cursor {
    weight: f64,
    delay_s: f64,
    /// The number of the phase on which it stands.
    on: u32,
    /// The part that it adds there, the phase later by the delay and times the weight; and whether that has been computed.
    part: AxisPhase,
    is_part: bool,
    /// The instant at which it comes to the end of the phase, s from the start of the run; the delay included.
    end_s: f64,
}

impl Cursor {
    const NONE: Self =
        Self { weight: 0.0, delay_s: 0.0, on: 0, part: AxisPhase::rest(0.0, 0.0), is_part: false, end_s: 0.0 };
}

/// A part of a shaped motion, at one acceleration or at one jerk.
#[derive(Clone, Copy, Debug)]
pub struct ShapedPart {
    pub(super) sum: Sum,
    /// The instant at which it ends, s from the start of the run.
    pub(super) end_s: f64,
    /// The whole step from which its place counts.
    pub(super) base_steps: i32,
    /// The steps made up to its end, if it comes to rest there. Both count from the beginning of the run.
    pub(super) last_steps: Option<i32>,
    /// That is the end of the run.
    pub(super) is_last: bool,
}

/// The shaped motion of one axis of a run. `LEN` phases are kept, which are those between the first impulse and the last. It is
/// large.
#[derive(Clone, Debug)]
pub struct Shaped<const LEN: usize> {
    cursors: [Cursor; IMPULSES_MAX],
    /// The number of them.
    count: usize,
    counter: PhaseCounter,
    /// If it is a box: the inverse of how long that lasts, and 0 otherwise.
    per_box_s: f64,
    /// The place of the axis in the mean, and the number of shaped phases over which that has been added up.
    mean_steps: f64,
    added: u8,
    phases: Ring<AxisPhase, LEN>,
    /// The number of the first phase that is kept.
    first: u32,
    /// Up to when phases are known, s from the start of the run; and whether the last one ends there.
    known_s: f64,
    is_whole: bool,
    /// The whole step from which the places of phases count, steps from the beginning of the run.
    base_steps: i32,
    /// Up to when shaped phases have been taken, also with what counts as that instant.
    t_s: f64,
    now_s: f64,
    /// The steps up to the last phase, if that is a rest; and whether it is the end.
    rest_steps: i32,
    is_finished: bool,
}

impl<const LEN: usize> Shaped<LEN> {
    /// Nothing is known of any motion. It is all zeros in memory, so that a chip needs no copy of it in flash.
    #[must_use]
    pub const fn empty() -> Self {
        Self {
            cursors: [Cursor::NONE; IMPULSES_MAX],
            count: 0,
            counter: PhaseCounter::NONE,
            per_box_s: 0.0,
            mean_steps: 0.0,
            added: 0,
            phases: Ring::new(AxisPhase::rest(0.0, 0.0)),
            first: 0,
            known_s: 0.0,
            is_whole: false,
            base_steps: 0,
            t_s: 0.0,
            now_s: 0.0,
            rest_steps: 0,
            is_finished: false,
        }
    }

    /// Begins a run, at rest at `place_steps` from the whole step where the axis is. `top_steps_s` is its top speed.
    pub fn begin(&mut self, impulses: Impulses, top_steps_s: f64, place_steps: f64) {
        self.phases.clear();
        (self.count, self.counter, self.first) = (0, PhaseCounter::new(top_steps_s), 0);
        (self.known_s, self.base_steps, self.rest_steps) = (0.0, 0, 0);
        (self.is_whole, self.is_finished) = (false, false);
        (self.t_s, self.now_s) = (0.0, SAME_S);
        self.append(AxisPhase::rest(0.0, place_steps));
        for (cursor, (weight, delay_s)) in self.cursors.iter_mut().zip(impulses.iter()) {
            *cursor = Cursor { weight, delay_s, ..Cursor::NONE };
            self.count += 1;
        }
        (self.per_box_s, self.mean_steps, self.added) = (0.0, place_steps, 0);
        if let Some([begin_s, end_s]) = impulses.box_ends_s() {
            // The mean changes by what comes in at its beginning and goes out at its end.
            self.per_box_s = 1.0 / (end_s - begin_s);
            (self.cursors[0].weight, self.cursors[1].weight) = (self.per_box_s, -self.per_box_s);
        }
        self.set_parts();
    }

    /// True if there is room for another phase.
    #[must_use]
    pub fn has_room(&self) -> bool {
        !self.phases.is_full()
    }

    /// Up to when phases are known, s from the start of the run.
    #[must_use]
    pub fn known_s(&self) -> f64 {
        self.known_s
    }

    /// Up to when shaped phases have been taken, s from the start of the run.
    #[must_use]
    pub fn taken_s(&self) -> f64 {
        self.t_s
    }

    /// The steps made up to the end, once that is known, from the beginning of the run.
    #[must_use]
    pub fn end_steps(&self) -> i32 {
        self.rest_steps
    }

    /// True if the end has been taken: the axis stands still, and so do all that it is the sum of.
    #[must_use]
    pub fn is_over(&self) -> bool {
        let last = self.last();
        self.is_finished && self.on_phases().iter().all(|cursor| cursor.on == last)
    }

    /// Adds what the axis does up to `end_s`, for which there is room; `is_whole` tells that it ends there. The place of the phase
    /// counts from the whole step `from_steps`, which is counted from the beginning of the run. False if it would last no time:
    /// then it is left out.
    pub fn push(&mut self, phase: AxisPhase, from_steps: i32, end_s: f64, is_whole: bool) -> bool {
        if is_earlier(end_s, self.known_s + SAME_S) {
            return false;
        }
        if phase.is_rest() {
            self.rest_steps = from_steps;
            if self.ends_at_rest() {
                self.extend(end_s, is_whole);
                return true;
            }
        }
        let is_far = from_steps.abs_diff(self.base_steps) > FAR_STEPS;
        if is_far {
            let moved_steps = f64::from(self.base_steps.wrapping_sub(from_steps));
            for index in 0..self.phases.len() {
                self.phases.get_mut(index).into_iter().for_each(|phase| phase.place_steps += moved_steps);
            }
            self.mean_steps += moved_steps;
            self.base_steps = from_steps;
        }
        let place_steps = phase.place_steps + f64::from(from_steps.wrapping_sub(self.base_steps));
        self.append(AxisPhase { place_steps, ..phase });
        self.extend(end_s, is_whole);
        if is_far {
            self.set_parts();
        }
        true
    }

    /// True if a phase at constant speed, as fast as the last one ends, lasts so little that the axis is as good as where it would
    /// be if the last phase went on instead. Moves that are not quite alike have many of these between their blends.
    pub(crate) fn can_do_without(&self, phase: &AxisPhase, end_s: f64) -> bool {
        let lasts_s = end_s - phase.begin_s;
        is_earlier(lasts_s, BRIEF_S)
            && self.phases.last().is_some_and(|last| {
                let twice_steps = last.accel_steps_s2.abs() * (lasts_s * lasts_s);
                twice_steps <= AS_GOOD_STEPS + AS_GOOD_S * phase.speed_steps_s.abs()
            })
    }

    /// The last phase goes on up to `end_s`; `is_whole` tells that it ends there.
    pub fn extend(&mut self, end_s: f64, is_whole: bool) {
        (self.known_s, self.is_whole) = (end_s, is_whole);
        let last = self.last();
        for index in 0..self.count {
            if self.cursors[index].on + 1 >= last {
                self.set_end(index);
            }
        }
    }

    /// The motion ends where the last phase ends, for which there is room: at `place_steps` from the whole step `from_steps`.
    /// It has made `steps` steps in all then, signed by direction.
    pub fn finish(&mut self, place_steps: f64, from_steps: i32, steps: i32) {
        let phase = AxisPhase::rest(self.known_s, place_steps);
        self.push(phase, from_steps, f64::INFINITY, false);
        (self.rest_steps, self.is_finished) = (steps, true);
    }

    /// The next motion of the axis; `None` if not enough is known, or if it is over.
    pub fn next_phase(&mut self) -> Option<CountedPhase> {
        let ShapedPart { sum, end_s, base_steps, last_steps, .. } = self.next_part()?;
        Some(self.counter.count(sum, end_s, base_steps, last_steps))
    }

    /// The same, before its steps are counted.
    #[inline(always)]
    pub fn next_part(&mut self) -> Option<ShapedPart> {
        let mut end_s = self.until_s();
        while is_earlier(end_s, self.now_s) {
            if !self.pass_on() {
                return None;
            }
            end_s = self.until_s();
        }
        if end_s.to_bits() == f64::INFINITY.to_bits() {
            return None;
        }
        if self.may_come_to_rest(end_s) {
            end_s -= LAST_S;
            if is_negative(end_s - self.now_s) {
                return None;
            }
        }
        let mut sum = Sum { phase: self.sum(), jerk_steps_s3: 0.0 };
        if !is_zero(self.per_box_s) {
            sum = self.mean(sum.phase);
            if sum.is_curved() {
                let turns_s = sum.turns_after_s();
                end_s = if turns_s < end_s - self.t_s - AT_ONCE_S { self.t_s + turns_s } else { end_s };
            }
            self.mean_steps = sum.at(end_s).0;
        }
        (self.t_s, self.now_s) = (end_s, end_s + SAME_S);
        let (base_steps, last_steps, is_last) = (self.base_steps, self.rest_count(end_s), self.is_finished);
        Some(ShapedPart { sum, end_s, base_steps, last_steps, is_last })
    }

    fn append(&mut self, phase: AxisPhase) {
        if let Some(place) = self.phases.next_place() {
            *place = phase;
            self.phases.extend();
        }
    }

    fn on_phases(&self) -> &[Cursor] {
        &self.cursors[..self.count]
    }

    /// The number of the last phase.
    fn last(&self) -> u32 {
        self.first + self.phases.len() as u32 - 1
    }

    /// The instant at which the first of the impulses comes to the end of its phase, s from the start of the run.
    fn until_s(&self) -> f64 {
        let mut until_s = f64::INFINITY;
        for cursor in self.on_phases() {
            if is_earlier(cursor.end_s, until_s) {
                until_s = cursor.end_s;
            }
        }
        until_s
    }

    /// Has the impulses that have come to the end of their phases go on to the next ones. False if one of these is not known.
    fn pass_on(&mut self) -> bool {
        let last = self.last();
        let mut oldest = last;
        for index in 0..self.count {
            let cursor = &mut self.cursors[index];
            if is_earlier(cursor.end_s, self.now_s) {
                if cursor.on == last {
                    return false;
                }
                (cursor.on, cursor.is_part) = (cursor.on + 1, false);
                self.set_end(index);
            }
            oldest = oldest.min(self.cursors[index].on);
        }
        while self.first < oldest {
            self.phases.pop();
            self.first += 1;
        }
        true
    }

    /// Has what all impulses add computed again, and sets up to when they add it.
    fn set_parts(&mut self) {
        for index in 0..self.count {
            self.cursors[index].is_part = false;
            self.set_end(index);
        }
    }

    /// Sets what an impulse adds on its phase.
    fn set_part(&mut self, index: usize) {
        let Cursor { weight, delay_s, on, .. } = self.cursors[index];
        let Some(phase) = self.phases.get((on - self.first) as usize) else { return };
        let by_weight = |value: f64| if is_zero(value) { 0.0 } else { weight * value };
        self.cursors[index].is_part = true;
        self.cursors[index].part = AxisPhase {
            begin_s: phase.begin_s + delay_s,
            place_steps: by_weight(phase.place_steps),
            speed_steps_s: by_weight(phase.speed_steps_s),
            accel_steps_s2: by_weight(phase.accel_steps_s2),
        };
    }

    /// Sets when an impulse comes to the end of its phase.
    fn set_end(&mut self, index: usize) {
        let Cursor { delay_s, on, .. } = self.cursors[index];
        let next = self.phases.get((on - self.first) as usize + 1);
        self.cursors[index].end_s = next.map_or(self.known_s, |next| next.begin_s) + delay_s;
    }

    /// The sum of all impulses, from now on.
    fn sum(&mut self) -> AxisPhase {
        let mut sum = AxisPhase::rest(self.t_s, 0.0);
        for index in 0..self.count {
            if !self.cursors[index].is_part {
                self.set_part(index);
            }
            let part = &self.cursors[index].part;
            let (place_steps, speed_steps_s) = part.at(self.t_s);
            if sum.is_rest() && is_zero(sum.place_steps) {
                // To add to nothing takes as long as to add to something.
                sum = AxisPhase { place_steps, speed_steps_s, ..*part };
            } else {
                sum.place_steps += place_steps;
                sum.speed_steps_s += speed_steps_s;
                sum.accel_steps_s2 += part.accel_steps_s2;
            }
        }
        sum.begin_s = self.t_s;
        sum
    }

    /// The motion of a box, of which the sum of its ends is the speed.
    #[cold]
    fn mean(&mut self, ends: AxisPhase) -> Sum {
        let [first, last] = [0, 1].map(|index| self.cursors[index].on);
        if first == last
            && let Some(phase) = self.phases.get((first - self.first) as usize)
        {
            // All of the box is on one phase.
            let [begin_s, end_s] = [0, 1].map(|index| self.cursors[index].delay_s);
            let (place_steps, speed_steps_s) = phase.at(self.t_s - 0.5 * (begin_s + end_s));
            let lasts_s = end_s - begin_s;
            self.mean_steps = place_steps + phase.accel_steps_s2 * (1.0 / 24.0) * lasts_s * lasts_s;
            self.added = 0;
            let phase = AxisPhase { begin_s: self.t_s, place_steps: self.mean_steps, speed_steps_s, ..*phase };
            return Sum { phase, jerk_steps_s3: 0.0 };
        }
        if self.added == ADDED_MAX {
            (self.mean_steps, self.added) = (self.whole_mean(), 0);
        }
        self.added += 1;
        let phase = AxisPhase {
            begin_s: self.t_s,
            place_steps: self.mean_steps,
            speed_steps_s: ends.place_steps,
            accel_steps_s2: ends.speed_steps_s,
        };
        Sum { phase, jerk_steps_s3: ends.accel_steps_s2 }
    }

    /// The mean of the place over the box, from all the phases in it.
    fn whole_mean(&self) -> f64 {
        let [to_s, from_s] = [0, 1].map(|index| self.t_s - self.cursors[index].delay_s);
        let mut integral = 0.0;
        for number in self.cursors[1].on..=self.cursors[0].on {
            let index = (number - self.first) as usize;
            let Some(phase) = self.phases.get(index) else { continue };
            let ends_s = self.phases.get(index + 1).map_or(self.known_s, |next| next.begin_s);
            let begins_s = if number == self.cursors[1].on { from_s } else { phase.begin_s };
            integral += phase.integral(begins_s, if number == self.cursors[0].on { to_s } else { ends_s });
        }
        integral * self.per_box_s
    }

    /// True if the last phase is a rest.
    fn ends_at_rest(&self) -> bool {
        self.phases.last().is_some_and(AxisPhase::is_rest)
    }

    /// True if it is not known yet if the axis comes to rest at `end_s`, where the count of that rest decides on its last step.
    fn may_come_to_rest(&self, end_s: f64) -> bool {
        let last = self.last();
        let comes = |cursor: &Cursor| cursor.on == last && is_earlier(cursor.end_s, end_s + SAME_S);
        self.is_whole && !self.ends_at_rest() && self.on_phases().iter().all(comes)
    }

    /// The count where the axis comes to rest, if it does so at `end_s`.
    fn rest_count(&self, end_s: f64) -> Option<i32> {
        if !self.ends_at_rest() {
            return None;
        }
        let last = self.last();
        let comes =
            |cursor: &Cursor| cursor.on == last || cursor.on + 1 == last && is_earlier(cursor.end_s, end_s + SAME_S);
        self.on_phases().iter().all(comes).then_some(self.rest_steps)
    }
}

/// True if an instant is another, or comes before it. No instant is before the start of the run, so they compare as their bits
/// do; comparing floats is a call.
fn is_earlier(t_s: f64, than_s: f64) -> bool {
    t_s.to_bits() <= than_s.to_bits()
}
