//! The table that drives `$$`, `$n=v`, `$ES` and the documentation of the settings.

use core::fmt;

use crate::axes::{A, ALL_AXES};
use crate::settings::TRAVEL_LEAST_MM;
use crate::{AXES, Fixed, SettingError, Settings};

pub(crate) const HOMING: u16 = 22;
#[cfg(feature = "trinamic")]
pub(crate) const MICROSTEPS: u16 = 150;

/// A row: one setting, or one for each axis.
#[derive(Debug, Clone, Copy)]
pub struct Setting {
    /// The number after `$`; for a setting with one value for each axis, that of X.
    pub number: u16,
    /// The unit, empty for flags and masks.
    pub unit: &'static str,
    /// The least value.
    pub min: f32,
    /// The greatest value.
    pub max: f32,
    field: Field,
}

#[derive(Debug, Clone, Copy)]
enum Field {
    Flag(fn(&mut Settings) -> &mut bool),
    Int(fn(&mut Settings) -> &mut u16),
    Float(fn(&mut Settings) -> &mut f32),
    PerAxis(fn(&mut Settings) -> &mut [f32; AXES]),
    IntPerAxis(fn(&mut Settings) -> &mut [u16; AXES]),
}

use Field::{Flag, Float, Int, IntPerAxis, PerAxis};

/// The field of a row. Its function has a name, by which the firmware's linker keeps it in flash; a closure would have none.
macro_rules! field {
    (Flag $name:ident) => { field!(@Flag, bool, $name) };
    (Int $name:ident) => { field!(@Int, u16, $name) };
    (Float $name:ident) => { field!(@Float, f32, $name) };
    (Int $name:ident [$index:literal]) => { field!(@Int, u16, $name [$index]) };
    (Float $name:ident [$index:literal]) => { field!(@Float, f32, $name [$index]) };
    (PerAxis $name:ident) => { field!(@PerAxis, [f32; AXES], $name) };
    (IntPerAxis $name:ident) => { field!(@IntPerAxis, [u16; AXES], $name) };
    (@$kind:ident, $type:ty, $name:ident $([$index:literal])?) => {{
        fn of(settings: &mut Settings) -> &mut $type {
            &mut settings.$name $([$index])?
        }
        $kind(of)
    }};
}

/// A setting and its meaning.
const fn row(
    number: u16,
    unit: &'static str,
    meaning: &'static str,
    min: f32,
    max: f32,
    field: Field,
) -> (Setting, &'static str) {
    (Setting { number, unit, min, max, field }, meaning)
}

/// A condition on the number of axes. Only a rotary axis may have no travel: see [`Settings::is_endless`].
const HAS_A: bool = AXES > A;
const TRAVEL: &str = if HAS_A { "travel; 0 for a rotary axis without an end" } else { "travel" };
const TRAVEL_MIN_MM: f32 = if HAS_A { 0.0 } else { TRAVEL_LEAST_MM };
const HOMING_ORDER: &str = match AXES {
    2 => "homing order, axis digits: 1 X, 2 Y",
    3 => "homing order, axis digits: 1 X, 2 Y, 3 Z",
    _ => "homing order, axis digits: 1 X, 2 Y, 3 Z, 4 A, which may be left out",
};
const HOMING_ORDERS: (f32, f32) = match AXES {
    2 => (12.0, 21.0),
    3 => (123.0, 321.0),
    _ => (123.0, 4321.0),
};
const SECOND_MOTOR: &str = match AXES {
    2 => "axis with a second motor: 0 none, 1 X, 2 Y",
    3 => "axis with a second motor: 0 none, 1 X, 2 Y, 3 Z",
    _ => "axis with a second motor: 0 none, 1 X, 2 Y, 3 Z, 4 A",
};

