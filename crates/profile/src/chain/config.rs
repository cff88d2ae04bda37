//! The configuration of a chain: how its moves are planned, and what is the same for all of them.

use core::cell::Cell;

use super::FEED_RATIO_MAX;
use crate::fixed::is_zero;
use crate::limits::Limits;
use crate::profile::DURATION_MAX_S;
use crate::square_root::sqrt;
use crate::sync::{MoveSteps, PlanError, check_moving, tightest};
use crate::{IntervalSplit, SpeedProfile};

/// The square of a speed along the path, in whole units, so that sums of them are exact.
pub(super) type Square = u64;

/// The largest square. The sum of two of them still fits.
pub(super) const SQUARE_MAX: f64 = 4.611_686_018_427_388e18;
/// The unit is chosen so that the square of the fastest speed along a path has this many units.
const SQUARE_OF_FASTEST: f64 = 1.152_921_504_606_847e18;

/// True if a square is no higher than another, apart from rounding.
pub(super) fn is_as_low(square: Square, than: Square) -> bool {
    square <= than + (than >> 24)
}

/// A ratio of 1, in units of 2^-16.
pub(super) const ONE: u32 = 1 << 16;
/// Accelerations at corners are lower by this ratio, so that no rounding exceeds any.
const SAFE: f64 = 0.999_99;

/// If a move lasts at most this fraction of the longest duration by the trapezoid, it is not too long by any speed profile.
const EASILY: f64 = 1.0 / 64.0;

/// The time that a caller needs for a move, beside making it, s. No move is planned to last less, so that the caller can
/// keep up with any number of them: what it cannot do in time is a lower speed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effort {
    /// For each step of each axis, if the caller makes the steps itself. If another axis has as many steps, they are made
    /// together, which takes a tenth more.
    pub step_s: f64,
    /// For each move.
    pub move_s: f64,
    /// In addition, for a move that no blend leads to. Moves that [lengthen](super::Chain::lengthen) it need none.
    pub straight_s: f64,
    /// In addition, for a move that may begin with a blend.
    pub blend_s: f64,
    /// In addition, for a move that changes its speed by a curved speed profile.
    pub ramps_s: f64,
    /// The same, for the square root of its steps: ramps of four times the steps take twice the time.
    pub root_step_s: f64,
    /// For each move instead, if it is more: this times the square root of the steps of all axes, of [`SHAPED_STEPS_MAX`] at most, for
    /// one whose acceleration changes all the time.
    pub shaped_root_step_s: f64,
}

impl Effort {
    /// No time at all.
    pub const NONE: Self = Self {
        step_s: 0.0,
        move_s: 0.0,
        straight_s: 0.0,
        blend_s: 0.0,
        ramps_s: 0.0,
        root_step_s: 0.0,
        shaped_root_step_s: 0.0,
    };

    /// True if a move needs time even at constant speed.
    pub(super) fn needs_time(&self) -> bool {
        self.move_s > 0.0 || self.step_s > 0.0
    }

    /// The time for a move at constant speed.
    pub(super) fn cruise_s<const N: usize>(&self, steps: &[i32; N]) -> f64 {
        self.move_s + self.steps_s(steps)
    }

    /// The part of it that is for its steps.
    pub(super) fn steps_s<const N: usize>(&self, steps: &[i32; N]) -> f64 {
        if is_zero(self.step_s) && is_zero(self.shaped_root_step_s) {
            return 0.0;
        }
        let [made, root] = made(steps);
        self.step_s * made + (self.shaped_root_step_s * root - self.move_s).max(0.0)
    }

    /// The additional time for a move of `steps` that changes its speed.
    pub(super) fn change_s(&self, steps: f64) -> f64 {
        if is_zero(self.root_step_s) { self.ramps_s } else { self.ramps_s + self.root_step_s * sqrt(steps) }
    }
}

/// More steps than these of all axes of a move make it no dearer where the acceleration changes all the time: the faster an axis is,
/// the more steps its segments hold.
pub const SHAPED_STEPS_MAX: f64 = 160.0;

/// The number of steps that are made by themselves, of which those of another axis with as many count a tenth; and the square root of
/// the number of all.
#[cold]
fn made<const N: usize>(steps: &[i32; N]) -> [f64; 2] {
    let share = |axis: usize| {
        let is_together = steps[..axis].iter().any(|other| other.unsigned_abs() == steps[axis].unsigned_abs());
        if is_together { 0.1 } else { 1.0 }
    };
    let all = || steps.iter().map(|steps| f64::from(steps.unsigned_abs()));
    [all().enumerate().map(|(axis, steps)| share(axis) * steps).sum(), sqrt(all().sum::<f64>().min(SHAPED_STEPS_MAX))]
}

