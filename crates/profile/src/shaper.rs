//! Input shapers: an axis's motion as a weighted sum of itself at several instants, so that its load does not ring.
//!
//! A load on a spring that is given a short push swings on. A second push, half a swing later and a little weaker, ends
//! that. So if a motion x is made as A1 x(t - t1) + A2 x(t - t2) + ..., what each change of acceleration begins is ended
//! by its own copies. The weights add up to 1: so the shaped motion goes where the motion goes, and it exceeds neither
//! the speed nor the acceleration of it, as no average does. It takes longer by the last of the delays.
//!
//! A motion whose acceleration is constant piece by piece stays one, with more pieces: [`Shaped`] makes them. A box, which is
//! the mean over a time, makes the acceleration change evenly.

mod crossed;
mod input;
mod phase_counter;
mod shaped;
mod sum;

use core::f64::consts::{FRAC_1_SQRT_2, PI, SQRT_2};
use core::fmt;
use core::ops::RangeInclusive;

use libm::{exp, sqrt};

pub use self::crossed::{Crossed, NextPart};
pub use self::input::{Combination, ShaperInput};
pub use self::shaped::{Shaped, ShapedPart};

/// The most impulses that a shaper has.
const IMPULSES_MAX: usize = 3;

/// The rest of an undamped vibration at the shaper's own frequency by [`ShaperKind::Ei`], as a fraction of the unshaped one;
/// with damping it is less.
pub const EI_TOLERANCE: f64 = 0.05;

/// The kinds of shapers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShaperKind {
    /// The motion as it is.
    #[default]
    None,
    /// Zero vibration: two impulses, half a period apart (Singer and Seering 1990). The shortest, and the most sensitive to a
    /// wrong frequency.
    Zv,
    /// A modified ZV of three impulses, 3/8 of a period apart, as in Klipper: longer by a half, and less sensitive.
    Mzv,
    /// Zero vibration and derivative: three impulses, half a period apart (Singer and Seering 1990).
    Zvd,
    /// Extra insensitive: as long as ZVD; leaves [`EI_TOLERANCE`] at its own frequency and no more for some way beside it
    /// (Singhose, Seering and Singer 1994).
    Ei,
    /// The mean over one period of the frequency: a box. It limits the jerk, to twice the acceleration over that time, and
    /// cancels an undamped vibration of that frequency and its multiples.
    Box,
}

impl ShaperKind {
    /// All kinds, in the order of their numbers in the settings.
    pub const ALL: [Self; 6] = [Self::None, Self::Zv, Self::Mzv, Self::Zvd, Self::Ei, Self::Box];
}

/// The shaper of an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shaper {
    /// Its kind.
    pub kind: ShaperKind,
    /// The frequency of the load when undamped, Hz: one of [`NATURAL_HZ`].
    pub natural_hz: f64,
    /// Its damping, as a fraction of that which just prevents oscillation: one of [`DAMPING_RATIO`].
    pub damping_ratio: f64,
}

/// Frequencies that a shaper may have, Hz. The longest shaper is as long as a period.
pub const NATURAL_HZ: RangeInclusive<f64> = 10.0..=500.0;
/// Damping ratios that a shaper may have. Machines have some 0.02 to 0.2.
pub const DAMPING_RATIO: RangeInclusive<f64> = 0.0..=0.5;

/// Why a shaper was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ShaperError {
    /// Its frequency is outside [`NATURAL_HZ`].
    Frequency {
        /// The frequency that was asked for, Hz.
        asked_hz: f64,
    },
    /// Its damping ratio is outside [`DAMPING_RATIO`].
    Damping {
        /// The value that was asked for.
        asked: f64,
    },
}

impl fmt::Display for ShaperError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Frequency { asked_hz } => {
                let (least, most) = (NATURAL_HZ.start(), NATURAL_HZ.end());
                write!(f, "shaper of {asked_hz} Hz is outside {least} to {most} Hz")
            }
            Self::Damping { asked } => {
                let (least, most) = (DAMPING_RATIO.start(), DAMPING_RATIO.end());
                write!(f, "shaper's damping ratio {asked} is outside {least} to {most}")
            }
        }
    }
}

impl core::error::Error for ShaperError {}

