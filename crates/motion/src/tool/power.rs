//! How strongly a tool works.

/// A fraction of the full output of a tool.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Level(u16);

impl Level {
    /// Zero.
    pub const ZERO: Self = Self(0);
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

    /// `percent` of the level; full at most.
    pub(crate) fn times(self, percent: u8) -> Self {
        let level = (u32::from(self.0) * u32::from(percent) + 50) / 100;
        Self(level.min(u16::MAX.into()) as u16)
    }

    /// The level when `passed` of `lasts` have passed, both µs and below 65,536, while it changes linearly to `other`.
    pub(crate) fn towards(self, other: Self, passed: u32, lasts: u32) -> Self {
        if lasts == 0 {
            return other;
        }
        let rise = i32::from(other.0) - i32::from(self.0);
        let done = rise.unsigned_abs() * passed.min(lasts) / lasts;
        Self((i32::from(self.0) + rise.signum() * done as i32) as u16)
    }
}

/// How strongly a laser shines in a move.
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

/// What the chain carries with each move: the program line that it comes from, and its power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tag {
    pub line: u32,
    pub power: Power,
}

const CONSTANT: u32 = 1 << 16;
const BY_SPEED: u32 = 2 << 16;

impl Tag {
    pub fn pack(self) -> u64 {
        let power = match self.power {
            Power::Off => 0,
            Power::Constant(level) => CONSTANT | u32::from(level.0),
            Power::BySpeed(level) => BY_SPEED | u32::from(level.0),
        };
        u64::from(power) << 32 | u64::from(self.line)
    }

    pub fn unpack(tag: u64) -> Self {
        let (power, line) = ((tag >> 32) as u32, tag as u32);
        let level = Level(power as u16);
        let power = match power & !0xFFFF {
            CONSTANT => Power::Constant(level),
            BY_SPEED => Power::BySpeed(level),
            _ => Power::Off,
        };
        Self { line, power }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tag_is_what_it_was_before_it_was_packed() {
        let level = Level(40_000);
        for power in [Power::Off, Power::Constant(level), Power::BySpeed(Level::FULL), Power::Constant(Level::ZERO)] {
            let tag = Tag { line: 10_000_000, power };
            assert_eq!(Tag::unpack(tag.pack()), tag);
        }
    }

    #[test]
    fn levels_go_evenly_and_end_where_they_are_to() {
        let (low, high) = (Level(1_000), Level(3_000));
        assert_eq!(
            [0, 250, 500, 1_000, 2_000].map(|t| low.towards(high, t, 1_000).0),
            [1_000, 1_500, 2_000, 3_000, 3_000]
        );
        assert_eq!([0, 250, 1_000].map(|t| high.towards(low, t, 1_000).0), [3_000, 2_500, 1_000]);
        assert_eq!(Level::ZERO.towards(Level::FULL, 65_534, 65_535).0, 65_534);
        assert_eq!(low.towards(high, 0, 0), high);
    }

    #[test]
    fn ratios_are_to_the_nearest_and_within_the_range() {
        assert_eq!(
            [-1.0, 0.0, 0.5, 1.0, 3.0, f32::NAN].map(|ratio| Level::of_ratio(ratio).0),
            [0, 0, 32_768, 65_535, 65_535, 0]
        );
        assert_eq!([10, 100, 200].map(|percent| Level(40_000).times(percent).0), [4_000, 40_000, 65_535]);
    }
}
