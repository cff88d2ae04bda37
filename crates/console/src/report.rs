//! Replies, byte for byte as Grbl writes them. Each ends in CR LF.

use core::fmt::{Result, Write};

use crate::setting_table::find;
use crate::status::write_coordinates;
use crate::{
    AXES, AlarmCode, Coordinate, Coordinates, Error, Fixed, Interpreter, SETTING_TABLE, Settings, TOOLS, ToolEntry,
    axes::Z,
    parameters::{StoredLine, WORK_SYSTEMS},
    tools::NM_PM,
};

/// Sent when the console opens and after a reset.
pub const WELCOME: &str = "\r\nGrbl 1.1h ['$' for help]\r\n";
/// A line was accepted.
pub const OK: &str = "ok\r\n";
/// The reply to `$`, before `ok`: Grbl's line and one of our own.
pub const HELP: &str = "[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]\r\n\
    [MSG:$En and $An explain a refusal or an alarm by its number n, $BUZZ=X moves X to and fro, \
    $BOOT makes way for new firmware]\r\n";
/// The name of the build. Senders look for "grbl" in the reply to `$I`.
const BUILD: &str = concat!("Isostep ", env!("CARGO_PKG_VERSION"), " (grbl dialect)");
/// The name of the firmware. Senders that read `grblHAL` here go on to use what is not here, such as its stop byte and M61.
pub(crate) const FIRMWARE: &str = "Isostep";
/// The letters are Grbl's: V: variable spindle speed, N: line numbers, M: M7 works, Z: the position after homing reads
/// 0, H: homing of single axes, L: not locked at power-up. Then the numbers of blocks and bytes that a sender may rely
/// on.
const OPTIONS: &str = "[OPT:VNMZHL,79,128";

/// Texts of `[MSG:...]` that senders recognise.
pub mod messages {
    /// Sent after the welcome if the machine is locked.
    pub const HOW_TO_UNLOCK: &str = "'$H'|'$X' to unlock";
    /// Sent after the welcome if another console, or the board, has asked for the reset.
    pub const RESET_ELSEWHERE: &str = "Reset from elsewhere: all lines sent before are forgotten";
    /// Sent before the error of every line that was lost.
    pub const LINES_LOST: &str = "This line is lost, because more was sent ahead than the console keeps: \
        reset (ctrl-x), then send no more than Bf: says";
    /// `$X` has left Alarm.
    pub const UNLOCKED: &str = "Caution: Unlocked";
    /// `$X` or `$H` has not left Alarm.
    pub const DRIVE_IN_ALARM: &str = "a drive is in alarm, also after ENABLE was off: mend what its display says, or its wire ($744, $745), then $X again";
    /// A limit switch is pressed that should not be.
    pub const CHECK_LIMITS: &str = "Check Limits";
    /// The safety door is open but should be closed.
    pub const CHECK_DOOR: &str = "Check Door";
    /// M6 when T has named no tool.
    pub const CHANGE_TOOL: &str = "M6: change the tool, then resume with ~";
    /// `~` before the length of the new tool is known.
    pub const MEASURE_FIRST: &str =
        "M6: the tool was not measured ($TPW), nor Z set (G10 L20 P0 Z): ~ again goes on as before";
    /// A tool has been measured, and it is the one that others are compared with.
    pub const REFERENCE: &str = "This tool counts as of length 0 from now on";
    /// A tool was not measured.
    pub const PROBE_TOUCHES: &str = "The probe touches already: free it, check $6";
    /// A tool was not measured.
    pub const PROBE_MISSED: &str = "The probe met nothing within $342: jog nearer, or raise $342";
    /// M2 or M30.
    pub const PROGRAM_END: &str = "Pgm End";
    /// `$C` has begun to check G-code.
    pub const CHECKING: &str = "Enabled";
    /// `$C` has ended the check.
    pub const NOT_CHECKING: &str = "Disabled";
    /// `$RST=`.
    pub const RESTORING: &str = "Restoring defaults";
    /// `$SLP`.
    pub const SLEEPING: &str = "Sleeping";
    /// `$BOOT`, on a board: what its boot loader calls its USB drive.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct Booting<'n>(pub &'n str);

    impl core::fmt::Display for Booting<'_> {
        fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
            let Self(drive) = self;
            write!(f, "The board becomes the USB drive {drive}: copy new firmware to it, or switch off and on")
        }
    }

    /// `$BOOT` where there is no boot loader.
    pub const NO_BOOT_LOADER: &str = "There is no boot loader here: $BOOT is for a board";
}

