//! A move in the chain, stored compactly for the passes over the chain.

use core::num::NonZero;

use super::blend::BlendBounds;
use super::config::{ChainConfig, Effort, Square};
use super::corner::{self, UnitVector};
use super::{FEED_RATIO_MAX, Request};
use crate::IntervalSplit;
use crate::fixed::is_zero;
use crate::limits::{Limits, SPEED_MIN_STEPS_S};
use crate::profile::{Profile, ProfileError};
use crate::ramp::delta_v2;
use crate::square_root::sqrt;
use crate::sync::{MoveSteps, PlanError, longest, longest_of, path_speed};

/// A line is none if blends leave no more of it than this.
pub(super) const NO_LINE_RATIO: f64 = 1e-6;

/// A square of this many units has a resolution better than 1e-7 of it.
const FINE: Square = 1 << 24;

/// A block ends beside a whole step by this many parts at most, so that the steps on both sides of a standstill there are
/// far enough from each other.
const OFFSET_MAX: i8 = 62;

/// The moves that a block is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MadeOf {
    OneMove,
    /// It ends at rest even if another move follows.
    OneThatStops,
    Several,
}

/// One move. There are many of them, so what is seldom needed and follows from the rest is not kept.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChainBlock<const N: usize, T> {
    pub(super) move_steps: MoveSteps<N>,
    /// Its length, steps of the longest axis.
    longest_steps: f64,
    pub(super) made_of: MadeOf,
    /// True if a blend may lead to it.
    may_bend: bool,
    /// True if it came when the machine was on its way to rest at the end of the block before it.
    pub(super) is_late: bool,
    /// True if it begins at the speed at which the block before ends. Otherwise it begins from rest.
    pub(super) flows: bool,
    pub(super) tag: T,
    /// The requested speed along the path, mm/s; infinite if it is to be as fast as the limits allow.
    feed_mm_s: f64,
    /// Path length of a step of the longest axis.
    pub(super) mm_per_step: f64,
    steps_per_mm: f64,
    /// The deviation that its request allows at the corner before it, mm; 0 if the path goes to the corner exactly.
    pub(super) deviation_mm: f32,
    /// The length of it that its request has for the blend at that corner, mm; 0 if that may have half of it.
    pub(super) reach_mm: f32,
    /// The time that it lasts at least, s, beside what the effort is for its steps; 0 for what the effort is.
    least_s: f32,
    /// The squared speed at which the corner before it may be taken; `None` if the machine has to stop there.
    pub(super) corner: Option<NonZero<Square>>,
    /// The blend at that corner.
    pub(super) blend: BlendBounds,
    /// The nominal speed, which is the requested one with overrides and limits applied, steps/s; and its square.
    nominal_steps_s: f64,
    pub(super) nominal: Square,
    /// The highest nominal square that overrides can make, in units of 2^32, if a blend may lead to it; otherwise 0.
    fastest: u32,
    /// The square of the speed to which it can jump from rest.
    pub(super) start: Square,
    /// The largest delta v² over the whole block, speeding up and slowing down.
    pub(super) accel_delta_v2: Square,
    pub(super) decel_delta_v2: Square,
    /// The highest squared speed at which it may begin without a stop.
    pub(super) cap: Square,
    /// The squared speed at which it begins.
    pub(super) entry: Square,
    /// The squared speed up to which it may change its speed, in units of 2^32: above it, the block would be over before
    /// its ramps are compiled.
    ramps_to: u32,
}

impl<const N: usize, T: Copy> ChainBlock<N, T> {
    /// No block.
    pub(super) const fn none(tag: T) -> Self {
        Self {
            move_steps: MoveSteps::NONE,
            longest_steps: 0.0,
            made_of: MadeOf::OneMove,
            may_bend: false,
            is_late: false,
            flows: false,
            tag,
            feed_mm_s: 0.0,
            mm_per_step: 0.0,
            steps_per_mm: 0.0,
            deviation_mm: 0.0,
            reach_mm: 0.0,
            least_s: 0.0,
            corner: None,
            blend: BlendBounds::NONE,
            nominal_steps_s: 0.0,
            nominal: 0,
            fastest: 0,
            start: 0,
            accel_delta_v2: 0,
            decel_delta_v2: 0,
            cap: 0,
            entry: 0,
            ramps_to: 0,
        }
    }

