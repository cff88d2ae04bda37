//! How the moves of a chain are planned, and what of that is the same for all of them.

use super::FEED_RATIO_MAX;
use crate::law::{IntervalLaw, SpeedLaw};
use crate::limits::Limits;
use crate::profile::DURATION_MAX_S;
use crate::root::sqrt;
use crate::sync::{PlanError, check_moving, tightest};

/// The square of a speed along the path, in whole units, so that sums of them are exact.
pub(super) type Square = u64;

/// No square is above this, so that the sum of two fits.
pub(super) const SQUARE_MAX: f64 = 4.611_686_018_427_388e18;
/// What a unit is, is chosen so that the square of the fastest path has so many.
const SQUARE_OF_FASTEST: f64 = 1.152_921_504_606_847e18;

/// A move that lasts so much of the longest at most by a trapezoid does not by any law last longer than it.
const EASILY: f64 = 1.0 / 64.0;

/// How the moves of a chain are planned.
#[derive(Clone, Copy, Debug)]
pub struct ChainConfig<const N: usize> {
    limits: [Limits; N],
    pub(super) mm_per_step: [f64; N],
    pub(super) interval_law: IntervalLaw,
    pub(super) speed_law: SpeedLaw,
    pub(super) feed_ratio: f64,
    pub(super) rapid_ratio: f64,
    pub(super) scale: Scale,
    /// Whose limits work.
    works: [bool; N],
    /// Of each axis, than which ones it has no limit lower.
    is_looser: [[bool; N]; N],
    /// The inverse of what an axis may do across a corner, s²/mm.
    pub(super) corner_s2_mm: [f32; N],
    /// Twice what a circle may deviate from a corner.
    pub(super) twice_deviation_mm: f32,
    /// Whoever cruises no longer than that does not last too long.
    pub(super) easily_s: f64,
}

impl<const N: usize> ChainConfig<N> {
    /// By which nothing can be planned.
    pub(super) const NONE: Self = Self {
        limits: [Limits::NONE; N],
        mm_per_step: [0.0; N],
        interval_law: IntervalLaw::Fastest,
        speed_law: SpeedLaw::Trapezoid,
        feed_ratio: 0.0,
        rapid_ratio: 0.0,
        scale: Scale::NONE,
        works: [false; N],
        is_looser: [[false; N]; N],
        corner_s2_mm: [0.0; N],
        twice_deviation_mm: 0.0,
        easily_s: 0.0,
    };

    /// For axes of these limits and resolutions. `corner_deviation_mm`, 0 or more, says how fast corners are taken: as
    /// fast as a circle that deviates from the corner by so much.
    #[must_use]
    pub fn new(
        limits: [Limits; N],
        mm_per_step: [f64; N],
        corner_deviation_mm: f64,
        interval_law: IntervalLaw,
        speed_law: SpeedLaw,
    ) -> Self {
        let works = limits.map(|limits| limits.check().is_ok());
        // An axis whose limits do not work moves nothing.
        let working = || (0..N).filter(|&axis| works[axis]);
        let tops_mm_s = working().map(|axis| limits[axis].top_speed_steps_s * mm_per_step[axis]);
        let longest_s = |accel: fn(&Limits) -> f64| {
            let ramps_s = working().map(|axis| limits[axis].top_speed_steps_s / accel(&limits[axis]));
            ramps_s.fold(0.0, f64::max)
        };
        // No ramp of several axes is longer than the longest of one: its top speed is no higher than that of the axis which
        // limits its acceleration.
        let ramps_s = longest_s(|limits| limits.accel_steps_s2) + longest_s(|limits| limits.decel_steps_s2);
        Self {
            limits,
            mm_per_step,
            interval_law,
            speed_law,
            feed_ratio: 1.0,
            rapid_ratio: 1.0,
            scale: Scale::of(tops_mm_s.map(|mm_s| mm_s * mm_s).sum()),
            works,
            is_looser: core::array::from_fn(|axis| limits.each_ref().map(|other| limits[axis].is_looser(other))),
            corner_s2_mm: core::array::from_fn(|axis| {
                let Limits { accel_steps_s2, decel_steps_s2, .. } = limits[axis];
                (1.0 / (accel_steps_s2.min(decel_steps_s2) * mm_per_step[axis])) as f32
            }),
            twice_deviation_mm: (2.0 * corner_deviation_mm) as f32,
            easily_s: DURATION_MAX_S * EASILY - ramps_s,
        }
    }

    /// So large a fraction of feeds, and of rapids.
    pub(super) fn set_ratios(&mut self, feed_ratio: f64, rapid_ratio: f64) {
        self.feed_ratio = feed_ratio.min(FEED_RATIO_MAX);
        self.rapid_ratio = rapid_ratio.min(1.0);
    }

    /// What holds for the longest axis of a move, so that none exceeds its own.
    pub(super) fn shared_limits(&self, steps: &[i32; N]) -> Result<Limits, PlanError> {
        check_moving(steps, |axis| if self.works[axis] { Ok(()) } else { self.limits[axis].check() })?;
        Ok(tightest(steps, &self.limits, |axis, other| self.is_looser[axis][other]))
    }
}

/// How squares of speeds, (mm/s)², are told in whole units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    per_mm2_s2: f64,
    mm2_s2: f64,
}

impl Scale {
    const NONE: Self = Self { per_mm2_s2: 0.0, mm2_s2: 0.0 };

    /// For paths as fast as that.
    fn of(fastest_mm2_s2: f64) -> Self {
        let mm2_s2 = fastest_mm2_s2 / SQUARE_OF_FASTEST;
        Self { per_mm2_s2: 1.0 / mm2_s2, mm2_s2 }
    }

    /// Rounded down.
    pub(super) fn square(self, mm2_s2: f64) -> Square {
        let units = mm2_s2 * self.per_mm2_s2;
        if units < SQUARE_MAX { units as Square } else { SQUARE_MAX as Square }
    }

    /// The square of a speed.
    pub(super) fn of_speed(self, mm_s: f64) -> Square {
        // Most machines start from nothing.
        if mm_s == 0.0 { 0 } else { self.square(mm_s * mm_s) }
    }

    pub(super) fn speed_mm_s(self, square: Square) -> f64 {
        sqrt(square as f64 * self.mm2_s2)
    }
}
