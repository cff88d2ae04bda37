//! One block of G-code: its words sorted by modal group and by letter, clashes refused.

use crate::{
    Error,
    modal::{Coolant, MotionMode, Spindle},
    words::{self, Word},
};

/// Letters that Grbl knows as values; those that no code here uses end as [`Error::UnusedWords`].
const VALUE_LETTERS: &[u8] = b"FIJKLNPRSTXYZ";
/// Letters whose value must not be negative.
const UNSIGNED_LETTERS: &[u8] = b"FNPST";
const MAX_LINE_NUMBER: f32 = 9_999_999.0;
const MAX_TOOL: f32 = 255.0;

/// Modal groups, by the names of RS274/NGC; at most one code of each may stand in a block.
#[derive(Clone, Copy)]
enum Group {
    NonModal,
    Motion,
    Plane,
    Distance,
    ArcDistance,
    FeedMode,
    Units,
    CutterCompensation,
    ToolLength,
    CoordinateSystem,
    PathControl,
    ProgramFlow,
    Spindle,
    Coolant,
}

/// A code of group 0: acts once, changes no mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NonModal {
    Dwell,
    GoHome,
}

/// The words of a block, each at most once.
#[derive(Debug, Default)]
pub(crate) struct Words {
    claimed_groups: u16,
    values: [Option<f32>; 26],
    pub(crate) non_modal: Option<NonModal>,
    pub(crate) motion: Option<MotionMode>,
    pub(crate) inches: Option<bool>,
    pub(crate) incremental: Option<bool>,
    pub(crate) spindle: Option<Spindle>,
    pub(crate) coolant: Option<Coolant>,
    pub(crate) ends_program: bool,
}

impl Words {
    pub(crate) fn read(line: &str) -> Result<Self, Error> {
        let mut block = Self::default();
        words::for_each(line, |word| match word {
            Word::G(tenths) => block.general(tenths),
            Word::M(tenths) if tenths % 10 != 0 => Err(Error::IntegerRequired),
            Word::M(tenths) => block.miscellaneous(tenths / 10),
            Word::Value(letter, value) => block.value(letter, value),
        })?;
        block.check_numbers()?;
        Ok(block)
    }

    /// The value of `letter`, which counts as used from now on.
    pub(crate) fn take(&mut self, letter: u8) -> Option<f32> {
        self.values[usize::from(letter - b'A')].take()
    }

    /// Takes X, Y and Z.
    pub(crate) fn take_axes(&mut self) -> [Option<f32>; 3] {
        [b'X', b'Y', b'Z'].map(|letter| self.take(letter))
    }

    /// Every value has been taken, or the block is refused.
    pub(crate) fn check_all_used(&self) -> Result<(), Error> {
        if self.values.iter().any(Option::is_some) { Err(Error::UnusedWords) } else { Ok(()) }
    }

    fn general(&mut self, tenths: u32) -> Result<(), Error> {
        let group = match tenths {
            0 => self.motion(MotionMode::Rapid)?,
            10 => self.motion(MotionMode::Linear)?,
            40 => self.non_modal(NonModal::Dwell)?,
            170 => Group::Plane,
            200 | 210 => {
                self.inches = Some(tenths == 200);
                Group::Units
            }
            280 => self.non_modal(NonModal::GoHome)?,
            400 => Group::CutterCompensation,
            490 => Group::ToolLength,
            540 => Group::CoordinateSystem,
            610 => Group::PathControl,
            800 => {
                self.motion = Some(MotionMode::Cancelled);
                Group::Motion
            }
            900 | 910 => {
                self.incremental = Some(tenths == 910);
                Group::Distance
            }
            911 => Group::ArcDistance,
            940 => Group::FeedMode,
            _ => return Err(Error::Unsupported),
        };
        self.claim(group)
    }

    /// M0 would have to stop until a resume, so it is refused rather than run past; M1 is optional and passes.
    fn miscellaneous(&mut self, number: u32) -> Result<(), Error> {
        let group = match number {
            1 => Group::ProgramFlow,
            2 | 30 => {
                self.ends_program = true;
                Group::ProgramFlow
            }
            3 => self.spindle(Spindle::Clockwise),
            4 => self.spindle(Spindle::CounterClockwise),
            5 => self.spindle(Spindle::Off),
            7 => self.coolant(Coolant::Mist),
            8 => self.coolant(Coolant::Flood),
            9 => self.coolant(Coolant::Off),
            _ => return Err(Error::Unsupported),
        };
        self.claim(group)
    }

    /// G0, G1 and G28 all want the axis words.
    fn motion(&mut self, mode: MotionMode) -> Result<Group, Error> {
        if self.non_modal == Some(NonModal::GoHome) {
            return Err(Error::AxisConflict);
        }
        self.motion = Some(mode);
        Ok(Group::Motion)
    }

    fn non_modal(&mut self, code: NonModal) -> Result<Group, Error> {
        if code == NonModal::GoHome && matches!(self.motion, Some(MotionMode::Rapid | MotionMode::Linear)) {
            return Err(Error::AxisConflict);
        }
        self.non_modal = Some(code);
        Ok(Group::NonModal)
    }

    fn spindle(&mut self, spindle: Spindle) -> Group {
        self.spindle = Some(spindle);
        Group::Spindle
    }

    fn coolant(&mut self, coolant: Coolant) -> Group {
        self.coolant = Some(coolant);
        Group::Coolant
    }

    fn claim(&mut self, group: Group) -> Result<(), Error> {
        let bit = 1 << group as u16;
        if self.claimed_groups & bit != 0 {
            return Err(Error::ModalClash);
        }
        self.claimed_groups |= bit;
        Ok(())
    }

    fn value(&mut self, letter: u8, value: f32) -> Result<(), Error> {
        if !VALUE_LETTERS.contains(&letter) {
            return Err(Error::Unsupported);
        }
        if UNSIGNED_LETTERS.contains(&letter) && value < 0.0 {
            return Err(Error::Negative);
        }
        match self.values[usize::from(letter - b'A')].replace(value) {
            Some(_) => Err(Error::RepeatedWord),
            None => Ok(()),
        }
    }

    /// The line number has no further use.
    fn check_numbers(&mut self) -> Result<(), Error> {
        if self.take(b'N').is_some_and(|number| number > MAX_LINE_NUMBER) {
            return Err(Error::BadLineNumber);
        }
        if self.values[usize::from(b'T' - b'A')].is_some_and(|tool| tool > MAX_TOOL) {
            return Err(Error::ToolNumber);
        }
        Ok(())
    }
}
