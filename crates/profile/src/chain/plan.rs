//! The plan of the chain's first block.

use super::block::{ChainBlock, MadeOf, NO_LINE_RATIO};
use super::config::{Square, is_as_low};
use super::{Chain, ChunkKind};
use crate::fixed::is_zero;
use crate::limits::Limits;
use crate::profile::Profile;
use crate::sync::{MoveSteps, SyncMove};
use crate::{IntervalSplit, SpeedProfile};

/// A plan under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnderWay<const N: usize> {
    /// True if there is a plan.
    pub(super) is_made: bool,
    pub(super) sync_move: SyncMove<N>,
    /// The instant at which it ends, s from the start of the run.
    pub(super) end_s: f64,
    /// The instant at which it begins to slow down, s from the start of the run.
    pub(super) slows_s: f64,
    /// The squared speed at which the block ends by this plan, or can end after it.
    pub(super) exit: Square,
    /// The squared speed at which the next block begins then.
    pub(super) onward: Square,
    /// True if it ends where the block ends, or where the blend begins that follows.
    pub(super) ends_block: bool,
    /// True if a blend follows, at once or at the end of the block.
    pub(super) is_bent: bool,
    /// True if the conditions it was made for have changed.
    pub(super) is_stale: bool,
    /// The kind of the next chunk of this plan.
    pub(super) kind: ChunkKind,
}

impl<const N: usize> UnderWay<N> {
    /// No plan.
    pub(super) const NONE: Self = Self {
        is_made: false,
        sync_move: SyncMove::NONE,
        end_s: 0.0,
        slows_s: 0.0,
        exit: 0,
        onward: 0,
        ends_block: false,
        is_bent: false,
        is_stale: false,
        kind: ChunkKind::Move,
    };
}

/// The beginning of a block after a blend.
#[derive(Clone, Copy, Debug)]
pub(super) struct Begun<const N: usize> {
    /// The steps of each axis for a step of the longest one, signed by direction.
    pub(super) shares: [f64; N],
    /// The place where the blend ended, steps of the longest axis.
    pub(super) place_steps: f64,
    /// The number of steps of each axis that were due before.
    pub(super) counts: [u32; N],
}

/// A distance this short counts as none, steps. The second constant is the same as a fraction of the move's distance;
/// it applies where rounding errors are larger than the first.
const NOTHING_STEPS: f64 = 1e-6;
const NOTHING_RATIO: f64 = 1e-14;

/// An approach this short is none.
const NO_APPROACH_STEPS: f64 = 1e-9;
const NO_APPROACH_RATIO: f64 = 1e-13;

/// The longest approach to a blend, s. It is committed as a whole, so a hold has to wait for it.
const APPROACH_MAX_S: f64 = 2e-3;

/// True if so few steps are none, at that distance.
fn is_nothing(steps: f64, distance_steps: f64) -> bool {
    steps <= NOTHING_STEPS || steps <= NOTHING_RATIO * distance_steps
}

/// The end of a block: its place and its speed.
#[derive(Clone, Copy, Default)]
pub(super) struct Goal {
    /// The squared speed at which it ends, and that at which the next block begins.
    pub(super) exit: Square,
    pub(super) onward: Square,
    /// The same speeds, steps/s of each block's longest axis, and mm/s; only if a blend follows.
    pub(super) speeds_steps_s: [f64; 2],
    pub(super) speeds_mm_s: [f64; 2],
    /// The place where its line ends, steps of its longest axis.
    pub(super) end_steps: f64,
    /// True if a blend follows.
    pub(super) is_bent: bool,
}

/// True if a speed is no higher than another, apart from rounding.
// Not inlined, or the compiler computes it ahead, and it is seldom needed.
#[inline(never)]
pub(super) fn is_no_faster(speed_steps_s: f64, than_steps_s: f64) -> bool {
    speed_steps_s <= than_steps_s * (1.0 + 1e-9)
}

/// A quotient that is computed only where it is asked for: ahead, it might be that of 0 and 0.
#[inline(never)]
pub(super) fn quotient(a: f64, b: f64) -> f64 {
    a / b
}