#[rustfmt::skip]
const ROWS: &[(Setting, &str)] = &[
    row(0, "us", "step pulse; 0 as short as the driver takes", 0.0, 20.0, field!(Int pulse_us)),
    row(1, "ms", "motors stay energised after a move; 255 for ever", 0.0, 255.0, field!(Int idle_delay_ms)),
    row(2, "", "step invert; 0 alone: STEP is active high", 0.0, 0.0, field!(Int step_invert_mask)),
    row(3, "", "direction invert, mask", 0.0, ALL_AXES as f32, field!(Int direction_invert_mask)),
    row(4, "", "enable is active high", 0.0, 1.0, field!(Flag enable_invert)),
    row(5, "", "limit switches open when pressed", 0.0, 1.0, field!(Flag limit_invert)),
    row(6, "", "probe input, mask: 1 contact is high, 2 no pull-up", 0.0, 3.0, field!(Int probe_mask)),
    row(8, "", "direction of the second motor other than the first's, mask", 0.0, ALL_AXES as f32, field!(Int second_invert_mask)),
    row(10, "", "status report, mask: 1 machine position, 2 buffers", 0.0, 3.0, field!(Int report_mask)),
    row(11, "mm", "junction deviation; 0 stops at every corner", 0.0, 100.0, field!(Float junction_deviation_mm)),
    row(12, "mm", "arc tolerance, a quarter of a step at most", 0.001, 100.0, field!(Float arc_tolerance_mm)),
    row(13, "", "report in inches", 0.0, 1.0, field!(Flag report_inches)),
    row(20, "", "soft limits, once homed", 0.0, 1.0, field!(Flag soft_limits)),
    row(21, "", "hard limits", 0.0, 1.0, field!(Flag hard_limits)),
    row(HOMING, "", "homing", 0.0, 1.0, field!(Flag homing)),
    row(23, "", "home towards negative, mask", 0.0, ALL_AXES as f32, field!(Int homing_direction_mask)),
    row(24, "mm/min", "homing latch", 1.0, 1e5, field!(Float homing_latch_mm_min)),
    row(25, "mm/min", "homing seek", 1.0, 1e5, field!(Float homing_seek_mm_min)),
    row(26, "ms", "homing debounce", 0.0, 1000.0, field!(Int homing_debounce_ms)),
    row(27, "mm", "homing pull-off", 0.1, 100.0, field!(Float homing_pull_off_mm)),
    row(28, "mm", "peck clearance of G73 and G83", 0.0, 100.0, field!(Float peck_clearance_mm)),
    row(30, "rpm", "S at full duty", 0.0, 1e5, field!(Float spindle_max_rpm)),
    row(31, "rpm", "S at least duty", 0.0, 1e5, field!(Float spindle_min_rpm)),
    row(32, "", "laser mode", 0.0, 1.0, field!(Flag laser_mode)),
    row(33, "Hz", "PWM frequency of spindle or laser", 10.0, 1e5, field!(Float spindle_pwm_hz)),
    row(35, "%", "PWM duty at $31", 0.0, 100.0, field!(Float pwm_least_percent)),
    row(36, "%", "PWM duty at $30", 0.0, 100.0, field!(Float pwm_full_percent)),
    // Before the steps, which follow them: so a listing that is sent back ends with the steps that it says.
    #[cfg(feature = "trinamic")]
    row(MICROSTEPS, "", "microsteps, a power of 2; $100-$102 follow", 1.0, 256.0, field!(IntPerAxis microsteps)),
    row(100, "steps/mm", "steps per millimetre", 0.1, 1e4, field!(PerAxis steps_per_mm)),
    row(110, "mm/min", "top speed", 1.0, 9e7, field!(PerAxis max_rate_mm_min)),
    row(120, "mm/s2", "acceleration", 0.1, 1e5, field!(PerAxis accel_mm_s2)),
    row(130, "mm", TRAVEL, TRAVEL_MIN_MM, 1e4, field!(PerAxis travel_mm)),
    #[cfg(feature = "trinamic")]
    row(140, "mA", "motor current, effective", 50.0, 1700.0, field!(IntPerAxis run_current_ma)),
    row(170, "mm", "how much farther the second motor is from its switch; below 0 the first", -5.0, 5.0, field!(PerAxis square_offset_mm)),
    #[cfg(feature = "trinamic")]
    row(200, "", "stall threshold, half of the SG_RESULT of a stall; $STALL=X finds it", 0.0, 255.0, field!(IntPerAxis stall_threshold)),
    #[cfg(feature = "trinamic")]
    row(210, "%", "motor current at standstill, of that at speed", 5.0, 100.0, field!(IntPerAxis hold_percent)),
    #[cfg(feature = "trinamic")]
    row(338, "", "axes whose drivers are set and watched, mask", 0.0, ALL_AXES as f32, field!(Int trinamic_mask)),
    #[cfg(feature = "trinamic")]
    row(339, "", "axes that home by a stall of their motor, not by a switch, mask", 0.0, ALL_AXES as f32, field!(Int stall_homing_mask)),
    row(340, "%", "how far from its speed a VFD's spindle may turn", 1.0, 50.0, field!(Float at_speed_percent)),
    row(341, "", "M6: 0 waits, 1 Z up and measure by $TPW, 2 the same at G59.3, 3 measures at G59.3 by itself, 4 does not wait", 0.0, 4.0, field!(Int tool_change_mode)),
    row(342, "mm", "way down to measure a tool", 0.1, 1000.0, field!(Float tool_probe_mm)),
    row(343, "mm/min", "tool latch", 1.0, 1e5, field!(Float tool_latch_mm_min)),
    row(344, "mm/min", "tool seek", 1.0, 1e5, field!(Float tool_seek_mm_min)),
    row(349, "mm", "how far one of two motors may go alone to its switch", 0.1, 100.0, field!(Float skew_max_mm)),
    row(374, "", "baud rate of Modbus; 2 is 9600, 3 19200, 4 38400, 5 115200", 2.0, 5.0, field!(Int modbus_baud_index)),
    row(375, "ms", "longest time to the reply of a VFD", 10.0, 60.0, field!(Int modbus_timeout_ms)),
    #[cfg(feature = "four-axes")]
    row(376, "", "rotary axes, mask: 1 A", 0.0, 1.0, field!(Int rotary_mask)),
    row(394, "s", "time for the spindle to reach its speed; of a VFD the longest, 0 for 10 s", 0.0, 60.0, field!(Float spin_up_s)),
    row(395, "", "spindle by: 0 PWM, 1 Huanyang, 2 GS20, 3 YL620, 4 a VFD by $462-$471, 5 H-100, 6 Nowforever", 0.0, 6.0, field!(Int spindle_type)),
    row(461, "rpm/Hz", "speed by a hertz of the VFD's output", 1.0, 3000.0, field!(Int vfd_rpm_per_hz)),
    row(462, "", "VFD's register to run and stop", 0.0, 65535.0, field!(Int vfd_registers[0])),
    row(463, "", "VFD's register of the frequency to set", 0.0, 65535.0, field!(Int vfd_registers[1])),
    row(464, "", "VFD's register of the output frequency", 0.0, 65535.0, field!(Int vfd_registers[2])),
    row(465, "", "VFD's word to run clockwise", 0.0, 65535.0, field!(Int vfd_words[0])),
    row(466, "", "VFD's word to run counter-clockwise", 0.0, 65535.0, field!(Int vfd_words[1])),
    row(467, "", "VFD's word to stop", 0.0, 65535.0, field!(Int vfd_words[2])),
    row(468, "", "multiplier of S for the frequency to set", 0.001, 1e5, field!(Float vfd_set_ratio[0])),
    row(469, "", "divisor of S for the frequency to set", 1.0, 1e5, field!(Float vfd_set_ratio[1])),
    row(470, "", "multiplier of the output frequency for the speed", 0.001, 1e5, field!(Float vfd_read_ratio[0])),
    row(471, "", "divisor of the output frequency for the speed", 1.0, 1e5, field!(Float vfd_read_ratio[1])),
    row(476, "", "Modbus address of the VFD", 1.0, 247.0, field!(Int vfd_address)),
    row(681, "", "parity of Modbus: 0 none, 1 even, 2 odd", 0.0, 2.0, field!(Int modbus_parity)),
    #[cfg(feature = "four-axes")]
    row(701, "", "F with a rotary axis, mask: 1 of the linear axes, 2 degrees also in inches mode", 0.0, 3.0, field!(Int rotary_feed_mask)),
    // The contacts before what looks at them: a listing that is sent back tells no alarm in between.
    row(745, "", "axes whose drives close a contact for their alarm, mask; others open it", 0.0, ALL_AXES as f32, field!(Int drive_alarm_closed_mask)),
    row(744, "", "axes whose drives have an alarm wired, mask; 1 is one wire for all", 0.0, ALL_AXES as f32, field!(Int drive_alarm_mask)),
    row(900, "", "interval split: 0 fastest, 1 thirds", 0.0, 1.0, field!(Flag interval_thirds)),
    row(901, "", HOMING_ORDER, HOMING_ORDERS.0, HOMING_ORDERS.1, field!(Int homing_order_digits)),
    row(902, "", "the feed-hold input is a safety door's switch", 0.0, 1.0, field!(Flag hold_input_is_door)),
    row(904, "mm", "blend deviation of G64; 0 for corners as with G61", 0.0, 10.0, field!(Float blend_deviation_mm)),
    row(905, "", SECOND_MOTOR, 0.0, AXES as f32, field!(Int second_motor_axis)),
    row(906, "mm", "room behind a limit switch, in which a homing seek brakes; 0: it stops at once", 0.0, 100.0, field!(Float switch_room_mm)),
    row(907, "", "kinematics: 0 each axis has its motor, 1 CoreXY or H-bot", 0.0, 1.0, field!(Int kinematics)),
    #[cfg(feature = "trinamic")]
    row(908, "", "drivers interpolate to 256 microsteps, mask", 0.0, ALL_AXES as f32, field!(Int interpolate_mask)),
    #[cfg(feature = "trinamic")]
    row(909, "", "axes of $339 whose motor stops the machine if it stalls at speed, mask", 0.0, ALL_AXES as f32, field!(Int stall_alarm_mask)),
    row(910, "mm/min", "start speed", 0.0, 9e7, field!(PerAxis start_rate_mm_min)),
    row(920, "mm/s2", "deceleration; 0 for the acceleration", 0.0, 1e5, field!(PerAxis decel_or_0_mm_s2)),
    row(930, "mm/s3", "jerk of the s-curve; 0 for no limit", 0.0, 9e7, field!(PerAxis jerk_or_0_mm_s3)),
    row(940, "", "speed profile: 0 trapezoid, 1 s-curve, 2 sine, 3 linear, 4 quadratic, 5 sinusoidal, 6 logarithmic", 0.0, 6.0, field!(Int speed_profile)),
    row(950, "", "shaper: 0 none, 1 ZV, 2 MZV, 3 ZVD, 4 EI, 5 box", 0.0, 5.0, field!(IntPerAxis shaper_kind)),
    row(960, "Hz", "shaper's frequency", 10.0, 500.0, field!(PerAxis shaper_hz)),
    row(970, "", "shaper's damping ratio", 0.0, 0.5, field!(PerAxis shaper_damping_ratio)),
    #[cfg(feature = "trinamic")]
    row(980, "mm/min", "StealthChop up to this speed, SpreadCycle above it; 0: SpreadCycle always", 0.0, 9e7, field!(PerAxis stealth_mm_min)),
];