    /// Makes it the block of a request, after no other. Returns its direction, and the limits of its longest axis, by
    /// which its delta v² is still to be computed.
    ///
    /// It begins beside whole steps by `begin`.
    pub(super) fn begin(
        &mut self,
        request: Request<N, T>,
        begin: [i8; N],
        config: &ChainConfig<N>,
    ) -> Result<(UnitVector<N>, Limits), PlanError> {
        let Request { steps, offsets, feed_mm_s, stops, deviation_mm, reach_mm, least_s, tag } = request;
        config.check_moving(&steps)?;
        let ends_beside = deviation_mm > 0.0 && config.can_blend();
        let end = core::array::from_fn(|axis| {
            if ends_beside && config.may_end_beside(axis) { offsets[axis].clamp(-OFFSET_MAX, OFFSET_MAX) } else { 0 }
        });
        let move_steps = MoveSteps { steps, offsets: [begin, end] };
        let lens = move_steps.lens();
        let limits = config.shared_limits(&move_steps);
        let distance_steps = lens[longest_of(&lens)].abs();
        let mut mm = lens;
        for axis in (0..N).filter(|&axis| !is_zero(lens[axis])) {
            mm[axis] *= config.mm_per_step[axis];
        }
        let length_mm = length(&mm);
        let per_mm = 1.0 / length_mm;
        let steps_per_mm = distance_steps * per_mm;
        let feed_steps_s = match feed_mm_s {
            Some(feed_mm_s) => path_speed(feed_mm_s * steps_per_mm)?,
            None => f64::INFINITY,
        };
        let feed_mm_s = feed_mm_s.unwrap_or(f64::INFINITY);
        let mm_per_step = length_mm / distance_steps;
        *self = Self {
            move_steps,
            longest_steps: distance_steps,
            made_of: if stops { MadeOf::OneThatStops } else { MadeOf::OneMove },
            feed_mm_s,
            mm_per_step,
            steps_per_mm,
            deviation_mm,
            reach_mm,
            least_s,
            ..Self::none(tag)
        };
        self.respeed(feed_steps_s, &limits, config);
        self.set_ramps_to(distance_steps, length_mm, config);
        self.check(distance_steps, &limits, config)?;
        Ok((corner::direction(&mm, per_mm), limits))
    }

    /// Makes it end at whole steps, from rest to rest: it does not flow into another. Returns the length of its line, mm, if
    /// that has changed.
    #[cold]
    pub(super) fn end_whole(&mut self, config: &ChainConfig<N>) -> Option<f64> {
        let Self { move_steps: MoveSteps { steps, offsets: [begin, _] }, deviation_mm, reach_mm, least_s, tag, .. } =
            *self;
        let feed_mm_s = (!self.is_rapid()).then_some(self.feed_mm_s);
        let stops = self.stops();
        let request = Request { steps, offsets: [0; N], feed_mm_s, stops, deviation_mm, reach_mm, least_s, tag };
        let mut whole = Self::none(tag);
        let (_, limits) = whole.begin(request, begin, config).ok()?;
        let line_mm = whole.set_line(whole.distance_steps(), &limits, config);
        whole.entry = self.entry.min(whole.start);
        *self = whole;
        Some(line_mm)
    }

    /// Lengthens it by a move that goes straight on at the same feed, if `join` returns a tag for both: see
    /// [`Chain::lengthen`](super::Chain::lengthen). Returns the length of its line then, mm.
    pub(super) fn lengthen(
        &mut self,
        request: &Request<N, T>,
        join: impl FnOnce(T, u32) -> Option<T>,
        config: &ChainConfig<N>,
    ) -> Option<f64> {
        let feed_mm_s = request.feed_mm_s.unwrap_or(f64::INFINITY);
        // Where each move stops, or needs a time of its own, two short ones are not one long one.
        let is_bound = config.interval_split != IntervalSplit::Fastest || config.effort.needs_time();
        if feed_mm_s != self.feed_mm_s
            || self.stops()
            || request.stops
            || is_bound
            || self.move_steps.offsets != [[0; N]; 2]
            || request.offsets != [0; N]
            || !self.goes_on(&request.steps)
        {
            return None;
        }
        let mut move_steps = self.move_steps;
        for (own, other) in move_steps.steps.iter_mut().zip(request.steps) {
            *own = own.checked_add(other)?;
        }
        let distance_steps = move_steps.longest();
        if distance_steps > self.nominal_steps_s * config.easily_s {
            return None;
        }
        let tag = join(self.tag, longest(&self.move_steps.steps))?;
        (self.move_steps, self.longest_steps, self.tag, self.made_of) =
            (move_steps, distance_steps, tag, MadeOf::Several);
        let line_steps = distance_steps - self.blend.reach_mm * self.steps_per_mm;
        let line_mm = self.set_line(line_steps, &config.shared_limits(&move_steps), config);
        self.set_ramps_to(distance_steps, distance_steps * self.mm_per_step, config);
        Some(line_mm)
    }

