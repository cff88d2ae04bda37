//! The chips that are emulated: the board's as it is, those that show how much the speed of flash matters, and for an RP2350, of which
//! the core's timing is assumed, those that show how much that matters.

/// The cost of reading flash, and the speed of the core.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chip {
    /// A word that is not in the cache is read from flash in the real time.
    AsItIs,
    /// Flash reads like RAM.
    IdealFlash,
    /// A word that is not in the cache takes twice the real time.
    CostlyMiss,
    /// It takes four times the real time.
    DearMiss,
    /// An instruction takes 1.6 times the assumed cycles.
    SlowCore,
    /// Both of the last two.
    SlowCoreAndDearMiss,
}

impl Chip {
    /// The options for the emulated board.
    pub fn options(self) -> &'static [&'static str] {
        match self {
            Self::AsItIs => &[],
            Self::IdealFlash => &["--ideal-flash"],
            Self::CostlyMiss => &["--miss-factor=2"],
            Self::DearMiss => &["--miss-factor=4"],
            Self::SlowCore => &["--core-factor=1.6"],
            Self::SlowCoreAndDearMiss => &["--core-factor=1.6", "--miss-factor=4"],
        }
    }

    /// The name for a folder.
    pub fn slug(self) -> &'static str {
        match self {
            Self::AsItIs => "chip",
            Self::IdealFlash => "ideal-flash",
            Self::CostlyMiss => "costly-miss",
            Self::DearMiss => "dear-miss",
            Self::SlowCore => "slow-core",
            Self::SlowCoreAndDearMiss => "slow-core-and-dear-miss",
        }
    }

    /// The name for the head of a column.
    pub const fn name(self) -> &'static str {
        match self {
            Self::AsItIs => "the chip",
            Self::IdealFlash => "ideal flash",
            Self::CostlyMiss => "miss costs twice",
            Self::DearMiss => "miss costs 4 times",
            Self::SlowCore => "core 1.6 times slower",
            Self::SlowCoreAndDearMiss => "both of these",
        }
    }
}
