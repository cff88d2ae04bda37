//! The pads' part in the outputs of the state machines: STEP of a ganged motor that is held stays low, and DIR of the second
//! motor may be inverted. So both state machines of an axis do the same, and count the same, in every run.

use embassy_rp::pac::IO_BANK0;
use embassy_rp::pac::io::vals::Outover;
use isostep_motion::{GangedMotor, Motors};

use crate::pins;

/// Sets the pads of `axis` for a run of `motors`, and those of the second motor if the axis has it. STEP is low meanwhile.
pub fn set(axis: usize, motors: &Motors) {
    let held = |ganged| if motors.moves(ganged) { Outover::NORMAL } else { Outover::LOW };
    set_override(pins::step(axis), held(GangedMotor::First));
    if motors.second.is_some() {
        let dir = if motors.is_second_inverted() { Outover::INVERT } else { Outover::NORMAL };
        set_override(pins::step(pins::SECOND), held(GangedMotor::Second));
        set_override(pins::dir(pins::SECOND), dir);
    }
}

fn set_override(pin: usize, outover: Outover) {
    IO_BANK0.gpio(pin).ctrl().modify(|ctrl| ctrl.set_outover(outover));
}