/// The configuration of a chain: how its moves are planned.
#[derive(Clone, Debug)]
pub struct ChainConfig<const N: usize> {
    limits: [Limits; N],
    pub(super) mm_per_step: [f64; N],
    pub(super) interval_split: IntervalSplit,
    pub(super) speed_profile: SpeedProfile,
    pub(super) feed_ratio: f64,
    pub(super) rapid_ratio: f64,
    pub(super) scale: Scale,
    /// True if the limits of each axis work.
    works: [bool; N],
    /// `is_looser[a][b]` says that no limit of axis `a` is lower than that of axis `b`.
    is_looser: [[bool; N]; N],
    /// The inverse of the acceleration that each axis may have across a corner, s²/mm.
    pub(super) corner_s2_mm: [f32; N],
    /// The lowest acceleration of all axes, as a ratio of the lowest of each, in units of 2^-16.
    pub(super) across: [u32; N],
    /// The acceleration and the deceleration of each axis, as ratios of that lowest one, in the same units.
    pub(super) accel_ratios: [[u32; 2]; N],
    /// The square of the speed that the lowest acceleration reaches over 1 mm.
    pub(super) bend_units_mm: f32,
    /// Twice the deviation of the circle from a corner, mm.
    pub(super) twice_deviation_mm: f32,
    /// A move that cruises no longer than this, s, does not last too long.
    pub(super) easily_s: f64,
    pub(super) effort: Effort,
    /// The inverse of the highest acceleration at which a curved ramp from rest, over any number of steps, does not need
    /// longer than it lasts, s²/steps.
    least_s2_steps: f64,
    /// The limits of half the sum and half the difference of the first two axes, if those of the axes do not imply them.
    crossed: Option<[Limits; 2]>,
}

impl<const N: usize> ChainConfig<N> {
    /// A configuration by which nothing can be planned.
    pub(super) const fn none() -> Self {
        Self {
            limits: [Limits::NONE; N],
            mm_per_step: [0.0; N],
            interval_split: IntervalSplit::Fastest,
            speed_profile: SpeedProfile::Trapezoid,
            feed_ratio: 0.0,
            rapid_ratio: 0.0,
            scale: Scale::none(),
            works: [false; N],
            is_looser: [[false; N]; N],
            corner_s2_mm: [0.0; N],
            across: [0; N],
            accel_ratios: [[0; 2]; N],
            bend_units_mm: 0.0,
            twice_deviation_mm: 0.0,
            easily_s: 0.0,
            effort: Effort::NONE,
            least_s2_steps: 0.0,
            crossed: None,
        }
    }

    /// A configuration for axes with these limits and resolutions. `corner_deviation_mm`, 0 or more, sets the speed at
    /// corners: that on a circle which deviates from the corner by this distance.
    #[must_use]
    pub fn new(
        limits: [Limits; N],
        mm_per_step: [f64; N],
        corner_deviation_mm: f64,
        interval_split: IntervalSplit,
        speed_profile: SpeedProfile,
    ) -> Self {
        let works = limits.map(|limits| limits.check().is_ok());
        // An axis whose limits do not work never moves, so it does not count here.
        let working = || (0..N).filter(|&axis| works[axis]);
        let tops_mm_s = working().map(|axis| limits[axis].top_speed_steps_s * mm_per_step[axis]);
        let longest_s = |accel: fn(&Limits) -> f64| {
            let ramps_s = working().map(|axis| limits[axis].top_speed_steps_s / accel(&limits[axis]));
            ramps_s.fold(0.0, f64::max)
        };
        // No ramp of several axes lasts longer than the longest ramp of a single axis, because its top speed is no
        // higher than that of the axis which limits its acceleration.
        let ramps_s = longest_s(|limits| limits.accel_steps_s2) + longest_s(|limits| limits.decel_steps_s2);
        let scale = Scale::of(tops_mm_s.map(|mm_s| mm_s * mm_s).sum());
        let mut config = Self {
            limits,
            mm_per_step,
            interval_split,
            speed_profile,
            feed_ratio: 1.0,
            rapid_ratio: 1.0,
            scale,
            works,
            is_looser: core::array::from_fn(|axis| limits.each_ref().map(|other| limits[axis].is_looser(other))),
            twice_deviation_mm: (2.0 * corner_deviation_mm) as f32,
            easily_s: DURATION_MAX_S * EASILY - ramps_s,
            ..Self::none()
        };
        config.set_corners(&limits);
        config
    }

