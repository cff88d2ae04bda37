//! `$` lines, which are not G-code: what they ask for, and in which states they are allowed.

use crate::axes::axis_named;
use crate::setting_table::find;
use crate::{
    AlarmCode, Catalogue, Command, Error, Interpreter, ReportedState, Settings, parameters::STARTUP_LINES,
    words::decimal::Decimal,
};

impl Interpreter {
    /// Interprets what follows the `$` of a stripped, upper-case line.
    // Not inlined, so that the lines of a program run through less code in flash.
    #[cold]
    #[inline(never)]
    pub(crate) fn statement<'l>(
        &mut self,
        statement: &'l str,
        state: ReportedState,
        settings: &Settings,
    ) -> Result<Command<'l>, Error> {
        if let Some(words) = statement.strip_prefix("PROVE") {
            return Ok(Command::Prove { words });
        }
        if let Some(axis) = statement.strip_prefix("BUZZ=").and_then(axis_named) {
            let is_idle = matches!(state, ReportedState::Idle);
            return if is_idle { Ok(Command::Buzz { axis }) } else { Err(Error::NotIdle) };
        }
        #[cfg(feature = "trinamic")]
        if let Some(axis) = statement.strip_prefix("STALL=").and_then(axis_named) {
            let is_idle = matches!(state, ReportedState::Idle);
            return if is_idle { Ok(Command::MeasureStall { axis }) } else { Err(Error::NotIdle) };
        }
        if let Some(text) = statement.strip_prefix("SED=") {
            let known = number(text).filter(|&number| find(number).is_some());
            let number = known.ok_or(Error::UnknownStatement)?;
            return long_list(Command::DescribeSetting { number }, state);
        }
        match statement {
            "" => Ok(Command::Help),
            "$" => long_list(Command::ShowSettings, state),
            "ES" => long_list(Command::ShowCatalogue(Catalogue::Settings), state),
            "EG" => long_list(Command::ShowCatalogue(Catalogue::Groups), state),
            "EE" => long_list(Command::ShowCatalogue(Catalogue::Errors), state),
            "EA" => long_list(Command::ShowCatalogue(Catalogue::Alarms), state),
            "G" => Ok(Command::ShowModal),
            "X" => Ok(Command::Unlock),
            "VFD" => Ok(Command::ShowVfd),
            "TPW" if state == ReportedState::Tool => Ok(Command::MeasureTool),
            "TPW" => Err(Error::NotIdle),
            "TLR" if matches!(state, ReportedState::Idle | ReportedState::Tool) => Ok(Command::SetToolReference),
            "TLR" => Err(Error::NotIdle),
            "#" if state == ReportedState::Tool => Ok(Command::ShowParameters),
            "C" if matches!(state, ReportedState::Idle | ReportedState::Check) => Ok(Command::ToggleCheck),
            "C" => Err(Error::NotIdle),
            _ => match statement.split_at_checked(1) {
                Some(("J", jog)) => self.begin_jog(jog, state, settings),
                Some(("E", code)) => explain(code, Error::from_code).map(Command::ExplainError),
                Some(("A", code)) => explain(code, AlarmCode::from_code).map(Command::ExplainAlarm),
                _ if !matches!(state, ReportedState::Idle | ReportedState::Alarm) => Err(Error::NotIdle),
                Some(("N", startup)) => self.startup(startup, state, settings),
                _ => at_rest(statement, settings),
            },
        }
    }

    fn begin_jog<'l>(&self, jog: &str, state: ReportedState, settings: &Settings) -> Result<Command<'l>, Error> {
        if !matches!(state, ReportedState::Idle | ReportedState::Jog | ReportedState::Tool) {
            return Err(Error::NotIdle);
        }
        self.jog(jog.strip_prefix('=').ok_or(Error::BadJog)?, settings).map(Command::Jog)
    }

    /// A start-up line is executed before it is stored, to check that it works. So it needs the Idle state.
    fn startup<'l>(
        &mut self,
        startup: &'l str,
        state: ReportedState,
        settings: &Settings,
    ) -> Result<Command<'l>, Error> {
        let Some((index, line)) = startup.split_once('=') else {
            return if startup.is_empty() { Ok(Command::ShowStartup) } else { Err(Error::UnknownStatement) };
        };
        if state != ReportedState::Idle {
            return Err(Error::NotIdle);
        }
        let index = usize::from(number(index).ok_or(Error::BadNumber)?);
        if index >= STARTUP_LINES {
            return Err(Error::UnknownStatement);
        }
        self.gcode(line, settings).map(|block| Command::SetStartup { index, block, line })
    }
}

/// A list that would hold up the lines of a program.
fn long_list(list: Command<'_>, state: ReportedState) -> Result<Command<'_>, Error> {
    let runs = matches!(state, ReportedState::Run | ReportedState::Hold { .. } | ReportedState::Door(_));
    if runs { Err(Error::NotIdle) } else { Ok(list) }
}

/// The statements that need a machine at rest.
fn at_rest<'l>(statement: &'l str, settings: &Settings) -> Result<Command<'l>, Error> {
    match statement {
        "#" => Ok(Command::ShowParameters),
        "H" => home(None, settings),
        "I" => Ok(Command::ShowBuild { is_extended: false }),
        "I+" => Ok(Command::ShowBuild { is_extended: true }),
        "SLP" => Ok(Command::Sleep),
        "BOOT" => Ok(Command::Boot),
        "RST=$" => Ok(Command::Restore { settings: true, parameters: false }),
        "RST=#" => Ok(Command::Restore { settings: false, parameters: true }),
        "RST=*" => Ok(Command::Restore { settings: true, parameters: true }),
        _ => {
            if let Some(axis) = statement.strip_prefix('H').and_then(axis_named) {
                return home(Some(axis), settings);
            }
            let (name, value) = statement.split_once('=').ok_or(Error::UnknownStatement)?;
            if name == "I" {
                return Ok(Command::SetBuild { text: value });
            }
            let number = number(name).ok_or(Error::UnknownStatement)?;
            Ok(Command::SetSetting { number, value: decimal(value)? })
        }
    }
}

fn home<'l>(axis: Option<usize>, settings: &Settings) -> Result<Command<'l>, Error> {
    let homes = settings.homing && axis.is_none_or(|axis| settings.homing_order().contains(&Some(axis)));
    if homes { Ok(Command::Home { axis }) } else { Err(Error::HomingDisabled) }
}

fn explain<T>(code: &str, from_code: fn(u8) -> Option<T>) -> Result<T, Error> {
    let code = number(code).and_then(|code| u8::try_from(code).ok());
    code.and_then(from_code).ok_or(Error::UnknownStatement)
}

/// Parses digits and nothing else.
fn number(text: &str) -> Option<u16> {
    text.bytes().all(|byte| byte.is_ascii_digit()).then(|| text.parse().ok())?
}

/// Parses a plain decimal and nothing else.
fn decimal(text: &str) -> Result<f32, Error> {
    match Decimal::read(text.as_bytes()) {
        Some((number, [])) => number.value().ok_or(Error::BadNumber),
        _ => Err(Error::BadNumber),
    }
}
