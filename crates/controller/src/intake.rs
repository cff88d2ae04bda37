//! Which of the bytes that a console receives are taken.

use core::cell::Cell;

/// The bytes of lines pass through it, real-time bytes do not.
pub(crate) struct Intake {
    state: Cell<State>,
    /// The last byte did not end a line.
    in_line: Cell<bool>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    /// Takes all.
    Open,
    /// Takes nothing.
    Shut,
    /// Takes nothing until a line has ended.
    ToLineEnd,
}

impl Intake {
    /// Open, at the beginning of a line.
    pub const fn new() -> Self {
        Self { state: Cell::new(State::Open), in_line: Cell::new(false) }
    }

    /// Takes nothing from now on.
    pub fn shut(&self) {
        self.state.set(State::Shut);
    }

    /// Takes all bytes from now on, beginning with a line. What the host sends of a line that it began before is not
    /// taken.
    pub fn open(&self) {
        self.state.set(if self.in_line.get() { State::ToLineEnd } else { State::Open });
    }

    /// Takes all bytes from now on: the next one begins a line.
    pub fn begin_line(&self) {
        self.state.set(State::Open);
        self.in_line.set(false);
    }

    pub fn is_shut(&self) -> bool {
        self.state.get() == State::Shut
    }

    /// Those of these bytes that are taken.
    pub fn taken<'b>(&self, bytes: &'b [u8]) -> &'b [u8] {
        let Some(last) = bytes.last() else { return bytes };
        self.in_line.set(!ends_line(last));
        match self.state.get() {
            State::Open => bytes,
            State::Shut => &[],
            State::ToLineEnd => match bytes.iter().position(ends_line) {
                Some(end) => {
                    self.state.set(State::Open);
                    &bytes[end + 1..]
                }
                None => &[],
            },
        }
    }
}

fn ends_line(byte: &u8) -> bool {
    matches!(byte, b'\r' | b'\n')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_of_a_line_is_not_taken() {
        let intake = Intake::new();
        assert_eq!(intake.taken(b"G1 X10\nG1 "), b"G1 X10\nG1 ");
        intake.shut();
        assert_eq!((intake.taken(b"X20 "), intake.is_shut()), (&b""[..], true));
        intake.open();
        assert_eq!((intake.taken(b"F10"), intake.is_shut()), (&b""[..], false));
        assert_eq!(intake.taken(b"0\nG21\nG"), b"G21\nG");
        assert_eq!(intake.taken(b"90\n"), b"90\n");
    }

    #[test]
    fn it_opens_at_a_line_when_the_last_one_had_ended_or_is_forgotten() {
        let intake = Intake::new();
        intake.shut();
        assert_eq!(intake.taken(b"G1 X10\r"), b"");
        intake.open();
        assert_eq!(intake.taken(b"G21\n"), b"G21\n");
        assert_eq!(intake.taken(b"G1 X"), b"G1 X");
        intake.shut();
        intake.begin_line();
        assert_eq!(intake.taken(b"G90\n"), b"G90\n");
    }
}
