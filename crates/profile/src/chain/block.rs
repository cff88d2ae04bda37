//! A move of a chain, as compact as the passes over the chain want it.

use super::{Terms, Wanted};
use crate::law::IntervalLaw;
use crate::limits::{Limits, SPEED_MIN_STEPS_S};
use crate::profile::{DURATION_MAX_S, Profile, ProfileError};
use crate::ramp::Bounds;
use crate::root::sqrt;
use crate::sync::{PlanError, longest, path_speed, shared_limits};

/// The square of a speed along the path, in whole units, so that sums of them are exact.
pub(super) type Square = u64;

/// No square is above this, so that the sum of two fits.
const SQUARE_MAX: f64 = 4.611_686_018_427_388e18;
/// What a unit is, is chosen so that the square of the fastest path has so many.
const SQUARE_OF_FASTEST: f64 = 1.152_921_504_606_847e18;

/// The most that a feed is overridden by: what may be gained is reckoned for it.
pub const FEED_SHARE_MAX: f64 = 2.0;

/// A move that lasts so much of the longest at most by a trapezoid does not by any law last longer than it.
const EASILY: f64 = 1.0 / 64.0;

/// Directions are the same if the square of half their difference is less: rounding, and no more.
const SAME: f64 = 1e-24;
/// They are opposite if it is nearer to 1: a cosine of -0.999999, as Grbl has it.
const OPPOSITE: f64 = 5e-7;

/// How squares of speeds, (mm/s)², are told in whole units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    per_mm2_s2: f64,
    mm2_s2: f64,
}

impl Scale {
    /// Of no terms.
    pub(super) const NONE: Self = Self { per_mm2_s2: 1.0, mm2_s2: 1.0 };

    /// For axes of these terms.
    pub(super) fn of<const N: usize>(terms: &Terms<N>) -> Self {
        // An axis whose limits do not work moves nothing.
        let working = terms.limits.iter().zip(&terms.mm_per_step).filter(|(limits, _)| limits.check().is_ok());
        let squares = working.map(|(limits, mm)| {
            let mm_s = limits.top_speed_steps_s * mm;
            mm_s * mm_s
        });
        let mm2_s2 = squares.sum::<f64>() / SQUARE_OF_FASTEST;
        Self { per_mm2_s2: 1.0 / mm2_s2, mm2_s2 }
    }

    /// Rounded down.
    pub(super) fn square(self, mm2_s2: f64) -> Square {
        let units = mm2_s2 * self.per_mm2_s2;
        if units < SQUARE_MAX { units as Square } else { SQUARE_MAX as Square }
    }

    pub(super) fn speed_mm_s(self, square: Square) -> f64 {
        sqrt(square as f64 * self.mm2_s2)
    }
}

/// One move.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block<const N: usize> {
    pub(super) wanted: Wanted<N>,
    /// Steps of the longest axis.
    pub(super) way_steps: f64,
    /// Path length of a step of the longest axis.
    pub(super) mm_per_step: f64,
    pub(super) steps_per_mm: f64,
    /// Of the longest axis, so that no axis exceeds its own; the top speed is the machine's, whatever the feed.
    limits: Limits,
    /// Each axis's share of the direction.
    direction: [f64; N],
    /// The squared speed at which the corner before it may be taken; `None` where it stops exactly.
    pub(super) corner: Option<Square>,
    /// How fast it is to be, mm/s, overridden; and its square.
    pub(super) nominal_mm_s: f64,
    pub(super) nominal: Square,
    /// The speed that needs no ramp, squared.
    pub(super) start: Square,
    /// What its squared speed gains or loses at most over the whole of it.
    pub(super) accel_gain: Square,
    pub(super) decel_gain: Square,
    /// The fastest at which it may begin, flowing.
    pub(super) cap: Square,
    /// How fast it begins.
    pub(super) entry: Square,
    /// It begins as fast as the one before it ends. Else it begins from rest.
    pub(super) flows: bool,
}

impl<const N: usize> Block<N> {
    pub(super) fn new(wanted: Wanted<N>, terms: &Terms<N>, scale: Scale) -> Result<Self, PlanError> {
        let limits = shared_limits(&wanted.steps, &terms.limits, None)?;
        let way_steps = f64::from(longest(&wanted.steps));
        let mm: [f64; N] = core::array::from_fn(|axis| f64::from(wanted.steps[axis]) * terms.mm_per_step[axis]);
        let length_mm = length(&mm);
        let per_mm = 1.0 / length_mm;
        let mut block = Self {
            wanted,
            way_steps,
            mm_per_step: length_mm / way_steps,
            steps_per_mm: way_steps * per_mm,
            limits,
            direction: mm.map(|mm| mm * per_mm),
            corner: None,
            nominal_mm_s: 0.0,
            nominal: 0,
            start: 0,
            accel_gain: 0,
            decel_gain: 0,
            cap: 0,
            entry: 0,
            flows: false,
        };
        if let Some(feed_mm_s) = wanted.feed_mm_s {
            path_speed(feed_mm_s * block.steps_per_mm)?;
        }
        block.respeed(terms, scale);
        block.set_gains(way_steps, terms, scale);
        block.check(terms)?;
        Ok(block)
    }

