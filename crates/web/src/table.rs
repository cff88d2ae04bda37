//! The table of settings, for a form: what each is called, what it may be, and what its numbers mean.
//!
//! All of it is read from the console's own table. A meaning has the shape `name: 0 one, 1 other` or `name; remark`,
//! and a name that ends in `mask` is of bits.

use isostep_console::{AXIS_NAMES, Fixed, SETTING_TABLE, Setting, Settings};
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
    let meaning = setting.meaning();
    let (options, (head, remark)) = match named(meaning) {
        Some((head, values)) => (options(values, setting), (head, values)),
        None => (Vec::new(), meaning.split_once("; ").unwrap_or((meaning, ""))),
    };
    let (name, is_mask) = head.strip_suffix(", mask").map_or((head, false), |name| (name, true));
    let kind = match options.is_empty() {
        _ if is_mask => Kind::Mask,
        false => Kind::Choice,
        true if setting.is_integer() && setting.max == 1.0 => Kind::Switch,
        true if setting.is_integer() => Kind::Whole,
        true => Kind::Number,
    };
    let decimals = if setting.is_integer() { 0 } else { 3 };
    let axis = AXIS_NAMES[usize::from(number - setting.number)];
    let default = Fixed { value: Settings::DEFAULT.get(number).unwrap_or(f32::NAN), decimals }.to_string();
    Row {
        number,
        group: group(number),
        name: if setting.numbers().len() > 1 { format!("{axis} {name}") } else { name.to_owned() },
        remark: if options.is_empty() { remark.to_owned() } else { String::new() },
        unit: setting.unit_of(number, &Settings::DEFAULT),
        min: setting.min,
        max: setting.max,
        default,
        kind,
        options: if is_mask && options.is_empty() { axis_bits() } else { options },
    }
}

/// A name, and the values that have names.
fn named(meaning: &str) -> Option<(&str, &str)> {
    meaning.split_once(": ").filter(|(_, values)| values.starts_with(|c: char| c.is_ascii_digit()))
}

/// The values and their names, if they are values of this setting: `1 X, 2 Y` of an order are its digits.
fn options(values: &str, setting: &Setting) -> Vec<(u16, String)> {
    let option =
        |part: &str| part.split_once(' ').and_then(|(value, name)| Some((value.parse().ok()?, name.to_owned())));
    let options: Option<Vec<(u16, String)>> = values.split(", ").map(option).collect();
    let may_be = |&(value, _): &(u16, String)| (setting.min..=setting.max).contains(&f32::from(value));
    options.filter(|options| options.iter().all(may_be)).unwrap_or_default()
}

fn axis_bits() -> Vec<(u16, String)> {
    (0..).zip(AXIS_NAMES).map(|(index, name)| (1 << index, name.to_owned())).collect()
}

/// The group that a setting belongs to.
fn group(number: u16) -> &'static str {
    match number {
        0..=4 => "Motors",
        140..=169 | 200..=219 | 338 | 339 | 908 | 909 | 980..=989 => "Drivers",
        100..=139 | 376 | 701 => "Axes",
        5 | 20..=27 | 901 | 906 => "Limits and homing",
        11 | 12 | 904 => "Corners and arcs",
        900 | 910..=949 => "How speed changes",
        950..=979 => "Shapers",
        28 => "Canned cycles",
        30..=36 | 394 => "Spindle and laser",
        6 | 902 => "Probe and door",
        8 | 170..=179 | 349 | 905 => "Second motor",
        10 | 13 => "Reports",
        _ => "Others",
    }
}
