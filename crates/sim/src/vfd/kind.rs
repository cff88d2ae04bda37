//! The types of VFD, by what is published of their frames.

use std::fmt;

use super::{Asked, Runs, Word};

/// The type of a VFD.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum VfdKind {
    /// The first Huanyang, whose frames are its own.
    Huanyang,
    /// A DURAPULSE GS20.
    Gs20,
    /// A YL620-A.
    Yl620,
    /// One whose registers the settings say.
    Generic,
    /// An H-100.
    H100,
    /// A Nowforever D100 or E100.
    Nowforever,
}

impl VfdKind {
    /// All of them, in the order of `$395`.
    pub const ALL: [Self; 6] = [Self::Huanyang, Self::Gs20, Self::Yl620, Self::Generic, Self::H100, Self::Nowforever];

    /// What a request asks for: its function and data.
    pub(super) fn understand(self, pdu: &[u8]) -> Option<Asked> {
        let word = |high: u8, low: u8| u16::from_be_bytes([high, low]);
        let runs = |clockwise, counter_clockwise, stop, value: u16| match value {
            value if value == stop => Some(Asked::Run(None)),
            value if value == clockwise => Some(Asked::Run(Some(Runs::Clockwise))),
            value if value == counter_clockwise => Some(Asked::Run(Some(Runs::CounterClockwise))),
            _ => None,
        };
        match (self, pdu) {
            (Self::Huanyang, &[3, 1, control]) => runs(0x01, 0x11, 0x08, control.into()),
            (Self::Huanyang, &[5, 2, high, low]) => Some(Asked::SetHz(word(high, low), 100)),
            (Self::Huanyang, &[4, 3, 0..=7, 0, 0]) => Some(Asked::Read(1)),
            (Self::H100, &[5, 0, coil, 0xFF, 0]) => runs(0x49, 0x4A, 0x4B, coil.into()),
            (Self::H100, &[6, 2, 1, high, low]) => Some(Asked::SetHz(word(high, low), 10)),
            (Self::H100, &[4, 0, 0, 0, count @ 1..=8]) => Some(Asked::Read(count)),
            (Self::Nowforever, &[16, 9, 0, 0, 1, 2, high, low]) => runs(1, 3, 0, word(high, low)),
            (Self::Nowforever, &[16, 9, 1, 0, 1, 2, high, low]) => Some(Asked::SetHz(word(high, low), 100)),
            (Self::Nowforever, &[3, 5, 0, 0, count @ 1..=8]) => Some(Asked::Read(count)),
            (Self::Gs20 | Self::Yl620 | Self::Generic, &[6, 0x20, 0, high, low]) => {
                runs(0x12, 0x22, 0x01, word(high, low))
            }
            (Self::Gs20 | Self::Generic, &[6, 0x20, 1, high, low]) => Some(Asked::SetHz(word(high, low), 100)),
            (Self::Yl620, &[6, 0x20, 1, high, low]) => Some(Asked::SetHz(word(high, low), 10)),
            (Self::Gs20 | Self::Generic, &[3, 0x21, _, 0, count @ 1..=8]) => Some(Asked::Read(count)),
            (Self::Yl620, &[3, 0x20, 0x0B, 0, count @ 1..=2]) => Some(Asked::Read(count)),
            _ => None,
        }
    }

    /// The words that a read asks for.
    pub(super) fn words(self, request: &[u8], count: u8) -> Vec<Word> {
        let word_at = |register: u16| match (self, register) {
            (Self::Gs20 | Self::Generic, 0x2100) | (Self::Nowforever, 0x0500) => Word::Fault,
            (Self::Gs20 | Self::Generic, 0x2102) | (Self::Nowforever, 0x0501) => Word::SetHz(100.0),
            (Self::Gs20 | Self::Generic, 0x2103) | (Self::Nowforever, 0x0502) => Word::OutputHz(100.0),
            (Self::Gs20, 0x2104) => Word::Current(100.0),
            (Self::Nowforever, 0x0503) => Word::Current(10.0),
            (Self::Yl620, 0x200B) => Word::OutputHz(10.0),
            (Self::Yl620, 0x200C) => Word::Current(10.0),
            (Self::H100, 0) => Word::OutputHz(10.0),
            (Self::H100, 1) => Word::SetHz(10.0),
            (Self::Huanyang, 0) => Word::SetHz(100.0),
            (Self::Huanyang, 1) => Word::OutputHz(100.0),
            (Self::Huanyang, 2) => Word::Current(10.0),
            _ => Word::Other,
        };
        let first = match self {
            Self::Huanyang => request[3].into(),
            _ => u16::from_be_bytes([request[2], request[3]]),
        };
        (first..).take(count.into()).map(word_at).collect()
    }

    /// The reply to a read, without its end.
    pub(super) fn reading(self, request: &[u8], words: &[u16]) -> Vec<u8> {
        let mut reply = request[..2].to_vec();
        match self {
            Self::Huanyang => reply.extend([3, request[3]]),
            _ => reply.push(2 * words.len() as u8),
        }
        reply.extend(words.iter().flat_map(|word| word.to_be_bytes()));
        reply
    }

    /// The reply to what was written, without its end.
    pub(super) fn written(self, request: &[u8]) -> Vec<u8> {
        match (self, request[1]) {
            // Its status.
            (Self::Huanyang, 3) => vec![request[0], 3, 1, request[3]],
            (_, 16) => request[..6].to_vec(),
            _ => request.to_vec(),
        }
    }
}

impl fmt::Display for VfdKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Huanyang => "huanyang",
            Self::Gs20 => "gs20",
            Self::Yl620 => "yl620",
            Self::Generic => "generic",
            Self::H100 => "h-100",
            Self::Nowforever => "nowforever",
        })
    }
}
