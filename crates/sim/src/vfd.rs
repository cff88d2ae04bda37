//! A VFD on RS-485, and its spindle: what it makes of frames, and what can be wrong with it.
//!
//! It has the registers of a few types, written from what is published of them and not from the controller's table, and a checksum
//! of its own. Speeds are output frequencies. It runs only while its terminal for that, which is the board's enable output, is on.
//!
//! ```
//! use isostep_sim::vfd::{Vfd, VfdKind, checksum};
//!
//! let framed = |bytes: &[u8]| [bytes, &checksum(bytes)].concat();
//! let mut vfd = Vfd::new(VfdKind::Gs20);
//! vfd.set_enabled(0, true);
//! vfd.hear(0, &framed(&[1, 6, 0x20, 1, 0x27, 0x10])).unwrap();
//! vfd.hear(0, &framed(&[1, 6, 0x20, 0, 0, 0x12])).unwrap();
//! vfd.advance(1_000_000_000);
//! assert_eq!(vfd.output_hz(), 100.0);
//! ```

mod kind;
mod line;

use std::fmt;

pub use self::kind::VfdKind;
pub(crate) use self::line::VfdLine;

/// The time from a request to the beginning of its reply, ns.
pub(crate) const ANSWERS_NS: u64 = 5_000_000;
/// The same of one that is late.
const LATE_NS: u64 = 300_000_000;
/// Acceleration and deceleration of one that is not set otherwise, Hz/s: 24,000 rpm of a motor with two poles in two seconds.
pub(crate) const RAMP_HZ_S: f64 = 200.0;
/// Deceleration of a spindle that coasts, Hz/s.
const COASTS_HZ_S: f64 = 10.0;
/// The load that it cannot carry takes it to this part of its speed.
const OVERLOADED: f64 = 0.7;
/// The fault that it reports.
const FAULT: u16 = 0x10;

/// A VFD outside of the simulation: what it replies to a frame.
pub(crate) type OutsideVfd = Box<dyn FnMut(&[u8]) -> Vec<u8>>;

/// A fault of a VFD, or of its wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum VfdFault {
    /// Its wire is cut: it hears nothing and goes on.
    Cut,
    /// It has no supply: it hears nothing, its spindle coasts, and afterwards it stands.
    Off,
    /// A bit of every second reply is wrong.
    Flickers,
    /// A bit of every reply is wrong.
    Garbled,
    /// Its replies come after the time for them.
    Late,
    /// It answers by another address.
    OtherAddress,
    /// It refuses everything, with exception 2.
    Refuses,
    /// It has found a fault, and has switched its output off.
    Tripped,
    /// Its motor does not reach its speed.
    Overloaded,
    /// Its spindle coasts when it is to stop.
    Coasts,
}

impl VfdFault {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Cut,
        Self::Off,
        Self::Flickers,
        Self::Garbled,
        Self::Late,
        Self::OtherAddress,
        Self::Refuses,
        Self::Tripped,
        Self::Overloaded,
        Self::Coasts,
    ];
}

impl fmt::Display for VfdFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Cut => "cut",
            Self::Off => "off",
            Self::Flickers => "flickers",
            Self::Garbled => "garbled",
            Self::Late => "late",
            Self::OtherAddress => "other-address",
            Self::Refuses => "refuses",
            Self::Tripped => "tripped",
            Self::Overloaded => "overloaded",
            Self::Coasts => "coasts",
        })
    }
}

/// The direction of a spindle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Runs {
    /// Clockwise.
    Clockwise,
    /// Counter-clockwise.
    CounterClockwise,
}

/// A VFD and its spindle.
#[derive(Debug)]
pub struct Vfd {
    kind: VfdKind,
    address: u8,
    ramp_hz_s: f64,
    fault: Option<VfdFault>,
    /// Since when that, or nothing, is wrong.
    fault_since_ns: u64,
    replies: u32,
    is_enabled: bool,
    /// Since when it is so.
    enabled_since_ns: u64,
    runs: Option<Runs>,
    set_hz: f64,
    /// The output frequency; below 0 counter-clockwise.
    turns_hz: f64,
    at_ns: u64,
    /// Valid requests that it has heard.
    pub requests: u32,
}

/// A word of a VFD, by its meaning.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Word {
    Fault,
    SetHz(f64),
    OutputHz(f64),
    Current(f64),
    Other,
}

/// What a request asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Asked {
    Run(Option<Runs>),
    /// The word of a frequency, and how much of a hertz one is.
    SetHz(u16, u16),
    Read(u8),
}

impl Vfd {
    /// One that has been switched on, at address 1.
    #[must_use]
    pub fn new(kind: VfdKind) -> Self {
        Self {
            kind,
            address: 1,
            ramp_hz_s: RAMP_HZ_S,
            fault: None,
            fault_since_ns: 0,
            replies: 0,
            is_enabled: false,
            enabled_since_ns: 0,
            runs: None,
            set_hz: 0.0,
            turns_hz: 0.0,
            at_ns: 0,
            requests: 0,
        }
    }

    /// The same with this acceleration and deceleration, Hz/s.
    #[must_use]
    pub fn with_ramp(self, ramp_hz_s: f64) -> Self {
        Self { ramp_hz_s, ..self }
    }

