//! What a line asks for, and the states that a machine may be asked in.

use core::fmt;

use crate::{AXES, Alarm, Arc, Error};

/// A line, understood; `'l` is the line's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Command<'l> {
    /// G-code; an empty line is an empty block, and so is one that is only `%`.
    Block(Block),
    /// `$J=`: begin a jog, or [`Error::TravelExceeded`].
    Jog(Jog),
    /// `$H`: home every axis. `$HX`, `$HY`, `$HZ`: home one.
    Home {
        /// Its index; none for every axis.
        axis: Option<usize>,
    },
    /// `$BUZZ=`: move an axis to and fro, to see that it is wired well.
    Buzz {
        /// Its index.
        axis: usize,
    },
    /// `$X`: leave Alarm without homing; nothing to do in any other state.
    Unlock,
    /// `$C`: begin to check G-code without moving, or, in [`ReportedState::Check`], end that by a reset.
    ToggleCheck,
    /// `$SLP`: sleep until a reset.
    Sleep,
    /// `$BOOT`: make way for new firmware, if there is a boot loader.
    Boot,
    /// `$`: list the `$` commands.
    Help,
    /// `$$`: list the settings.
    ShowSettings,
    /// `$#`: list offsets and places.
    ShowParameters,
    /// `$n=v`: change a setting, by [`Settings::with`](crate::Settings::with).
    SetSetting {
        /// The number after `$`.
        number: u16,
        /// The value, finite, not yet checked against the setting's range.
        value: f32,
    },
    /// `$RST=`: put back defaults, and reset. `*` forgets the text of `$I=`, too.
    Restore {
        /// `$` and `*`: the settings.
        settings: bool,
        /// `#` and `*`: the [`Parameters`](crate::Parameters).
        parameters: bool,
    },
    /// `$I`: name the build.
    ShowBuild,
    /// `$I=`: keep a text for `$I` to tell.
    SetBuild {
        /// At most [`STORED_LINE_CHARS`](crate::parameters::STORED_LINE_CHARS) long; empty for none.
        text: &'l str,
    },
    /// `$G`: list the modal state.
    ShowModal,
    /// `$N`: list the start-up lines.
    ShowStartup,
    /// `$N0=`, `$N1=`: carry out a block, then keep its line to be carried out after every reset and homing.
    SetStartup {
        /// Which of them.
        index: usize,
        /// The block; the interpreter is there already.
        block: Block,
        /// Its line, at most [`STORED_LINE_CHARS`](crate::parameters::STORED_LINE_CHARS) long.
        line: &'l str,
    },
    /// `$En`: say what `error:n` means.
    ExplainError(Error),
    /// `$An`: say what `ALARM:n` means.
    ExplainAlarm(Alarm),
}

/// What one line of G-code does, in the order of the fields.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Block {
    /// N; 0 without one.
    pub line_number: u32,
    /// M6: first of all hold until a resume, for this tool to be put in; 0 where none was named.
    pub tool_change: Option<u8>,
    /// M3, M4 or M5 other than in force before the line: the modal state tells which.
    pub switches_spindle: bool,
    /// S other than in force before the line: the modal state tells it, in rpm.
    pub changes_speed: bool,
    /// M7, M8 or M9 that change what was in force before the line: the modal state tells what is on.
    pub switches_coolant: bool,
    /// G4: wait this long, 0 s or more.
    pub dwell_s: Option<f32>,
    /// G28, G30 with axis words: rapid there first.
    pub via_mm: Option<[f32; AXES]>,
    /// G0 to G3, G28, G30.
    pub motion: Option<Move>,
    /// G38.2 to G38.5: probe, in place of a motion.
    pub probe: Option<Probe>,
    /// M0: when all this is done, hold until a resume; not a second time where M6 is all that was done.
    pub pauses: bool,
    /// G10, G28.1, G30.1: work offsets or places are others than before it.
    pub changes_coordinates: bool,
    /// M2, M30: the program is over (`[MSG:Pgm End]`); the modal state is already back to its defaults.
    pub ends_program: bool,
}

/// A move, straight or along an arc. Targets are machine coordinates, each finite and within
/// [`MAX_COORDINATE_MM`](crate::MAX_COORDINATE_MM) of zero, as is all of an arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Move {
    /// Where every axis ends.
    pub target_mm: [f32; AXES],
    /// How fast.
    pub rate: Rate,
    /// The way there, if it is not straight.
    pub arc: Option<Arc>,
    /// G61.1: it ends in a stop, whatever comes next. G61 and G64: it does not.
    pub exact_stop: bool,
}

/// A straight way at the feed that ends where the probe's contact changes, or at the target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Probe {
    /// Where every axis ends if the contact does not change, in machine coordinates; never where it begins.
    pub target_mm: [f32; AXES],
    /// Along the path; at least [`MIN_FEED_MM_MIN`](crate::MIN_FEED_MM_MIN).
    pub mm_min: f32,
    /// G38.4, G38.5: until the contact opens rather than closes.
    pub away: bool,
    /// G38.2, G38.4: no change of the contact on the way is an alarm.
    pub must: bool,
}

/// The speed of a move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rate {
    /// As fast as the axes allow.
    Rapid,
    /// Along the path, but no faster than the axes allow.
    Feed {
        /// At least [`MIN_FEED_MM_MIN`](crate::MIN_FEED_MM_MIN).
        mm_min: f32,
    },
}

/// A straight move that a jog cancel may end, and that no override touches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jog {
    /// Where every axis ends, in machine coordinates.
    pub target_mm: [f32; AXES],
    /// Along the path; at least [`MIN_FEED_MM_MIN`](crate::MIN_FEED_MM_MIN).
    pub mm_min: f32,
}

/// How far a machine is whose safety door was opened; its value is the number that a status report gives it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Door {
    /// At rest, the door closed again: ready to resume.
    Closed = 0,
    /// At rest, the door open.
    Open = 1,
    /// Braking, or the outputs going off.
    Stopping = 2,
    /// The door closed and the machine resuming: the spindle is spinning up.
    Resuming = 3,
}

/// The machine's state, as a status report names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReportedState {
    /// At rest, ready.
    Idle,
    /// Moving, or dwelling.
    Run,
    /// Held, or still braking for that.
    Hold {
        /// Not at rest yet.
        stopping: bool,
    },
    /// Held as by a feed hold, spindle and coolant off: the safety door was opened.
    Door(Door),
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
}

impl ReportedState {
    /// Nothing moves and nothing waits to.
    pub const fn at_rest(self) -> bool {
        matches!(self, Self::Idle | Self::Alarm | Self::Check | Self::Sleep)
    }

    /// G-code queues up behind a move, but not behind homing, which changes what its coordinates mean.
    ///
    /// # Errors
    /// [`Error::NotIdle`], or [`Error::Locked`] in Alarm and while jogging.
    pub const fn takes_gcode(self) -> Result<(), Error> {
        match self {
            Self::Idle | Self::Run | Self::Hold { .. } | Self::Door(_) | Self::Check => Ok(()),
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
            Self::Door(Door::Closed) => "Door:0",
            Self::Door(Door::Open) => "Door:1",
            Self::Door(Door::Stopping) => "Door:2",
            Self::Door(Door::Resuming) => "Door:3",
            Self::Jog => "Jog",
            Self::Home => "Home",
            Self::Alarm => "Alarm",
            Self::Check => "Check",
            Self::Sleep => "Sleep",
        })
    }
}