/// Every setting, by ascending number but for the microsteps, which come before the steps per millimetre, because these
/// follow them: so a listing that is sent back in this order ends as it was, whatever was set before. So do the contacts of drives'
/// alarms, before what looks at them.
pub static TABLE: &[Setting] = &settings();
/// The meaning of each setting. Kept apart from the table, which is read with every `$n=v`, as a constant without a symbol
/// name: so it stays in the chip's flash.
const MEANINGS: &[&str; ROWS.len()] = &meanings();

const fn settings() -> [Setting; ROWS.len()] {
    let mut settings = [ROWS[0].0; ROWS.len()];
    let mut index = 0;
    while index < settings.len() {
        settings[index] = ROWS[index].0;
        index += 1;
    }
    settings
}

const fn meanings() -> [&'static str; ROWS.len()] {
    let mut meanings = [""; ROWS.len()];
    let mut index = 0;
    while index < meanings.len() {
        meanings[index] = ROWS[index].1;
        index += 1;
    }
    meanings
}

/// The row that holds `number`, and the axis index.
pub(crate) fn find(number: u16) -> Option<(&'static Setting, usize)> {
    TABLE
        .iter()
        .find(|setting| setting.numbers().contains(&number))
        .map(|setting| (setting, usize::from(number - setting.number)))
}

