//! Real-time bytes. They act as soon as they arrive, are never part of a line, and never get an `ok`. Those from 0x80 to 0x87
//! are grblHAL's, by which it has a second byte for each of `?`, `~` and `!`.

/// The request of a real-time byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Realtime {
    /// `?`, 0x80: send a status report.
    Status,
    /// 0x87: send a status report with every field.
    FullStatus,
    /// 0x83: send the modal state, as `$G` does.
    Modal,
    /// 0x18 (ctrl-x): stop, discard the queue and start again.
    Reset,
    /// `!`, 0x82: feed hold.
    Hold,
    /// 0x84: act as if the safety door were opened.
    Door,
    /// `~`, 0x81: resume from a feed hold.
    Resume,
    /// 0x85: end the jog.
    JogCancel,
    /// 0x90-0x97 and 0x99-0x9D: for [`Overrides::apply`](crate::Overrides::apply).
    Override(u8),
    /// 0x9E: in a feed hold, toggle the spindle.
    SpindleStop,
    /// 0xA0: toggle flood coolant.
    Flood,
    /// 0xA1: toggle mist coolant.
    Mist,
    /// 0xA3: lines behind it are of a person who changes the tool; those before it wait until that is done.
    ToolChange,
    /// Any other byte from 0x80 up, which is ignored silently. A sender that encodes real-time bytes as UTF-8 sends
    /// 0xC2 before each of them.
    Ignored,
}

/// Classifies a byte: `Some` for a real-time byte, `None` for a byte that belongs to a line.
// Inlined because it is called for every byte.
#[inline]
pub const fn classify(byte: u8) -> Option<Realtime> {
    match byte {
        b'?' | 0x80 => Some(Realtime::Status),
        0x18 => Some(Realtime::Reset),
        b'!' | 0x82 => Some(Realtime::Hold),
        b'~' | 0x81 => Some(Realtime::Resume),
        0x83 => Some(Realtime::Modal),
        0x87 => Some(Realtime::FullStatus),
        0x84 => Some(Realtime::Door),
        0x85 => Some(Realtime::JogCancel),
        0x90..=0x97 | 0x99..=0x9D => Some(Realtime::Override(byte)),
        0x9E => Some(Realtime::SpindleStop),
        0xA0 => Some(Realtime::Flood),
        0xA1 => Some(Realtime::Mist),
        0xA3 => Some(Realtime::ToolChange),
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
                0x80 => Realtime::Status,
                0x81 => Realtime::Resume,
                0x82 => Realtime::Hold,
                0x83 => Realtime::Modal,
                0x87 => Realtime::FullStatus,
                0x84 => Realtime::Door,
                0x85 => Realtime::JogCancel,
                0x90..=0x97 | 0x99..=0x9D => Realtime::Override(byte),
                0x9E => Realtime::SpindleStop,
                0xA0 => Realtime::Flood,
                0xA1 => Realtime::Mist,
                0xA3 => Realtime::ToolChange,
                _ => Realtime::Ignored,
            };
            assert_eq!(classify(byte), Some(expected), "0x{byte:02X}");
        }
    }
}