    /// What would keep it from being planned, whatever comes before and after it.
    fn check(&self, terms: &Terms<N>) -> Result<(), PlanError> {
        let limits = self.limits_now();
        let slowest = limits.start_speed_steps_s;
        if terms.speed_law.is_over_displacement() && slowest < SPEED_MIN_STEPS_S.min(limits.top_speed_steps_s) {
            let standstill = ProfileError::Standstill { law: terms.speed_law, asked: slowest, min: SPEED_MIN_STEPS_S };
            return Err(PlanError::Profile(standstill));
        }
        // No more than that, by far the most moves are far from what is too long.
        let Limits { top_speed_steps_s, accel_steps_s2, decel_steps_s2, .. } = limits;
        let ramps_s = top_speed_steps_s / accel_steps_s2 + top_speed_steps_s / decel_steps_s2;
        if self.way_steps / top_speed_steps_s + ramps_s > DURATION_MAX_S * EASILY {
            Profile::plan(self.way_steps, slowest, slowest, &limits, terms.interval_law, terms.speed_law)?;
        }
        Ok(())
    }

    /// Takes on the overrides in force.
    pub(super) fn respeed(&mut self, terms: &Terms<N>, scale: Scale) {
        let top_mm_s = self.limits.top_speed_steps_s * self.mm_per_step;
        let (asked_mm_s, share) = match self.wanted.feed_mm_s {
            Some(feed_mm_s) => (feed_mm_s, terms.feed_share),
            None => (top_mm_s, terms.rapid_share),
        };
        let slowest_mm_s = asked_mm_s.min(SPEED_MIN_STEPS_S * self.mm_per_step);
        self.nominal_mm_s = (asked_mm_s * share).max(slowest_mm_s).min(top_mm_s);
        self.nominal = scale.square(self.nominal_mm_s * self.nominal_mm_s);
        let start_mm_s = self.limits.start_speed_steps_s * self.mm_per_step;
        self.start = scale.square(start_mm_s * start_mm_s).min(self.nominal);
    }

    /// Reckons what its last `steps` (of the longest axis) gain and lose.
    pub(super) fn set_gains(&mut self, steps: f64, terms: &Terms<N>, scale: Scale) {
        let Limits { accel_steps_s2, decel_steps_s2, jerk_steps_s3, top_speed_steps_s, .. } = self.limits;
        let top_steps_s = match self.wanted.feed_mm_s {
            Some(feed_mm_s) => (FEED_SHARE_MAX * feed_mm_s * self.steps_per_mm).min(top_speed_steps_s),
            None => top_speed_steps_s,
        };
        let square = self.mm_per_step * self.mm_per_step;
        let gain = |accel_steps_s2| {
            let bounds = Bounds::new(terms.speed_law, accel_steps_s2, jerk_steps_s3);
            scale.square(bounds.gain(steps, top_steps_s) * square)
        };
        self.accel_gain = gain(accel_steps_s2);
        self.decel_gain = if accel_steps_s2 == decel_steps_s2 { self.accel_gain } else { gain(decel_steps_s2) };
    }

    /// The limits of the longest axis, as fast as it is to be now.
    pub(super) fn limits_now(&self) -> Limits {
        let nominal_steps_s = (self.nominal_mm_s * self.steps_per_mm).max(SPEED_MIN_STEPS_S);
        let top_speed_steps_s = nominal_steps_s.min(self.limits.top_speed_steps_s);
        let start_speed_steps_s = self.limits.start_speed_steps_s.min(top_speed_steps_s);
        Limits { top_speed_steps_s, start_speed_steps_s, ..self.limits }
    }

    /// Makes it follow `before`: how fast the corner between them may be taken.
    pub(super) fn follow(&mut self, before: &Self, terms: &Terms<N>, scale: Scale) {
        let stops = before.wanted.stops || terms.interval_law == IntervalLaw::Thirds;
        self.corner = if stops { None } else { self.corner_after(before, terms, scale) };
        self.set_cap(before.pace());
    }

    /// It begins, or goes on, from rest.
    pub(super) fn stop(&mut self) {
        (self.corner, self.flows) = (None, false);
    }

