//! The meaning of each `error:N`, and the remedy.

use core::fmt;

use crate::codes::codes;

codes! {
    /// Why a line was refused, by Grbl's numbers.
    pub enum Error {
        LetterMissing = 1, "A word must begin with a letter: remove the stray character.";
        BadNumber = 2, "A value is missing, malformed or out of range: write a plain decimal.";
        UnknownStatement = 3, "No such $ command or setting: $ and $$ list them.";
        Negative = 4, "The value must not be negative: remove the minus sign.";
        HomingDisabled = 5, "Homing is switched off: set $22=1 first.";
        NotStored = 7, "The flash has refused: the change is in force, but a power cycle will undo it. Give it again.";
        NotIdle = 8, "The command needs a machine at rest: wait until ? says Idle.";
        Locked = 9, "G-code is locked out in Alarm and Jog: home with $H, unlock with $X, or end the jog.";
        SoftLimitsNeedHoming = 10, "Soft limits need homing: set $22=1 first.";
        LineTooLong = 11, "A line holds 79 characters, spaces and comments not counted: split it. Or it was lost, as a message says.";
        RateTooHigh = 12, "The step rate is above what the outputs carry: lower $110-$112, $100-$102 or $0.";
        DoorOpen = 13, "The safety door is open: close it and try again.";
        TravelExceeded = 15, "The jog would leave the travel ($130-$132), so it was not begun: jog less far.";
        BadJog = 16, "A jog is $J= with axis words, F, G20, G21, G90, G91 or G53: remove all else.";
        Unsupported = 20, "The machine has no such code or word: remove it, or do what the message before the refusal says.";
        ModalClash = 21, "Two codes of one modal group share the line: put them on lines of their own.";
        NoFeed = 22, "The move needs a feed above 0: add F.";
        IntegerRequired = 23, "The value must be a whole number: remove the fraction.";
        AxisConflict = 24, "Two codes claim the axis words: put them on lines of their own.";
        RepeatedWord = 25, "A word stands twice on the line: keep one.";
        AxisWordsMissing = 26, "The code needs axis words: add X, Y or Z.";
        BadLineNumber = 27, "Line numbers end at N10000000: renumber, or leave N out.";
        ValueMissing = 28, "A word is missing: G4 needs P, G10 L and P, G43.2 H, canned cycles R and Z, with pecks Q, G82 and G89 P.";
        UnsupportedSystem = 29, "The work coordinates are G54 to G59.3, G10 P1 to P9: choose one of them.";
        AbsoluteNeedsMotion = 30, "G53 works with G0 and G1 only: add one of them.";
        UnusedAxisWords = 31, "G80 has ended an arc or a probe, so nothing uses the axis words: add G0 or G1.";
        PlaneAxesMissing = 32, "An arc needs an axis word of its plane, or its centre alone: G17 wants X or Y, G18 X or Z, G19 Y or Z.";
        InvalidTarget = 33, "No arc or probe leads there, or it is over 10 m from zero: check G20, G21, G90, G91, I, J, K, R.";
        RadiusTooSmall = 34, "The target is farther than twice the radius: raise R.";
        OffsetsMissing = 35, "An arc needs its centre or its radius: G17 wants I or J, G18 I or K, G19 J or K, or R.";
        UnusedWords = 36, "No code on the line uses one of its words: remove it.";
        ToolAxis = 37, "Tools have a length along Z alone: remove the other axes.";
        ToolNumber = 38, "Tools are 1 to 99999, 32 of them in the table, of 1000 mm radius at most: correct it, or free a place by G10 L1 Pn Z0 R0.";
        BadCycle = 39, "No such holes can be made: do what the message before the refusal says.";
        ToolChangePending = 40, "A tool is being changed: end that with ~, or reset (ctrl-x).";
        HomingNeeded = 46, "M6 has to know where Z is up, and G59.3 ($341): home with $H, then send it again.";
        ToolNotMeasured = 47, "The tool was not measured: do what the message before the refusal says.";
    }
}

/// The fault, and the remedy.
impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.words())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_lead_back_to_their_error() {
        for &error in Error::ALL {
            assert_eq!(Error::from_code(error.code()), Some(error));
            assert!(error.words().ends_with('.') && error.words().contains(": "), "{error}");
        }
        assert!(Error::ALL.is_sorted_by_key(|error| error.code()));
        assert_eq!(Error::from_code(0), None);
    }
}
