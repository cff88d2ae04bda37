//! One profile for all axes of a move.

use core::fmt;
use core::ops::Range;

use crate::compile::{AxisCompiler, NEAREST_STEPS, PhaseBoundaries, Segments, StepRange, TimedPlan};
use crate::fixed::is_zero;
use crate::limits::{LimitError, Limits, SPEED_MIN_STEPS_S};
use crate::phase::AxisPhase;
use crate::profile::{Profile, ProfileError, sum};
use crate::ramp::Ramp;
use crate::{IntervalSplit, SpeedProfile};

/// A synchronised move of `N` axes: one profile over the longest axis's steps, and a signed step count per axis.
///
/// Step k of an axis with n steps is due when the profile has covered (k - 1/2)/n of its distance. So every axis has
/// the intervals of the profile, and the path stays within half a step of the straight line on each axis.
///
/// It may also be a replan of such a move, which begins where an earlier plan was cut: see [`chain`](crate::chain).
/// Steps keep the numbers and the places that they have in the whole move.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SyncMove<const N: usize> {
    /// Displacement of the longest axis.
    pub profile: Profile,
    /// Steps of each axis in the whole move, signed by direction.
    pub steps: [i32; N],
    /// The places where the whole move begins and ends beside the whole steps.
    pub(crate) offsets: [[i8; N]; 2],
    /// The length of the whole move, steps of the longest axis.
    pub(crate) longest_steps: f64,
    /// The place where this plan begins, steps of the longest axis from the beginning of the whole move.
    pub(crate) from_steps: f64,
    /// The place where the profile begins, in the same steps. That may be before the plan begins.
    pub(crate) origin_steps: f64,
    /// The instant at which the profile begins, s from the start of the run.
    pub(crate) origin_s: f64,
}

/// Why a move could not be planned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlanError {
    /// No axis moves.
    NoSteps,
    /// The limits of the axis with this index do not work.
    Limits {
        /// Index of the axis.
        axis: usize,
        /// The fault in them.
        error: LimitError,
    },
    /// The requested speed along the path is too slow or not a number, steps/s of the longest axis.
    PathSpeed {
        /// The value that was asked for.
        asked: f64,
        /// The slowest that works.
        min: f64,
    },
    /// The profile could not be planned.
    Profile(ProfileError),
    /// The chain of moves is full.
    NoRoom,
}

impl<const N: usize> SyncMove<N> {
    /// A plan of no move.
    pub(crate) const NONE: Self = Self {
        profile: Profile::NONE,
        steps: [0; N],
        offsets: [[0; N]; 2],
        longest_steps: 0.0,
        from_steps: 0.0,
        origin_steps: 0.0,
        origin_s: 0.0,
    };

    /// Plans a move from rest to rest; it starts and ends at the start speed.
    ///
    /// The limits of every axis are scaled onto the longest axis, and the tightest apply, so no axis exceeds its own.
    /// `path_speed_steps_s` is the feed rate, in steps/s of the longest axis. It lowers the top speed further, and has
    /// no upper bound.
    ///
    /// # Errors
    /// The limit that was crossed. An axis that does not move is not checked.
    pub fn plan(
        steps: [i32; N],
        limits: &[Limits; N],
        interval_split: IntervalSplit,
        speed_profile: SpeedProfile,
        path_speed_steps_s: Option<f64>,
    ) -> Result<Self, PlanError> {
        let shared = shared_limits(&steps, limits, path_speed_steps_s)?;
        let (start, distance) = (shared.start_speed_steps_s, f64::from(longest(&steps)));
        let profile = Profile::plan(distance, start, start, &shared, interval_split, speed_profile)?;
        Ok(Self {
            profile,
            steps,
            offsets: [[0; N]; 2],
            longest_steps: distance,
            from_steps: 0.0,
            origin_steps: 0.0,
            origin_s: 0.0,
        })
    }

    /// A plan of no distance in a move of these steps: at `place_steps` of its longest axis and at that speed, `t_s` from the
    /// start of the run.
    pub(crate) fn passing(move_steps: &MoveSteps<N>, place_steps: f64, speed_steps_s: f64, t_s: f64) -> Self {
        let (profile, MoveSteps { steps, offsets }) = (Profile::passing(speed_steps_s), *move_steps);
        Self {
            profile,
            steps,
            offsets,
            longest_steps: move_steps.longest(),
            from_steps: place_steps,
            origin_steps: place_steps,
            origin_s: t_s,
        }
    }

