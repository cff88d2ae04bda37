//! The status report, and Grbl's rule for what it adds now and then.

use core::fmt::{Result, Write};

use crate::{AXES, Coolant, Fixed, Overrides, ReportedState, Settings, Spindle};

/// What a status report tells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Status {
    /// What the machine does.
    pub state: ReportedState,
    /// Machine position.
    pub position_mm: [f32; AXES],
    /// Work zero in machine coordinates.
    pub work_offset_mm: [f32; AXES],
    /// The line number, N, of the move under way; 0 for none.
    pub line_number: u32,
    /// The speed along the path now.
    pub feed_mm_min: f32,
    /// The S in force, as overridden; 0 with the spindle off.
    pub spindle_rpm: f32,
    /// How the spindle, or the laser, is switched now.
    pub spindle: Spindle,
    /// Which coolant is on now.
    pub coolant: Coolant,
    /// The probe's contact is as after G38.2; reported as P.
    pub probe_touched: bool,
    /// Limit switches pressed.
    pub limits_pressed: [bool; AXES],
    /// The safety door is open; reported as D.
    pub door_open: bool,
    /// The emergency stop is pressed; reported as R, Grbl's letter for its reset input.
    pub emergency_stop: bool,
    /// The feed-hold button is pressed; reported as H.
    pub hold_pressed: bool,
    /// The cycle-start button is pressed; reported as S.
    pub start_pressed: bool,
    /// Moves that the queue has room for.
    pub free_blocks: u8,
    /// Bytes that the console has room for.
    pub free_bytes: u16,
    /// The overrides in force.
    pub overrides: Overrides,
}

const REPORT_MACHINE_POSITION: u16 = 1;
const REPORT_BUFFERS: u16 = 2;

/// Writes reports, and counts them: the work offset, and the overrides with what of spindle and coolant is on, are told
/// now and then, and when they have changed, never both at once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatusReporter {
    reports_to_offset: u8,
    reports_to_overrides: u8,
    /// The work offset, and whether in inches.
    offset_told: ([f32; AXES], bool),
    overrides_told: (Overrides, Spindle, Coolant),
}

impl StatusReporter {
    /// As after a reset: the next report tells the work offset, the one after it the overrides.
    pub const fn new() -> Self {
        Self {
            reports_to_offset: 0,
            reports_to_overrides: 0,
            offset_told: ([0.0; AXES], false),
            overrides_told: (Overrides::DEFAULT, Spindle::Off, Coolant::Off),
        }
    }

    /// `<Idle|MPos:0.000,0.000,0.000|FS:0,0|...>`, at most 145 bytes.
    pub fn write(&mut self, out: &mut impl Write, status: &Status, settings: &Settings) -> Result {
        let inches = settings.report_inches;
        let machine = settings.report_mask & REPORT_MACHINE_POSITION != 0;
        let offset_mm = status.work_offset_mm;
        let work_mm = core::array::from_fn(|axis| status.position_mm[axis] - offset_mm[axis]);
        write!(out, "<{}|{}Pos:", status.state, if machine { 'M' } else { 'W' })?;
        write_coordinates(out, if machine { status.position_mm } else { work_mm }, inches)?;
        if settings.report_mask & REPORT_BUFFERS != 0 {
            write!(out, "|Bf:{},{}", status.free_blocks, status.free_bytes)?;
        }
        if status.line_number > 0 {
            write!(out, "|Ln:{}", status.line_number)?;
        }
        let spindle_rpm = Fixed { value: status.spindle_rpm, decimals: 0 };
        write!(out, "|FS:{},{spindle_rpm}", Fixed::rate(status.feed_mm_min, inches))?;
        write_pins(out, status)?;
        self.write_extra(out, status, inches)?;
        out.write_str(">\r\n")
    }

    fn write_extra(&mut self, out: &mut impl Write, status: &Status, inches: bool) -> Result {
        let (offset_period, overrides_period) = if status.state.at_rest() { (10, 10) } else { (30, 20) };
        let offset = (status.work_offset_mm, inches);
        if self.offset_told != offset {
            (self.reports_to_offset, self.offset_told) = (0, offset);
        }
        let overrides = (status.overrides, status.spindle, status.coolant);
        if self.overrides_told != overrides {
            (self.reports_to_overrides, self.overrides_told) = (0, overrides);
        }
        if due(&mut self.reports_to_offset, offset_period) {
            self.reports_to_overrides = self.reports_to_overrides.max(1);
            out.write_str("|WCO:")?;
            write_coordinates(out, status.work_offset_mm, inches)?;
        }
        if due(&mut self.reports_to_overrides, overrides_period) {
            let Overrides { feed_percent, rapid_percent, spindle_percent } = status.overrides;
            write!(out, "|Ov:{feed_percent},{rapid_percent},{spindle_percent}")?;
            write_accessories(out, status)?;
        }
        Ok(())
    }
}

impl Default for StatusReporter {
    fn default() -> Self {
        Self::new()
    }
}

/// Counts down; true, and counting anew, once per `period`.
fn due(reports_left: &mut u8, period: u8) -> bool {
    let due = *reports_left == 0;
    *reports_left = if due { period - 1 } else { *reports_left - 1 };
    due
}

/// `x,y,z`.
pub(crate) fn write_coordinates(out: &mut impl Write, mm: [f32; AXES], inches: bool) -> Result {
    let [x, y, z] = mm.map(|mm| Fixed::coordinate(mm, inches));
    write!(out, "{x},{y},{z}")
}

fn write_pins(out: &mut impl Write, status: &Status) -> Result {
    let [x, y, z] = status.limits_pressed;
    let pins = [
        (status.probe_touched, "P"),
        (x, "X"),
        (y, "Y"),
        (z, "Z"),
        (status.door_open, "D"),
        (status.emergency_stop, "R"),
        (status.hold_pressed, "H"),
        (status.start_pressed, "S"),
    ];
    write_letters(out, "|Pn:", &pins)
}

/// What of spindle and coolant is on.
fn write_accessories(out: &mut impl Write, status: &Status) -> Result {
    let Status { spindle, coolant, .. } = *status;
    let accessories = [
        (spindle == Spindle::Clockwise, "S"),
        (spindle == Spindle::CounterClockwise, "C"),
        (coolant.flood(), "F"),
        (coolant.mist(), "M"),
    ];
    write_letters(out, "|A:", &accessories)
}

/// The letters of what is on, behind `prefix`; nothing at all if nothing is.
fn write_letters(out: &mut impl Write, mut prefix: &str, letters: &[(bool, &str)]) -> Result {
    for (_, letter) in letters.iter().filter(|(is_on, _)| *is_on) {
        out.write_str(prefix)?;
        out.write_str(letter)?;
        prefix = "";
    }
    Ok(())
}