impl Shaper {
    /// Refuses a shaper whose numbers do not work.
    ///
    /// # Errors
    /// The first number out of range, with the range.
    pub fn check(&self) -> Result<(), ShaperError> {
        if !NATURAL_HZ.contains(&self.natural_hz) {
            return Err(ShaperError::Frequency { asked_hz: self.natural_hz });
        }
        if !DAMPING_RATIO.contains(&self.damping_ratio) {
            return Err(ShaperError::Damping { asked: self.damping_ratio });
        }
        Ok(())
    }

    /// Its impulses, the first of them at once. If it has passed [`check`](Self::check), they are finite.
    #[must_use]
    #[cold]
    pub fn impulses(&self) -> Impulses {
        let own = sqrt(1.0 - self.damping_ratio * self.damping_ratio);
        // The period of the damped load, and how much smaller a swing is after a part of a period.
        let period_s = 1.0 / (self.natural_hz * own);
        let kept = |periods: f64| exp(-2.0 * PI * periods * self.damping_ratio / own);
        let (weights, periods): (&[f64], _) = match self.kind {
            ShaperKind::None => return Impulses::ONE,
            ShaperKind::Box => return Impulses::of_box(1.0 / self.natural_hz),
            ShaperKind::Zv => (&[1.0, 1.0], 0.5),
            ShaperKind::Mzv => (&[1.0 - FRAC_1_SQRT_2, SQRT_2 - 1.0, 1.0 - FRAC_1_SQRT_2], 0.375),
            ShaperKind::Zvd => (&[1.0, 2.0, 1.0], 0.5),
            ShaperKind::Ei => (&[1.0 + EI_TOLERANCE, 2.0 - 2.0 * EI_TOLERANCE, 1.0 + EI_TOLERANCE], 0.5),
        };
        let mut impulses = Impulses { count: weights.len(), ..Impulses::ONE };
        let mut sum = 0.0;
        for (index, weight) in weights.iter().enumerate() {
            let after = index as f64 * periods;
            impulses.weights[index] = weight * kept(after);
            impulses.delays_s[index] = after * period_s;
            sum += impulses.weights[index];
        }
        impulses.weights.iter_mut().for_each(|weight| *weight /= sum);
        impulses
    }
}

/// The weights and the delays of a shaper.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Impulses {
    count: usize,
    /// They add up to 1; those beyond `count` are 0.
    weights: [f64; IMPULSES_MAX],
    /// In ascending order.
    delays_s: [f64; IMPULSES_MAX],
    /// If the motion is the mean from the first delay to the second, how long that is; otherwise 0. Not a flag, of which the other
    /// values would say that there are no impulses: a chip could not have them in memory that is all zeros.
    box_s: f64,
}

impl Impulses {
    /// The motion as it is.
    pub const ONE: Self = Self { count: 1, weights: [1.0, 0.0, 0.0], delays_s: [0.0; IMPULSES_MAX], box_s: 0.0 };

    /// A box of this length.
    const fn of_box(box_s: f64) -> Self {
        Self { count: 2, weights: [0.5, 0.5, 0.0], delays_s: [0.0, box_s, 0.0], box_s }
    }

    /// If it is a box, the delays of its beginning and its end, s: the motion is the mean over all delays between them.
    #[must_use]
    pub fn box_ends_s(&self) -> Option<[f64; 2]> {
        let [begin_s, end_s, _] = self.delays_s;
        (self.box_s > 0.0).then_some([begin_s, end_s])
    }

    /// Each weight with its delay, s. Of a box, its ends.
    pub fn iter(&self) -> impl Iterator<Item = (f64, f64)> + use<> {
        let (weights, delays_s) = (self.weights, self.delays_s);
        (0..self.count).map(move |index| (weights[index], delays_s[index]))
    }

    /// By how much the shaped motion is late at constant speed: the mean of the delays, s.
    #[must_use]
    #[cold]
    pub fn mean_s(&self) -> f64 {
        self.iter().map(|(weight, delay_s)| weight * delay_s).sum()
    }

    /// The time by which the shaped motion takes longer: the last delay, s.
    #[must_use]
    pub fn last_s(&self) -> f64 {
        self.delays_s[self.count - 1]
    }

    /// The same impulses, all of them later.
    #[must_use]
    pub fn later(mut self, by_s: f64) -> Self {
        self.delays_s.iter_mut().for_each(|delay_s| *delay_s += by_s);
        self
    }
}