    /// Makes it as fast as is asked of it, if it was too short for that. Returns whether it was.
    pub(super) fn quicken(&mut self, config: &ChainConfig<N>) -> bool {
        if self.nominal_steps_s >= self.feed_steps_s() * config.feed_ratio {
            return false;
        }
        let before_steps_s = self.nominal_steps_s;
        self.respeed(self.feed_steps_s(), &config.shared_limits(&self.move_steps), config);
        self.nominal_steps_s > before_steps_s
    }

    /// True if these steps have exactly its direction.
    fn goes_on(&self, steps: &[i32; N]) -> bool {
        let longest = (0..N).max_by_key(|&axis| self.move_steps.steps[axis].unsigned_abs()).unwrap_or(0);
        let [own, other] = [self.move_steps.steps[longest], steps[longest]].map(i64::from);
        let is_along = |axis: usize| {
            let (one, next) = (self.move_steps.steps[axis], steps[axis]);
            // Most lines are along one axis, and a chip takes long for products of 64 bits.
            axis == longest || (one, next) == (0, 0) || i64::from(one) * other == i64::from(next) * own
        };
        own.signum() * other.signum() > 0 && (0..N).all(is_along)
    }

    /// Steps of the longest axis.
    pub(super) fn distance_steps(&self) -> f64 {
        self.longest_steps
    }

    /// The steps of each axis for a step of the longest one, signed by direction.
    pub(super) fn shares(&self) -> [f64; N] {
        self.move_steps.shares(self.longest_steps)
    }

    pub(super) fn steps_per_mm(&self) -> f64 {
        self.steps_per_mm
    }

    /// True if it ends at rest even if another move follows.
    pub(super) fn stops(&self) -> bool {
        self.made_of == MadeOf::OneThatStops
    }

    fn is_rapid(&self) -> bool {
        self.feed_mm_s == f64::INFINITY
    }

    /// The requested speed, steps/s of the longest axis; infinite if it is to be as fast as the limits allow.
    pub(super) fn feed_steps_s(&self) -> f64 {
        self.feed_mm_s * self.steps_per_mm
    }

    /// The requested speed, steps/s of the longest axis.
    pub(super) fn asked_steps_s(&self, config: &ChainConfig<N>) -> f64 {
        if self.is_rapid() { config.shared_limits(&self.move_steps).top_speed_steps_s } else { self.feed_steps_s() }
    }

    /// Refuses a block that could not be planned, whatever its neighbours are.
    fn check(&self, distance_steps: f64, limits: &Limits, config: &ChainConfig<N>) -> Result<(), PlanError> {
        let slowest = self.start_steps_s(limits);
        let is_too_slow = slowest < SPEED_MIN_STEPS_S && slowest < self.nominal_steps_s;
        if config.speed_profile.is_over_displacement() && is_too_slow {
            let standstill = ProfileError::Standstill {
                speed_profile: config.speed_profile,
                asked: slowest,
                min: SPEED_MIN_STEPS_S,
            };
            return Err(PlanError::Profile(standstill));
        }
        // Only a long move needs the full check: most moves are far from lasting too long.
        if distance_steps > self.nominal_steps_s * config.easily_s {
            self.check_long(distance_steps, limits, config)?;
        }
        Ok(())
    }