    /// The same for a machine of crossed belts (CoreXY): its first two axes are motors, with as many steps per millimetre of belt, and
    /// what the machine moves on two axes are half the sum and half the difference of their steps. These limits of the two hold besides
    /// those of the motors, in such steps. At corners the lowest acceleration of all four holds.
    #[must_use]
    #[cold]
    pub fn with_crossed(mut self, crossed: [Limits; 2]) -> Self {
        let mut lowest = self.limits;
        for limits in lowest.iter_mut().take(crossed.len()) {
            *limits = limits.tighter(&crossed[0]).tighter(&crossed[1]);
        }
        self.set_corners(&lowest);
        // Half of a sum is within what both are within.
        let implied =
            self.limits.iter().take(crossed.len()).all(|own| crossed.iter().all(|limits| limits.is_looser(own)));
        self.crossed = (!implied).then_some(crossed);
        self
    }

    /// Sets the accelerations that the axes may have at corners.
    #[cold]
    fn set_corners(&mut self, limits: &[Limits; N]) {
        let Self { works, mm_per_step, .. } = *self;
        let accels_mm_s2 = |axis: usize| {
            let Limits { accel_steps_s2, decel_steps_s2, .. } = limits[axis];
            [accel_steps_s2, decel_steps_s2].map(|accel_steps_s2| accel_steps_s2 * mm_per_step[axis])
        };
        let lowest_mm_s2 = |axis: usize| accels_mm_s2(axis).into_iter().fold(f64::INFINITY, f64::min);
        let working = (0..N).filter(|&axis| works[axis]);
        let slowest_mm_s2 = working.map(lowest_mm_s2).fold(f64::INFINITY, f64::min);
        self.corner_s2_mm = core::array::from_fn(|axis| {
            let Limits { accel_steps_s2, decel_steps_s2, .. } = limits[axis];
            (1.0 / (accel_steps_s2.min(decel_steps_s2) * mm_per_step[axis])) as f32
        });
        self.across = core::array::from_fn(|axis| across(slowest_mm_s2 / lowest_mm_s2(axis)));
        self.accel_ratios = core::array::from_fn(|axis| accels_mm_s2(axis).map(|mm_s2| ratio(mm_s2 / slowest_mm_s2)));
        self.bend_units_mm = (2.0 * SAFE * slowest_mm_s2 * self.scale.per_mm2_s2) as f32;
    }

    /// The same for a caller that needs this time for a move. All of it is 0 or more.
    #[must_use]
    pub fn with_effort(self, effort: Effort) -> Self {
        let is_curved = self.speed_profile != SpeedProfile::Trapezoid;
        let effort = if is_curved { effort } else { Effort { ramps_s: 0.0, root_step_s: 0.0, ..effort } };
        // Two ramps of n/2 steps each last 2 √(n/a), and need √n times the time for the root.
        let root_half_s = effort.root_step_s / 2.0;
        Self { effort, least_s2_steps: root_half_s * root_half_s, ..self }
    }

    /// The top speed of an axis, steps/s.
    pub(super) fn top_steps_s(&self, axis: usize) -> f64 {
        self.limits[axis].top_speed_steps_s
    }

    /// True if an axis may end beside a whole step. Not if it is at its top speed after some steps: there it might stand
    /// still for less than a period after one that it makes just before it turns.
    pub(super) fn may_end_beside(&self, axis: usize) -> bool {
        let Limits { top_speed_steps_s, accel_steps_s2, decel_steps_s2, .. } = self.limits[axis];
        self.works[axis] && 8.0 * accel_steps_s2.max(decel_steps_s2) <= top_speed_steps_s * top_speed_steps_s
    }

    /// True if corners may be blends: not where every move stops, nor between curved ramps, which end at an acceleration
    /// of 0.
    pub(super) fn can_blend(&self) -> bool {
        self.interval_split == IntervalSplit::Fastest && self.speed_profile == SpeedProfile::Trapezoid
    }

    /// Sets the overrides of feeds and of rapids.
    pub(super) fn set_ratios(&mut self, feed_ratio: f64, rapid_ratio: f64) {
        self.feed_ratio = feed_ratio.min(FEED_RATIO_MAX);
        self.rapid_ratio = rapid_ratio.min(1.0);
    }