impl<const N: usize, const LEN: usize, T: Copy> Chain<N, LEN, T> {
    /// Until when the plan of the first block is right. `None` if another plan is needed from here on.
    pub(super) fn sound_until_s(&self) -> Option<f64> {
        let plan = &self.plan;
        if !plan.is_made || plan.kind == ChunkKind::Continuation && self.at_s >= plan.end_s {
            return None;
        }
        if self.is_bound_to_bend() || !plan.is_stale && (!plan.ends_block || self.is_as_wanted()) {
            return Some(plan.end_s);
        }
        let is_bound = self.at_s > plan.slows_s && self.config.speed_profile != SpeedProfile::Trapezoid
            || plan.ends_block && is_nothing(plan.sync_move.end_steps() - self.place_steps, plan.sync_move.end_steps());
        if is_bound {
            return Some(plan.end_s);
        }
        if !plan.is_bent && self.bent().is_some() {
            // To brake to a blend may take as much room as to brake to rest, so there is none to lose.
            return None;
        }
        // Until it slows down, the plan is as fast as it can be. But it must be another before a blend might begin.
        let until_s = match self.line_end_steps() {
            _ if self.bent().is_none() => plan.slows_s,
            turns if turns <= self.place_steps + NOTHING_STEPS => return None,
            turns => plan.slows_s.min(plan.sync_move.time_at(turns)),
        };
        (!plan.is_stale && self.at_s < until_s).then_some(until_s)
    }

    /// True if the plan ends as the passes want it.
    fn is_as_wanted(&self) -> bool {
        let (plan, exit) = (&self.plan, self.exit());
        plan.exit == exit && plan.onward == self.onward(exit) && plan.is_bent == self.bent().is_some()
    }

    /// The place where the longest blend at the end of the first block begins, steps; if there is none, where the block ends.
    fn line_end_steps(&self) -> f64 {
        let Some(first) = self.blocks.get(0) else { return 0.0 };
        let reach_steps = self.bent().map(|next| next.blend.reach_mm * first.steps_per_mm());
        reach_steps.map_or(first.distance_steps(), |reach_steps| first.distance_steps() - reach_steps)
    }

    /// True if the blend that follows the plan can be no other any more: the plan has come to where the longest begins, or
    /// slows down to a shorter one.
    pub(super) fn is_bound_to_bend(&self) -> bool {
        let plan = &self.plan;
        if !(plan.is_made && plan.ends_block && plan.is_bent) {
            return false;
        }
        let beyond = self.line_end_steps() + NOTHING_STEPS;
        self.place_steps > beyond || self.at_s > plan.slows_s && plan.sync_move.end_steps() > beyond
    }

    /// Plans what is left of the first block, or a first part of it. If nothing is left, it ends the block instead;
    /// if a hold has come to rest, it stays at rest.
    pub(super) fn replan(&mut self) {
        if self.blocks.len() == 1
            && self.is_at_rest()
            && !self.has_begun()
            && let Some(first) = self.blocks.get_mut(0)
            && first.move_steps.offsets[1] != [0; N]
        {
            self.last_line_mm = first.end_whole(&self.config).unwrap_or(self.last_line_mm);
            (self.last_direction, self.begun) = (first.direction(&self.config), None);
        }
        let Some(block) = self.blocks.get(0) else { return };
        let (speed_steps_s, accel_steps_s2) = self.motion(block);
        if self.has_nothing_left() {
            let exit = self.square_of(speed_steps_s, block);
            return self.end_block(exit);
        }
        if let Some((goal, approach_steps)) = self.approach(speed_steps_s) {
            return self.blend_on(&goal, approach_steps);
        }
        let Some(block) = self.blocks.get(0) else { return };
        let limits = block.limits_now(&self.config.shared_limits(&block.move_steps));
        if self.config.speed_profile == SpeedProfile::SCurve && accel_steps_s2 > 0.0 && limits.jerk_steps_s3.is_finite()
        {
            return self.ease(speed_steps_s, accel_steps_s2, limits.jerk_steps_s3);
        }
        if self.is_held && is_no_faster(speed_steps_s, limits.start_speed_steps_s) {
            return self.rest();
        }
        self.cut(speed_steps_s);
        let mut goal = self.goal(self.exit());
        if self.is_too_late(&goal) {
            // There is no room for the blend, or to brake to it, but to rest where the block ends.
            self.halt();
            goal = self.goal(self.exit());
        }
        if goal.is_bent && self.is_no_approach(goal.end_steps - self.place_steps, &goal) {
            let entry = self.blocks.get(0).map_or(0, |first| first.entry);
            return self.blend_on(&self.goal(entry), 0.0);
        }
        if !self.slow_down(speed_steps_s, &limits) {
            self.end(speed_steps_s, goal, &limits);
        }
    }

    /// True if a blend has come too late for this goal: it should have begun, or could only be left faster than the
    /// next block is to be.
    fn is_too_late(&self, goal: &Goal) -> bool {
        self.bent().is_some_and(|next| {
            let is_promised = self.plan.is_made && self.plan.is_bent;
            goal.end_steps + NOTHING_STEPS < self.place_steps
                || !is_as_low(goal.exit, next.corner_square())
                || next.is_late && !is_promised && !is_as_low(goal.onward, next.nominal)
        })
    }

