//! The status report, and Grbl's rule for the fields that it adds only in some reports.

use core::fmt::{Result, Write};

use crate::report::{FIRMWARE, system_name};
use crate::{AXES, AXIS_NAMES, Coolant, Coordinate, Fixed, Overrides, ReportedState, Settings, SpindleMode};

/// The content of a status report.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatusReport {
    /// The machine's state.
    pub state: ReportedState,
    /// Machine position.
    pub position_pm: [i64; AXES],
    /// Work zero in machine coordinates.
    pub work_offset_pm: [i64; AXES],
    /// The line number, N, of the move under way; 0 for none.
    pub line_number: u32,
    /// The present speed along the path.
    pub feed_mm_min: f32,
    /// The S in force, after the override; 0 if the spindle is off.
    pub spindle_rpm: f32,
    /// The speed at which a spindle that reports it turns; reported behind the S in force, as grblHAL does.
    pub actual_rpm: Option<f32>,
    /// The present state of the spindle, or the laser.
    pub spindle: SpindleMode,
    /// The coolant that is on at present.
    pub coolant: Coolant,
    /// The probe's contact is in the state that ends G38.2; reported as P.
    pub probe_touched: bool,
    /// Limit switches pressed, of either motor of an axis with two motors.
    pub limits_pressed: [bool; AXES],
    /// That of the second motor is; reported as 2, behind the letter of its axis.
    pub second_limit_pressed: bool,
    /// The safety door is open; reported as D.
    pub door_open: bool,
    /// A drive is in alarm; reported as M, as grblHAL's motor fault is.
    pub drive_alarm: bool,
    /// The emergency stop is pressed; reported as R, Grbl's letter for its reset input.
    pub emergency_stop: bool,
    /// The feed-hold button is pressed; reported as H.
    pub hold_pressed: bool,
    /// The cycle-start button is pressed; reported as S.
    pub start_pressed: bool,
    /// Free places in the queue of moves.
    pub free_blocks: u8,
    /// Free bytes in the buffer of the console.
    pub free_bytes: u16,
    /// The overrides in force.
    pub overrides: Overrides,
    /// The axes that have been homed and whose zero is still known.
    pub homed: [bool; AXES],
    /// The tool in the spindle; 0 if nobody knows it.
    pub tool: u32,
    /// The work coordinate system: 0 for G54.
    pub system: u8,
    /// There is a tool with which the lengths of others are compared.
    pub has_tool_reference: bool,
}

const REPORT_MACHINE_POSITION: u16 = 1;
const REPORT_BUFFERS: u16 = 2;

/// Writes reports and counts them. The work offset is added in some reports only, at regular intervals and whenever it
/// has changed. The same applies to the overrides, together with the state of spindle and coolant. No report has both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatusReporter {
    reports_to_offset: u8,
    reports_to_overrides: u8,
    /// The last reported work offset, and whether it was in inches.
    offset_reported: ([i64; AXES], bool),
    overrides_reported: (Overrides, SpindleMode, Coolant),
    seldom_reported: Seldom,
}

/// What is added to a report if it has changed since the last one, as grblHAL does.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Seldom {
    homed: [bool; AXES],
    tool: u32,
    system: u8,
    has_tool_reference: bool,
}

impl StatusReporter {
    /// The state where a host begins to listen: the next report has the work offset, the one after it the overrides.
    pub const fn new() -> Self {
        Self {
            reports_to_offset: 0,
            reports_to_overrides: 0,
            offset_reported: ([0; AXES], false),
            overrides_reported: (Overrides::DEFAULT, SpindleMode::Off, Coolant::Off),
            seldom_reported: Seldom { homed: [false; AXES], tool: 0, system: 0, has_tool_reference: false },
        }
    }

    /// A reset has come: the next report has the work offset, the one after it the overrides. What changes seldom is told again only if
    /// it is another than the host has heard.
    pub fn restart(&mut self) {
        *self = Self { seldom_reported: self.seldom_reported, ..Self::new() };
    }

