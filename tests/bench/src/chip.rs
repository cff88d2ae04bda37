//! The chips that are emulated: the board's as it is, and two that show how much the speed of flash matters.

/// The cost of reading flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chip {
    /// A word that is not in the cache is read from flash in the real time.
    AsItIs,
    /// Flash reads like RAM.
    IdealFlash,
    /// A word that is not in the cache takes twice the real time.
    CostlyMiss,
}

impl Chip {
    /// The options for the emulated board.
    pub fn options(self) -> &'static [&'static str] {
        match self {
            Self::AsItIs => &[],
            Self::IdealFlash => &["--ideal-flash"],
            Self::CostlyMiss => &["--miss-factor=2"],
        }
    }

    /// The name for a folder.
    pub fn slug(self) -> &'static str {
        match self {
            Self::AsItIs => "chip",
            Self::IdealFlash => "ideal-flash",
            Self::CostlyMiss => "costly-miss",
        }
    }

    /// The name for the head of a column.
    pub const fn name(self) -> &'static str {
        match self {
            Self::AsItIs => "the chip",
            Self::IdealFlash => "ideal flash",
            Self::CostlyMiss => "miss costs twice",
        }
    }
}
