//! The command of a line, and the states in which a machine may be asked.

use core::fmt;

use crate::{AXES, AlarmCode, Arc, Catalogue, Error, PathControl};

/// A line that has been interpreted; it borrows texts from the line (`'l`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Command<'l> {
    /// G-code. An empty line, or one that is only `%`, is an empty block.
    Block(Block),
    /// `$J=`: begin a jog. The machine may refuse it with [`Error::TravelExceeded`].
    Jog(Jog),
    /// `$H`: home every axis. `$HX`, `$HY`, `$HZ`: home one.
    Home {
        /// Axis index; `None` for every axis.
        axis: Option<usize>,
    },
    /// `$BUZZ=`: move an axis back and forth, to check its wiring.
    Buzz {
        /// Axis index.
        axis: usize,
    },
    /// `$STALL=`: move an axis back and forth, and measure how near its motor is to a stall.
    #[cfg(feature = "trinamic")]
    MeasureStall {
        /// Axis index.
        axis: usize,
    },
    /// `$X`: leave Alarm without homing; does nothing in any other state.
    Unlock,
    /// `$TPW`: measure the tool below the spindle.
    MeasureTool,
    /// `$TLR`: the place of the last contact of the probe is that of a tool of length 0; without one, none is.
    SetToolReference,
    /// `$C`: begin to check G-code without moving. In [`ReportedState::Check`]: end the check by a reset.
    ToggleCheck,
    /// `$SLP`: sleep until a reset.
    Sleep,
    /// `$BOOT`: start the boot loader, if there is one, to load new firmware.
    Boot,
    /// `$PROVE`, on a board that measures itself: what it is asked for.
    Prove {
        /// The text behind `$PROVE`: nothing, or `=` and more.
        words: &'l str,
    },
    /// `$`: list the `$` commands.
    Help,
    /// `$$`: list the settings.
    ShowSettings,
    /// `$ES`, `$EG`, `$EE`, `$EA`: list what the numbers of settings, groups, errors or alarms mean.
    ShowCatalogue(Catalogue),
    /// `$SED=n`: remark on a setting.
    DescribeSetting {
        /// The number of a setting that there is.
        number: u16,
    },
    /// `$#`: list work offsets and stored positions.
    ShowParameters,
    /// `$VFD`: report what the spindle's VFD says.
    ShowVfd,
    /// M122, alone in a line: report what Trinamic drivers say.
    #[cfg(feature = "trinamic")]
    ShowDrivers,
    /// `$n=v`: change a setting, by [`Settings::with`](crate::Settings::with).
    SetSetting {
        /// The number after `$`.
        number: u16,
        /// The value, finite, not yet checked against the setting's range.
        value: f32,
    },
    /// `$RST=`: restore defaults, then reset. `*` also clears the text of `$I=`.
    Restore {
        /// Restore the settings: `$` and `*`.
        settings: bool,
        /// Restore the [`Parameters`](crate::Parameters): `#` and `*`.
        parameters: bool,
    },
    /// `$I`, `$I+`: report the build.
    ShowBuild {
        /// `$I+`: with what grblHAL adds.
        is_extended: bool,
    },
    /// `$I=`: store a text that `$I` reports.
    SetBuild {
        /// At most [`STORED_LINE_CHARS`](crate::parameters::STORED_LINE_CHARS) long; empty for none.
        text: &'l str,
    },
    /// `$G`: list the modal state.
    ShowModal,
    /// `$N`: list the start-up lines.
    ShowStartup,
    /// `$N0=`, `$N1=`: execute a block, then store its line, to be executed after every reset and homing.
    SetStartup {
        /// Index of the start-up line: 0 or 1.
        index: usize,
        /// The block; the interpreter has already taken over its modes and position.
        block: Block,
        /// Its line, at most [`STORED_LINE_CHARS`](crate::parameters::STORED_LINE_CHARS) long.
        line: &'l str,
    },
    /// `$En`: explain `error:n`.
    ExplainError(Error),
    /// `$An`: explain `ALARM:n`.
    ExplainAlarm(AlarmCode),
}

/// The effect of one line of G-code. The machine acts on the fields in their order.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Block {
    /// N; 0 without one.
    pub line_number: u32,
    /// M6: before anything else, hold until a resume, so that this tool can be put in; 0 if no tool was named. `None` also
    /// if it is in the spindle already, and if `$341` says that nothing waits.
    pub tool_change: Option<u32>,
    /// M3, M4 or M5 changed the spindle's state; the new one is in the modal state.
    pub switches_spindle: bool,
    /// S changed; the new value is in the modal state, in rpm.
    pub changes_speed: bool,
    /// M7, M8 or M9 changed the coolant; the new state is in the modal state.
    pub switches_coolant: bool,
    /// G4: dwell for this time, 0 s or more.
    pub dwell_s: Option<f32>,
    /// G28, G30 with axis words: first a rapid to this point.
    pub via_pm: Option<[i64; AXES]>,
    /// The move of G0 to G3, G28 or G30.
    pub motion: Option<BlockMove>,
    /// A canned cycle: holes instead of a move, [`Interpreter::cycle`](crate::Interpreter::cycle).
    pub drills: bool,
    /// G38.2 to G38.5: a probe instead of a move.
    pub probe: Option<Probe>,
    /// M0: when the block is done, hold until a resume. Not set if M6 has held already and nothing else was done.
    pub pauses: bool,
    /// G10, G28.1, G30.1: work offsets, stored positions or tools have changed.
    pub changes_parameters: bool,
    /// M2, M30: the program ends (`[MSG:Pgm End]`); the modal state has already been reset to its defaults.
    pub ends_program: bool,
}

