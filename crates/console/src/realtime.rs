//! Real-time bytes: acted on as they arrive, never part of a line, never answered with `ok`.

/// What a real-time byte asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Realtime {
    /// `?`: send a status report.
    Status,
    /// 0x18 (ctrl-x): stop, forget the queue, start afresh.
    Reset,
    /// `!`: feed hold.
    Hold,
    /// 0x84: as if the safety door were opened.
    Door,
    /// `~`: resume from a feed hold.
    Resume,
    /// 0x85: end the jog.
    JogCancel,
    /// 0x90-0x97 and 0x99-0x9D: for [`Overrides::apply`](crate::Overrides::apply).
    Override(u8),
    /// 0x9E: in a feed hold, spindle off, or on again.
    SpindleStop,
    /// 0xA0: flood on, or off again.
    Flood,
    /// 0xA1: mist on, or off again.
    Mist,
    /// Any other byte from 0x80 up, dropped in silence. 0xC2 comes before every real-time byte of a sender that encodes
    /// them as UTF-8.
    Ignored,
}

/// Sorts a byte: `Some` if it is a real-time byte, `None` if it belongs to a line.
// Inlined: it is asked of every byte.
#[inline]
pub const fn classify(byte: u8) -> Option<Realtime> {
    match byte {
        b'?' => Some(Realtime::Status),
        0x18 => Some(Realtime::Reset),
        b'!' => Some(Realtime::Hold),
        b'~' => Some(Realtime::Resume),
        0x84 => Some(Realtime::Door),
        0x85 => Some(Realtime::JogCancel),
        0x90..=0x97 | 0x99..=0x9D => Some(Realtime::Override(byte)),
        0x9E => Some(Realtime::SpindleStop),
        0xA0 => Some(Realtime::Flood),
        0xA1 => Some(Realtime::Mist),
        0x80.. => Some(Realtime::Ignored),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_named_bytes_and_those_from_0x80_are_real_time() {
        assert_eq!(classify(b'?'), Some(Realtime::Status));
        assert_eq!(classify(0x18), Some(Realtime::Reset));
        assert_eq!(classify(b'!'), Some(Realtime::Hold));
        assert_eq!(classify(b'~'), Some(Realtime::Resume));
        assert_eq!((0..0x80).filter(|&byte| classify(byte).is_some()).count(), 4);
        for byte in 0x80..=0xFF {
            let expected = match byte {
                0x84 => Realtime::Door,
                0x85 => Realtime::JogCancel,
                0x90..=0x97 | 0x99..=0x9D => Realtime::Override(byte),
                0x9E => Realtime::SpindleStop,
                0xA0 => Realtime::Flood,
                0xA1 => Realtime::Mist,
                _ => Realtime::Ignored,
            };
            assert_eq!(classify(byte), Some(expected), "0x{byte:02X}");
        }
    }
}
