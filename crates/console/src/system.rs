//! `$` lines, which are not G-code.

use crate::{Command, Error, words::VALUE_BOUND};

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

/// A plain decimal. Rust alone would read exponents, `INF` and `NAN` too.
fn decimal(text: &str) -> Result<f32, Error> {
    if !text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'.' | b'-' | b'+')) {
        return Err(Error::BadNumber);
    }
    text.parse().ok().filter(|value: &f32| value.abs() < VALUE_BOUND).ok_or(Error::BadNumber)
}
