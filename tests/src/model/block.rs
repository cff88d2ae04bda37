//! A block of G-code: which of its words go together (Grbl's order of checking), and what they mean.

use super::modes::Modes;
use super::tools::NUMBER_MAX;
use super::words::{ONE, Word};

/// The most that a place or an offset may be away from zero.
const FARTHEST_ANGSTROM: i64 = 10_000 * ONE;

/// `error:N`.
pub type Refused = u8;

/// The code of a block that uses its axis words.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Axes {
    /// None, or there are none.
    Nobody,
    /// The motion mode.
    Motion,
    /// G10, G28, G30, G92.
    Once,
    /// G43.1.
    ToolLength,
}

/// The words of a block, sorted.
pub struct Block {
    /// The modes in force in the block.
    pub modes: Modes,
    /// The code that uses the axis words.
    pub axes: Axes,
    /// The code that acts once, tenths of its number: 40, 100, 280, 281, 300, 301, 530, 920, 921.
    pub once: Option<i64>,
    /// 430, 431, 432, 490.
    pub tool_length: Option<i64>,
    /// M6.
    pub changes_tool: bool,
    /// M0.
    pub pauses: bool,
    /// M2, M30.
    pub ends: bool,
    values: Vec<Word>,
    used: Vec<char>,
    groups: Vec<&'static str>,
}

impl Block {
    /// Sorts the words.
    ///
    /// # Errors
    /// The fault of the words, whatever the state of the machine.
    pub fn read(words: &[Word], modes: Modes) -> Result<Self, Refused> {
        let mut block = Self {
            modes,
            axes: Axes::Nobody,
            once: None,
            tool_length: None,
            changes_tool: false,
            pauses: false,
            ends: false,
            values: Vec::new(),
            used: Vec::new(),
            groups: Vec::new(),
        };
        for &word in words {
            match word.letter {
                'G' => block.general(word.tenths())?,
                'M' => block.miscellaneous(word.tenths() / 10)?,
                _ => block.value(word)?,
            }
        }
        let is_arc = matches!(block.modes.motion, 20 | 30);
        if block.axes == Axes::Nobody && (block.has("XYZ") || is_arc && block.has("IJK")) {
            block.axes = Axes::Motion;
        }
        Ok(block)
    }

    fn general(&mut self, tenths: i64) -> Result<(), Refused> {
        let group = match tenths {
            0 | 10 | 20 | 30 | 382..=385 | 730 | 810 | 820 | 830 | 850 | 860 | 890 => {
                // G0 and G1 may stand beside G28 and G30, which use the axis words.
                if !matches!((tenths, self.once), (0 | 10, Some(280 | 300))) {
                    self.claim(Axes::Motion)?;
                }
                self.modes.motion = tenths;
                "motion"
            }
            800 => {
                if !self.groups.contains(&"motion") {
                    self.modes.motion = 800;
                }
                "end of motion"
            }
            980 | 990 => {
                self.modes.leaves_at_r = tenths == 990;
                "retract"
            }
            100 | 280 | 300 | 920 => {
                if matches!((tenths, self.modes.motion), (280 | 300, 0 | 10)) && self.axes == Axes::Motion {
                    self.axes = Axes::Nobody;
                }
                self.claim(Axes::Once)?;
                self.once = Some(tenths);
                "once"
            }
            40 | 281 | 301 | 530 | 921 => {
                self.once = Some(tenths);
                "once"
            }
            430 | 431 | 432 | 490 => {
                if tenths == 431 {
                    self.claim(Axes::ToolLength)?;
                }
                self.tool_length = Some(tenths);
                "tool length"
            }
            170 | 180 | 190 => {
                self.modes.plane = tenths / 10;
                "plane"
            }
            200 | 210 | 700 | 710 => {
                self.modes.inches = matches!(tenths, 200 | 700);
                "units"
            }
            540 | 550 | 560 | 570 | 580 | 590 => {
                self.modes.system = (tenths / 10 - 54) as usize;
                "system"
            }
            591..=593 => {
                self.modes.system = (tenths - 585) as usize;
                "system"
            }
            541..=599 => return Err(23),
            610 | 611 | 640 => {
                (self.modes.exact_stop, self.modes.blends) = (tenths == 611, tenths == 640);
                "path"
            }
            900 | 910 => {
                self.modes.incremental = tenths == 910;
                "distance"
            }
            911 => "arc distance",
            930 | 940 => {
                self.modes.inverse_time = tenths == 930;
                "feed mode"
            }
            400 => "compensation",
            500 => "scaling",
            690 => "rotation",
            _ => return Err(20),
        };
        self.group(group)
    }

