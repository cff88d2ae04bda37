//! Moves that follow each other: takes them from the queue into the chain, and makes the chain by runs.

use core::convert::Infallible;

use embedded_hal::digital::OutputPin;
use isostep_profile::{IntervalSplit, SpeedProfile};

use crate::axes::AXES;
use crate::config::Config;
use crate::coordinator::{Coordinator, Purpose};
use crate::event::{Alarm, Event, Finish};
use crate::group::{Begin, Course, GroupRule, MoveGroup, deviation_beside};
use crate::machine::{CHAIN_MOVES, Motion, Move, SpeedOverrides};
use crate::run::{CHUNK_S, PROBED_CHUNK_S};
use crate::tag::{Request, Tag};
use crate::tool::Power;

/// The number of blocks in the chain with which a group may wait for moves that are still to come, and for those that only have to
/// be taken: with fewer, the machine would brake for want of what is in it. Blocks of many moves are longer: so many marks count as
/// a block.
const ENOUGH_TO_WAIT: usize = CHAIN_MOVES / 4;
const ENOUGH_TO_TAKE_MORE: usize = 4;
const MARKS_AS_A_BLOCK: usize = 8;

/// The fate of a motion that was to be taken into the chain.
enum Taken {
    /// It is in the chain, or has no steps.
    In,
    /// It has to wait until the moves in the chain have been made.
    Waits,
    /// It cannot be made.
    Refused(Alarm),
}

