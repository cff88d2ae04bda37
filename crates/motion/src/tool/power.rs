//! The power at which a tool works.

use embassy_time::Duration;

/// A fraction of the full output of a tool.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Level(u16);

impl Level {
    /// Zero.
    pub const ZERO: Self = Self(0);
    /// The lowest above zero.
    pub const LEAST: Self = Self(1);
    /// The full output.
    pub const FULL: Self = Self(u16::MAX);

    /// The level that is nearest to a fraction of the full one; zero below 0, and full above 1.
    #[must_use]
    pub fn of_ratio(ratio: f32) -> Self {
        // The cast saturates.
        Self((ratio * f32::from(u16::MAX) + 0.5) as u16)
    }

    /// The level as a fraction, from 0 to 1.
    #[must_use]
    pub fn ratio(self) -> f32 {
        f32::from(self.0) / f32::from(u16::MAX)
    }

    pub(crate) const fn from_65535ths(level: u16) -> Self {
        Self(level)
    }

    /// The level, of 65,535.
    #[must_use]
    pub const fn of_65535(self) -> u16 {
        self.0
    }
}

/// The request over some time: a level that changes linearly from one to another. It may be above the full one,
/// because a feed override makes the speed higher than the programmed one. Only what is made of it is limited, after the
/// override of the level and at every instant; otherwise what is below the full level would be too dim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Asked {
    /// Both in 65,535ths of the full level, [`Asked::MAX`] at most.
    from: u32,
    to: u32,
}

impl Asked {
    /// Nothing, which is dark.
    pub const NOTHING: Self = Self::even(Level::ZERO);

    /// The highest: the full level at the highest feed override.
    const MAX: u32 = 2 * u16::MAX as u32;

    /// The longest time over which it may change, so that the products below do not overflow. It is a tick less than what
    /// they hold, because both ends are rounded to ticks.
    pub const CHANGE_MAX: Duration = Duration::from_ticks(Duration::from_micros_floor(32_768).as_ticks() - 1);

    /// The same level all the time.
    pub const fn even(level: Level) -> Self {
        Self { from: level.0 as u32, to: level.0 as u32 }
    }

    /// From one multiple of `level` to another.
    pub fn between(level: Level, [from, to]: [f32; 2]) -> Self {
        // The cast saturates.
        let times = |ratio: f32| ((ratio * f32::from(level.0) + 0.5) as u32).min(Self::MAX);
        Self { from: times(from), to: times(to) }
    }

    /// True if it does not change.
    pub fn is_even(self) -> bool {
        self.from == self.to
    }

    /// The part of it from `begin` to `end`, of `lasts`, all µs. If it changes it lasts [`Asked::CHANGE_MAX`] at most.
    pub fn part(self, [begin, end]: [u32; 2], lasts: u32) -> Self {
        let at = |passed: u32| {
            let done = (self.from.abs_diff(self.to) * passed.min(lasts)).checked_div(lasts);
            let done = done.unwrap_or(self.from.abs_diff(self.to));
            if self.to < self.from { self.from - done } else { self.from + done }
        };
        Self { from: at(begin), to: at(end) }
    }

    /// The level that `percent` of it makes: the mean over the time of what is full at most at every instant. So the
    /// light is exact, even if it reaches the full level in the middle.
    pub fn made(self, percent: u8) -> Level {
        const FULL: u32 = u16::MAX as u32;
        // No override makes nothing of what is asked for: a spindle would stand, and start again without a wait.
        let [from, to] = [self.from, self.to].map(|level| ((level * u32::from(percent) + 50) / 100).max(level.min(1)));
        let (low, high) = (from.min(to), from.max(to));
        let mean = match FULL.saturating_sub(low) {
            0 => FULL,
            _ if high <= FULL => (low + high).div_ceil(2),
            // Below the full level is a triangle.
            below => FULL - ((below * ((below << 16) / (high - low))) >> 17),
        };
        Level(mean as u16)
    }
}

/// The power at which a laser shines in a move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Power {
    /// Not at all.
    #[default]
    Off,
    /// At this level (M3).
    Constant(Level),
    /// At this level where the move is as fast as was asked for, and elsewhere in proportion to the speed (M4): every
    /// millimetre gets as much light.
    BySpeed(Level),
}

