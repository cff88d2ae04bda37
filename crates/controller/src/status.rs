//! The machine's words for the console.

use isostep_console::Alarm as Code;
use isostep_motion::{AXES, Alarm, Axis, Config};

/// The window that senders count on, bytes; a console keeps more.
pub(crate) const ADVERTISED_BYTES: usize = 128;

/// The alarm by its number, and the name of the axis it is about, if it is about one.
pub(crate) fn code(alarm: Alarm) -> (Code, &'static str) {
    let (code, axis) = match alarm {
        Alarm::HardLimit { axis } => (Code::HardLimit, axis),
        Alarm::SoftLimit { axis } => (Code::SoftLimit, axis),
        Alarm::SwitchStuck { axis } => (Code::PullOff, axis),
        Alarm::SwitchNotFound { axis } => (Code::SwitchNotFound, axis),
        Alarm::LateStep { axis } => (Code::LateStep, axis),
        Alarm::Underrun { axis } => (Code::Underrun, axis),
        Alarm::ResetInMotion => return (Code::ResetInMotion, ""),
        Alarm::HomingReset => return (Code::HomingReset, ""),
        Alarm::EmergencyStop => return (Code::EmergencyStop, ""),
        Alarm::Unplannable => return (Code::Unplannable, ""),
    };
    (code, ["X", "Y", "Z"][axis as usize])
}

pub(crate) fn position_mm(steps: [i32; AXES], config: &Config) -> [f32; AXES] {
    Axis::ALL.map(|axis| config.mm(axis, steps[axis as usize]) as f32)
}
