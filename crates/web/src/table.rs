//! The table of settings, for a form: what each is called, what it may be, and what its numbers mean.
//!
//! All of it is read from the console's own table.

use isostep_console::{AXIS_NAMES, Fixed, SETTING_TABLE, Setting, SettingKind, Settings};
use isostep_sim::settings::read_for_any_port;
use serde::Serialize;

use crate::Trouble;

/// A setting of one number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The number after `$`.
    pub number: u16,
    /// The group that it belongs to.
    pub group: &'static str,
    /// Its name, with its axis.
    pub name: String,
    /// A remark about it.
    pub remark: String,
    /// Its unit, or nothing.
    pub unit: &'static str,
    /// The least value.
    pub min: f32,
    /// The greatest value.
    pub max: f32,
    /// The default, as `$$` prints it.
    pub default: String,
    /// The way to enter it.
    pub kind: Kind,
    /// The values that have names; those of a mask are its bits.
    pub options: Vec<(u16, String)>,
}

/// The way to enter a setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// On or off.
    Switch,
    /// Some of the options.
    Mask,
    /// One of the options.
    Choice,
    /// A whole number.
    Whole,
    /// Any number.
    Number,
}

/// Every setting, by ascending number.
pub fn rows() -> Vec<Row> {
    SETTING_TABLE.iter().flat_map(|setting| setting.numbers().map(|number| row(setting, number))).collect()
}

/// Why settings, lines of `$n=v`, cannot be together, on whichever board; `None` if they can. What the step outputs of
/// a board carry is known to that board only.
pub fn refusal(lines: &str) -> Option<Trouble> {
    read_for_any_port("settings", lines.as_bytes()).err().map(Trouble::from)
}

fn row(setting: &Setting, number: u16) -> Row {
    let decimals = if setting.is_integer() { 0 } else { 3 };
    let (axis, name) = (AXIS_NAMES[usize::from(number - setting.number)], setting.name());
    let default = Fixed { value: Settings::DEFAULT.get(number).unwrap_or(f32::NAN), decimals }.to_string();
    let options = setting.options().map(|(value, name)| (value, name.to_owned())).collect();
    Row {
        number,
        group: setting.group().name(),
        name: if setting.numbers().len() > 1 { format!("{axis} {name}") } else { name.to_owned() },
        remark: setting.remark().to_owned(),
        unit: setting.unit_of(number, &Settings::DEFAULT),
        min: setting.min,
        max: setting.max,
        default,
        kind: setting.kind().into(),
        options: if setting.kind() == SettingKind::AxisMask { axis_bits() } else { options },
    }
}

impl From<SettingKind> for Kind {
    fn from(kind: SettingKind) -> Self {
        match kind {
            SettingKind::Switch => Self::Switch,
            SettingKind::Mask | SettingKind::AxisMask => Self::Mask,
            SettingKind::Choice => Self::Choice,
            SettingKind::Whole => Self::Whole,
            SettingKind::Number => Self::Number,
        }
    }
}

fn axis_bits() -> Vec<(u16, String)> {
    (0..).zip(AXIS_NAMES).map(|(index, name)| (1 << index, name.to_owned())).collect()
}