    /// True if so few steps are none on the way to this goal.
    fn is_no_approach(&self, left_steps: f64, goal: &Goal) -> bool {
        left_steps <= NO_APPROACH_STEPS + NO_APPROACH_RATIO * goal.end_steps
    }

    /// The goal of a line between two blends that is short, and to be made at constant speed, and its length, steps.
    fn approach(&self, speed_steps_s: f64) -> Option<(Goal, f64)> {
        let first = self.blocks.get(0)?;
        if self.begun.is_none() || self.plan.is_made || self.is_held || first.made_of == MadeOf::Several {
            return None;
        }
        let exit = self.exit();
        let is_even = first.entry == exit && (first.accel_delta_v2 == 0 || exit == first.nominal);
        if !is_even || self.bent().is_none() {
            return None;
        }
        let goal = self.goal(exit);
        if self.is_too_late(&goal) {
            return None;
        }
        let left_steps = goal.end_steps - self.place_steps;
        let approach_steps = if self.is_no_approach(left_steps, &goal) { 0.0 } else { left_steps };
        (left_steps < APPROACH_MAX_S * speed_steps_s).then_some((goal, approach_steps))
    }

    /// The end of the first block if it ends at this squared speed.
    fn goal(&self, exit: Square) -> Goal {
        self.goal_onward(exit, self.onward(exit))
    }

    /// The same if the next block begins at the squared speed `onward`.
    pub(super) fn goal_onward(&self, exit: Square, onward: Square) -> Goal {
        let Some(first) = self.blocks.get(0) else { return Goal::default() };
        let distance_steps = first.distance_steps();
        let Some(next) = self.bent() else {
            return Goal { exit, onward: exit, end_steps: distance_steps, ..Goal::default() };
        };
        let speeds_steps_s = [first.speed_steps_s(exit, &self.config), next.speed_steps_s(onward, &self.config)];
        let [from_mm_s, to_mm_s] = [speeds_steps_s[0] * first.mm_per_step, speeds_steps_s[1] * next.mm_per_step];
        let share = if exit < onward { quotient(from_mm_s, to_mm_s) } else { 1.0 };
        let end_steps = distance_steps - next.blend.reach_mm * share * first.steps_per_mm();
        Goal { exit, onward, speeds_steps_s, speeds_mm_s: [from_mm_s, to_mm_s], end_steps, is_bent: true }
    }

    /// Makes the first block end where it ends, at rest, instead of going on to the next one by a blend.
    #[cold]
    pub(super) fn halt(&mut self) {
        if let Some(next) = self.blocks.get_mut(1) {
            next.stop();
            next.entry = next.entry.min(next.start);
        }
        self.set_line(1);
        self.set_line(0);
        self.forward(0);
    }

    /// Computes the largest delta v² of a block over the line that blends leave of it.
    fn set_line(&mut self, index: usize) {
        let after_mm = self.blocks.get(index + 1).map_or(0.0, |next| next.blend.reach_mm);
        let place_steps = if index == 0 { self.place_steps } else { 0.0 };
        let Some(block) = self.blocks.get_mut(index) else { return };
        let before_mm = if index == 0 { 0.0 } else { block.blend.reach_mm };
        let blends_mm = before_mm + after_mm;
        let steps = block.distance_steps() - place_steps - blends_mm * block.steps_per_mm();
        let is_line = is_zero(blends_mm) || steps > NO_LINE_RATIO * block.distance_steps();
        let limits = self.config.shared_limits(&block.move_steps);
        let line_mm = block.set_line(if is_line { steps } else { 0.0 }, &limits, &self.config);
        if index + 1 == self.blocks.len() {
            self.last_line_mm = line_mm;
        }
    }

    /// Fits the first block, at rest, and the blend at its end to what is left of it.
    #[cold]
    pub(super) fn set_left(&mut self) {
        if let (Some(before), Some(block)) = (self.blocks.get(0), self.blocks.get(1))
            && !block.blend.is_none()
        {
            let end = before.end(self.place_steps, true);
            let directions = [before.direction(&self.config), block.direction(&self.config)];
            if let Some(block) = self.blocks.get_mut(1) {
                let limits = self.config.shared_limits(&block.move_steps);
                block.follow(end, directions.each_ref(), &limits, &self.config);
            }
            self.set_line(1);
        }
        self.set_line(0);
    }