    /// The instant at which the `k`-th step of the axis with index `axis` is due, s from the start of the run, by the closed
    /// form. `k` counts from 1 to the axis's steps; in a replan it is one of [`step_numbers`](Self::step_numbers).
    #[must_use]
    pub fn step_time_s(&self, axis: usize, k: u32) -> f64 {
        let step_range = self.step_range(axis, self.is_whole());
        let steps = (f64::from(k) - 0.5 - self.move_steps().begin_of(axis)) * step_range.stride - self.origin_steps;
        let Profile { accel, decel, .. } = &self.profile;
        let nearest = |ramp: &Ramp| (NEAREST_STEPS * step_range.stride - ramp.lead_steps()).max(0.0);
        // How many steps of this plan come before step `k`.
        let before = k.saturating_sub(self.step_numbers(axis).start);
        let steps = match step_range.phase_ends(&PhaseBoundaries::of(&self.profile)) {
            [accel_end, ..] if before < accel_end => steps.max(nearest(accel)),
            [_, cruise_end, _] if before >= cruise_end => steps.min(self.profile.distance_steps() - nearest(decel)),
            _ => steps,
        };
        self.origin_s + self.profile.time_at(steps)
    }

    /// The steps of the axis with index `axis` as segments, in ticks of 1/`tick_hz` s; `tick_hz` is above 0. Most of
    /// the float operations are done in this call. A few follow with each phase, and with each span of a curved ramp.
    #[must_use]
    pub fn segments(&self, axis: usize, tick_hz: u32) -> Segments {
        let mut timed_plan = TimedPlan::empty();
        self.convert_to_ticks(&mut timed_plan, tick_hz);
        let compiler = self.compiler(axis, &timed_plan);
        Segments::new(timed_plan, compiler)
    }

    /// Makes `timed_plan` hold what the axes of this move have in common, in ticks of 1/`tick_hz` s; `tick_hz` is above 0.
    /// Compiling all axes from it is less work than compiling each by its [`segments`](Self::segments).
    pub fn convert_to_ticks(&self, timed_plan: &mut TimedPlan, tick_hz: u32) {
        timed_plan.set(&self.profile, self.is_whole(), self.origin_s, tick_hz);
        if timed_plan.is_curved() {
            let is_whole = timed_plan.is_whole;
            let moving = (0..N).filter(|axis| self.steps[*axis] != 0);
            timed_plan.set_reach(moving.map(|axis| self.step_range(axis, is_whole)));
        }
    }

    /// A compiler of the axis with index `axis`, in the timed plan that [`convert_to_ticks`](Self::convert_to_ticks) has made
    /// from this move.
    #[must_use]
    pub fn compiler(&self, axis: usize, timed_plan: &TimedPlan) -> AxisCompiler {
        let mut compiler = AxisCompiler::empty();
        self.begin_compiler(axis, timed_plan, &mut compiler);
        compiler
    }

    /// As [`compiler`](Self::compiler), but reuses a compiler that is no longer needed: it is large, and this copies less.
    pub fn begin_compiler(&self, axis: usize, timed_plan: &TimedPlan, compiler: &mut AxisCompiler) {
        compiler.begin(self.step_range(axis, timed_plan.is_whole), timed_plan);
    }

    /// Speeding up, cruising and slowing down, at constant acceleration: the ramps of a curved speed profile are no phases.
    // Not inlined, or sums of what may be a blend's numbers are computed before it is known that this is a line.
    #[inline(never)]
    pub(crate) fn phase(&self, axis: usize, index: usize) -> Option<(AxisPhase, f64)> {
        let profile = &self.profile;
        let cruises_s = self.origin_s + profile.t_accel_s();
        let slows_s = || cruises_s + profile.t_cruise_s();
        let accel = |ramp: &Ramp| ramp.constant_accel_steps_s2().unwrap_or(0.0);
        let cruise_steps_s = profile.cruise_speed_steps_s();
        let (begin_s, end_s, place_steps, speed_steps_s, accel_steps_s2) = match index {
            0 => (self.origin_s, cruises_s, 0.0, profile.entry_speed_steps_s(), accel(&profile.accel)),
            1 => (cruises_s, slows_s(), profile.accel_end_steps(), cruise_steps_s, 0.0),
            2 => (slows_s(), self.end_s(), profile.cruise_end_steps(), cruise_steps_s, -accel(&profile.decel)),
            _ => return None,
        };
        if is_zero(end_s - begin_s) {
            return Some((AxisPhase::rest(begin_s, 0.0), end_s));
        }
        if self.steps[axis] == 0 && is_zero(self.axis_steps(axis)) {
            return Some((AxisPhase::rest(begin_s, self.axis_place(axis, 0.0)), end_s));
        }
        let share = self.axis_steps(axis) / self.distance_steps();
        let place_steps = self.axis_place(axis, 0.0) + share * (self.origin_steps + place_steps);
        let speed_steps_s = share * speed_steps_s;
        let accel_steps_s2 = share * accel_steps_s2;
        let phase = AxisPhase { begin_s, place_steps, speed_steps_s, accel_steps_s2 };
        Some((phase, end_s))
    }