    fn miscellaneous(&mut self, number: i64) -> Result<(), Refused> {
        let group = match number {
            0..=2 | 30 => {
                self.pauses = number == 0;
                self.ends = matches!(number, 2 | 30);
                "program"
            }
            3..=5 => {
                self.modes.spindle = number;
                "spindle"
            }
            6 => {
                self.changes_tool = true;
                "tool"
            }
            7 | 8 => {
                self.modes.mist |= number == 7;
                self.modes.flood |= number == 8;
                "coolant"
            }
            9 => {
                (self.modes.mist, self.modes.flood) = (false, false);
                "coolant"
            }
            _ => return Err(20),
        };
        self.group(group)
    }

    fn value(&mut self, word: Word) -> Result<(), Refused> {
        match word {
            _ if !"FHIJKLNPQRSTXYZ".contains(word.letter) => Err(20),
            _ if "HLNT".contains(word.letter) && word.value % ONE != 0 => Err(23),
            Word { letter: 'H' | 'T', value } if value > NUMBER_MAX * ONE => Err(38),
            _ if self.get(word.letter).is_some() => Err(25),
            _ if "FHNPST".contains(word.letter) && word.value < 0 => Err(4),
            _ => {
                self.values.push(word);
                Ok(())
            }
        }
    }

    fn claim(&mut self, axes: Axes) -> Result<(), Refused> {
        if self.axes != Axes::Nobody {
            return Err(24);
        }
        self.axes = axes;
        Ok(())
    }

    fn group(&mut self, group: &'static str) -> Result<(), Refused> {
        if self.groups.contains(&group) {
            return Err(21);
        }
        self.groups.push(group);
        Ok(())
    }

    /// The groups that have a code in the block.
    pub fn groups(&self) -> &[&'static str] {
        &self.groups
    }

    /// The value of a letter.
    #[must_use]
    pub fn get(&self, letter: char) -> Option<i64> {
        self.values.iter().find(|word| word.letter == letter).map(|word| word.value)
    }

    /// The value of a letter, which a code uses.
    pub fn take(&mut self, letter: char) -> Option<i64> {
        self.used.push(letter);
        self.get(letter)
    }

    /// True if one of the letters is there.
    #[must_use]
    pub fn has(&self, letters: &str) -> bool {
        self.values.iter().any(|word| letters.contains(word.letter))
    }

    /// X, Y and Z in angstroms.
    #[must_use]
    pub fn lengths(&self) -> [Option<i64>; 3] {
        ['X', 'Y', 'Z'].map(|letter| self.get(letter).map(|value| self.modes.length(value)))
    }

    /// Checks that a code has used each value.
    ///
    /// # Errors
    /// `error:36`.
    pub fn all_used(&self) -> Result<(), Refused> {
        let is_used = |word: &Word| "XYZ".contains(word.letter) || self.used.contains(&word.letter);
        if self.values.iter().all(is_used) { Ok(()) } else { Err(36) }
    }
}

/// Checks that a place or an offset is near enough to zero.
///
/// # Errors
/// `error:33`.
pub fn near(angstrom: i64) -> Result<i64, Refused> {
    if angstrom.abs() <= FARTHEST_ANGSTROM { Ok(angstrom) } else { Err(33) }
}