    #[cold]
    fn check_long(&self, distance_steps: f64, limits: &Limits, config: &ChainConfig<N>) -> Result<(), PlanError> {
        // An override may change before the block is made. So none makes a block too long that is not too long itself.
        let plain = Self { nominal_steps_s: self.feed_steps_s().min(self.bearable_steps_s(limits, config)), ..*self };
        let (limits, end) = (plain.limits_now(limits), plain.start_steps_s(limits));
        Profile::plan(distance_steps, end, end, &limits, config.interval_split, config.speed_profile)?;
        Ok(())
    }

    /// Applies the overrides in force. `limits` are those of the longest axis.
    /// `feed_steps_s` is its own.
    pub(super) fn respeed(&mut self, feed_steps_s: f64, limits: &Limits, config: &ChainConfig<N>) {
        let top_steps_s = self.bearable_steps_s(limits, config);
        let (mut steps_s, mut mm_s) = if self.is_rapid() {
            (top_steps_s * config.rapid_ratio, 0.0)
        } else {
            // The square is computed from the feed itself, so that moves of the same feed have the same square.
            let ratio = config.feed_ratio;
            let overridden = |feed: f64| if ratio == 1.0 { feed } else { feed * ratio };
            (overridden(feed_steps_s), overridden(self.feed_mm_s))
        };
        let is_bound = steps_s < SPEED_MIN_STEPS_S || steps_s > top_steps_s;
        if is_bound {
            steps_s = if steps_s > top_steps_s { top_steps_s } else { SPEED_MIN_STEPS_S };
        }
        if is_bound || self.is_rapid() {
            mm_s = steps_s * self.mm_per_step;
        }
        self.nominal_steps_s = steps_s;
        self.nominal = config.scale.of_speed(mm_s);
        self.start = self.stops_from(limits, config).min(self.nominal);
        if self.deviation_mm > 0.0 {
            self.set_fastest(feed_steps_s, top_steps_s, config);
        }
    }

    fn set_fastest(&mut self, feed_steps_s: f64, top_steps_s: f64, config: &ChainConfig<N>) {
        let fastest_steps_s = FEED_RATIO_MAX * feed_steps_s;
        let square = if self.nominal_steps_s == top_steps_s {
            self.nominal
        } else {
            let is_bound = self.is_rapid() || fastest_steps_s > top_steps_s;
            let mm_s = if is_bound { top_steps_s * self.mm_per_step } else { FEED_RATIO_MAX * self.feed_mm_s };
            config.scale.square(mm_s * mm_s)
        };
        // Rounded up.
        self.fastest = (square >> 32) as u32 + 1;
    }

    pub(super) fn fastest(&self) -> Square {
        u64::from(self.fastest) << 32
    }

    /// Notes that a blend may lead to it, and lets it last as long as that needs.
    pub(super) fn slow_down_to_bend(&mut self, limits: &Limits, config: &ChainConfig<N>) {
        self.may_bend = true;
        if self.bearable_steps_s(limits, config) < self.nominal_steps_s {
            self.respeed(self.feed_steps_s(), limits, config);
        }
    }

    /// Its top speed, at which it lasts no less than the caller needs for it, with the blend that may lead to it.
    fn bearable_steps_s(&self, limits: &Limits, config: &ChainConfig<N>) -> f64 {
        let (top_steps_s, Effort { straight_s, blend_s, .. }) = (limits.top_speed_steps_s, config.effort);
        let more_s = if self.may_bend { blend_s } else { straight_s };
        let own_s = match self.least_s.to_bits() {
            0 if is_zero(more_s) => return top_steps_s,
            0 => config.effort.move_s + more_s,
            _ => f64::from(self.least_s),
        };
        let least_s = own_s + config.effort.steps_s(&self.move_steps.steps);
        // A division takes a chip longer than a product.
        if top_steps_s * least_s <= self.distance_steps() { top_steps_s } else { self.distance_steps() / least_s }
    }

    /// Computes the largest delta v² over a line of this many steps. Steps and `limits` are those of the longest axis. Returns
    /// the length of that line, mm.
    pub(super) fn set_line(&mut self, steps: f64, limits: &Limits, config: &ChainConfig<N>) -> f64 {
        let Limits { accel_steps_s2, decel_steps_s2, jerk_steps_s3, top_speed_steps_s, .. } = *limits;
        let top_steps_s = || {
            let most_steps_s = FEED_RATIO_MAX * self.feed_steps_s();
            if most_steps_s < top_speed_steps_s { most_steps_s } else { top_speed_steps_s }
        };
        let mm2_per_step2 = self.mm_per_step * self.mm_per_step;
        let delta_v2 = |accel_steps_s2| {
            let delta_v2 = delta_v2(config.speed_profile, accel_steps_s2, jerk_steps_s3, steps, top_steps_s);
            config.scale.square(delta_v2 * mm2_per_step2)
        };
        let accel = delta_v2(accel_steps_s2);
        let decel = if accel_steps_s2 == decel_steps_s2 { accel } else { delta_v2(decel_steps_s2) };
        (self.accel_delta_v2, self.decel_delta_v2) = (accel, decel);
        steps * self.mm_per_step
    }

