//! What a line asks for, and when the machine may be asked.

use core::fmt;

use crate::{AXES, Error, Settings};

/// A line, understood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Command {
    /// G-code; an empty line is an empty block.
    Block(Block),
    /// `$H`: home every axis.
    Home,
    /// `$X`: leave Alarm without homing; nothing to do in any other state.
    Unlock,
    /// `$`: list the `$` commands.
    Help,
    /// `$$`: list the settings.
    ShowSettings,
    /// `$n=v`: change a setting, by [`Settings::with`].
    SetSetting {
        /// The number after `$`.
        number: u16,
        /// The value, finite, not yet checked against the setting's range.
        value: f32,
    },
    /// `$I`: name the build.
    ShowBuild,
    /// `$G`: list the modal state.
    ShowModal,
}

/// What one line of G-code does, in the order of the fields.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Block {
    /// G4: wait this long, 0 s or more.
    pub dwell_s: Option<f32>,
    /// G0, G1, G28.
    pub motion: Option<Motion>,
    /// M2, M30: the program is over (`[MSG:Pgm End]`); the modal state is already back to its defaults.
    pub ends_program: bool,
}

/// A straight move, or the way to the origin. Targets are machine coordinates, each finite and within
/// [`MAX_COORDINATE_MM`](crate::MAX_COORDINATE_MM) of zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// G0, G1.
    Move {
        /// Where every axis ends.
        target_mm: [f32; AXES],
        /// How fast.
        rate: Rate,
    },
    /// G28: rapid to `via_mm`, if given, then rapid to `target_mm`.
    GoHome {
        /// The intermediate point, if the block had axis words.
        via_mm: Option<[f32; AXES]>,
        /// The origin; with axis words, only for the axes named: the others stay.
        target_mm: [f32; AXES],
    },
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

/// The machine's state, as a status report names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// At rest, ready.
    Idle,
    /// Moving, or dwelling.
    Run,
    /// Homing.
    Home,
    /// Locked until homed or unlocked.
    Alarm,
}

impl State {
    /// Idle and Alarm: nothing moves.
    pub const fn at_rest(self) -> bool {
        matches!(self, Self::Idle | Self::Alarm)
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Idle => "Idle",
            Self::Run => "Run",
            Self::Home => "Home",
            Self::Alarm => "Alarm",
        })
    }
}

impl Command {
    /// Whether the machine may be asked for this in `state`; [`Interpreter`](crate::Interpreter) has asked
    /// already, a caller that queues commands may ask again.
    ///
    /// # Errors
    /// [`Error::NotIdle`], [`Error::Locked`] for G-code in Alarm, [`Error::HomingDisabled`] for `$H`.
    pub fn allowed(&self, state: State, settings: &Settings) -> Result<(), Error> {
        match self {
            Self::Block(block) if *block == Block::default() => Ok(()),
            Self::Block(_) => gcode_allowed(state),
            Self::Help | Self::ShowModal | Self::Unlock => Ok(()),
            Self::Home if !settings.homing => Err(Error::HomingDisabled),
            Self::Home | Self::ShowSettings | Self::ShowBuild | Self::SetSetting { .. } => {
                if state.at_rest() {
                    Ok(())
                } else {
                    Err(Error::NotIdle)
                }
            }
        }
    }
}

/// G-code queues up behind a move, but not behind homing, which changes what its coordinates mean.
pub(crate) const fn gcode_allowed(state: State) -> Result<(), Error> {
    match state {
        State::Idle | State::Run => Ok(()),
        State::Home => Err(Error::NotIdle),
        State::Alarm => Err(Error::Locked),
    }
}
