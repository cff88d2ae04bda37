//! `$` lines, which are not G-code.

use crate::{Command, Error, decimal::Decimal};

/// Understands a stripped, upper-case line that begins with `$`.
pub(crate) fn parse(line: &str) -> Result<Command, Error> {
    match line {
        "$" => Ok(Command::Help),
        "$$" => Ok(Command::ShowSettings),
        "$G" => Ok(Command::ShowModal),
        "$H" => Ok(Command::Home),
        "$I" => Ok(Command::ShowBuild),
        "$X" => Ok(Command::Unlock),
        _ => setting(line),
    }
}

fn setting(line: &str) -> Result<Command, Error> {
    let (name, value) = line.split_once('=').ok_or(Error::UnknownStatement)?;
    let digits = name.strip_prefix('$').ok_or(Error::UnknownStatement)?;
    if !digits.bytes().all(|byte| byte.is_ascii_digit()) {
        return Err(Error::UnknownStatement);
    }
    let number = digits.parse().map_err(|_| Error::UnknownStatement)?;
    Ok(Command::SetSetting { number, value: decimal(value)? })
}

/// A plain decimal and nothing else.
fn decimal(text: &str) -> Result<f32, Error> {
    match Decimal::read(text.as_bytes()) {
        Some((number, [])) => number.value().ok_or(Error::BadNumber),
        _ => Err(Error::BadNumber),
    }
}