    /// Takes a length for a blend off the line on which it changes its speed, which is `line_mm` long.
    pub(super) fn shorten(&mut self, line_mm: f64, mm: f64) {
        let left_mm = line_mm - mm;
        // Where two blends meet, rounding may leave a little.
        if left_mm <= NO_LINE_RATIO * line_mm {
            (self.accel_delta_v2, self.decel_delta_v2) = (0, 0);
            return;
        }
        let ratio = left_mm / line_mm;
        let is_alike = self.accel_delta_v2 == self.decel_delta_v2;
        let shorter = |delta_v2: Square| (delta_v2 as f64 * ratio) as Square;
        self.accel_delta_v2 = shorter(self.accel_delta_v2);
        self.decel_delta_v2 = if is_alike { self.accel_delta_v2 } else { shorter(self.decel_delta_v2) };
    }

    fn set_ramps_to(&mut self, distance_steps: f64, length_mm: f64, config: &ChainConfig<N>) {
        let change_s = config.effort.change_s(distance_steps);
        self.ramps_to = u32::MAX;
        if change_s > 0.0 {
            self.limit_ramps(change_s, length_mm, config);
        }
    }

    /// Lets it change its speed only so far that it lasts longer than that takes to compile.
    #[cold]
    fn limit_ramps(&mut self, change_s: f64, length_mm: f64, config: &ChainConfig<N>) {
        let cruise_s = config.effort.cruise_s(&self.move_steps.steps);
        self.may_ramp_to(config.scale.of_speed(length_mm / (cruise_s + change_s)));
    }

    /// The squared speed up to which it may change its speed.
    pub(super) fn ramps_to(&self) -> Square {
        u64::from(self.ramps_to) << 32
    }

    /// Lets it change its speed up to this square.
    pub(super) fn may_ramp_to(&mut self, square: Square) {
        // Rounded up, so that it is never 0.
        self.ramps_to = (square >> 32) as u32 + 1;
    }

    /// The highest speed to which it may ramp, steps/s.
    pub(super) fn ramps_to_steps_s(&self, config: &ChainConfig<N>) -> f64 {
        self.speed_steps_s(self.ramps_to().min(self.nominal), config)
    }

    /// The highest square that it can have at one end, with `square` at the other end, between which it changes by
    /// `delta_v2` at most.
    pub(super) fn at_other_end(&self, square: Square, delta_v2: Square) -> Square {
        square.max((square + delta_v2).min(self.ramps_to()))
    }

    /// The speed to which it can jump from rest, steps/s.
    fn start_steps_s(&self, limits: &Limits) -> f64 {
        let start_steps_s = limits.start_speed_steps_s;
        if start_steps_s < self.nominal_steps_s { start_steps_s } else { self.nominal_steps_s }
    }

    /// `limits`, which are those of the longest axis, with its own speeds.
    pub(super) fn limits_now(&self, limits: &Limits) -> Limits {
        let start_speed_steps_s = self.start_steps_s(limits);
        Limits { top_speed_steps_s: self.nominal_steps_s, start_speed_steps_s, ..*limits }
    }

    /// Its direction.
    pub(super) fn direction(&self, config: &ChainConfig<N>) -> UnitVector<N> {
        let mm = core::array::from_fn(|axis| self.move_steps.len(axis) * config.mm_per_step[axis]);
        corner::direction(&mm, 1.0 / (self.distance_steps() * self.mm_per_step))
    }

    /// The highest and the lowest squared speed that it can reach at its end.
    pub(super) fn reach(&self) -> (Square, Square) {
        let is_bound = self.entry > self.ramps_to();
        let lowest = if is_bound { self.entry } else { self.entry.saturating_sub(self.decel_delta_v2) };
        (self.at_other_end(self.entry, self.accel_delta_v2), lowest)
    }

