//! What a form needs to know of a setting: its group, its name, the way to enter it, and what its numbers mean.
//!
//! All of it is read from the table's meanings. A meaning has the shape `name: 0 one, 1 other` or `name; remark`, and a name that
//! ends in `, mask` is of bits, of axes if they have no names.

use crate::Setting;

/// What a setting is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum SettingGroup {
    /// All motors.
    Motors = 1,
    /// The axes.
    Axes,
    /// Drivers that are set by UART.
    Drivers,
    /// A second motor of an axis.
    SecondMotor,
    /// Limit switches, soft limits and homing.
    Homing,
    /// How speed changes along a move.
    SpeedChanges,
    /// Corners between moves, and arcs.
    Corners,
    /// Input shapers.
    Shapers,
    /// Canned cycles.
    Cycles,
    /// Spindle and laser.
    Tool,
    /// What M6 does.
    ToolChange,
    /// The probe and the safety door.
    Inputs,
    /// What the console prints.
    Reports,
}

impl SettingGroup {
    /// All groups, by ascending number.
    pub const ALL: &[Self] = &[
        Self::Motors,
        Self::Axes,
        Self::Drivers,
        Self::SecondMotor,
        Self::Homing,
        Self::SpeedChanges,
        Self::Corners,
        Self::Shapers,
        Self::Cycles,
        Self::Tool,
        Self::ToolChange,
        Self::Inputs,
        Self::Reports,
    ];

    /// The name.
    pub fn name(self) -> &'static str {
        GROUP_NAMES[self as usize - 1]
    }
}

// A constant: so it stays in the chip's flash, which the table of a `match` does not.
const GROUP_NAMES: &[&str; SettingGroup::ALL.len()] = &[
    "Motors",
    "Axes",
    "Drivers",
    "Second motor",
    "Limits and homing",
    "How speed changes",
    "Corners and arcs",
    "Shapers",
    "Canned cycles",
    "Spindle and laser",
    "Change of the tool",
    "Probe and door",
    "Reports",
];

/// The way to enter a setting, by grblHAL's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum SettingKind {
    /// On or off.
    Switch = 0,
    /// Some of the options, which are bits.
    Mask = 1,
    /// One of the options.
    Choice = 3,
    /// Some of the axes.
    AxisMask = 4,
    /// A whole number.
    Whole = 5,
    /// Any number.
    Number = 6,
}

impl Setting {
    /// The group that it belongs to.
    pub const fn group(&self) -> SettingGroup {
        match self.number {
            0..=4 | 744 | 745 | 907 => SettingGroup::Motors,
            100..=139 | 376 | 701 => SettingGroup::Axes,
            140..=169 | 200..=219 | 338 | 339 | 908 | 909 | 980..=989 => SettingGroup::Drivers,
            8 | 170..=179 | 349 | 905 => SettingGroup::SecondMotor,
            5 | 20..=27 | 901 | 906 => SettingGroup::Homing,
            900 | 910..=949 => SettingGroup::SpeedChanges,
            11 | 12 | 904 => SettingGroup::Corners,
            950..=979 => SettingGroup::Shapers,
            28 => SettingGroup::Cycles,
            30..=36 | 340 | 374 | 375 | 394 | 395 | 461..=476 | 681 => SettingGroup::Tool,
            341..=344 => SettingGroup::ToolChange,
            6 | 902 => SettingGroup::Inputs,
            _ => SettingGroup::Reports,
        }
    }

    /// Its name: the meaning without a remark and without the meanings of its values.
    pub fn name(&self) -> &'static str {
        let name = self.parts().0;
        name.strip_suffix(MASK).unwrap_or(name)
    }

    /// A remark about it, or nothing.
    pub fn remark(&self) -> &'static str {
        if self.options().next().is_some() { "" } else { self.parts().1 }
    }

    /// The way to enter it.
    pub fn kind(&self) -> SettingKind {
        let has_options = self.options().next().is_some();
        match self.parts().0.ends_with(MASK) {
            true if has_options => SettingKind::Mask,
            true => SettingKind::AxisMask,
            false if has_options => SettingKind::Choice,
            false if self.is_integer() && self.max == 1.0 => SettingKind::Switch,
            false if self.is_integer() => SettingKind::Whole,
            false => SettingKind::Number,
        }
    }

    /// The values that have names, and their names; those of a mask are its bits.
    pub fn options(&self) -> NamedValues {
        let text = self.values().map_or("", |(_, values)| values);
        // Otherwise they are not values of this setting: `1 X, 2 Y` of an order are its digits.
        if self.are_values(text) { NamedValues { left: text } } else { NamedValues { left: "" } }
    }

    fn are_values(&self, text: &'static str) -> bool {
        let mut named = NamedValues { left: text };
        while !named.left.is_empty() {
            if named.next().is_none_or(|(value, _)| !self.is_within(value)) {
                return false;
            }
        }
        true
    }

    fn is_within(&self, value: u16) -> bool {
        (self.min..=self.max).contains(&f32::from(value))
    }

    /// The name, and what follows it.
    fn parts(&self) -> (&'static str, &'static str) {
        let meaning = self.meaning();
        self.values().or_else(|| meaning.split_once("; ")).unwrap_or((meaning, ""))
    }

    /// The name, and what the numbers mean, if the meaning says it.
    fn values(&self) -> Option<(&'static str, &'static str)> {
        self.meaning().split_once(": ").filter(|(_, values)| values.starts_with(|c: char| c.is_ascii_digit()))
    }
}

/// The end of a name of bits.
const MASK: &str = ", mask";

/// Values and their names, as a meaning has them: `0 one, 1 other`.
// Not adapters of the core's, which would run from RAM.
#[derive(Debug, Clone)]
pub struct NamedValues {
    left: &'static str,
}

impl Iterator for NamedValues {
    type Item = (u16, &'static str);

    fn next(&mut self) -> Option<Self::Item> {
        let (text, left) = self.left.split_once(", ").unwrap_or((self.left, ""));
        self.left = left;
        let (value, name) = text.split_once(' ')?;
        Some((value.parse().ok()?, name))
    }
}