/// The setting at `index` among all, and its number: those with a value for each axis have several.
pub(crate) fn numbered(index: usize) -> Option<(&'static Setting, u16)> {
    TABLE.iter().flat_map(|setting| setting.numbers().map(move |number| (setting, number))).nth(index)
}

impl Setting {
    /// The numbers that the row holds: one, or one for each axis.
    pub fn numbers(&self) -> core::ops::Range<u16> {
        let count = if matches!(self.field, PerAxis(_) | IntPerAxis(_)) { AXES as u16 } else { 1 };
        self.number..self.number + count
    }

    /// True if it is about Trinamic drivers, which not every board has.
    pub fn is_trinamic(&self) -> bool {
        cfg!(feature = "trinamic") && matches!(self.number, 140 | 150 | 200 | 210 | 338 | 339 | 908 | 909 | 980)
    }

    /// The meaning of the setting.
    pub fn meaning(&self) -> &'static str {
        let mut rows = TABLE.iter().zip(MEANINGS);
        rows.find(|(row, _)| row.number == self.number).map_or("", |(_, meaning)| *meaning)
    }

    /// The unit of setting `number` of this row: a rotary axis has degrees for millimetres.
    pub fn unit_of(&self, number: u16, settings: &Settings) -> &'static str {
        let is_rotary = matches!(self.field, PerAxis(_)) && settings.is_rotary(usize::from(number - self.number));
        match self.unit {
            "steps/mm" if is_rotary => "steps/degree",
            "mm" if is_rotary => "degrees",
            "mm/min" if is_rotary => "degrees/min",
            "mm/s2" if is_rotary => "degrees/s2",
            "mm/s3" if is_rotary => "degrees/s3",
            unit => unit,
        }
    }

    /// True if the value must be a whole number.
    pub fn is_integer(&self) -> bool {
        matches!(self.field, Flag(_) | Int(_) | IntPerAxis(_))
    }

    /// Checks `value` for setting `number` against the range of this row.
    pub(crate) fn check(&self, settings: &Settings, number: u16, value: f32) -> Result<(), SettingError> {
        let (Self { min, max, .. }, unit) = (*self, self.unit_of(number, settings));
        if value < 0.0 && min >= 0.0 {
            return Err(SettingError::Negative { number, value });
        }
        if self.is_integer() && value % 1.0 != 0.0 {
            return Err(SettingError::NotInteger { number, value });
        }
        if value < min {
            return Err(SettingError::TooLow { number, value, min, unit });
        }
        if value > max || value.is_nan() {
            return Err(SettingError::TooHigh { number, value, max, unit });
        }
        Ok(())
    }

    pub(crate) fn value(&self, settings: &Settings, axis: usize) -> f32 {
        let mut settings = *settings;
        match self.field {
            Flag(field) => u8::from(*field(&mut settings)).into(),
            Int(field) => (*field(&mut settings)).into(),
            Float(field) => *field(&mut settings),
            PerAxis(field) => field(&mut settings)[axis],
            IntPerAxis(field) => field(&mut settings)[axis].into(),
        }
    }

    pub(crate) fn set(&self, settings: &mut Settings, axis: usize, value: f32) {
        match self.field {
            Flag(field) => *field(settings) = value != 0.0,
            Int(field) => *field(settings) = value as u16,
            Float(field) => *field(settings) = value,
            PerAxis(field) => field(settings)[axis] = value,
            IntPerAxis(field) => field(settings)[axis] = value as u16,
        }
    }

    /// `$n=v` for each number of the row, as `$$` prints it.
    pub(crate) fn print(&self, out: &mut dyn fmt::Write, settings: &Settings) -> fmt::Result {
        let decimals = if self.is_integer() { 0 } else { 3 };
        self.numbers().enumerate().try_for_each(|(axis, number)| {
            let value = Fixed { value: self.value(settings, axis), decimals };
            write!(out, "${number}={value}\r\n")
        })
    }
}
