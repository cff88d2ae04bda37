//! Lists of what numbers mean, for senders, as grblHAL prints them: `$ES`, `$EG`, `$EE`, `$EA`.
//!
//! A line of a setting has one colon: ioSender reads no other. Texts have no `|` and no `]`, which end their fields.

use core::fmt::{Result, Write};

use crate::setting_table::numbered;
use crate::{AXIS_NAMES, AlarmCode, Error, Fixed, SETTING_TABLE, Setting, SettingGroup, SettingKind, Settings};

/// A list of numbers and what they mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Catalogue {
    /// `$ES`: the settings, with their groups, units and limits.
    Settings,
    /// `$EG`: the groups of the settings.
    Groups,
    /// `$EE`: the errors.
    Errors,
    /// `$EA`: the alarms.
    Alarms,
}

impl Catalogue {
    /// Number of its lines.
    pub fn lines(self) -> usize {
        match self {
            Self::Settings => SETTING_TABLE.iter().map(|row| row.numbers().len()).sum(),
            Self::Groups => SettingGroup::ALL.len(),
            Self::Errors => Error::ALL.len(),
            Self::Alarms => AlarmCode::ALL.len(),
        }
    }

    /// The setting of line `index`, if it has one.
    pub fn setting(self, index: usize) -> Option<&'static Setting> {
        numbered(index).filter(|_| self == Self::Settings).map(|(setting, _)| setting)
    }

    /// Prints line `index`, below [`lines`](Self::lines): at most 190 bytes.
    ///
    /// # Errors
    /// That of `out`.
    pub fn print(self, out: &mut impl Write, index: usize, settings: &Settings) -> Result {
        match self {
            Self::Settings => numbered(index).map_or(Ok(()), |(row, number)| setting(out, row, number, settings)),
            Self::Groups => SettingGroup::ALL
                .get(index)
                .map_or(Ok(()), |&group| write!(out, "[SETTINGGROUP:{}|0|{}]\r\n", group as u8, group.name())),
            Self::Errors => {
                Error::ALL.get(index).map_or(Ok(()), |error| write!(out, "[ERRORCODE:{}||{error}]\r\n", error.code()))
            }
            Self::Alarms => AlarmCode::ALL
                .get(index)
                .map_or(Ok(()), |alarm| write!(out, "[ALARMCODE:{}||{alarm}]\r\n", alarm.code())),
        }
    }
}

/// `[SETTING:number|group|name|unit|type|format|min|max|0|0]`: it needs no restart, and may not be empty.
fn setting(out: &mut impl Write, row: &Setting, number: u16, settings: &Settings) -> Result {
    write!(out, "[SETTING:{number}|{}|", row.group() as u8)?;
    if row.numbers().len() > 1 {
        write!(out, "{} ", AXIS_NAMES[usize::from(number - row.number)])?;
    }
    let kind = row.kind();
    write!(out, "{}|{}|{}|", row.name(), row.unit_of(number, settings), kind as u8)?;
    match kind {
        SettingKind::Switch | SettingKind::AxisMask => out.write_str("||")?,
        SettingKind::Mask | SettingKind::Choice => {
            for (index, (_, name)) in row.options().enumerate() {
                write!(out, "{}{name}", if index > 0 { "," } else { "" })?;
            }
            out.write_str("||")?;
        }
        SettingKind::Whole | SettingKind::Number => limits(out, row)?,
    }
    out.write_str("|0|0]\r\n")
}

/// `##0.000|0.000|100.000`: the digits of a number, its least and its greatest value.
fn limits(out: &mut impl Write, row: &Setting) -> Result {
    let decimals = if row.is_integer() { 0 } else { 3 };
    if row.min < 0.0 {
        out.write_char('-')?;
    }
    let mut power = 10.0;
    while power <= row.max {
        out.write_char('#')?;
        power *= 10.0;
    }
    let (min, max) = (Fixed { value: row.min, decimals }, Fixed { value: row.max, decimals });
    write!(out, "0{}|{min}|{max}", if row.is_integer() { "" } else { ".000" })
}

#[cfg(test)]
mod tests {
    use std::string::String;
    use std::vec::Vec;

    use super::*;
    use crate::report;

    const ALL: [Catalogue; 4] = [Catalogue::Settings, Catalogue::Groups, Catalogue::Errors, Catalogue::Alarms];

