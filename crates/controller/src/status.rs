//! The machine's words for the console.

use isostep_console::Alarm as Code;
use isostep_motion::{AXES, Alarm, Axis, Config};

/// The window that senders count on, bytes; a console keeps more.
pub(crate) const ADVERTISED_BYTES: usize = 128;

/// The alarm's number, and the axis it is about.
pub(crate) fn code(alarm: Alarm) -> (Code, Option<Axis>) {
    match alarm {
        Alarm::HardLimit { axis } => (Code::HardLimit, Some(axis)),
        Alarm::SoftLimit { axis } => (Code::SoftLimit, Some(axis)),
        Alarm::ResetInMotion => (Code::ResetInMotion, None),
        Alarm::HomingReset => (Code::HomingReset, None),
        Alarm::SwitchStuck { axis } => (Code::PullOff, Some(axis)),
        Alarm::SwitchNotFound { axis } => (Code::SwitchNotFound, Some(axis)),
        Alarm::EmergencyStop => (Code::EmergencyStop, None),
        Alarm::LateStep { axis } => (Code::LateStep, Some(axis)),
        Alarm::Unplannable => (Code::Unplannable, None),
        Alarm::Underrun { axis } => (Code::Underrun, Some(axis)),
    }
}

pub(crate) fn position_mm(steps: [i32; AXES], config: &Config) -> [f32; AXES] {
    Axis::ALL.map(|axis| config.mm(axis, steps[axis as usize]) as f32)
}
