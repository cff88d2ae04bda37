//! One block of G-code. Sorts its words by modal group and by letter, and refuses conflicts, in Grbl's order of
//! checking.

use crate::{
    AXES, Error, Modal,
    axes::{A, Z, of_each},
    length,
    modal::{Coolant, MotionMode, PathControl, SpindleMode},
    rotary::Rotary,
    words::{self, Word},
};

/// Letters that Grbl reads as values, apart from lengths. Those that no code of the block uses end as [`Error::UnusedWords`].
const VALUE_LETTERS: u32 = letters(b"FHLNPST");
const AXIS_LETTERS: u32 = letters(AXES_BYTES.as_slice());
/// The letters of the axes.
const AXES_BYTES: [u8; AXES] = of_each(*b"XYZA");
const OFFSET_LETTERS: u32 = letters(b"IJK");
/// Letters whose value must not be negative.
const UNSIGNED_LETTERS: u32 = letters(b"FHNPST");
/// The number of letters that give a length: I, J, K, Q and R, and those of the axes.
const LENGTHS: usize = 5 + AXES;
const MAX_LINE_NUMBER: f32 = 10_000_000.0;
/// The highest number of a tool, in T and wherever a tool is named.
pub(crate) const MAX_TOOL: f32 = 99_999.0;

/// A set of letters, one bit for each.
const fn letters(mut those: &[u8]) -> u32 {
    let mut set = 0;
    while let [letter, others @ ..] = those {
        set |= bit(*letter);
        those = others;
    }
    set
}

const fn bit(letter: u8) -> u32 {
    1 << (letter - b'A')
}

/// Modal groups, named as in RS274/NGC. A block may have at most one code of each group.
#[derive(Clone, Copy)]
enum ModalGroup {
    NonModal,
    Motion,
    /// G80, which may stand beside a code of the group before: that one is in force then.
    MotionEnd,
    Plane,
    Distance,
    ArcDistance,
    FeedMode,
    Units,
    CutterCompensation,
    Scaling,
    Rotation,
    ToolLength,
    CoordinateSystem,
    PathControl,
    Retract,
    ProgramFlow,
    ToolChange,
    Spindle,
    Coolant,
}

impl ModalGroup {
    const fn bit(self) -> u32 {
        1 << self as u32
    }
}

/// The groups that a jog may use. Of group 0 it may only use G53.
const JOG_GROUPS: u32 = ModalGroup::NonModal.bit() | ModalGroup::Distance.bit() | ModalGroup::Units.bit();

/// A code of group 0: it acts once and changes no mode. The `usize` is 0 for G28 and 1 for G30.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NonModal {
    /// G4.
    Dwell,
    /// G10.
    Set,
    /// G28, G30.
    GoTo(usize),
    /// G28.1, G30.1.
    Keep(usize),
    /// G53.
    MachineCoordinates,
    /// G92.
    Shift,
    /// G92.1.
    Unshift,
}

/// The purpose of the axis words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum AxisCommand {
    /// G10, G28, G30, G92.
    NonModal,
    /// The motion mode in force.
    Motion,
    /// G43.1.
    ToolLength,
}

/// The length of a tool that comes into force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ToolLength {
    /// G43: that of tool H, or of the tool in the spindle.
    OfTool,
    /// G43.1: that of the Z word.
    Given,
    /// G43.2: that of tool H, beside the one in force.
    Added,
    /// G49: none.
    Zero,
}

/// The words of a block, each letter at most once.
#[derive(Debug)]
pub(crate) struct BlockWords {
    claimed_groups: u32,
    /// The letters that were given a value which has not been used yet.
    given: u32,
    values: [f32; 26],
    /// The values that are lengths, in 10^-8 mm or inch (or degrees), by [`length_index`].
    lengths: [i64; LENGTHS],
    /// The meaning of A.
    pub(crate) rotary: Rotary,
    /// The modes in force in the block: those before it, changed by its own codes.
    pub(crate) modal: Modal,
    pub(crate) non_modal: Option<NonModal>,
    pub(crate) axis_command: Option<AxisCommand>,
    /// G43 to G43.2 or G49.
    pub(crate) tool_length: Option<ToolLength>,
    /// G64, which may have a P word, and then a Q word.
    pub(crate) blends: bool,
    /// M6.
    pub(crate) changes_tool: bool,
    /// M0.
    pub(crate) pauses: bool,
    /// M2, M30.
    pub(crate) ends_program: bool,
}