    fn step_range(&self, axis: usize, is_whole: bool) -> StepRange {
        let (move_steps, total) = (self.move_steps(), self.steps[axis].unsigned_abs());
        let (longest_steps, own) = (self.longest_steps, move_steps.len(axis).abs());
        // An axis without steps may have any stride.
        let is_alike = own == longest_steps || total == 0;
        let stride = if is_alike { 1.0 } else { longest_steps / own };
        let (begins, ends) = (move_steps.begin_of(axis), move_steps.end_of(axis));
        if is_whole {
            return StepRange { stride, before: 0, steps: total, ahead: begins, beyond: ends };
        }
        let numbers = self.step_numbers(axis);
        let (before, end) = (numbers.start - 1, numbers.end - 1);
        let ahead = self.origin_steps / stride + begins - f64::from(before);
        let beyond = (self.end_steps() - longest_steps) / stride + ends + f64::from(total - end);
        StepRange { stride, before, steps: end - before, ahead, beyond }
    }

    /// True if the profile is that of the whole move, not of a replan.
    fn is_whole(&self) -> bool {
        is_zero(self.origin_steps) && is_zero(self.from_steps) && self.profile.distance_steps() == self.distance_steps()
    }

    /// The numbers of the steps that the axis with index `axis` makes in this plan, counted from 1 at the beginning of
    /// the whole move.
    #[must_use]
    pub fn step_numbers(&self, axis: usize) -> Range<u32> {
        self.steps_before(axis, self.from_steps) + 1..self.steps_before(axis, self.end_steps()) + 1
    }

    /// The number of steps of the axis with index `axis` that are due before the longest axis is at `place_steps` of the whole
    /// move.
    #[must_use]
    pub fn steps_before(&self, axis: usize, place_steps: f64) -> u32 {
        self.move_steps().steps_before(axis, place_steps, self.longest_steps)
    }

    /// The place where the longest axis is at `t_s` from the start of the run, steps from the beginning of the whole move.
    #[must_use]
    pub fn place_at(&self, t_s: f64) -> f64 {
        self.origin_steps + self.profile.position_at(t_s - self.origin_s)
    }

    /// The instant at which the longest axis is at `place_steps` from the beginning of the whole move, s from the start of the
    /// run.
    #[must_use]
    pub fn time_at(&self, place_steps: f64) -> f64 {
        self.origin_s + self.profile.time_at(place_steps - self.origin_steps)
    }

    /// Speed of the longest axis at `t_s` from the start of the run, steps/s; 0 outside the profile.
    #[must_use]
    pub fn speed_at(&self, t_s: f64) -> f64 {
        self.profile.speed_at(t_s - self.origin_s)
    }

    /// Speed and acceleration of the longest axis at `t_s` from the start of the run, steps/s and steps/s².
    pub(crate) fn motion_at(&self, t_s: f64) -> (f64, f64) {
        let (_, speed_steps_s, accel_steps_s2) = self.profile.motion_at(t_s - self.origin_s);
        (speed_steps_s, accel_steps_s2)
    }

    /// The instant at which this plan begins, s from the start of the run.
    #[must_use]
    pub fn begin_s(&self) -> f64 {
        self.time_at(self.from_steps)
    }

    /// The instant at which the profile ends, s from the start of the run.
    #[must_use]
    pub fn end_s(&self) -> f64 {
        self.origin_s + self.profile.duration_s()
    }

    /// The place where this plan begins, steps of the longest axis from the beginning of the whole move.
    #[must_use]
    pub fn begin_steps(&self) -> f64 {
        self.from_steps
    }

    /// The place where this plan ends, steps of the longest axis from the beginning of the whole move.
    #[must_use]
    pub fn end_steps(&self) -> f64 {
        sum(self.origin_steps, self.profile.distance_steps())
    }

