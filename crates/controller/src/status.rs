//! The machine's words for the console.

use isostep_console::{Alarm as Code, State as Word, Status as Report};
use isostep_motion::{AXES, Alarm, Axis, Config, State, Status};

/// The window that senders count on, bytes; a console keeps more.
pub(crate) const ADVERTISED_BYTES: usize = 128;

pub(crate) fn word(state: State) -> Word {
    match state {
        State::Idle => Word::Idle,
        State::Run => Word::Run,
        State::Home => Word::Home,
        State::Alarm(_) => Word::Alarm,
    }
}

pub(crate) fn code(alarm: Alarm) -> Code {
    match alarm {
        Alarm::HardLimit { .. } => Code::HardLimit,
        Alarm::SoftLimit { .. } => Code::SoftLimit,
        Alarm::ResetInMotion => Code::ResetInMotion,
        Alarm::HomingReset => Code::HomingReset,
        Alarm::SwitchStuck { .. } => Code::PullOff,
        Alarm::SwitchNotFound { .. } => Code::SwitchNotFound,
        Alarm::EmergencyStop => Code::EmergencyStop,
        Alarm::LateStep { .. } => Code::LateStep,
        Alarm::Unplannable => Code::Unplannable,
        Alarm::Underrun { .. } => Code::Underrun,
    }
}

pub(crate) fn report(status: &Status, config: &Config, free_bytes: usize) -> Report {
    Report {
        state: word(status.state),
        position_mm: position_mm(status.position_steps, config),
        feed_mm_min: (status.speed_mm_s * 60.0) as f32,
        limits_pressed: status.pressed,
        free_blocks: status.queue_free as u8,
        free_bytes: free_bytes.min(ADVERTISED_BYTES) as u16,
    }
}

pub(crate) fn position_mm(steps: [i32; AXES], config: &Config) -> [f32; AXES] {
    Axis::ALL.map(|axis| config.mm(axis, steps[axis as usize]) as f32)
}