    /// Refuses a move without steps, or one of an axis whose limits do not work.
    pub(super) fn check_moving(&self, steps: &[i32; N]) -> Result<(), PlanError> {
        check_moving(steps, |axis| if self.works[axis] { Ok(()) } else { self.limits[axis].check() })
    }

    /// The limits of the longest axis of a move at which no axis exceeds its own, and which the caller can bear.
    pub(super) fn shared_limits(&self, move_steps: &MoveSteps<N>) -> Limits {
        let (longest, len) = (move_steps.longest_axis(), |axis| move_steps.len(axis));
        let mut limits = tightest(longest, len, &self.limits, |axis, other| self.is_looser[axis][other]);
        if let Some(crossed) = &self.crossed {
            limits = tighter_by_crossed(limits, crossed, [len(0), len(1)], len(longest));
        }
        if self.least_s2_steps > 0.0 {
            for accel_steps_s2 in [&mut limits.accel_steps_s2, &mut limits.decel_steps_s2] {
                if *accel_steps_s2 * self.least_s2_steps > 1.0 {
                    *accel_steps_s2 = 1.0 / self.least_s2_steps;
                }
            }
        }
        let cruise_s = self.effort.cruise_s(&move_steps.steps);
        if cruise_s > 0.0 {
            let distance_steps = len(longest).abs();
            if limits.top_speed_steps_s * cruise_s > distance_steps {
                limits.top_speed_steps_s = distance_steps / cruise_s;
            }
        }
        limits
    }
}

/// The limits of the longest axis at which half the sum and half the difference of the steps of two motors do not exceed theirs.
#[cold]
fn tighter_by_crossed(limits: Limits, crossed: &[Limits; 2], motors: [f64; 2], longest: f64) -> Limits {
    let sums = [motors[0] + motors[1], motors[0] - motors[1]];
    crossed
        .iter()
        .zip(sums)
        .filter(|(_, sum)| !is_zero(*sum))
        .fold(limits, |limits, (own, sum)| limits.tighter(&own.scaled(2.0 * longest.abs() / sum.abs())))
}

/// A ratio of 1 or less in units of 2^-16, rounded up.
fn across(ratio: f64) -> u32 {
    if ratio < 1.0 { (ratio * f64::from(ONE)) as u32 + 1 } else { ONE }
}

/// A ratio of 1 or more in units of 2^-16, rounded down, the largest number at most.
fn ratio(ratio: f64) -> u32 {
    if ratio > 1.0 { (ratio * f64::from(ONE)) as u32 } else { ONE }
}

/// Converts squared speeds between (mm/s)² and whole units. It keeps the last result in either direction: most moves
/// have the feed of the one before, and begin at the speed at which that ends.
#[derive(Clone, Debug)]
pub(super) struct Scale {
    per_mm2_s2: f64,
    mm2_s2: f64,
    squared: Cell<(f64, Square)>,
    rooted: Cell<(Square, f64)>,
}

impl Scale {
    const fn none() -> Self {
        Self { per_mm2_s2: 0.0, mm2_s2: 0.0, squared: Cell::new((0.0, 0)), rooted: Cell::new((0, 0.0)) }
    }

    /// A scale for paths whose squared speed is at most this.
    fn of(fastest_mm2_s2: f64) -> Self {
        let mm2_s2 = fastest_mm2_s2 / SQUARE_OF_FASTEST;
        Self { per_mm2_s2: 1.0 / mm2_s2, mm2_s2, ..Self::none() }
    }

    /// A squared speed in whole units, rounded down.
    pub(super) fn square(&self, mm2_s2: f64) -> Square {
        let units = mm2_s2 * self.per_mm2_s2;
        if units < SQUARE_MAX { units as Square } else { SQUARE_MAX as Square }
    }

    /// The square of a speed, in whole units.
    pub(super) fn of_speed(&self, mm_s: f64) -> Square {
        let (known_mm_s, known) = self.squared.get();
        if mm_s == known_mm_s {
            return known;
        }
        let square = self.square(mm_s * mm_s);
        self.squared.set((mm_s, square));
        square
    }

    pub(super) fn speed_mm_s(&self, square: Square) -> f64 {
        let (known, known_mm_s) = self.rooted.get();
        if square == known {
            return known_mm_s;
        }
        let mm_s = sqrt(square as f64 * self.mm2_s2);
        self.rooted.set((square, mm_s));
        mm_s
    }
}
