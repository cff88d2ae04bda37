//! The status report, and Grbl's rule for what it adds now and then.

use core::fmt::{Result, Write};

use crate::{AXES, Fixed, Settings, State};

/// What a status report tells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Status {
    /// What the machine does.
    pub state: State,
    /// Machine position.
    pub position_mm: [f32; AXES],
    /// The speed along the path now.
    pub feed_mm_min: f32,
    /// Limit switches pressed.
    pub limits_pressed: [bool; AXES],
    /// Moves that the queue has room for.
    pub free_blocks: u8,
    /// Bytes that the console has room for.
    pub free_bytes: u16,
}

const REPORT_MACHINE_POSITION: u16 = 1;
const REPORT_BUFFERS: u16 = 2;

/// Writes reports, and counts them: the work offset and the overrides are told now and then, never both at once.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StatusReporter {
    reports_to_offset: u8,
    reports_to_overrides: u8,
}

impl StatusReporter {
    /// As after a reset: the next report tells the work offset, the one after it the overrides.
    pub const fn new() -> Self {
        Self { reports_to_offset: 0, reports_to_overrides: 0 }
    }

    /// `<Idle|MPos:0.000,0.000,0.000|FS:0,0|...>`, at most 128 bytes. Work and machine coordinates are one.
    pub fn write(&mut self, out: &mut impl Write, status: &Status, settings: &Settings) -> Result {
        let inches = settings.report_inches;
        let machine = settings.report_mask & REPORT_MACHINE_POSITION != 0;
        let [x, y, z] = status.position_mm.map(|mm| Fixed::coordinate(mm, inches));
        write!(out, "<{}|{}Pos:{x},{y},{z}", status.state, if machine { 'M' } else { 'W' })?;
        if settings.report_mask & REPORT_BUFFERS != 0 {
            write!(out, "|Bf:{},{}", status.free_blocks, status.free_bytes)?;
        }
        write!(out, "|FS:{},0", Fixed::rate(status.feed_mm_min, inches))?;
        write_pins(out, status.limits_pressed)?;
        self.write_extra(out, status.state, inches)?;
        out.write_str(">\r\n")
    }

    fn write_extra(&mut self, out: &mut impl Write, state: State, inches: bool) -> Result {
        let (offset_period, overrides_period) = if state.at_rest() { (10, 10) } else { (30, 20) };
        if due(&mut self.reports_to_offset, offset_period) {
            self.reports_to_overrides = self.reports_to_overrides.max(1);
            let zero = Fixed::coordinate(0.0, inches);
            write!(out, "|WCO:{zero},{zero},{zero}")?;
        }
        if due(&mut self.reports_to_overrides, overrides_period) {
            out.write_str("|Ov:100,100,100")?;
        }
        Ok(())
    }
}

/// Counts down; true, and counting anew, once per `period`.
fn due(reports_left: &mut u8, period: u8) -> bool {
    let due = *reports_left == 0;
    *reports_left = if due { period - 1 } else { *reports_left - 1 };
    due
}

fn write_pins(out: &mut impl Write, limits_pressed: [bool; AXES]) -> Result {
    if !limits_pressed.contains(&true) {
        return Ok(());
    }
    out.write_str("|Pn:")?;
    limits_pressed
        .iter()
        .zip(["X", "Y", "Z"])
        .filter(|(pressed, _)| **pressed)
        .try_for_each(|(_, axis)| out.write_str(axis))
}