    fn lines(catalogue: Catalogue) -> Vec<String> {
        let line = |index| {
            let mut line = String::new();
            catalogue.print(&mut line, index, &Settings::DEFAULT).unwrap();
            line
        };
        (0..catalogue.lines()).map(line).collect()
    }

    #[test]
    fn every_line_is_read_as_grblhal_writes_it() {
        for (catalogue, name, fields) in [
            (Catalogue::Settings, "[SETTING:", 10),
            (Catalogue::Groups, "[SETTINGGROUP:", 3),
            (Catalogue::Errors, "[ERRORCODE:", 3),
            (Catalogue::Alarms, "[ALARMCODE:", 3),
        ] {
            for line in lines(catalogue) {
                let values = line.strip_prefix(name).and_then(|line| line.strip_suffix("]\r\n")).unwrap();
                assert_eq!(values.split('|').count(), fields, "{line}");
                assert!(!values.contains([']', '[', '\r', '\n']) && values.is_ascii(), "{line}");
                assert!(line.len() <= 190, "{line} has {} bytes", line.len());
                let has_other_colons =
                    values.contains(':') && matches!(catalogue, Catalogue::Settings | Catalogue::Groups);
                assert!(!has_other_colons, "ioSender does not read {line}");
            }
        }
    }

    #[test]
    fn no_text_is_taken_for_an_answer() {
        for line in ALL.into_iter().flat_map(lines) {
            let text = line.split_once(':').unwrap().1;
            for word in ["ok", "error", "ALARM"] {
                assert!(!text.contains(word), "{line}");
            }
            assert!(!text.to_ascii_lowercase().contains("grblhal"), "by this word gSender knows it: {line}");
        }
    }

    #[test]
    fn every_setting_has_a_description_that_is_read() {
        let said = |number| {
            let mut said = String::new();
            report::description(&mut said, number).unwrap();
            said
        };
        for number in SETTING_TABLE.iter().flat_map(Setting::numbers) {
            let said = said(number);
            let text = said.strip_suffix("]\r\n").and_then(|said| said.split_once('|')).unwrap().1;
            assert!(said.len() <= 190 && !text.contains(['|', ']', '\r', '\n']), "{said}");
            assert!(["ok", "error", "ALARM"].iter().all(|word| !text.contains(word)), "{said}");
        }
        assert_eq!(said(0), "[SETTINGDESCR:0|0 as short as the driver takes]\r\n");
        assert_eq!(said(922), "[SETTINGDESCR:922|0 for the acceleration]\r\n");
        assert_eq!(said(940), "[SETTINGDESCR:940|]\r\n", "its names are in its list");
    }

    #[test]
    fn a_list_of_names_begins_with_the_first_value() {
        for row in SETTING_TABLE {
            let values: Vec<_> = row.options().map(|(value, _)| value).collect();
            let is_mask = row.kind() == SettingKind::Mask;
            let expected = (0..values.len() as u16).map(|index| if is_mask { 1 << index } else { index });
            assert!(values.iter().copied().eq(expected), "${}", row.number);
            assert!(row.options().all(|(_, name)| !name.contains(',')), "${}", row.number);
        }
    }

    #[test]
    fn groups_have_settings_and_numbers_of_their_own() {
        assert!(SettingGroup::ALL.iter().zip(1..).all(|(&group, number)| group as u8 == number));
        for &group in SettingGroup::ALL {
            let is_used = SETTING_TABLE.iter().any(|row| row.group() == group);
            assert!(is_used || group == SettingGroup::Drivers, "{group:?}");
        }
    }

    #[test]
    fn settings_are_described_by_what_they_are() {
        let lines = lines(Catalogue::Settings);
        let rows = [
            "[SETTING:1|1|motors stay energised after a move|ms|5|##0|0|255|0|0]",
            "[SETTING:3|1|direction invert||4||||0|0]",
            "[SETTING:6|12|probe input||1|contact is high,no pull-up|||0|0]",
            "[SETTING:22|5|homing||0||||0|0]",
            "[SETTING:111|2|Y top speed|mm/min|6|#######0.000|1.000|90000000.000|0|0]",
            "[SETTING:170|4|X how much farther the second motor is from its switch|mm|6|-0.000|-5.000|5.000|0|0]",
            "[SETTING:900|6|interval split||3|fastest,thirds|||0|0]",
            "[SETTING:901|5|homing order, axis digits||5|##0|123|321|0|0]",
        ];
        for row in rows {
            assert!(lines.iter().any(|line| line.trim_end() == row), "{row} is not in {lines:#?}");
        }
    }
}
