//! The choice of the bytes that a console takes from those it receives.

use core::cell::Cell;

use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;

/// The bytes of lines pass through it, real-time bytes do not.
pub(crate) struct Intake {
    state: Cell<IntakeState>,
    /// The last byte did not end a line.
    in_line: Cell<bool>,
    /// The number of lines that have been lost whose loss has not been reported.
    lost: Cell<u32>,
    loses: Signal<NoopRawMutex, ()>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum IntakeState {
    /// Takes all.
    Open,
    /// Takes nothing.
    Shut,
    /// Takes nothing until a line has ended.
    ToLineEnd,
    /// Takes nothing, because bytes before have been lost, and counts the lines.
    Losing,
}

impl Intake {
    /// Open, at the beginning of a line.
    pub const fn new() -> Self {
        Self {
            state: Cell::new(IntakeState::Open),
            in_line: Cell::new(false),
            lost: Cell::new(0),
            loses: Signal::new(),
        }
    }

    /// Takes nothing from now on.
    pub fn shut(&self) {
        self.begin(IntakeState::Shut);
    }

    /// Takes all bytes from now on, beginning with a line. What the host sends of a line that it began before is not
    /// taken.
    pub fn open(&self) {
        self.begin(if self.in_line.get() { IntakeState::ToLineEnd } else { IntakeState::Open });
    }

    /// Takes all bytes from now on: the next one begins a line.
    pub fn begin_line(&self) {
        self.begin(IntakeState::Open);
        self.in_line.set(false);
    }

    /// A reset has come: what was lost before is forgotten.
    fn begin(&self, state: IntakeState) {
        self.state.set(state);
        self.lost.set(0);
    }

    /// There is no room for these bytes, which were taken. Nothing is taken from now on, before a reset.
    #[cold]
    pub fn lose(&self, bytes: &[u8]) {
        self.state.set(IntakeState::Losing);
        let lines = bytes.iter().filter(|byte| ends_line(byte)).count() as u32;
        self.lost.set(self.lost.get().saturating_add(lines));
        self.loses.signal(());
    }

    /// Waits until a line has been lost that has not been returned yet.
    ///
    /// # Cancellation
    /// Safe: no line is forgotten.
    pub async fn lost_line(&self) {
        loop {
            if let Some(left) = self.lost.get().checked_sub(1) {
                return self.lost.set(left);
            }
            self.loses.wait().await;
        }
    }

    pub fn is_shut(&self) -> bool {
        self.state.get() == IntakeState::Shut
    }

    /// Those of these bytes that are taken.
    pub fn taken<'b>(&self, bytes: &'b [u8]) -> &'b [u8] {
        let Some(last) = bytes.last() else { return bytes };
        self.in_line.set(!ends_line(last));
        match self.state.get() {
            IntakeState::Open => bytes,
            IntakeState::Shut => &[],
            IntakeState::Losing => {
                self.lose(bytes);
                &[]
            }
            IntakeState::ToLineEnd => match bytes.iter().position(ends_line) {
                Some(end) => {
                    self.state.set(IntakeState::Open);
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
    use core::pin::pin;

    use embassy_futures::poll_once;

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
    fn every_line_that_is_lost_is_reported_once_until_a_reset() {
        let intake = Intake::new();
        let reported = || (0..9).take_while(|_| poll_once(pin!(intake.lost_line())).is_ready()).count();
        assert_eq!((intake.taken(b"G1 X1\nG1"), reported()), (&b"G1 X1\nG1"[..], 0));
        // The pipe takes all but the rest of the second line and what is behind it.
        intake.lose(b"1\nG1 X2\nG");
        assert_eq!((reported(), reported()), (2, 0));
        assert_eq!((intake.taken(b"1 X3\nG21\r"), reported()), (&b""[..], 2));
        assert_eq!((intake.taken(b"G90\n"), intake.taken(b"M")), (&b""[..], &b""[..]));
        intake.open();
        assert_eq!((intake.taken(b"3\nM5\n"), reported()), (&b"M5\n"[..], 0), "the rest of the line is forgotten");
        intake.lose(b"M3\n");
        intake.begin_line();
        assert_eq!((intake.taken(b"M5\n"), reported()), (&b"M5\n"[..], 0));
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