    /// The one before it has ended by `exit`, and might have stopped from `start`: it begins as fast, or from rest.
    pub(super) fn begin_after(&mut self, exit: Square, start: Square) {
        if self.flows && exit <= self.entry {
            self.entry = exit;
        } else if (self.flows || exit > start)
            && let Some(corner) = self.corner
        {
            // It could not brake to what it should be by now. But for rounding it is no faster than the corner allows, if it
            // was not to stop there at another feed.
            self.flows = exit <= corner + (corner >> 24);
            self.entry = if self.flows { exit } else { self.start };
        }
    }

    /// Its entry is as high as it will ever be.
    pub(super) fn has_final_entry(&self) -> bool {
        if self.flows { self.entry == self.cap } else { self.corner.is_none() && self.entry == self.start }
    }

    /// The highest and the lowest speed that it comes to at its end.
    pub(super) fn reach(&self) -> (Square, Square) {
        (self.entry + self.accel_gain, self.entry.saturating_sub(self.decel_gain))
    }

    /// The fastest at which it may begin if it ends by `exit`, and whether that is as fast as `before` ends.
    pub(super) fn fastest_entry(&self, exit: Square, before: Option<Pace>) -> (Square, bool) {
        let most = exit + self.decel_gain;
        let flowing = self.cap.min(most);
        match (self.corner, before) {
            (Some(_), Some(before)) if flowing >= before.start => (flowing, true),
            _ => (self.start.min(most), false),
        }
    }

    /// What the cap of the block after it depends on.
    pub(super) fn pace(&self) -> Pace {
        Pace { nominal: self.nominal, start: self.start }
    }

    /// Reckons anew how fast it may begin after a block of that pace, flowing.
    pub(super) fn set_cap(&mut self, before: Pace) {
        let fastest = self.corner.unwrap_or(0).min(self.nominal).min(before.nominal);
        // No slower than a stop would leave it.
        self.cap = fastest.max(self.start.min(before.start));
    }

    /// Grbl's rule: the speed at which a circle that strays from the corner by the deviation asks for the acceleration
    /// that the axes have across the corner. `None` if it has to stop there.
    ///
    /// v² = a deviation s/(1 - s), s being the sine of half the angle between the way in, reversed, and the way out. With q
    /// = 1 - s², the square of half the difference of both directions, s/(1 - s) is s (1 + s)/q, which does not cancel; and
    /// a is the least of what an axis may do, by its share of the difference.
    fn corner_after(&self, before: &Self, terms: &Terms<N>, scale: Scale) -> Option<Square> {
        let differences = || self.direction.iter().zip(&before.direction).map(|(own, other)| own - other);
        let square = differences().map(|difference| difference * difference).sum::<f64>() / 4.0;
        if square < SAME {
            return Some(SQUARE_MAX as Square);
        }
        let sine_square = 1.0 - square;
        if sine_square < OPPOSITE || terms.corner_deviation_mm == 0.0 {
            return None;
        }
        let mut across_mm_s2 = f64::MAX;
        for (difference, most_mm_s2) in differences().zip(&terms.corner_accel_mm_s2) {
            // Most corners turn some axes alone.
            if difference != 0.0 && difference.abs() * across_mm_s2 > *most_mm_s2 {
                across_mm_s2 = most_mm_s2 / difference.abs();
            }
        }
        let (sine, half) = (sqrt(sine_square), sqrt(square));
        // half/square, by the product of two roots.
        Some(scale.square(2.0 * across_mm_s2 * terms.corner_deviation_mm * sine * (1.0 + sine) / half))
    }

    /// How fast a square is on it, steps/s of the longest axis.
    pub(super) fn speed_steps_s(&self, square: Square, scale: Scale) -> f64 {
        // As it is wanted, to the last digit.
        let limits = self.limits_now();
        match square {
            _ if square == self.nominal => limits.top_speed_steps_s,
            _ if square == self.start => limits.start_speed_steps_s,
            _ => {
                let speed_steps_s = scale.speed_mm_s(square) * self.steps_per_mm;
                if square < self.nominal { speed_steps_s.min(limits.top_speed_steps_s) } else { speed_steps_s }
            }
        }
    }

    /// Whether all its steps are due before the longest axis is at `place_steps`.
    pub(super) fn has_no_step_after(&self, place_steps: f64) -> bool {
        self.wanted.steps.iter().all(|steps| {
            let steps = steps.unsigned_abs();
            (place_steps / self.way_steps * f64::from(steps) + 0.5) as u32 >= steps
        })
    }
}

/// How fast a block is.
#[derive(Clone, Copy)]
pub(super) struct Pace {
    nominal: Square,
    start: Square,
}

fn length(mm: &[f64]) -> f64 {
    let mut moving = mm.iter().filter(|mm| **mm != 0.0);
    match (moving.next(), moving.next()) {
        (Some(only), None) => only.abs(),
        _ => sqrt(mm.iter().map(|mm| mm * mm).sum()),
    }
}