    /// `<Idle|MPos:0.000,0.000,0.000|FS:0,0|...>`, at most 188 bytes. What has changed of the work coordinate system,
    /// of the homed axes and of the tool is added to the first report behind that.
    pub fn write(&mut self, out: &mut impl Write, status: &StatusReport, settings: &Settings) -> Result {
        write_always(out, status, settings)?;
        self.write_extra(out, status, settings)?;
        let (before, seldom) = (self.seldom_reported, Seldom::of(status));
        if before != seldom {
            self.seldom_reported = seldom;
            seldom.write(Some(&before), out, settings)?;
        }
        out.write_str(">\r\n")
    }

    /// The same with every field, as grblHAL's: work offset, overrides, what is on even if nothing is, what has changed seldom, and the
    /// name of the firmware. At most 220 bytes, 244 with four axes.
    #[cold]
    pub fn write_full(&mut self, out: &mut impl Write, status: &StatusReport, settings: &Settings) -> Result {
        write_always(out, status, settings)?;
        let (offset_period, overrides_period) = periods(status.state);
        (self.reports_to_offset, self.reports_to_overrides) = (offset_period - 1, overrides_period - 1);
        self.offset_reported = (status.work_offset_pm, settings.report_inches);
        self.overrides_reported = (status.overrides, status.spindle, status.coolant);
        write_offset(out, status, settings)?;
        write_overrides(out, status)?;
        out.write_str("|A:")?;
        write_accessories(out, "", status)?;
        self.seldom_reported = Seldom::of(status);
        self.seldom_reported.write(None, out, settings)?;
        write!(out, "|FW:{FIRMWARE}>\r\n")
    }

    fn write_extra(&mut self, out: &mut impl Write, status: &StatusReport, settings: &Settings) -> Result {
        let (offset_period, overrides_period) = periods(status.state);
        let offset = (status.work_offset_pm, settings.report_inches);
        if self.offset_reported != offset {
            (self.reports_to_offset, self.offset_reported) = (0, offset);
        }
        let overrides = (status.overrides, status.spindle, status.coolant);
        if self.overrides_reported != overrides {
            (self.reports_to_overrides, self.overrides_reported) = (0, overrides);
        }
        if due(&mut self.reports_to_offset, offset_period) {
            self.reports_to_overrides = self.reports_to_overrides.max(1);
            write_offset(out, status, settings)?;
        }
        if due(&mut self.reports_to_overrides, overrides_period) {
            write_overrides(out, status)?;
            write_accessories(out, "|A:", status)?;
        }
        Ok(())
    }
}

impl Seldom {
    fn of(status: &StatusReport) -> Self {
        let StatusReport { homed, tool, system, has_tool_reference, .. } = *status;
        Self { homed, tool, system, has_tool_reference }
    }

    /// The fields that are not as they were `before`: the work coordinate system, whether all axes that home are homed and a mask of
    /// those that are, the tool, and whether there is one that others are compared with.
    #[cold]
    fn write(&self, before: Option<&Self>, out: &mut impl Write, settings: &Settings) -> Result {
        if before.is_none_or(|before| before.system != self.system) {
            write!(out, "|WCS:{}", system_name(self.system.into()))?;
        }
        if settings.homing && before.is_none_or(|before| before.homed != self.homed) {
            write_homed(out, self.homed, settings)?;
        }
        if before.is_none_or(|before| before.tool != self.tool) {
            write!(out, "|T:{}", self.tool)?;
        }
        if before.is_none_or(|before| before.has_tool_reference != self.has_tool_reference) {
            write!(out, "|TLR:{}", u8::from(self.has_tool_reference))?;
        }
        Ok(())
    }
}

impl Default for StatusReporter {
    fn default() -> Self {
        Self::new()
    }
}

/// What every report begins with.
fn write_always(out: &mut impl Write, status: &StatusReport, settings: &Settings) -> Result {
    let machine = settings.report_mask & REPORT_MACHINE_POSITION != 0;
    let offset_pm = status.work_offset_pm;
    let work_pm = core::array::from_fn(|axis| status.position_pm[axis] - offset_pm[axis]);
    write!(out, "<{}|{}Pos:", status.state, if machine { 'M' } else { 'W' })?;
    write_coordinates(out, if machine { status.position_pm } else { work_pm }, settings)?;
    if settings.report_mask & REPORT_BUFFERS != 0 {
        write!(out, "|Bf:{},{}", status.free_blocks, status.free_bytes)?;
    }
    if status.line_number > 0 {
        write!(out, "|Ln:{}", status.line_number)?;
    }
    let spindle_rpm = Fixed { value: status.spindle_rpm, decimals: 0 };
    write!(out, "|FS:{},{spindle_rpm}", Fixed::rate(status.feed_mm_min, settings.report_inches))?;
    if let Some(value) = status.actual_rpm {
        write!(out, ",{}", Fixed { value, decimals: 0 })?;
    }
    write_pins(out, status)
}

