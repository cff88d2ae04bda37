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
    /// `~`: resume from a feed hold.
    Resume,
    /// Any byte from 0x80 up. Overrides live there, and some senders wrap them in UTF-8 (`C2 96`), so
    /// all of them are dropped in silence.
    Ignored,
}

/// Sorts a byte: `Some` if it is a real-time byte, `None` if it belongs to a line.
pub const fn classify(byte: u8) -> Option<Realtime> {
    match byte {
        b'?' => Some(Realtime::Status),
        0x18 => Some(Realtime::Reset),
        b'!' => Some(Realtime::Hold),
        b'~' => Some(Realtime::Resume),
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
        assert!((0x80..=0xFF).all(|byte| classify(byte) == Some(Realtime::Ignored)));
        assert_eq!((0..0x80).filter(|&byte| classify(byte).is_some()).count(), 4);
    }
}