/// A move, straight or along an arc. Targets are machine coordinates, in [picometres](crate::length), and within
/// [`MAX_COORDINATE_PM`](crate::MAX_COORDINATE_PM) of zero, and so is every point of an arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlockMove {
    /// End position of every axis.
    pub target_pm: [i64; AXES],
    /// Its speed.
    pub rate: Rate,
    /// The path, if it is not straight.
    pub arc: Option<Arc>,
    /// The path control: how it follows the move before it, and whether it ends in a stop, whatever follows.
    pub path: PathControl,
}

/// A straight probing move at the feed. It ends where the probe's contact changes, or at the target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Probe {
    /// End position of every axis if the contact does not change, in machine coordinates; never equal to the start.
    pub target_pm: [i64; AXES],
    /// Feed along the path; at least [`MIN_FEED_MM_MIN`](crate::MIN_FEED_MM_MIN).
    pub mm_min: f32,
    /// G38.4, G38.5: probe until the contact opens; otherwise until it closes.
    pub away: bool,
    /// G38.2, G38.4: raise an alarm if the contact does not change.
    pub must: bool,
}

/// The speed of a move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rate {
    /// As fast as the axes allow.
    Rapid,
    /// Feed along the path, limited to what the axes allow.
    Feed {
        /// At least [`MIN_FEED_MM_MIN`](crate::MIN_FEED_MM_MIN).
        mm_min: f32,
    },
}

/// A straight move that a jog cancel may end, and that overrides do not affect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jog {
    /// End position of every axis, in machine coordinates.
    pub target_pm: [i64; AXES],
    /// Feed along the path; at least [`MIN_FEED_MM_MIN`](crate::MIN_FEED_MM_MIN).
    pub mm_min: f32,
}

/// Progress of the stop and resume after the safety door was opened. The values are the numbers in a status report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum DoorPhase {
    /// At rest and the door is closed again: ready to resume.
    Closed = 0,
    /// At rest and the door is open.
    Open = 1,
    /// Braking, or switching the outputs off.
    Stopping = 2,
    /// The door is closed and the machine resumes: the spindle is spinning up.
    Resuming = 3,
}

/// The machine's state, as a status report names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReportedState {
    /// At rest, ready.
    Idle,
    /// Moving, or dwelling.
    Run,
    /// Held, or still braking for the hold.
    Hold {
        /// The machine is not at rest yet.
        stopping: bool,
    },
    /// The safety door was opened: held as by a feed hold, with spindle and coolant off.
    Door(DoorPhase),
    /// Jogging.
    Jog,
    /// Homing.
    Home,
    /// Locked until homed or unlocked.
    Alarm,
    /// At rest; G-code is checked and moves nothing.
    Check,
    /// At rest until a reset.
    Sleep,
    /// At rest in a change of the tool: jogs and lines by hand are taken, and `~` goes on with the program.
    Tool,
}

impl ReportedState {
    /// Every state, with each of its details.
    pub const ALL: [Self; 14] = [
        Self::Idle,
        Self::Run,
        Self::Hold { stopping: false },
        Self::Hold { stopping: true },
        Self::Door(DoorPhase::Closed),
        Self::Door(DoorPhase::Open),
        Self::Door(DoorPhase::Stopping),
        Self::Door(DoorPhase::Resuming),
        Self::Jog,
        Self::Home,
        Self::Alarm,
        Self::Check,
        Self::Sleep,
        Self::Tool,
    ];

    /// True if nothing moves and no motion is waiting.
    pub const fn at_rest(self) -> bool {
        matches!(self, Self::Idle | Self::Alarm | Self::Check | Self::Sleep | Self::Tool)
    }

    /// Success if the machine accepts G-code. That is queued behind a move, but not behind homing, which changes the meaning
    /// of coordinates.
    ///
    /// # Errors
    /// [`Error::NotIdle`], or [`Error::Locked`] in Alarm and while jogging.
    pub const fn takes_gcode(self) -> Result<(), Error> {
        match self {
            Self::Idle | Self::Run | Self::Hold { .. } | Self::Door(_) | Self::Check | Self::Tool => Ok(()),
            Self::Home | Self::Sleep => Err(Error::NotIdle),
            Self::Alarm | Self::Jog => Err(Error::Locked),
        }
    }
}

impl fmt::Display for ReportedState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Idle => "Idle",
            Self::Run => "Run",
            Self::Hold { stopping: false } => "Hold:0",
            Self::Hold { stopping: true } => "Hold:1",
            Self::Door(DoorPhase::Closed) => "Door:0",
            Self::Door(DoorPhase::Open) => "Door:1",
            Self::Door(DoorPhase::Stopping) => "Door:2",
            Self::Door(DoorPhase::Resuming) => "Door:3",
            Self::Jog => "Jog",
            Self::Home => "Home",
            Self::Alarm => "Alarm",
            Self::Check => "Check",
            Self::Sleep => "Sleep",
            Self::Tool => "Tool",
        })
    }
}
