//! Runs a program on a machine at power-up.

use crate::lines::Lines;
use crate::motion::Motion;
use crate::sent::Sent;
use crate::trouble::Trouble;
use crate::watch::Watch;
use crate::{config, summary};

/// The records that are kept of a run beside its motion. Each takes memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kept {
    /// No more.
    #[default]
    Nothing,
    /// The line of each move: [`End::lines`].
    Lines,
    /// The same, of a run without edges: what the machine would do, sooner. Nothing is checked. A program that homes has edges, which that
    /// needs.
    Plan,
    /// Every step, as `isostep sim --trace` writes them.
    Trace,
    /// Every change of every wire, as `isostep sim --vcd` writes them, at the end.
    Waves,
}

/// A program under way.
pub struct Job {
    sent: Sent,
    watch: Watch,
}

/// The end of a program, with what was not taken before.
pub struct End {
    /// The findings, as JSON.
    pub summary: String,
    /// The rest of how the axes moved.
    pub motion: Motion,
    /// The rest of what is written.
    pub rows: Vec<u8>,
    /// The rest of the instants at which each line moved the machine, if that was kept.
    pub lines: Lines,
}

impl Job {
    /// Sends `program` to a machine at power-up with these settings, lines of `$n=v`.
    ///
    /// # Errors
    /// [`Trouble`] with the line of the program, or of the settings, that cannot be.
    pub fn new(program: &[u8], settings: &str, kept: Kept) -> Result<Self, Trouble> {
        let mut config = config(settings)?;
        config.keep_waves = kept == Kept::Waves;
        Ok(Self { sent: Sent::new(program, config, kept == Kept::Plan)?, watch: Watch::new(kept) })
    }

    /// Runs until `until_us` since power-up, and returns whether the program has come to its end.
    ///
    /// # Errors
    /// [`Trouble`] if it never ends.
    pub fn advance(&mut self, until_us: f64) -> Result<bool, Trouble> {
        let (has_ended, piece) = self.sent.advance(until_us)?;
        self.watch.add(&piece);
        Ok(has_ended)
    }

    /// Machine time, us since power-up.
    pub fn now_us(&self) -> f64 {
        self.sent.now_us()
    }

    /// Lines answered so far.
    pub fn answered(&self) -> usize {
        self.sent.answered()
    }

    /// Lines of the program.
    pub fn lines(&self) -> usize {
        self.sent.lines()
    }

    /// The motion of the axes since this was asked last.
    pub fn take_motion(&mut self) -> Motion {
        self.watch.take_motion()
    }

    /// The next whole piece of it, if there is one: see [`piece`](crate::piece).
    pub fn take_piece(&mut self) -> Option<Motion> {
        self.watch.take_piece()
    }

    /// The text since this was asked last: see [`Kept`].
    pub fn take_rows(&mut self) -> Vec<u8> {
        self.watch.take_rows()
    }

    /// The instants at which lines moved the machine since they were taken last.
    pub fn lines_since(&mut self) -> &mut Lines {
        &mut self.watch.lines
    }

    /// Its end, and what was recorded since the last [`advance`](Self::advance).
    ///
    /// # Errors
    /// [`Trouble`] if the machine did not answer a line.
    pub fn end(self) -> Result<End, Trouble> {
        let Self { sent, mut watch } = self;
        let end = sent.end()?;
        let lines = watch.end(&end);
        let summary = summary::of(&watch.gathered, &end);
        Ok(End { summary, motion: watch.take_motion(), rows: watch.take_rows(), lines })
    }
}
