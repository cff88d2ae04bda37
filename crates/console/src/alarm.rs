//! What `ALARM:N` means, and what to do about it.

use core::fmt;

macro_rules! alarms {
    ($($name:ident = $code:literal, $explain:literal;)*) => {
        /// Why the machine locked itself, by Grbl's numbers; from 20 on by our own.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(u8)]
        pub enum Alarm {
            $(#[doc = $explain] $name = $code,)*
        }

        impl Alarm {
            /// Every alarm, by rising number.
            pub const ALL: &[Self] = &[$(Self::$name),*];

            /// What happened, and what to do. Reads well behind the name of an axis.
            pub const fn explain(self) -> &'static str {
                match self { $(Self::$name => $explain),* }
            }
        }
    };
}

alarms! {
    HardLimit = 1, "limit switch closed while moving, steps may be lost: clear the axis, $X, then $H";
    SoftLimit = 2, "target outside the travel ($130-$132), nothing moved: correct the program or the travel, then $X";
    ResetInMotion = 3, "reset while moving, steps may be lost: home with $H";
    HomingReset = 6, "reset while homing, position unknown: home again with $H";
    PullOff = 8, "limit switch still closed after pulling off: free a stuck switch, raise $27, check $5";
    SwitchNotFound = 9, "limit switch never closed: check its wiring, the direction ($23) and the travel ($130-$132)";
    EmergencyStop = 10, "emergency stop pressed: release it, then $X and $H";
    LateStep = 20, "step too late: lower the rate ($110-$112), then $H";
    Unplannable = 21, "the settings do not allow this move, nothing moved: check $110-$122, then $X";
    Underrun = 22, "step output ran dry: lower the rate or the acceleration ($110-$122), then $H";
}

impl Alarm {
    /// The number after `ALARM:`.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The alarm that `ALARM:N` names.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.iter().copied().find(|alarm| alarm.code() == code)
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
        for &alarm in Alarm::ALL {
            assert_eq!(Alarm::from_code(alarm.code()), Some(alarm));
            assert!(alarm.explain().contains(": "), "{alarm}");
        }
        assert!(Alarm::ALL.is_sorted_by_key(|alarm| alarm.code()));
        assert_eq!(Alarm::from_code(0), None);
    }
}