impl BlockWords {
    /// No words, in these modes.
    pub(crate) fn new(modal: Modal, rotary: Rotary) -> Self {
        Self {
            claimed_groups: 0,
            given: 0,
            values: [0.0; 26],
            lengths: [0; LENGTHS],
            rotary,
            modal,
            non_modal: None,
            axis_command: None,
            tool_length: None,
            blends: false,
            changes_tool: false,
            pauses: false,
            ends_program: false,
        }
    }

    /// Reads a line. If it fails, `line` is left at the word that caused the error.
    // Not part of `new`: a returned value would be copied on every line.
    pub(crate) fn read(&mut self, line: &mut &[u8]) -> Result<(), Error> {
        words::for_each(line, |word| match word {
            Word::G(hundredths) => self.general(hundredths),
            Word::M(hundredths) => self.miscellaneous(hundredths),
            Word::Length(letter, value) => self.length(letter, value),
            Word::Value(letter, value) => self.value(letter, value),
        })?;
        // Axis words without a code that uses them belong to the motion mode, and so does the centre of an arc.
        if self.has_axes() || self.modal.motion.is_arc() && self.has_offsets() {
            self.axis_command.get_or_insert(AxisCommand::Motion);
        }
        Ok(())
    }

    /// The value of `letter`, which then counts as used. The letter gives no length.
    pub(crate) fn take(&mut self, letter: u8) -> Option<f32> {
        self.use_up(letter).then(|| self.values[usize::from(letter - b'A')])
    }

    /// Notes that a letter is used. Returns whether it was given, and not used before.
    pub(crate) fn use_up(&mut self, letter: u8) -> bool {
        let was_given = self.given & bit(letter) != 0;
        self.given &= !bit(letter);
        was_given
    }

    /// The length that `letter` gives, by the units in force in the block.
    fn length_pm(&self, letter: u8) -> Option<i64> {
        let value = (self.given & bit(letter) != 0).then(|| self.lengths[length_index(letter)]);
        let is_in_inches = self.modal.inches && !(AXES > A && letter == b'A' && self.rotary.is_on);
        value.map(|value| length::of_word(value, is_in_inches))
    }

    /// The axes as given.
    pub(crate) fn axes_pm(&self) -> [Option<i64>; AXES] {
        core::array::from_fn(|axis| self.length_pm(AXES_BYTES[axis]))
    }

    /// The length that `letter` gives, which then counts as used.
    pub(crate) fn take_length_pm(&mut self, letter: u8) -> Option<i64> {
        let length_pm = self.length_pm(letter);
        self.use_up(letter);
        length_pm
    }

    pub(crate) fn has_radius(&self) -> bool {
        self.given & bit(b'R') != 0
    }

    /// I, J and K, which then count as used.
    pub(crate) fn take_offsets_pm(&mut self) -> [Option<i64>; 3] {
        let offsets_pm = b"IJK".map(|letter| self.length_pm(letter));
        b"IJK".iter().for_each(|&letter| _ = self.use_up(letter));
        offsets_pm
    }

    /// True if there is I, J or K.
    pub(crate) fn has_offsets(&self) -> bool {
        self.given & OFFSET_LETTERS != 0
    }

    pub(crate) fn has_axes(&self) -> bool {
        self.given & AXIS_LETTERS != 0
    }

    /// The line number, 0 without one.
    ///
    /// # Errors
    /// [`Error::BadLineNumber`].
    pub(crate) fn line_number(&mut self) -> Result<u32, Error> {
        match self.take(b'N') {
            None => Ok(0),
            Some(number) if number > MAX_LINE_NUMBER => Err(Error::BadLineNumber),
            Some(number) => Ok(number as u32),
        }
    }

    /// Refuses the block unless all its values except the axes have been used.
    pub(crate) fn check_all_used(&self) -> Result<(), Error> {
        if self.unused().is_none() { Ok(()) } else { Err(Error::UnusedWords) }
    }

    /// A letter that no code has used, other than those of the axes.
    pub(crate) fn unused(&self) -> Option<u8> {
        let unused = self.given & !AXIS_LETTERS;
        (unused != 0).then(|| b'A' + unused.trailing_zeros() as u8)
    }

    /// True if all codes of the block are allowed in a jog.
    pub(crate) fn may_jog(&self) -> bool {
        self.claimed_groups & !JOG_GROUPS == 0 && matches!(self.non_modal, None | Some(NonModal::MachineCoordinates))
    }

