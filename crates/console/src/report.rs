//! Replies, byte for byte as Grbl writes them. Each ends in CR LF.

use core::fmt::{Result, Write};

use crate::{Alarm, Error, Fixed, Modal, SETTING_TABLE, Settings};

/// Sent when the console opens and after a reset.
pub const WELCOME: &str = "\r\nGrbl 1.1h ['$' for help]\r\n";
/// A line was accepted.
pub const OK: &str = "ok\r\n";
/// The reply to `$`, before `ok`: what of Grbl's commands there is.
pub const HELP: &str = "[HLP:$$ $G $I $x=val $X $H ? ctrl-x]\r\n";
/// The reply to `$I`, before `ok`. Senders look for "grbl" and Grbl's date in it; Z is Grbl's letter for a machine that reads 0 where
/// it rests after homing; then the blocks and bytes that a sender may count on.
pub const BUILD: &str =
    concat!("[VER:1.1h.20190830:Isostep ", env!("CARGO_PKG_VERSION"), " (grbl dialect)]\r\n[OPT:Z,15,128]\r\n");

/// Texts of `[MSG:...]` that senders know.
pub mod messages {
    /// After an alarm that only a reset ends.
    pub const RESET_TO_CONTINUE: &str = "Reset to continue";
    /// At the welcome, when the machine is locked.
    pub const HOW_TO_UNLOCK: &str = "'$H'|'$X' to unlock";
    /// `$X` left Alarm.
    pub const UNLOCKED: &str = "Caution: Unlocked";
    /// A limit switch is pressed where none should be.
    pub const CHECK_LIMITS: &str = "Check Limits";
    /// M2 or M30.
    pub const PROGRAM_END: &str = "Pgm End";
}

/// `error:N`.
pub fn error(out: &mut impl Write, error: Error) -> Result {
    write!(out, "error:{}\r\n", error.code())
}

/// `ALARM:N`.
pub fn alarm(out: &mut impl Write, alarm: Alarm) -> Result {
    write!(out, "ALARM:{}\r\n", alarm.code())
}

/// `[MSG:...]`: one of [`messages`], a [`SettingError`](crate::SettingError), or other words.
pub fn message(out: &mut impl Write, text: impl core::fmt::Display) -> Result {
    write!(out, "[MSG:{text}]\r\n")
}

/// The reply to `$$`, before `ok`: about 700 bytes. A caller with a smaller buffer prints row by row with [`setting`].
pub fn settings(out: &mut impl Write, settings: &Settings) -> Result {
    SETTING_TABLE.iter().try_for_each(|row| setting(out, row, settings))
}

/// The lines of one row of the table: one, or one for each axis; at most 64 bytes.
pub fn setting(out: &mut impl Write, row: &crate::Setting, settings: &Settings) -> Result {
    row.print(out, settings)
}

/// The reply to `$G`, before `ok`.
pub fn modal(out: &mut impl Write, modal: &Modal, inches: bool) -> Result {
    let units = if modal.inches { "G20" } else { "G21" };
    let distance = if modal.incremental { "G91" } else { "G90" };
    let (motion, spindle, coolant) = (modal.motion.word(), modal.spindle.word(), modal.coolant.word());
    let feed = Fixed::rate(modal.feed_mm_min, inches);
    let speed = Fixed { value: modal.speed_rpm, decimals: 0 };
    write!(out, "[GC:{motion} G54 G17 {units} {distance} G94 {spindle} {coolant} T{} F{feed} S{speed}]\r\n", modal.tool)
}