    /// True if too little of the first block is left to be planned.
    fn has_nothing_left(&self) -> bool {
        // All of a block that has not begun is left.
        self.place_steps > 0.0
            && self.blocks.get(0).is_none_or(|first| {
                let distance_steps = first.distance_steps();
                is_nothing(distance_steps - self.place_steps, distance_steps)
            })
    }

    /// Plans to slow down to the start speed in a hold, or else to the top speed, if it is faster than that and there
    /// is room. Returns whether it does.
    fn slow_down(&mut self, speed_steps_s: f64, limits: &Limits) -> bool {
        let Some(first) = self.blocks.get(0) else { return false };
        let is_slow = !self.is_held && first.entry <= first.nominal;
        !(is_slow || first.entry > first.ramps_to()) && self.brake(speed_steps_s, limits)
    }

    #[cold]
    fn brake(&mut self, speed_steps_s: f64, limits: &Limits) -> bool {
        let Some(first) = self.blocks.get(0) else { return false };
        let slow_steps_s = if self.is_held { limits.start_speed_steps_s } else { limits.top_speed_steps_s };
        if is_no_faster(speed_steps_s, slow_steps_s) {
            return false;
        }
        let braking = |fast, slow| Profile::braking(fast, slow, limits, self.config.speed_profile);
        let slower = braking(speed_steps_s, slow_steps_s);
        let mut needed_steps = slower.distance_steps() + NOTHING_STEPS;
        let exit_steps_s = first.speed_steps_s(self.exit(), &self.config);
        if !self.is_held && exit_steps_s < slow_steps_s {
            needed_steps += braking(slow_steps_s, exit_steps_s).distance_steps();
        }
        // Where the blend at its end would begin now does not matter: a hold may yet make it longer.
        let has_room = needed_steps < self.line_end_steps() - self.place_steps;
        if has_room {
            self.begin(slower, None);
        }
        has_room
    }

    /// Plans to the end of the block.
    fn end(&mut self, speed_steps_s: f64, goal: Goal, limits: &Limits) {
        let Some(first) = self.blocks.get(0) else { return };
        let (exit, left_steps) = (goal.exit, goal.end_steps - self.place_steps);
        let exit_steps_s = first.speed_steps_s(exit, &self.config);
        let is_fastest = self.config.interval_split == IntervalSplit::Fastest || !self.is_at_rest();
        let speed_profile = self.config.speed_profile;
        // Its delta v² is that of the shortest line that blends may leave.
        let is_whole = !goal.is_bent && first.blend.is_none();
        let profile = if is_fastest && speed_profile == SpeedProfile::Trapezoid && is_whole && first.has_fine_delta_v2()
        {
            let top = if self.is_held { 0 } else { first.nominal };
            first.trapezoid(left_steps, speed_steps_s, (exit, exit_steps_s), top, limits, &self.config)
        } else {
            let top_steps_s = if self.is_held { 0.0 } else { first.ramps_to_steps_s(&self.config) };
            let limits = Limits { top_speed_steps_s: top_steps_s.max(speed_steps_s).max(exit_steps_s), ..*limits };
            let interval_split = if is_fastest { IntervalSplit::Fastest } else { self.config.interval_split };
            Profile::between(left_steps, speed_steps_s, exit_steps_s, &limits, interval_split, speed_profile)
        };
        self.begin(profile, Some(goal));
    }

    /// Speed and acceleration at the current place, steps/s and steps/s² of the longest axis.
    fn motion(&self, block: &ChainBlock<N, T>) -> (f64, f64) {
        let plan = &self.plan;
        if !plan.is_made {
            (block.speed_steps_s(block.entry, &self.config), 0.0)
        } else if self.at_s >= plan.end_s {
            (plan.sync_move.profile.exit_speed_steps_s(), 0.0)
        } else {
            plan.sync_move.motion_at(self.at_s)
        }
    }

    fn square_of(&self, speed_steps_s: f64, block: &ChainBlock<N, T>) -> Square {
        self.config.scale.of_speed(speed_steps_s * block.mm_per_step)
    }

    /// Shortens the first block to what its plan has left of it.
    fn cut(&mut self, speed_steps_s: f64) {
        if !self.plan.is_made {
            return;
        }
        self.pass();
        self.set_line(0);
        let Some(first) = self.blocks.get_mut(0) else { return };
        first.entry = self.config.scale.of_speed(speed_steps_s * first.mm_per_step);
        if first.entry > first.ramps_to() {
            // A plan under way can brake to the speed that it promises, from any speed that it has.
            first.may_ramp_to(first.entry);
        }
        self.keep_promise(self.plan.exit, speed_steps_s);
        self.forward(0);
    }