/// The reply to `$I`, before `ok`: Grbl's version and date, then our name or the user's text. With `is_extended` the first lines of
/// the reply to `$I+`: the options end with the numbers of axes and of tools in a table.
pub fn build(out: &mut impl Write, text: &str, is_extended: bool) -> Result {
    let name = if text.is_empty() { BUILD } else { text };
    write!(out, "[VER:1.1h.20190830:{name}]\r\n{OPTIONS}")?;
    if is_extended {
        write!(out, ",{AXES},0")?;
    }
    out.write_str("]\r\n")?;
    if is_extended || AXES != 3 {
        // As grblHAL says it; Grbl has three.
        out.write_str(match AXES {
            2 => "[AXS:2:XY]\r\n",
            3 => "[AXS:3:XYZ]\r\n",
            _ => "[AXS:4:XYZA]\r\n",
        })?;
    }
    if text.is_empty() { Ok(()) } else { message(out, BUILD) }
}

/// What `$I+` adds, as grblHAL prints it. The options are its words. ENUMS: there are [catalogues](crate::Catalogue). RT+: `?`, `!`
/// and `~` act wherever they stand. HOME: homing is switched on. SED: `$SED=n` is known. Others are not true here: TC and ES
/// promise its M61 and its letter E of `Pn:`, too.
pub fn extended_build(out: &mut impl Write, settings: &Settings) -> Result {
    let home = if settings.homing { ",HOME" } else { "" };
    write!(out, "[NEWOPT:ENUMS,RT+{home},SED]\r\n[FIRMWARE:{FIRMWARE}]\r\n[NVS STORAGE:FLASH]\r\n")
}

/// `error:N`.
pub fn error(out: &mut impl Write, error: Error) -> Result {
    write!(out, "error:{}\r\n", error.code())
}

/// `ok` or `error:N`: every line gets one of the two.
pub fn answer(out: &mut impl Write, answer: core::result::Result<(), Error>) -> Result {
    match answer {
        Ok(()) => out.write_str(OK),
        Err(refused) => error(out, refused),
    }
}

/// `ALARM:N`.
pub fn alarm(out: &mut impl Write, alarm: AlarmCode) -> Result {
    write!(out, "ALARM:{}\r\n", alarm.code())
}

/// `[MSG:...]` with one of [`messages`], an [`Error`], an [`AlarmCode`], a [`SettingError`](crate::SettingError), a
/// [`Refusal`](crate::Refusal) or another text. The text must not contain `ok`, `error` or `ALARM`: some senders take
/// every line with one of these in it as the answer to their own line.
pub fn message(out: &mut impl Write, text: impl core::fmt::Display) -> Result {
    write!(out, "[MSG:{text}]\r\n")
}

/// `[MSG:...]` with a text of the program's, as `(MSG, ...)`. Words that some senders take for an answer, wherever they
/// stand, have their letters in the other case: `book` is `boOK`.
pub fn program_message(out: &mut impl Write, text: &str) -> Result {
    message(out, ProgramText(text))
}

struct ProgramText<'t>(&'t str);

impl core::fmt::Display for ProgramText<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> Result {
        let mut left = self.0;
        while let Some(first) = left.chars().next() {
            let answer = [("ok", "OK"), ("error", "ERROR"), ("ALARM", "alarm")]
                .into_iter()
                .find(|(word, _)| left.starts_with(word));
            let length = match answer {
                Some((word, other)) => {
                    f.write_str(other)?;
                    word.len()
                }
                None => {
                    f.write_char(first)?;
                    first.len_utf8()
                }
            };
            left = &left[length..];
        }
        Ok(())
    }
}

/// The reply to `$$`, before `ok`: about 700 bytes. A caller with a smaller buffer prints it row by row with
/// [`setting`].
pub fn settings(out: &mut impl Write, settings: &Settings) -> Result {
    SETTING_TABLE.iter().try_for_each(|row| setting(out, row, settings))
}

/// The lines of one row of the table: one, or one for each axis; at most 64 bytes, and 86 with four axes.
pub fn setting(out: &mut impl Write, row: &crate::Setting, settings: &Settings) -> Result {
    row.print(out, settings)
}