    /// The codes of moves; [`mode`](Self::mode) has the others.
    #[rustfmt::skip]
    fn general(&mut self, hundredths: u32) -> Result<(), Error> {
        let group = match hundredths {
            0 => self.motion(MotionMode::Rapid)?,
            100 => self.motion(MotionMode::Linear)?,
            200 => self.motion(MotionMode::ClockwiseArc)?,
            300 => self.motion(MotionMode::CounterClockwiseArc)?,
            9000 | 9100 => { self.modal.incremental = hundredths == 9100; ModalGroup::Distance }
            _ => self.mode(hundredths)?,
        };
        self.claim(group)
    }

    /// The other codes. They are seldom, so on a chip this may lie in slow memory.
    #[cold]
    #[inline(never)]
    #[rustfmt::skip]
    fn mode(&mut self, hundredths: u32) -> Result<ModalGroup, Error> {
        let modal = &mut self.modal;
        let code = hundredths / 100;
        Ok(match hundredths {
            3820 => self.motion(MotionMode::ProbeToward)?,
            3830 => self.motion(MotionMode::ProbeTowardIfAny)?,
            3840 => self.motion(MotionMode::ProbeAway)?,
            3850 => self.motion(MotionMode::ProbeAwayIfAny)?,
            400 => self.non_modal(NonModal::Dwell),
            1000 => self.non_modal_with_axes(NonModal::Set)?,
            1800 | 1900 | 4300..=4320 if AXES <= Z => return Err(Error::Unsupported),
            1700 | 1800 | 1900 => { modal.plane = code as u8 - 17; ModalGroup::Plane }
            // G70 and G71 are what some controls write for G20 and G21.
            2000 | 2100 | 7000 | 7100 => { modal.inches = matches!(code, 20 | 70); ModalGroup::Units }
            2800 | 3000 => self.non_modal_with_axes(NonModal::GoTo(usize::from(code == 30)))?,
            2810 | 3010 => self.non_modal(NonModal::Keep(usize::from(code == 30))),
            4000 => ModalGroup::CutterCompensation,
            // No scaling, no rotation: there is neither here.
            5000 => ModalGroup::Scaling,
            6900 => ModalGroup::Rotation,
            4300 | 4310 | 4320 | 4900 if AXES > Z => {
                let length = match hundredths {
                    4300 => ToolLength::OfTool,
                    4310 => ToolLength::Given,
                    4320 => ToolLength::Added,
                    _ => ToolLength::Zero,
                };
                if length == ToolLength::Given {
                    self.claim_axes(AxisCommand::ToolLength)?;
                }
                self.tool_length = Some(length);
                ModalGroup::ToolLength
            }
            4900 => ModalGroup::ToolLength,
            5300 => self.non_modal(NonModal::MachineCoordinates),
            5400 | 5500 | 5600 | 5700 | 5800 | 5900 => { modal.system = code as u8 - 54; ModalGroup::CoordinateSystem }
            5910 | 5920 | 5930 => { modal.system = 5 + (hundredths % 100 / 10) as u8; ModalGroup::CoordinateSystem }
            6100 | 6110 | 6400 => {
                modal.path = match hundredths {
                    6100 => PathControl::Exact,
                    6110 => PathControl::Stop,
                    _ => PathControl::Blend,
                };
                self.blends = code == 64;
                ModalGroup::PathControl
            }
            7300 | 8100 | 8200 | 8300 | 8500 | 8600 | 8900 if AXES > Z => self.motion(match code {
                73 => MotionMode::BreakChips,
                81 => MotionMode::Drill,
                82 => MotionMode::DrillDwell,
                83 => MotionMode::Peck,
                85 => MotionMode::Bore,
                86 => MotionMode::BoreStop,
                _ => MotionMode::BoreDwell,
            })?,
            9800 | 9900 => { modal.retracts_to_r = code == 99; ModalGroup::Retract }
            8000 => {
                if self.claimed_groups & ModalGroup::Motion.bit() == 0 {
                    modal.motion = MotionMode::Cancelled;
                }
                ModalGroup::MotionEnd
            }
            9110 => ModalGroup::ArcDistance,
            9200 => self.non_modal_with_axes(NonModal::Shift)?,
            9210 => self.non_modal(NonModal::Unshift),
            9300 | 9400 => { modal.inverse_time = code == 93; ModalGroup::FeedMode }
            _ if matches!(code, 0..=4 | 10 | 17..=21 | 40 | 43 | 50 | 69..=71 | 49 | 53..=59 | 80 | 93 | 94) => {
                return Err(Error::IntegerRequired);
            }
            _ => return Err(Error::Unsupported),
        })
    }

