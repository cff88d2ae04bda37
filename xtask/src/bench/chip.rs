//! The chips that are emulated: the RP2040 as it is, and two that say how much its flash matters.

/// What reads of flash cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chip {
    /// What its cache does not hold comes from flash, in the time that takes.
    AsItIs,
    /// Flash reads like RAM.
    IdealFlash,
    /// What its cache does not hold takes twice that time.
    DearMiss,
}

impl Chip {
    /// As the emulated board takes it.
    pub fn options(self) -> &'static [&'static str] {
        match self {
            Self::AsItIs => &[],
            Self::IdealFlash => &["--ideal-flash"],
            Self::DearMiss => &["--miss-factor=2"],
        }
    }

    /// Its name as a folder's.
    pub fn slug(self) -> &'static str {
        match self {
            Self::AsItIs => "chip",
            Self::IdealFlash => "ideal-flash",
            Self::DearMiss => "dear-miss",
        }
    }

    /// Its name as a column's head.
    pub fn name(self) -> &'static str {
        match self {
            Self::AsItIs => "the chip",
            Self::IdealFlash => "ideal flash",
            Self::DearMiss => "miss twice as dear",
        }
    }
}