/// After how many reports the work offset follows again, and the overrides.
fn periods(state: ReportedState) -> (u8, u8) {
    if state.at_rest() { (10, 10) } else { (30, 20) }
}

fn write_offset(out: &mut impl Write, status: &StatusReport, settings: &Settings) -> Result {
    out.write_str("|WCO:")?;
    write_coordinates(out, status.work_offset_pm, settings)
}

fn write_overrides(out: &mut impl Write, status: &StatusReport) -> Result {
    let Overrides { feed_percent, rapid_percent, spindle_percent } = status.overrides;
    write!(out, "|Ov:{feed_percent},{rapid_percent},{spindle_percent}")
}

/// `|H:1,7`: 1 if all axes are homed that home, and a mask of those that are.
fn write_homed(out: &mut impl Write, homed: [bool; AXES], settings: &Settings) -> Result {
    // Loops, because the functions of iterators would run from RAM.
    let (mut all, mut mask) = (true, 0);
    for axis in settings.homing_order().into_iter().flatten() {
        all &= homed[axis];
    }
    for (axis, &is_homed) in homed.iter().enumerate() {
        mask |= u8::from(is_homed) << axis;
    }
    write!(out, "|H:{},{mask}", u8::from(all))
}

/// Counts down. Returns true once per `period` and then starts again.
fn due(reports_left: &mut u8, period: u8) -> bool {
    let due = *reports_left == 0;
    *reports_left = if due { period - 1 } else { *reports_left - 1 };
    due
}

/// `x,y,z`, in the units of the reports; a rotary axis is in degrees. Senders read three, so without Z it is 0.
pub(crate) fn write_coordinates(out: &mut impl Write, pm: [i64; AXES], settings: &Settings) -> Result {
    let of = |axis| Coordinate { pm: pm.get(axis).copied().unwrap_or_default(), inches: settings.reports_inches(axis) };
    let (x, y, z) = (of(0), of(1), of(2));
    write!(out, "{x},{y},{z}")?;
    (0..AXES).skip(3).try_for_each(|axis| write!(out, ",{}", of(axis)))
}

fn write_pins(out: &mut impl Write, status: &StatusReport) -> Result {
    let limits = status.limits_pressed.into_iter().zip(AXIS_NAMES);
    let others = [
        (status.second_limit_pressed, "2"),
        (status.door_open, "D"),
        (status.drive_alarm, "M"),
        (status.emergency_stop, "R"),
        (status.hold_pressed, "H"),
        (status.start_pressed, "S"),
    ];
    write_letters(out, "|Pn:", [(status.probe_touched, "P")].into_iter().chain(limits).chain(others))
}

/// Writes which of spindle and coolant are on, after `prefix`.
fn write_accessories(out: &mut impl Write, prefix: &str, status: &StatusReport) -> Result {
    let StatusReport { spindle, coolant, .. } = *status;
    let accessories = [
        (spindle == SpindleMode::Clockwise, "S"),
        (spindle == SpindleMode::CounterClockwise, "C"),
        (coolant.flood(), "F"),
        (coolant.mist(), "M"),
    ];
    write_letters(out, prefix, accessories)
}

/// Writes the letters of what is on, after `prefix`; writes nothing if nothing is on.
fn write_letters<'a>(
    out: &mut impl Write,
    mut prefix: &str,
    letters: impl IntoIterator<Item = (bool, &'a str)>,
) -> Result {
    for (_, letter) in letters.into_iter().filter(|(is_on, _)| *is_on) {
        out.write_str(prefix)?;
        out.write_str(letter)?;
        prefix = "";
    }
    Ok(())
}