    /// True if its delta v² has so many units that their rounding does not matter.
    pub(super) fn has_fine_delta_v2(&self) -> bool {
        self.accel_delta_v2.min(self.decel_delta_v2) >= FINE
    }

    /// The highest squared speed between the entry and `exit` at constant accelerations. It is no higher than `top`,
    /// unless an end speed is.
    ///
    /// The ramps before and after the peak p are (p - entry)/(2 a) and (p - exit)/(2 d) long, and together as long as
    /// the distance.
    fn peak(&self, exit: Square, top: Square, limits: &Limits) -> Square {
        let (entry, highest, from) = (self.entry, self.entry + self.accel_delta_v2, exit + self.decel_delta_v2);
        let Limits { accel_steps_s2: a, decel_steps_s2: d, .. } = *limits;
        // The peak is computed from the smaller delta v², because the larger one may be cut off at the largest square.
        let peak = if a == d {
            (highest + exit) / 2
        } else if a < d {
            ((d * highest as f64 + a * exit as f64) / (a + d)) as Square
        } else {
            ((a * from as f64 + d * entry as f64) / (a + d)) as Square
        };
        // Rounding must not split a single ramp into two.
        peak.min(highest).min(from).min(top).max(entry).max(exit)
    }

    /// The fastest profile over what is left of it, at constant accelerations, from `entry_steps_s` to `exit`. It is no
    /// faster than `top`, unless an end speed is.
    pub(super) fn trapezoid(
        &self,
        left_steps: f64,
        entry_steps_s: f64,
        (exit, exit_steps_s): (Square, f64),
        top: Square,
        limits: &Limits,
        config: &ChainConfig<N>,
    ) -> Profile {
        let peak = self.peak(exit, top, limits);
        let peak_steps_s = match peak {
            _ if peak == self.entry => entry_steps_s,
            _ if peak == exit => exit_steps_s,
            _ => self.speed_steps_s(peak, config),
        };
        let steps = |rise: Square, delta_v2: Square, slow_steps_s: f64, accel_steps_s2: f64| match rise {
            0 => 0.0,
            _ if rise >= delta_v2 => left_steps,
            _ => (peak_steps_s - slow_steps_s) * (peak_steps_s + slow_steps_s) / (2.0 * accel_steps_s2),
        };
        let Limits { accel_steps_s2, decel_steps_s2, .. } = *limits;
        let accel_steps = steps(peak - self.entry, self.accel_delta_v2, entry_steps_s, accel_steps_s2);
        let decel_steps = steps(peak - exit, self.decel_delta_v2, exit_steps_s, decel_steps_s2);
        let speeds_steps_s = [entry_steps_s, peak_steps_s, exit_steps_s];
        Profile::constant_accel(left_steps, speeds_steps_s, [accel_steps, decel_steps], limits)
    }

    /// The speed of a square on this block, steps/s of the longest axis.
    pub(super) fn speed_steps_s(&self, square: Square, config: &ChainConfig<N>) -> f64 {
        // The nominal speed and the start speed are returned exactly, to the last digit.
        match square {
            _ if square == self.nominal => self.nominal_steps_s,
            _ if square == self.start => self.start_steps_s(&config.shared_limits(&self.move_steps)),
            _ => {
                let speed_steps_s = config.scale.speed_mm_s(square) * self.steps_per_mm;
                let is_above = square < self.nominal && speed_steps_s > self.nominal_steps_s;
                if is_above { self.nominal_steps_s } else { speed_steps_s }
            }
        }
    }

    /// True if all its steps are due before the longest axis is at `place_steps`.
    pub(super) fn has_no_step_after(&self, place_steps: f64) -> bool {
        (0..N).all(|axis| {
            self.move_steps.steps_before(axis, place_steps, self.longest_steps)
                >= self.move_steps.steps[axis].unsigned_abs()
        })
    }
}

fn length(mm: &[f64]) -> f64 {
    let mut moving = mm.iter().filter(|mm| !is_zero(**mm));
    match (moving.next(), moving.next()) {
        (Some(only), None) => only.abs(),
        _ => sqrt(mm.iter().map(|mm| mm * mm).sum()),
    }
}