impl<E, F> Coordinator<'_, E, F>
where
    E: OutputPin<Error = Infallible>,
    F: FnMut(Event),
{
    /// Makes `motion`, a move or a jog, and the motions that follow it without a stop. Returns how it ended, and how
    /// many motions that were.
    pub(crate) async fn flow(&mut self, motion: Motion, purpose: Purpose) -> (Result<(), Alarm>, usize) {
        self.begin_chain(purpose);
        self.taken = 0;
        if let Taken::Refused(alarm) = self.take(motion, purpose) {
            return (Err(alarm), 1);
        }
        let result = loop {
            self.take_waiting(purpose);
            if self.chain.is_empty() {
                break self.refused.take().map_or(Ok(()), Err);
            }
            match self.make(purpose).await {
                Finish::Done => {}
                Finish::Held if self.machine.outlast_hold().await => {}
                // A motion that was held and not resumed is forgotten.
                Finish::Held => break Ok(()),
                Finish::Stopped | Finish::Fault { .. } => break Err(self.stop_alarm()),
            }
        };
        self.chain.clear();
        (self.group, self.refused) = (None, None);
        (result, self.taken)
    }

    /// Moves by signed `steps` of the motors for homing. Returns when every axis has answered. A halt is not an error here: homing halts on
    /// purpose.
    pub(crate) async fn travel(
        &mut self,
        steps: [i32; AXES],
        feed_mm_s: f64,
        purpose: Purpose,
    ) -> Result<Finish, Alarm> {
        self.begin_chain(purpose);
        self.push(steps, feed_mm_s, 0)?;
        let finish = self.make(purpose).await;
        self.chain.clear();
        Ok(finish)
    }

    /// Makes one run of the chain.
    pub(crate) async fn make(&mut self, purpose: Purpose) -> Finish {
        self.chain.start();
        if self.chain.is_empty() {
            // No step was left of the move that was held.
            return Finish::Done;
        }
        if self.is_overridden(purpose) {
            self.override_chain(purpose);
        }
        self.machine.set_moving(true);
        let finish = self.run(purpose).await;
        self.machine.set_moving(false);
        finish
    }

    /// Gets the chain ready for moves from where the machine stands.
    #[cold]
    pub(crate) fn begin_chain(&mut self, purpose: Purpose) {
        let config = self.machine.config();
        let Config { speed_profile, kinematics, .. } = config;
        // Homing stops at a switch, whose distance is not known, so a move cannot be divided into thirds of that
        // distance.
        let interval_split = if purpose.is_homing() { IntervalSplit::Fastest } else { config.interval_split };
        self.chain.clear();
        self.marks.clear();
        let shaping = purpose.shaping(&config);
        let times = self.least_times;
        let effort =
            times.effort(speed_profile, &self.machine.capabilities(), &config.wiring, shaping.as_ref(), kinematics);
        self.chain.set_config(config.chain(interval_split, shaping.as_ref()).with_effort(effort));
        let has_blends = speed_profile == SpeedProfile::Trapezoid && interval_split == IntervalSplit::Fastest;
        self.group_rule = if purpose == Purpose::Program && has_blends {
            let Config { limits, steps_per_mm, .. } = config.of_motors();
            GroupRule::new(effort.move_s + effort.blend_s, times, &limits, &steps_per_mm)
        } else {
            GroupRule::NONE
        };
        self.is_curved = speed_profile != SpeedProfile::Trapezoid;
        self.chunk_s = if purpose.ends_by_contact() { PROBED_CHUNK_S } else { CHUNK_S };
        self.overrides = SpeedOverrides::NONE;
        self.kinematics = kinematics;
        self.planned_steps = self.machine.motor_steps();
        (self.begin, self.group, self.used_mm, self.refused) = (Begin::WHOLE, None, 0.0, None);
        self.course = Course::NONE;
    }

    /// Takes the waiting motions into the chain, for as long as they can follow.
    #[cold]
    fn take_waiting(&mut self, purpose: Purpose) {
        while self.take_next(purpose) {}
        self.settle_group(ENOUGH_TO_WAIT);
    }

    /// Takes so many of the waiting motions into the chain, as far as they can follow.
    pub(crate) fn take_some(&mut self, most: usize, purpose: Purpose) {
        let before = self.taken;
        let takes_all = (0..most).any(|_| !self.take_next(purpose));
        self.settle_group(match takes_all {
            false => ENOUGH_TO_TAKE_MORE,
            // It has waited for a while, and nothing has come.
            true if self.taken == before && self.takes() => usize::MAX,
            true => ENOUGH_TO_WAIT,
        });
    }

    /// Puts the moves that wait to be taken together with others into the chain, unless that has so many blocks without them.
    fn settle_group(&mut self, enough: usize) {
        if self.group.is_some() && self.needs_group(enough) {
            self.course = Course::NONE;
            self.push_group();
        }
    }

    fn needs_group(&self, enough: usize) -> bool {
        let marks = self.chain.first_tag().map_or(0, |first| self.marks.count_from(first));
        let known = self.chain.len() + marks / MARKS_AS_A_BLOCK;
        (self.waiting.is_some() || known < enough) && !self.machine.is_to_brake()
    }

    fn push_group(&mut self) {
        let Some(group) = self.group.take() else { return };
        if group.is_empty() {
            // The path is still where it began.
            self.begin = group.begin();
            return;
        }
        let (request, used_mm) = group.finish(self.used_mm, &mut self.course, &self.group_rule, self.marks);
        self.used_mm = used_mm;
        if let Err(error) = self.chain.push(request) {
            self.refused = Some(Alarm::Unplannable { reason: error.into() });
        }
    }

    /// Has the group end where the path is smooth: the next one begins there.
    #[cold]
    fn smooth_group(&mut self) {
        let Some(group) = &mut self.group else { return };
        let (asked_steps, _) = group.end();
        group.smooth(&mut self.course, &self.group_rule);
        let (steps, begin) = group.end();
        for (axis, planned_steps) in self.planned_steps.iter_mut().enumerate() {
            *planned_steps = planned_steps.wrapping_add(steps[axis] - asked_steps[axis]);
        }
        self.begin = begin;
    }

    /// Takes the next motion, if one waits and may follow; false if there is nothing to take.
    pub(crate) fn take_next(&mut self, purpose: Purpose) -> bool {
        let motion = if self.takes() { self.machine.try_motion() } else { None };
        if let Some(motion) = motion
            && !matches!(self.take(motion, purpose), Taken::In)
        {
            // If it cannot be made it is refused later, when no moves before it are left.
            self.waiting = Some(motion);
        }
        // Nothing follows a probe or homing in its chain.
        let may_follow = self.waiting.is_none() && matches!(purpose, Purpose::Program | Purpose::Jog);
        let has_room = may_follow && !self.marks.is_full();
        self.machine.set_room(if has_room { CHAIN_MOVES - self.blocks() } else { 0 });
        motion.is_some()
    }

    /// True if another motion may follow; none may while the machine is to brake. Without room for a mark the lines of a raster
    /// would be blocks of their own, each of which takes the processor longer than many lines that are one.
    pub(crate) fn takes(&self) -> bool {
        let has_room = self.blocks() < CHAIN_MOVES && !self.marks.is_full();
        has_room && self.waiting.is_none() && self.refused.is_none() && !self.machine.is_to_brake()
    }

    /// The number of blocks in the chain, with the one that is not there yet.
    fn blocks(&self) -> usize {
        self.chain.len() + usize::from(self.group.is_some())
    }

    fn take(&mut self, motion: Motion, purpose: Purpose) -> Taken {
        let one = match motion {
            Motion::Move(one) if purpose == Purpose::Program => self.kinematics.of_move(&one),
            Motion::Jog(one) if purpose == Purpose::Jog => self.kinematics.of_move(&one),
            _ => return Taken::Waits,
        };
        let steps = self.steps_to(&one);
        if steps == [0; AXES] {
            self.taken += 1;
            return Taken::In;
        }
        if let Some(motor) = self.machine.onto_switch(self.kinematics.axes(steps)) {
            return self.refuse(Alarm::HardLimit { motor });
        }
        match self.join_or_push(steps, &one) {
            Ok(()) => {
                self.taken += 1;
                self.planned_steps = one.target_steps;
                let beside = if one.deviation_mm > 0.0 { one.offsets } else { [0; AXES] };
                self.begin = Begin { beside, ..Begin::WHOLE };
                Taken::In
            }
            Err(alarm) => self.refuse(alarm),
        }
    }

    /// Refuses a motion with `alarm`, or has it wait until no moves before it are left.
    fn refuse(&self, alarm: Alarm) -> Taken {
        if self.chain.is_empty() && self.taken == 0 { Taken::Refused(alarm) } else { Taken::Waits }
    }

    /// Takes a move of so many steps together with the group, or lengthens the last block by it. Otherwise it begins another
    /// group, or becomes a block.
    fn join_or_push(&mut self, steps: [i32; AXES], one: &Move) -> Result<(), Alarm> {
        let mut request = self.request(steps, one);
        if let Some(group) = &mut self.group {
            // A line of a laser that goes straight on is better off as a mark in the last block.
            let lengthens = one.power != Power::Off && group.is_straight_to(&request);
            if !lengthens && group.join(&request, one, &self.group_rule, self.marks) {
                self.number(one);
                return Ok(());
            }
            self.push_group_before(&mut request, one, lengthens)?;
            if request.steps == [0; AXES] {
                // The path is smooth to where it was to end.
                self.number(one);
                return Ok(());
            }
        }
        if !(one.power != Power::Off && self.lengthen(&request)) {
            self.group = self.group_of(&request, one);
            if self.group.is_none() {
                request.deviation_mm = deviation_beside(request.deviation_mm, self.used_mm);
                self.used_mm = 0.0;
                return self.push_request(request, one);
            }
        }
        self.number(one);
        Ok(())
    }

    /// Puts the group into the chain before a move that is not taken together with it. If that begins a group, too, it begins
    /// where the path is smooth, and its steps are another number then.
    #[inline(never)]
    fn push_group_before(&mut self, request: &mut Request, one: &Move, lengthens: bool) -> Result<(), Alarm> {
        if self.group.as_ref().is_some_and(|group| group.may_be_smooth(&self.course))
            && !lengthens
            && self.group_of(request, one).is_some()
        {
            self.smooth_group();
            request.steps = self.steps_to(one);
        } else {
            self.course = Course::NONE;
        }
        self.push_group();
        self.refused.map_or(Ok(()), Err)
    }

    /// The group that begins with a move, if others may be taken together with it.
    fn group_of(&self, request: &Request, one: &Move) -> Option<MoveGroup> {
        MoveGroup::of(request, one, self.begin, &self.group_rule, &self.course, self.overrides.feed_percent)
    }

    fn steps_to(&self, one: &Move) -> [i32; AXES] {
        core::array::from_fn(|axis| one.target_steps[axis].wrapping_sub(self.planned_steps[axis]))
    }

    /// Lengthens the last block by a move of a laser, if that goes straight on and only its power or its line is another. On a
    /// curved ramp the instant of a mark takes too long to compute for so many of them.
    fn lengthen(&mut self, request: &Request) -> bool {
        !self.is_curved
            && self.chain.lengthen(request, |last, place_steps| self.marks.join(last, place_steps, &request.tag))
    }

    /// Puts a move of so many steps into the chain, which stops at its end.
    #[cold]
    pub(crate) fn push(&mut self, steps: [i32; AXES], feed_mm_s: f64, line: u32) -> Result<(), Alarm> {
        let target_steps = core::array::from_fn(|axis| self.planned_steps[axis].wrapping_add(steps[axis]));
        let one = Move { feed_mm_s, exact_stop: true, line, ..Move::to(target_steps) };
        self.push_request(self.request(steps, &one), &one)
    }

    fn request(&self, steps: [i32; AXES], one: &Move) -> Request {
        let &Move { offsets, feed_mm_s, exact_stop: stops, deviation_mm, reach_mm, .. } = one;
        let tag = Tag::new(self.next_number, one, self.marks.none());
        let feed_mm_s = (feed_mm_s != f64::INFINITY).then_some(feed_mm_s);
        Request { steps, offsets, feed_mm_s, stops, deviation_mm, reach_mm, least_s: 0.0, tag }
    }

    #[inline(never)]
    fn push_request(&mut self, request: Request, one: &Move) -> Result<(), Alarm> {
        self.chain.push(request).map_err(|error| Alarm::Unplannable { reason: error.into() })?;
        self.number(one);
        Ok(())
    }

    /// Notes that a move is in the chain, by its number.
    fn number(&mut self, one: &Move) {
        self.report(Event::Taken { number: self.next_number, asked: *one });
        self.next_number = self.next_number.wrapping_add(1);
    }

    /// True if the overrides in force are not those that the moves are planned with.
    pub(crate) fn is_overridden(&self, purpose: Purpose) -> bool {
        purpose == Purpose::Program && self.machine.overrides() != self.overrides
    }

    /// Plans the chain with the overrides in force.
    #[cold]
    pub(crate) fn override_chain(&mut self, purpose: Purpose) {
        if purpose == Purpose::Program {
            self.overrides = self.machine.overrides();
            let ratio = |percent: u8| f64::from(percent) / 100.0;
            self.chain.override_speed(ratio(self.overrides.feed_percent), ratio(self.overrides.rapid_percent));
        }
    }
}