    /// Lets the first block end slower than its delta v² allows. It can do so if there is room to brake, or if this end
    /// speed is what was `promised`. Otherwise it ends at the promised speed, if that is still slower than its delta v²
    /// allows. There may be room for the promised speed only, because with limited jerk, braking to a slightly higher
    /// speed can take a longer distance.
    fn keep_promise(&mut self, promised: Square, speed_steps_s: f64) {
        if let Some(first) = self.blocks.get(0)
            && self.exit_of(0, first) < first.reach().1
        {
            self.end_slower(promised, speed_steps_s);
        }
    }

    #[cold]
    fn end_slower(&mut self, promised: Square, speed_steps_s: f64) {
        let Some(first) = self.blocks.get(0) else { return };
        let exit_asked = self.exit_of(0, first);
        let has_room = exit_asked == promised || {
            let asked_steps_s = first.speed_steps_s(exit_asked, &self.config);
            let limits = first.limits_now(&self.config.shared_limits(&first.move_steps));
            let braking = Profile::braking(speed_steps_s, asked_steps_s, &limits, self.config.speed_profile);
            braking.distance_steps() <= self.goal(exit_asked).end_steps - self.place_steps
        };
        if !has_room && !self.plan.is_bent && self.bent().is_some() {
            // It was to rest where the block ends.
            self.halt();
            return self.keep_promise(promised, speed_steps_s);
        }
        let Some(first) = self.blocks.get(0) else { return };
        let lowest = first.reach().1;
        let exit = if has_room { exit_asked } else { promised };
        if exit >= lowest {
            return;
        }
        match self.blocks.get_mut(1) {
            Some(next) if next.flows && !next.blend.is_none() => {}
            Some(next) if next.flows => next.entry = next.entry.min(exit),
            _ => self.blocks.get_mut(0).into_iter().for_each(|first| first.start = first.start.min(exit)),
        }
        if let Some(first) = self.blocks.get_mut(0) {
            first.decel_delta_v2 = first.entry - exit;
        }
    }

    /// Plans the second half of a ramp of jerk alone, which brings the acceleration to zero.
    #[cold]
    fn ease(&mut self, speed_steps_s: f64, accel_steps_s2: f64, jerk_steps_s3: f64) {
        let profile = Profile::easing(speed_steps_s, accel_steps_s2, jerk_steps_s3);
        let half_s = profile.duration_s() / 2.0;
        let plan = &mut self.plan;
        plan.sync_move = SyncMove {
            profile,
            steps: plan.sync_move.steps,
            offsets: plan.sync_move.offsets,
            longest_steps: plan.sync_move.longest_steps,
            from_steps: self.place_steps,
            origin_steps: self.place_steps - profile.position_at(half_s),
            origin_s: self.at_s - half_s,
        };
        // Nothing may change this plan. It is never faster, nor further along the path, than the plan that it replaces.
        (plan.end_s, plan.slows_s) = (plan.sync_move.end_s(), f64::NEG_INFINITY);
        (plan.ends_block, plan.is_bent, plan.is_stale, plan.kind) = (false, false, false, ChunkKind::Replan);
    }

    /// Makes `profile` the plan from the current place on. It ends at the goal of the block, if there is one.
    fn begin(&mut self, profile: Profile, goal: Option<Goal>) {
        let ends_block = goal.is_some();
        let Goal { exit, onward, is_bent, .. } = goal.unwrap_or_else(|| {
            let exit = self.exit();
            Goal { exit, onward: exit, is_bent: self.bent().is_some(), ..Goal::default() }
        });
        let Some(block) = self.blocks.get(0) else { return };
        let (place_steps, origin_s) = (self.place_steps, self.at_s);
        let (MoveSteps { steps, offsets }, longest_steps) = (block.move_steps, block.distance_steps());
        let sync_move = SyncMove {
            profile,
            steps,
            offsets,
            longest_steps,
            from_steps: place_steps,
            origin_steps: place_steps,
            origin_s,
        };
        let end_s = sync_move.end_s();
        let slows_s = end_s - profile.t_decel_s();
        let goes_on = self.plan.is_made || place_steps > 0.0 && block.flows;
        let kind = if goes_on { ChunkKind::Replan } else { ChunkKind::Move };
        self.settled = self.settled.max(1);
        let is_stale = false;
        self.plan =
            UnderWay { is_made: true, sync_move, end_s, slows_s, exit, onward, ends_block, is_bent, is_stale, kind };
    }
}