    /// The length of the whole move, steps of the longest axis.
    #[must_use]
    pub fn distance_steps(&self) -> f64 {
        self.longest_steps
    }

    /// The place where an axis is when the longest one is at `place_steps`, steps from the whole step next to where the move
    /// begins, signed by direction.
    #[must_use]
    pub fn axis_place(&self, axis: usize, place_steps: f64) -> f64 {
        let move_steps = self.move_steps();
        offset(move_steps.offsets[0][axis]) + move_steps.len(axis) * (place_steps / self.longest_steps)
    }

    /// The distance that an axis goes in the whole move, steps, signed by direction. That is its steps, unless the move begins
    /// or ends beside a whole one.
    #[must_use]
    pub fn axis_steps(&self, axis: usize) -> f64 {
        self.move_steps().len(axis)
    }

    pub(crate) fn move_steps(&self) -> MoveSteps<N> {
        MoveSteps { steps: self.steps, offsets: self.offsets }
    }
}

/// The number of parts of a step in which offsets are given.
pub const OFFSET_PARTS: i32 = 128;

/// An offset in steps.
pub(crate) fn offset(parts: i8) -> f64 {
    of_parts(parts.into())
}

/// Parts of a step in steps.
fn of_parts(parts: i32) -> f64 {
    // A smaller exponent stands for a product, which is slow.
    let bits = f64::from(parts).to_bits();
    if parts == 0 { 0.0 } else { f64::from_bits(bits - (u64::from(OFFSET_PARTS.ilog2()) << 52)) }
}

/// The path of a move: whole steps, and where it begins and ends beside them, in parts of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MoveSteps<const N: usize> {
    /// Signed by direction.
    pub(crate) steps: [i32; N],
    pub(crate) offsets: [[i8; N]; 2],
}

impl<const N: usize> MoveSteps<N> {
    pub(crate) const NONE: Self = Self { steps: [0; N], offsets: [[0; N]; 2] };

    /// The distance that an axis goes, steps, signed by direction.
    pub(crate) fn len(&self, axis: usize) -> f64 {
        let [steps, begin, end] = [self.steps[axis], self.offsets[0][axis].into(), self.offsets[1][axis].into()];
        if begin == end {
            f64::from(steps)
        } else if steps.unsigned_abs() < (1 << 24) - 2 {
            of_parts(steps * OFFSET_PARTS + end - begin)
        } else {
            f64::from(steps) + of_parts(end - begin)
        }
    }

    /// The distance that each axis goes, steps, signed by direction.
    pub(crate) fn lens(&self) -> [f64; N] {
        core::array::from_fn(|axis| self.len(axis))
    }

    /// The axis that goes farthest.
    pub(crate) fn longest_axis(&self) -> usize {
        let [begin, end] = self.offsets;
        let parts = |axis: usize| {
            let steps = i64::from(self.steps[axis]) << OFFSET_PARTS.ilog2();
            steps + i64::from(end[axis]) - i64::from(begin[axis])
        };
        (0..N).max_by_key(|&axis| parts(axis).unsigned_abs()).unwrap_or(0)
    }

    /// The distance of the axis that goes farthest, steps.
    pub(crate) fn longest(&self) -> f64 {
        if self.offsets == [[0; N]; 2] {
            return f64::from(longest(&self.steps));
        }
        let lens = self.lens();
        lens[longest_of(&lens)].abs()
    }

    /// The distance beyond a whole step at which an axis begins, in its direction, steps.
    pub(crate) fn begin_of(&self, axis: usize) -> f64 {
        self.along(axis, 0)
    }

    /// The distance beyond a whole step at which an axis ends, in its direction, steps.
    pub(crate) fn end_of(&self, axis: usize) -> f64 {
        self.along(axis, 1)
    }

    fn along(&self, axis: usize, index: usize) -> f64 {
        match self.offsets[index][axis] {
            0 => 0.0,
            parts if self.steps[axis] < 0 => -offset(parts),
            parts => offset(parts),
        }
    }

    /// The number of steps of an axis that are due before the longest axis is at `place_steps` of its `longest_steps` steps.
    pub(crate) fn steps_before(&self, axis: usize, place_steps: f64, longest_steps: f64) -> u32 {
        if self.steps[axis] == 0 {
            0
        } else {
            self.steps_by(axis, place_steps, longest_steps, || share(self.len(axis), longest_steps))
        }
    }