    /// M1, the optional stop, is accepted and does nothing.
    #[rustfmt::skip]
    fn miscellaneous(&mut self, hundredths: u32) -> Result<(), Error> {
        let modal = &mut self.modal;
        let group = match hundredths {
            _ if !hundredths.is_multiple_of(100) => return Err(Error::IntegerRequired),
            0 => { self.pauses = true; ModalGroup::ProgramFlow }
            100 => ModalGroup::ProgramFlow,
            200 | 3000 => { self.ends_program = true; ModalGroup::ProgramFlow }
            300 => { modal.spindle = SpindleMode::Clockwise; ModalGroup::Spindle }
            400 => { modal.spindle = SpindleMode::CounterClockwise; ModalGroup::Spindle }
            500 => { modal.spindle = SpindleMode::Off; ModalGroup::Spindle }
            600 => { self.changes_tool = true; ModalGroup::ToolChange }
            700 => { modal.coolant = modal.coolant.and(Coolant::Mist); ModalGroup::Coolant }
            800 => { modal.coolant = modal.coolant.and(Coolant::Flood); ModalGroup::Coolant }
            900 => { modal.coolant = Coolant::Off; ModalGroup::Coolant }
            _ => return Err(Error::Unsupported),
        };
        self.claim(group)
    }

    fn motion(&mut self, mode: MotionMode) -> Result<ModalGroup, Error> {
        // Beside G28 or G30, G0 and G1 are modes that stay, and the axis words are those of G28 or G30.
        if !(mode.is_straight() && matches!(self.non_modal, Some(NonModal::GoTo(_)))) {
            self.claim_axes(AxisCommand::Motion)?;
        }
        self.modal.motion = mode;
        Ok(ModalGroup::Motion)
    }

    fn non_modal(&mut self, code: NonModal) -> ModalGroup {
        self.non_modal = Some(code);
        ModalGroup::NonModal
    }

    fn non_modal_with_axes(&mut self, code: NonModal) -> Result<ModalGroup, Error> {
        if matches!(code, NonModal::GoTo(_)) && self.modal.motion.is_straight() {
            self.axis_command.take_if(|command| *command == AxisCommand::Motion);
        }
        self.claim_axes(AxisCommand::NonModal)?;
        Ok(self.non_modal(code))
    }

    fn claim_axes(&mut self, command: AxisCommand) -> Result<(), Error> {
        match self.axis_command.replace(command) {
            Some(_) => Err(Error::AxisConflict),
            None => Ok(()),
        }
    }

    fn claim(&mut self, group: ModalGroup) -> Result<(), Error> {
        if self.claimed_groups & group.bit() != 0 {
            return Err(Error::ModalClash);
        }
        self.claimed_groups |= group.bit();
        Ok(())
    }

    fn value(&mut self, letter: u8, value: f32) -> Result<(), Error> {
        let bit = bit(letter);
        if VALUE_LETTERS & bit == 0 {
            return Err(Error::Unsupported);
        }
        if matches!(letter, b'H' | b'T') && value > MAX_TOOL {
            return Err(Error::ToolNumber);
        }
        self.give(bit)?;
        self.values[usize::from(letter - b'A')] = value;
        if UNSIGNED_LETTERS & bit != 0 && value < 0.0 { Err(Error::Negative) } else { Ok(()) }
    }

    fn length(&mut self, letter: u8, value: i64) -> Result<(), Error> {
        self.give(bit(letter))?;
        self.lengths[length_index(letter)] = value;
        Ok(())
    }

    fn give(&mut self, bit: u32) -> Result<(), Error> {
        if self.given & bit != 0 {
            return Err(Error::RepeatedWord);
        }
        self.given |= bit;
        Ok(())
    }
}

/// The place where the value of a letter that gives a length is kept.
const fn length_index(letter: u8) -> usize {
    match letter {
        b'I'..=b'K' => (letter - b'I') as usize,
        b'Q' | b'R' => (letter - b'Q') as usize + 3,
        b'X'..=b'Z' => 5 + (letter - b'X') as usize,
        _ => LENGTHS - 1,
    }
}
