//! The meaning of each `ALARM:N`, and the remedy. A `*` in a text stands for the axis or the reason.

use core::fmt;

use crate::codes::codes;

codes! {
    /// Why the machine locked itself. Numbers below 20 are Grbl's or grblHAL's, from 20 on they are our own.
    pub enum AlarmCode {
        HardLimit = 1, "* limit switch closed, steps may be lost: $X, move off it, then $H";
        SoftLimit = 2, "* target outside the travel ($130-$132), nothing moved: correct the program or the travel, then $X";
        ResetInMotion = 3, "reset again while braking, steps may be lost: $X, then $H";
        ProbeInitial = 4, "the probe was not as it had to be before it moved: free it (G38.4: touch first), check $6, then $X";
        ProbeContact = 5, "the probe met nothing on its way: check its wiring, $6 and the target, then $X";
        HomingReset = 6, "reset while homing, position unknown: home again with $H";
        HomingDoor = 7, "the safety door opened while homing, position unknown: close it, home again with $H";
        PullOff = 8, "* limit switch still closed after pulling off: free a stuck switch, raise $27, check $5";
        SwitchNotFound = 9, "* limit switch never closed: check its wiring, the direction ($23) and the travel ($130-$132); by stall ($339) raise $200-$202";
        EmergencyStop = 10, "emergency stop pressed: release it, or mend its wire, then $X and $H";
        SpindleSpeed = 14, "the spindle has not the speed that was asked for: $VFD says which it has, correct S, $340 or $394, then $X";
        Skewed = 15, "* did not reach its switch within $349 of the other motor: free what is jammed, check motor and switch, square it by hand, then $H";
        MotorFault = 17, "the driver of * has failed, stalled or is in alarm: its display or M122 says why, mend it, then $X and $H";
        VfdFailed = 19, "the VFD has failed or does not answer: $VFD says why, mend it, then $X";
        LateStep = 20, "a step of * came too late: lower the rate ($110-$112), then $H";
        Unplannable = 21, "nothing moved: *, then $X";
        Underrun = 22, "the step port of * ran dry: lower the rate or the acceleration ($110-$122), then $H";
        ToolCutOff = 23, "the processor was held up, so the tool was cut off: $X, then $H, and report it";
        StallsApart = 24, "* has stalled at two places: lower $200-$202 ($STALL proposes it), free the axis, then $H";
    }
}

impl AlarmCode {
    /// The event and the remedy, with `what`, the affected axis or the reason, in place of the `*`.
    pub const fn about(self, what: &'static str) -> impl fmt::Display {
        About(self.words(), what)
    }
}

/// The event, and the remedy.
impl fmt::Display for AlarmCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = if *self == Self::Unplannable {
            "the move cannot be planned - a message with the alarm says why"
        } else {
            "axis"
        };
        self.about(what).fmt(f)
    }
}

/// The text of an alarm, and what to put in place of its `*`.
struct About(&'static str, &'static str);

impl fmt::Display for About {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(pattern, what) = self;
        let Some((before, after)) = pattern.split_once('*') else { return f.write_str(pattern) };
        f.write_str(before)?;
        f.write_str(what)?;
        f.write_str(after)
    }
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    #[test]
    fn codes_lead_back_to_their_alarm() {
        for &alarm in AlarmCode::ALL {
            assert_eq!(AlarmCode::from_code(alarm.code()), Some(alarm));
            assert!(alarm.words().contains(": "), "{alarm}");
        }
        assert!(AlarmCode::ALL.is_sorted_by_key(|alarm| alarm.code()));
        assert_eq!(AlarmCode::from_code(0), None);
    }

    #[test]
    fn words_name_the_axis_where_there_is_one() {
        let begins = |words: &str, with| assert!(words.starts_with(with), "{words}");
        begins(&AlarmCode::SwitchNotFound.about("Z").to_string(), "Z limit switch never closed: ");
        begins(&AlarmCode::Underrun.about("Y").to_string(), "the step port of Y ran dry: ");
        begins(&AlarmCode::HardLimit.to_string(), "axis limit switch closed");
        begins(&AlarmCode::Skewed.about("Y2").to_string(), "Y2 did not reach its switch");
        begins(&AlarmCode::EmergencyStop.about("X").to_string(), "emergency stop pressed: ");
    }
}