    /// The same for an axis that makes so many steps for a step of the longest one.
    pub(crate) fn steps_by(
        &self,
        axis: usize,
        place_steps: f64,
        longest_steps: f64,
        share: impl FnOnce() -> f64,
    ) -> u32 {
        let total = self.steps[axis].unsigned_abs();
        if total == 0 || place_steps <= 0.0 {
            0
        } else if place_steps >= longest_steps {
            total
        } else {
            let place = place_steps * share().abs() + self.begin_of(axis);
            ((place + 0.5) as u32).min(total)
        }
    }

    /// The steps of each axis for a step of the longest one, whose length that is; signed by direction.
    pub(crate) fn shares(&self, longest_steps: f64) -> [f64; N] {
        self.lens().map(|len| share(len, longest_steps))
    }
}

/// The steps of an axis of this length for a step of the longest one.
fn share(len: f64, longest_steps: f64) -> f64 {
    if is_zero(len) {
        0.0
    } else if len.to_bits() << 1 == longest_steps.to_bits() << 1 {
        1_f64.copysign(len)
    } else {
        len / longest_steps
    }
}

/// The axis that goes farthest.
pub(crate) fn longest_of<const N: usize>(lens: &[f64; N]) -> usize {
    // As bits, which are in the order of numbers above 0: comparing floats is a call.
    (0..N).max_by_key(|&axis| lens[axis].to_bits() << 1).unwrap_or(0)
}

/// Steps of the longest axis.
pub(crate) fn longest(steps: &[i32]) -> u32 {
    steps.iter().map(|n| n.unsigned_abs()).max().unwrap_or(0)
}

/// The limits of the longest axis at which no axis exceeds its own.
fn shared_limits<const N: usize>(
    steps: &[i32; N],
    limits: &[Limits; N],
    path_speed_steps_s: Option<f64>,
) -> Result<Limits, PlanError> {
    check_moving(steps, |axis| limits[axis].check())?;
    let lens = steps.map(f64::from);
    let mut shared = tightest(longest_of(&lens), |axis| lens[axis], limits, |_, _| false);
    if let Some(asked) = path_speed_steps_s {
        shared.top_speed_steps_s = shared.top_speed_steps_s.min(path_speed(asked)?);
        shared.start_speed_steps_s = shared.start_speed_steps_s.min(shared.top_speed_steps_s);
    }
    Ok(shared)
}

/// Refuses a move without steps, and a moving axis that `check` refuses.
pub(crate) fn check_moving<const N: usize>(
    steps: &[i32; N],
    check: impl Fn(usize) -> Result<(), LimitError>,
) -> Result<(), PlanError> {
    let mut moving = (0..N).filter(|&axis| steps[axis] != 0).peekable();
    moving.peek().ok_or(PlanError::NoSteps)?;
    moving.try_for_each(|axis| check(axis).map_err(|error| PlanError::Limits { axis, error }))
}

/// The tightest limits of the axes that move, as seen from the longest axis; `len` is how far each goes. `is_looser(a, b)` says that no limit of
/// axis `a` is lower than that of axis `b`. If `b` is the longest axis, then `a` cannot tighten the limits.
pub(crate) fn tightest<const N: usize>(
    longest: usize,
    len: impl Fn(usize) -> f64,
    limits: &[Limits; N],
    is_looser: impl Fn(usize, usize) -> bool,
) -> Limits {
    let mut shared = limits[longest];
    for axis in (0..N).filter(|&axis| axis != longest && !is_looser(axis, longest)) {
        let own = len(axis);
        if !is_zero(own) {
            shared = shared.tighter(&limits[axis].scaled(len(longest).abs() / own.abs()));
        }
    }
    shared
}

/// The requested speed along the path, steps/s of the longest axis, if it can be planned. No speed is too fast: it is
/// an upper bound, and the limits apply as well.
pub(crate) fn path_speed(asked: f64) -> Result<f64, PlanError> {
    if asked >= SPEED_MIN_STEPS_S { Ok(asked) } else { Err(PlanError::PathSpeed { asked, min: SPEED_MIN_STEPS_S }) }
}

impl From<ProfileError> for PlanError {
    fn from(error: ProfileError) -> Self {
        Self::Profile(error)
    }
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NoSteps => write!(f, "no axis moves"),
            Self::Limits { axis, error } => write!(f, "axis {axis}: {error}"),
            Self::PathSpeed { asked, min } => write!(f, "path speed {asked} steps/s is below {min} steps/s"),
            Self::Profile(error) => error.fmt(f),
            Self::NoRoom => write!(f, "the chain of moves is full"),
        }
    }
}

impl core::error::Error for PlanError {}