/// The reply to `$SED=n`, before `ok`: a remark on a setting, which may have none.
pub fn description(out: &mut impl Write, number: u16) -> Result {
    let remark = find(number).map_or("", |(setting, _)| setting.remark());
    write!(out, "[SETTINGDESCR:{number}|{remark}]\r\n")
}

/// The reply to `$G`, before `ok`.
pub fn modal(out: &mut impl Write, interpreter: &Interpreter, settings: &Settings) -> Result {
    let inches = settings.report_inches;
    let modal = interpreter.modal();
    let ((motion, decimal), system, plane) =
        (modal.motion.number(), system_name(modal.system.into()), 17 + modal.plane);
    let units = 21 - u8::from(modal.inches);
    let distance = 90 + u8::from(modal.incremental);
    let feed_mode = 94 - u8::from(modal.inverse_time);
    let path = modal.path.word(settings.blend_deviation_mm);
    let retract = if modal.retracts_to_r { " G99" } else { "" };
    write!(out, "[GC:G{motion}{decimal} {system} G{plane} G{units} G{distance} G{feed_mode}{path}{retract}")?;
    write!(out, " M{}", modal.spindle as u8)?;
    let (feed, speed) = (Fixed::rate(modal.feed, inches), Fixed { value: modal.speed_rpm, decimals: 0 });
    write!(out, " {} T{} F{feed} S{speed}]\r\n", modal.coolant.word(), modal.tool)
}

/// Number of lines that [`parameter`] has.
pub const PARAMETERS: usize = PARAMETER_NAMES.len() + TOOLS + 2;
/// The systems, then other places.
const PARAMETER_NAMES: [&str; WORK_SYSTEMS + 3] =
    ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3", "G28", "G30", "G92"];

/// The code of a work coordinate system.
pub(crate) fn system_name(system: usize) -> &'static str {
    PARAMETER_NAMES[system]
}

/// Line `index`, below [`PARAMETERS`], of the reply to `$#`; nothing if there are fewer tools. `ok` follows the last one.
pub fn parameter(out: &mut impl Write, index: usize, interpreter: &Interpreter, settings: &Settings) -> Result {
    let Coordinates { work_offsets_pm, places_pm } = interpreter.coordinates();
    let coordinates_pm = work_offsets_pm.iter().chain(places_pm).copied();
    if let Some(name) = PARAMETER_NAMES.get(index) {
        write!(out, "[{name}:")?;
        write_coordinates(
            out,
            coordinates_pm.chain([interpreter.shift_pm()]).nth(index).unwrap_or_default(),
            settings,
        )?;
        return out.write_str("]\r\n");
    }
    let inches = settings.report_inches;
    match index - PARAMETER_NAMES.len() {
        TOOLS => write!(out, "[TLO:{}]\r\n", Coordinate { pm: interpreter.tool_length_pm(), inches }),
        place @ ..TOOLS => tool(out, place, interpreter, settings),
        _ => probed(out, interpreter, settings),
    }
}

/// `[T:n|x,y,z|radius]`, as grblHAL writes it, of the tool with the `place`-th number of the table.
fn tool(out: &mut impl Write, place: usize, interpreter: &Interpreter, settings: &Settings) -> Result {
    let tools = interpreter.tools();
    let mut in_order = core::iter::successors(tools.next_above(0), |tool| tools.next_above(tool.number));
    let Some(&ToolEntry { number, length_pm, radius_nm }) = in_order.nth(place) else { return Ok(()) };
    write!(out, "[T:{number}|")?;
    write_coordinates(out, core::array::from_fn(|axis| if axis == Z { length_pm } else { 0 }), settings)?;
    let radius = Coordinate { pm: i64::from(radius_nm) * NM_PM, inches: settings.report_inches };
    write!(out, "|{radius}]\r\n")
}

/// `[PRB:x,y,z:n]`: where the last probe ended, in machine coordinates, and 1 if its contact changed there. A line of
/// the reply to `$#`; also sent after each probe.
pub fn probed(out: &mut impl Write, interpreter: &Interpreter, settings: &Settings) -> Result {
    let (place_pm, touched) = interpreter.touched();
    out.write_str("[PRB:")?;
    write_coordinates(out, place_pm, settings)?;
    write!(out, ":{}]\r\n", u8::from(touched))
}

/// One line of the reply to `$N`, before `ok`.
pub fn startup(out: &mut impl Write, index: usize, line: &StoredLine) -> Result {
    write!(out, "$N{index}={line}\r\n")
}
