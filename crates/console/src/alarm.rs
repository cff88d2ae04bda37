//! What `ALARM:N` means, and what to do about it.

use core::fmt;

/// Why the machine locked itself, by Grbl's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Alarm {
    /// A limit switch closed outside homing.
    HardLimit = 1,
    /// A target lies outside the travel.
    SoftLimit = 2,
    /// A reset stopped a move.
    ResetInMotion = 3,
    /// A reset stopped homing.
    HomingReset = 6,
    /// The switch stayed closed after pulling off.
    PullOff = 8,
    /// The switch was not found within the travel searched.
    SwitchNotFound = 9,
    /// The emergency stop was pressed (grblHAL's number).
    EmergencyStop = 10,
    /// A step was too late to be emitted (our own number).
    LateStep = 20,
    /// A move could not be planned (our own number).
    Unplannable = 21,
    /// A step output ran out of steps in the middle of a move (our own number).
    Underrun = 22,
}

impl Alarm {
    /// Every alarm, by rising number.
    pub const ALL: &[Self] = &[
        Self::HardLimit,
        Self::SoftLimit,
        Self::ResetInMotion,
        Self::HomingReset,
        Self::PullOff,
        Self::SwitchNotFound,
        Self::EmergencyStop,
        Self::LateStep,
        Self::Unplannable,
        Self::Underrun,
    ];

    /// The number after `ALARM:`.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The alarm that `ALARM:N` names.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.iter().copied().find(|alarm| alarm.code() == code)
    }

    /// What happened, whether the position is still true, and what to do.
    pub const fn explain(self) -> &'static str {
        match self {
            Self::HardLimit => {
                "A limit switch closed and the axes stopped at once, so steps may be lost: clear the switch ($X unlocks), then home with $H."
            }
            Self::SoftLimit => {
                "The target lies outside the travel ($130-$132) and nothing moved: $X unlocks, the position is true; correct the program or the travel."
            }
            Self::ResetInMotion => {
                "A reset stopped a move in full motion, so steps may be lost: home with $H, or $X if that is accepted."
            }
            Self::HomingReset => "A reset stopped homing, so the position is unknown: home again with $H.",
            Self::PullOff => {
                "The limit switch stayed closed after pulling off: raise $27, or look for a stuck switch or a wrong $5."
            }
            Self::SwitchNotFound => {
                "No limit switch closed within the travel searched: check its wiring, the direction ($23) and the travel ($130-$132)."
            }
            Self::EmergencyStop => {
                "The emergency stop was pressed and the axes stopped at once: release it, unlock with $X and home with $H."
            }
            Self::LateStep => {
                "The processor was held up and a step came too late, so the axes stopped at once: lower the rate, then home with $H."
            }
            Self::Underrun => {
                "The processor was held up and a step output ran dry, so the axes stopped at once: lower the rate or the acceleration, then home with $H."
            }
            Self::Unplannable => {
                "The settings do not allow this move and nothing moved: check rates and accelerations ($110-$122), then $X."
            }
        }
    }
}

/// The number and its words, for people.
impl fmt::Display for Alarm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ALARM:{} {}", self.code(), self.explain())
    }
}

impl core::error::Error for Alarm {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_lead_back_to_their_alarm() {
        assert!(Alarm::ALL.iter().all(|&alarm| Alarm::from_code(alarm.code()) == Some(alarm)));
        assert_eq!(Alarm::from_code(0), None);
    }
}