/// A [`Power`] without its level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PowerMode {
    Off,
    Constant,
    BySpeed,
}

impl Power {
    /// In the same way, at another level.
    pub(crate) fn with_level(self, level: Level) -> Self {
        Self::of(self.parts().0, level)
    }

    pub(crate) fn of(mode: PowerMode, level: Level) -> Self {
        match mode {
            PowerMode::Off => Self::Off,
            PowerMode::Constant => Self::Constant(level),
            PowerMode::BySpeed => Self::BySpeed(level),
        }
    }

    pub(crate) fn parts(self) -> (PowerMode, Level) {
        match self {
            Self::Off => (PowerMode::Off, Level::ZERO),
            Self::Constant(level) => (PowerMode::Constant, level),
            Self::BySpeed(level) => (PowerMode::BySpeed, level),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(from: u32, to: u32) -> Asked {
        Asked { from, to }
    }

    #[test]
    fn what_is_asked_for_goes_evenly_and_ends_where_it_is_to() {
        let (rise, fall) = (asked(1_000, 3_000), asked(3_000, 1_000));
        assert_eq!(rise.part([250, 1_000], 1_000), asked(1_500, 3_000));
        assert_eq!(rise.part([0, 2_000], 1_000), rise, "it ends with the time");
        assert_eq!(fall.part([0, 250], 1_000), asked(3_000, 2_500));
        assert_eq!(rise.part([0, 0], 0), asked(3_000, 3_000));
        let lasts = Asked::CHANGE_MAX.as_micros() as u32;
        assert_eq!(asked(0, Asked::MAX).part([lasts / 2, lasts], lasts), asked(65_532, Asked::MAX));
        let even = Asked::even(Level(700));
        assert_eq!(even.part([0, 10_000_000], 10_000_000), even);
        assert!(even.is_even() && !rise.is_even());
    }

    #[test]
    fn what_is_made_is_limited_at_every_instant_and_not_before() {
        let made = |from, to, percent| asked(from, to).made(percent).0;
        assert_eq!([10, 100, 200].map(|percent| made(40_000, 40_000, percent)), [4_000, 40_000, 65_535]);
        assert_eq!(made(100_000, 100_000, 50), 50_000, "the override comes before the limit");
        assert_eq!([made(0, 0, 10), made(1, 1, 10), made(4, 4, 10)], [0, 1, 1], "it makes nothing only of nothing");
        assert_eq!([made(10_000, 20_000, 100), made(20_000, 10_000, 200)], [15_000, 30_000]);
        assert_eq!(
            [made(0, 131_070, 100), made(131_070, 0, 100)],
            [49_152; 2],
            "half the time half, half the time full"
        );
        assert_eq!(made(65_534, 131_070, 200), 65_535);
        assert_eq!(made(32_767, 131_070, 200), 65_535);
        // Against a sum over many instants.
        for (from, to, percent) in [(0, 131_070, 200), (60_000, 70_000, 100), (65_000, 0, 110), (1, 65_536, 100)] {
            let at = |i: u32| f64::from(from) + (f64::from(to) - f64::from(from)) * (f64::from(i) + 0.5) / 1e4;
            let sum: f64 = (0..10_000).map(|i| (at(i) * f64::from(percent) / 100.0).min(65_535.0)).sum();
            let off = f64::from(made(from, to, percent)) - sum / 1e4;
            assert!(off.abs() <= 2.0, "{from} to {to}, {percent} %: {off}");
        }
    }

    #[test]
    fn ratios_are_to_the_nearest_and_within_the_range() {
        assert_eq!(
            [-1.0, 0.0, 0.5, 1.0, 3.0, f32::NAN].map(|ratio| Level::of_ratio(ratio).0),
            [0, 0, 32_768, 65_535, 65_535, 0]
        );
        let between = |ratios| Asked::between(Level(40_000), ratios);
        assert_eq!(between([0.5, 2.0]), asked(20_000, 80_000));
        assert_eq!(between([-1.0, 1e9]), asked(0, Asked::MAX));
    }
}
