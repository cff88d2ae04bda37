//! What `error:N` means, and what to do about it.

use core::fmt;

macro_rules! errors {
    ($($name:ident = $code:literal, $explain:literal;)*) => {
        /// Why a line was refused, by Grbl's numbers.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(u8)]
        pub enum Error {
            $(#[doc = $explain] $name = $code,)*
        }

        impl Error {
            /// Every error, by rising number.
            pub const ALL: &[Self] = &[$(Self::$name),*];

            /// What is wrong, and what to do.
            pub const fn explain(self) -> &'static str {
                match self { $(Self::$name => $explain),* }
            }
        }
    };
}

errors! {
    LetterMissing = 1, "A word must begin with a letter and the line be plain ASCII text: remove the stray character.";
    BadNumber = 2, "A value is missing, malformed or out of range: write a plain decimal of at most 8 digits before the point.";
    UnknownStatement = 3, "No such $ command or setting: $ lists the commands, $$ the settings.";
    Negative = 4, "The value must not be negative: give it without the minus sign.";
    HomingDisabled = 5, "Homing is switched off: set $22=1 before $H.";
    NotIdle = 8, "The command needs a machine at rest: wait until ? reports Idle, then send it again.";
    Locked = 9, "G-code is locked out in Alarm: find the cause, then home with $H or unlock with $X.";
    SoftLimitsNeedHoming = 10, "Soft limits need a homed machine: set $22=1 first.";
    LineTooLong = 11, "A line holds at most 79 characters, spaces and comments not counted: split it.";
    RateTooHigh = 12, "The step rate is above what the step outputs carry: lower the rate ($110-$112), the steps/mm ($100-$102) or the pulse ($0).";
    Unsupported = 20, "The machine has no such G-code, M-code or word: remove it, or post-process for a 3-axis gantry without arcs.";
    ModalClash = 21, "Two codes of one modal group share the line: put them on lines of their own.";
    NoFeed = 22, "G1 needs a feed rate of 1 mm/min or more: add an F word.";
    IntegerRequired = 23, "The value must be a whole number: remove the fraction.";
    AxisConflict = 24, "Two codes on the line both claim the axis words: put them on lines of their own.";
    RepeatedWord = 25, "A word stands twice on the line: keep one.";
    BadLineNumber = 27, "Line numbers run from N0 to N9999999: renumber, or leave N out.";
    ValueMissing = 28, "A code lacks the word it needs: G4 needs P, the seconds to wait.";
    UnusedAxisWords = 31, "Axis words after G80 have no motion to use them: add G0 or G1.";
    InvalidTarget = 33, "The target lies more than 10 m from zero: check the units (G20, G21) and the mode (G90, G91).";
    UnusedWords = 36, "No code on the line uses one of its words: remove it.";
    ToolNumber = 38, "Tool numbers run from T0 to T255.";
}

impl Error {
    /// The number after `error:`.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The error that `error:N` names.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.iter().copied().find(|error| error.code() == code)
    }
}

/// The number and its words, for people.
impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "error:{} {}", self.code(), self.explain())
    }
}

impl core::error::Error for Error {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_lead_back_to_their_error() {
        for &error in Error::ALL {
            assert_eq!(Error::from_code(error.code()), Some(error));
            assert!(error.explain().ends_with('.'));
        }
        assert!(Error::ALL.is_sorted_by_key(|error| error.code()));
        assert_eq!(Error::from_code(0), None);
    }
}
