//! Drives that close their own loop: what they alarm for, and the wires that tell it.

use isostep_motion::{AXES, Axis};

use crate::config::Config;

/// A drive is reset that was off by ENABLE for so long, ns.
const RESET_NS: u64 = 300_000_000;

/// The drive of a motor.
#[derive(Clone, Copy, Default)]
struct Drive {
    /// It is in alarm, and its motor is off.
    is_in_alarm: bool,
    /// Something is wrong with it that no reset mends.
    lasts: bool,
}

/// All drives, and their wires to the controller: one for each axis, or X's for all.
pub(super) struct DriveAlarms {
    /// In the order of the motors.
    drives: [Drive; AXES + 1],
    /// The contact of each axis opens in an alarm. On one wire all are as X's.
    opens: [bool; AXES],
    is_cut: [bool; AXES],
    has_one_wire: bool,
    /// Drives notice lost steps.
    closes_loop: bool,
    /// When ENABLE went off last, ns since power-up.
    off_ns: u64,
}

impl DriveAlarms {
    /// The contacts are those of the settings at power-up.
    pub fn new(config: &Config) -> Self {
        Self {
            drives: [Drive::default(); AXES + 1],
            opens: std::array::from_fn(|axis| config.settings.drive_alarm_closed_mask & (1 << axis) == 0),
            is_cut: [false; AXES],
            has_one_wire: config.one_alarm_wire,
            closes_loop: config.closed_loop,
            off_ns: 0,
        }
    }

    pub fn is_in_alarm(&self, motor: usize) -> bool {
        self.drives[motor].is_in_alarm
    }

    /// Something begins to be wrong with a drive, or is mended. Then it stays in alarm until it is reset.
    pub fn set(&mut self, motor: usize, lasts: bool) {
        let drive = &mut self.drives[motor];
        drive.lasts = lasts;
        drive.is_in_alarm |= lasts;
    }

    /// A motor has not followed.
    pub fn lose(&mut self, motor: usize) {
        self.drives[motor].is_in_alarm |= self.closes_loop;
    }

    pub fn cut(&mut self, axis: Axis, is_cut: bool) {
        self.is_cut[axis as usize] = is_cut;
    }

    /// ENABLE of all drives has changed.
    pub fn enable(&mut self, t_ns: u64, on: bool) {
        if !on {
            self.off_ns = t_ns;
        } else if t_ns - self.off_ns >= RESET_NS {
            self.drives.iter_mut().for_each(|drive| drive.is_in_alarm = drive.lasts);
        }
    }

    /// The level of an axis's wire, if this axis has a second motor.
    pub fn is_high(&self, axis: Axis, second: Option<Axis>) -> bool {
        let of_second = self.drives[AXES].is_in_alarm && second == Some(axis);
        let of_axis = self.drives[axis as usize].is_in_alarm || of_second;
        let is_in_alarm = if self.has_one_wire { self.drives.iter().any(|drive| drive.is_in_alarm) } else { of_axis };
        self.is_cut[axis as usize] || is_in_alarm == self.opens[axis as usize]
    }
}
