//! The types of VFD: what each of them is written and read by. A type is a row.

use isostep_console::Settings;

/// The way in which a word is written.
#[derive(Clone, Copy)]
pub enum Write {
    /// Function 6.
    Register,
    /// Function 16, of one register.
    Registers,
    /// Function 5: the word is the number of a coil, which is switched on.
    Coil,
    /// Huanyang's function 3.
    HuanyangRun,
    /// Huanyang's function 5.
    HuanyangSpeed,
}

/// The way in which words are read.
#[derive(Clone, Copy)]
pub enum Read {
    /// Function 3.
    Holding,
    /// Function 4.
    Input,
    /// Huanyang's function 4.
    Huanyang,
}

/// VfdWords that are read at once, and which of them says what.
#[derive(Clone, Copy)]
pub struct Monitor {
    pub read: Read,
    pub register: u16,
    pub words: u8,
    /// The word of the output frequency.
    pub speed: Option<u8>,
    /// The word of the current, and how much one of it is, amperes.
    pub current: Option<(u8, f32)>,
    /// The word of a fault, and its bits: if one is set, the VFD has failed.
    pub fault: Option<(u8, u16)>,
}

/// What a VFD is written and read by.
#[derive(Clone, Copy)]
pub struct Type {
    pub name: &'static str,
    /// How and where it is run, and the words for clockwise, counter-clockwise and stop.
    pub run: (Write, u16, [u16; 3]),
    pub speed: (Write, u16),
    /// The word of a speed, by rpm.
    pub word_per_rpm: f32,
    /// The speed of a word, rpm.
    pub rpm_per_word: f32,
    /// Read in every round.
    pub monitor: Monitor,
    /// Read in some rounds: a VFD whose words stand apart.
    pub beside: Option<Monitor>,
}

/// The types whose words are fixed: their frequencies are in hundredths of a hertz, or in tenths. `$395` counts them from 1, and
/// has the generic one at [`GENERIC`].
#[rustfmt::skip]
const TYPES: [(Type, f32); 6] = [
    (Type { name: "Huanyang",
        run: (Write::HuanyangRun, 0, [0x01, 0x11, 0x08]), speed: (Write::HuanyangSpeed, 0),
        monitor: Monitor { words: 1, ..monitor(Read::Huanyang, 1) },
        beside: Some(Monitor { speed: None, current: Some((0, 0.1)), ..monitor(Read::Huanyang, 2) }), ..PLAIN }, 100.0),
    // A status of faults and warnings, status, frequency to set, output frequency, current.
    (Type { name: "GS20",
        monitor: Monitor { words: 5, speed: Some(3), current: Some((4, 0.01)), fault: Some((0, 0xFF)), ..monitor(Read::Holding, 0x2100) },
        ..PLAIN }, 100.0),
    (Type { name: "YL620",
        monitor: Monitor { words: 2, current: Some((1, 0.1)), ..monitor(Read::Holding, 0x200B) }, ..PLAIN }, 10.0),
    (Type { name: "generic", ..PLAIN }, 100.0),
    (Type { name: "H-100",
        run: (Write::Coil, 0, [0x49, 0x4A, 0x4B]), speed: (Write::Register, 0x0201),
        monitor: Monitor { words: 2, ..monitor(Read::Input, 0) }, ..PLAIN }, 10.0),
    // Status, frequency to set, output frequency, current.
    (Type { name: "Nowforever",
        run: (Write::Registers, 0x0900, [1, 3, 0]), speed: (Write::Registers, 0x0901),
        monitor: Monitor { words: 4, speed: Some(2), current: Some((3, 0.1)), fault: Some((0, 0x18)), ..monitor(Read::Holding, 0x0500) },
        ..PLAIN }, 100.0),
];
const GENERIC: usize = 3;

/// What most have in common.
const PLAIN: Type = Type {
    name: "",
    run: (Write::Register, 0x2000, [0x12, 0x22, 0x01]),
    speed: (Write::Register, 0x2001),
    word_per_rpm: 0.0,
    rpm_per_word: 0.0,
    monitor: monitor(Read::Holding, 0),
    beside: None,
};

/// One word, of the output frequency.
const fn monitor(read: Read, register: u16) -> Monitor {
    Monitor { read, register, words: 1, speed: Some(0), current: None, fault: None }
}

impl Type {
    /// A type by its number in `$395`, with the other settings.
    pub fn of(number: u16, settings: &Settings) -> Self {
        let index = usize::from(number).saturating_sub(1).min(TYPES.len() - 1);
        let (row, words_per_hz) = TYPES[index];
        if index == GENERIC {
            let ([run, speed, actual], [set, by], [read, of]) =
                (settings.vfd_registers, settings.vfd_set_ratio, settings.vfd_read_ratio);
            return Self {
                run: (Write::Register, run, settings.vfd_words),
                speed: (Write::Register, speed),
                word_per_rpm: set / by,
                rpm_per_word: read / of,
                monitor: monitor(Read::Holding, actual),
                ..row
            };
        }
        let rpm_per_word = f32::from(settings.vfd_rpm_per_hz) / words_per_hz;
        Self { rpm_per_word, word_per_rpm: 1.0 / rpm_per_word, ..row }
    }

    /// The register of the output frequency.
    pub fn speed_register(&self) -> u16 {
        match self.monitor.read {
            Read::Huanyang => self.monitor.register,
            _ => self.monitor.register + u16::from(self.monitor.speed.unwrap_or_default()),
        }
    }
}