    /// From now on this is wrong with it, and nothing else; or nothing is.
    pub fn set_fault(&mut self, fault: Option<VfdFault>) {
        (self.fault, self.fault_since_ns, self.replies) = (fault, self.at_ns, 0);
        if matches!(fault, Some(VfdFault::Off | VfdFault::Tripped)) {
            self.runs = None;
        }
        if fault == Some(VfdFault::Tripped) {
            self.turns_hz = 0.0;
        }
    }

    /// Switches its terminal that lets it run.
    pub fn set_enabled(&mut self, now_ns: u64, is_enabled: bool) {
        self.advance(now_ns);
        if is_enabled != self.is_enabled {
            (self.is_enabled, self.enabled_since_ns) = (is_enabled, self.at_ns);
        }
    }

    /// The output frequency; below 0 counter-clockwise.
    #[must_use]
    pub fn output_hz(&self) -> f64 {
        self.turns_hz
    }

    /// What is wrong with it, if anything is, and since when, ns.
    pub(crate) fn fault(&self) -> (Option<VfdFault>, u64) {
        (self.fault, self.fault_since_ns)
    }

    /// True if its terminal lets it run, and since when it does or does not, ns.
    pub(crate) fn enabled(&self) -> (bool, u64) {
        (self.is_enabled, self.enabled_since_ns)
    }

    /// True if it was told to run last, and has not failed since.
    pub(crate) fn is_told_to_run(&self) -> bool {
        self.runs.is_some()
    }

    /// True if it drives its motor.
    #[must_use]
    pub fn drives(&self) -> bool {
        self.is_enabled && self.runs.is_some()
    }

    /// Time passes.
    pub fn advance(&mut self, now_ns: u64) {
        let s = now_ns.saturating_sub(self.at_ns) as f64 / 1e9;
        self.at_ns = self.at_ns.max(now_ns);
        let share = if self.fault == Some(VfdFault::Overloaded) { OVERLOADED } else { 1.0 };
        let target_hz = match self.runs.filter(|_| self.is_enabled) {
            None => 0.0,
            Some(Runs::Clockwise) => self.set_hz * share,
            Some(Runs::CounterClockwise) => -self.set_hz * share,
        };
        let coasts = matches!(self.fault, Some(VfdFault::Coasts | VfdFault::Off));
        let most_hz = s * if coasts && target_hz == 0.0 { COASTS_HZ_S } else { self.ramp_hz_s };
        self.turns_hz += (target_hz - self.turns_hz).clamp(-most_hz, most_hz);
    }

    /// What it replies to these bytes, and after how many ns, if it does.
    pub fn hear(&mut self, now_ns: u64, sent: &[u8]) -> Option<(Vec<u8>, u64)> {
        self.advance(now_ns);
        if matches!(self.fault, Some(VfdFault::Cut | VfdFault::Off)) {
            return None;
        }
        let (request, sum) = sent.split_last_chunk::<2>()?;
        if *sum != checksum(request) || request.first() != Some(&self.address) {
            return None;
        }
        self.requests += 1;
        let function = *request.get(1)?;
        let mut reply = match self.kind.understand(&request[1..]) {
            Some(asked) if self.fault != Some(VfdFault::Refuses) => self.carry_out(asked, request),
            _ => vec![self.address, function | 0x80, 2],
        };
        if self.fault == Some(VfdFault::OtherAddress) {
            reply[0] += 1;
        }
        reply.extend(checksum(&reply));
        self.replies += 1;
        let is_garbled = match self.fault {
            Some(VfdFault::Garbled) => true,
            Some(VfdFault::Flickers) => self.replies.is_multiple_of(2),
            _ => false,
        };
        if is_garbled {
            // Another bit each time.
            let byte = self.replies as usize / 2 % reply.len();
            reply[byte] ^= 1 << (self.replies % 7);
        }
        let after_ns = if self.fault == Some(VfdFault::Late) { LATE_NS } else { ANSWERS_NS };
        Some((reply, after_ns))
    }

    fn carry_out(&mut self, asked: Asked, request: &[u8]) -> Vec<u8> {
        match asked {
            Asked::Run(runs) => {
                if self.fault != Some(VfdFault::Tripped) {
                    self.runs = runs;
                }
            }
            Asked::SetHz(word, per_hz) => self.set_hz = f64::from(word) / f64::from(per_hz),
            Asked::Read(count) => {
                let words: Vec<_> = self.kind.words(request, count).into_iter().map(|word| self.word(word)).collect();
                return self.kind.reading(request, &words);
            }
        }
        self.kind.written(request)
    }

    fn word(&self, word: Word) -> u16 {
        let times = |value: f64, per: f64| (value.abs() * per).round() as u16;
        match word {
            Word::Fault if self.fault == Some(VfdFault::Tripped) => FAULT,
            Word::Fault | Word::Other => 0,
            Word::SetHz(per_hz) => times(self.set_hz, per_hz),
            Word::OutputHz(per_hz) => times(self.turns_hz, per_hz),
            // Of some motor: half an ampere, and more with speed.
            Word::Current(per_ampere) if self.drives() => times(0.5 + self.turns_hz.abs() / 200.0, per_ampere),
            Word::Current(_) => 0,
        }
    }
}

/// The two bytes that end a frame, bit by bit as the specification has them.
#[must_use]
pub fn checksum(bytes: &[u8]) -> [u8; 2] {
    let mut sum = u16::MAX;
    for &byte in bytes {
        sum ^= u16::from(byte);
        for _ in 0..8 {
            let is_odd = sum % 2 == 1;
            sum = (sum / 2) ^ if is_odd { 0xA001 } else { 0 };
        }
    }
    sum.to_le_bytes()
}
