//! From the machine's alarms and positions to the console's.

use isostep_console::{AXIS_NAMES, AlarmCode, SpindleMode, length};
use isostep_motion::{AXES, Alarm, Axis, Config, GangedMotor, Motor, Spindle, SpindleFault, Unplannable};

/// The window that is advertised to senders, bytes; a console has room for more.
pub(crate) const ADVERTISED_BYTES: usize = 128;

/// The names of an axis's second motor, and of its switch.
const SECOND_NAMES: [&str; 4] = ["X2", "Y2", "Z2", "A2"];

/// The console's alarm, and what it is about: the axis, or the reason why a move cannot be planned. So
/// [`AlarmCode::about`] says it to a person, with the remedy.
#[must_use]
pub fn alarm_code(alarm: Alarm) -> (AlarmCode, &'static str) {
    let (code, axis) = match alarm {
        Alarm::HardLimit { motor } => return (AlarmCode::HardLimit, name(motor)),
        Alarm::SoftLimit { axis } => (AlarmCode::SoftLimit, axis),
        Alarm::SwitchStuck { motor } => return (AlarmCode::PullOff, name(motor)),
        Alarm::Skewed { motor } => return (AlarmCode::Skewed, name(motor)),
        Alarm::StallsApart { axis } => (AlarmCode::StallsApart, axis),
        Alarm::SwitchNotFound { axis } => (AlarmCode::SwitchNotFound, axis),
        Alarm::LateStep { axis } => (AlarmCode::LateStep, axis),
        Alarm::Underrun { axis } => (AlarmCode::Underrun, axis),
        Alarm::ResetInMotion => return (AlarmCode::ResetInMotion, ""),
        Alarm::HomingReset => return (AlarmCode::HomingReset, ""),
        Alarm::ProbeInitial => return (AlarmCode::ProbeInitial, ""),
        Alarm::ProbeContact => return (AlarmCode::ProbeContact, ""),
        Alarm::HomingDoor => return (AlarmCode::HomingDoor, ""),
        Alarm::EmergencyStop => return (AlarmCode::EmergencyStop, ""),
        Alarm::ToolCutOff => return (AlarmCode::ToolCutOff, ""),
        Alarm::SpindleFailed { fault: SpindleFault::Speed } => return (AlarmCode::SpindleSpeed, ""),
        Alarm::SpindleFailed { fault: SpindleFault::Drive } => return (AlarmCode::VfdFailed, ""),
        Alarm::DriverFailed { motor } => return (AlarmCode::MotorFault, name(motor)),
        Alarm::Unplannable { reason } => return (AlarmCode::Unplannable, why_not(reason)),
    };
    (code, AXIS_NAMES[axis as usize])
}

pub(crate) fn name(motor: Motor) -> &'static str {
    let axis = motor.axis as usize;
    if motor.ganged == GangedMotor::Second { SECOND_NAMES[axis] } else { AXIS_NAMES[axis] }
}

fn why_not(reason: Unplannable) -> &'static str {
    match reason {
        Unplannable::NoSteps => "the move has no steps - correct its target",
        Unplannable::Limits { axis: Axis::X } => "X has no speed or acceleration - set $110 and $120",
        Unplannable::Limits { axis: Axis::Y } => "Y has no speed or acceleration - set $111 and $121",
        #[cfg(any(not(feature = "two-axes"), feature = "four-axes"))]
        Unplannable::Limits { axis: Axis::Z } => "Z has no speed or acceleration - set $112 and $122",
        #[cfg(feature = "four-axes")]
        Unplannable::Limits { axis: Axis::A } => "A has no speed or acceleration - set $113 and $123",
        Unplannable::Feed => "the feed is below a step in 2,000 s - raise F",
        Unplannable::TooLong => "the move would last longer than 1,000,000 s - raise F, or make it shorter",
        Unplannable::Standstill => "the speed profile ($940) needs a start speed - set $910-$912",
        Unplannable::Ends => "the speeds of the move do not fit its length - check $910-$912",
    }
}

/// A place in steps, in the console's terms.
pub(crate) fn position_pm(steps: [i32; AXES], config: &Config) -> [i64; AXES] {
    Axis::ALL.map(|axis| length::from_mm(config.mm(axis, steps[axis as usize])))
}

/// The state of the spindle, in the console's terms.
pub(crate) fn spindle(spindle: Spindle) -> SpindleMode {
    match spindle {
        Spindle::Off => SpindleMode::Off,
        Spindle::Clockwise => SpindleMode::Clockwise,
        Spindle::CounterClockwise => SpindleMode::CounterClockwise,
    }
}

#[cfg(test)]
mod tests {
    use std::string::ToString;
    use std::vec::Vec;

    use super::*;

    #[test]
    fn every_reason_says_something_of_its_own() {
        let axis = Axis::Y;
        let motor = Motor { axis, ganged: GangedMotor::Second };
        let reasons = [
            Unplannable::NoSteps,
            Unplannable::Limits { axis },
            Unplannable::Feed,
            Unplannable::TooLong,
            Unplannable::Standstill,
            Unplannable::Ends,
        ];
        let alarms = [
            Alarm::HardLimit { motor },
            Alarm::SoftLimit { axis },
            Alarm::ResetInMotion,
            Alarm::HomingReset,
            Alarm::SwitchStuck { motor },
            Alarm::Skewed { motor },
            Alarm::StallsApart { axis: Axis::X },
            Alarm::SwitchNotFound { axis },
            Alarm::EmergencyStop,
            Alarm::LateStep { axis },
            Alarm::Underrun { axis },
            Alarm::ToolCutOff,
            Alarm::SpindleFailed { fault: SpindleFault::Speed },
            Alarm::SpindleFailed { fault: SpindleFault::Drive },
            Alarm::DriverFailed { motor },
            Alarm::ProbeInitial,
            Alarm::ProbeContact,
            Alarm::HomingDoor,
        ];
        let alarms = alarms.into_iter().chain(reasons.map(|reason| Alarm::Unplannable { reason }));
        let words = |alarm| {
            let (code, what) = alarm_code(alarm);
            code.about(what).to_string()
        };
        let mut texts: Vec<_> = alarms.map(words).collect();
        assert!(texts.iter().all(|text| text.len() > 10), "{texts:?}");
        assert!(texts.iter().filter(|text| text.contains('Y')).count() == 9, "those of an axis name it: {texts:?}");
        let all = texts.len();
        texts.sort();
        texts.dedup();
        assert_eq!(texts.len(), all, "two say the same");
    }
}
