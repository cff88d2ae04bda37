//! Runs a program on a machine at power-up.

use isostep_sim::{Sim, Streamed, program, time};

use crate::config;
use crate::motion::Motion;
use crate::summary;
use crate::trouble::Trouble;
use crate::watch::Watch;

/// A program under way.
pub struct Job {
    streamed: Streamed,
    lines: usize,
    watch: Watch,
}

impl Job {
    /// Sends `program` to a machine at power-up with these settings, lines of `$n=v`.
    ///
    /// # Errors
    /// [`Trouble`] with the line of the program, or of the settings, that cannot be.
    pub fn new(program: &[u8], settings: &str) -> Result<Self, Trouble> {
        let config = config(settings)?;
        let lines = program::lines(program)?;
        let count = lines.len();
        let streamed = Streamed::new(Sim::new(&config), lines.into());
        Ok(Self { streamed, lines: count, watch: Watch::new(false) })
    }

    /// Keeps the trace from now on, for [`take_trace`](Self::take_trace).
    #[must_use]
    pub fn with_trace(mut self) -> Self {
        self.watch = Watch::new(true);
        self
    }

    /// Runs until `until_us` since power-up, and returns whether the program has come to its end.
    ///
    /// # Errors
    /// [`Trouble`] if it never ends.
    pub fn advance(&mut self, until_us: f64) -> Result<bool, Trouble> {
        let has_ended = self.streamed.run_until(time::instant_from((until_us * 1e3) as u64))?;
        let piece = self.streamed.take_piece();
        self.watch.add(&piece);
        Ok(has_ended)
    }

    /// Machine time, us since power-up.
    pub fn now_us(&self) -> f64 {
        self.streamed.progress().t_ns as f64 * 1e-3
    }

    /// Lines answered so far.
    pub fn answered(&self) -> usize {
        self.streamed.progress().answered
    }

    /// Lines of the program.
    pub fn lines(&self) -> usize {
        self.lines
    }

    /// How the axes moved since this was asked last.
    pub fn take_motion(&mut self) -> Motion {
        self.watch.take_motion()
    }

    /// The rows of the trace since this was asked last, as `isostep sim --trace` writes them.
    pub fn take_trace(&mut self) -> Vec<u8> {
        self.watch.take_trace()
    }

    /// How it ended and what was found, as JSON. What was recorded since the last [`advance`](Self::advance) is in what
    /// [`end_with`](Self::end_with) gives.
    ///
    /// # Errors
    /// [`Trouble`] if the machine did not answer a line.
    pub fn end(self) -> Result<String, Trouble> {
        Ok(self.end_with()?.0)
    }

    /// As [`end`](Self::end), with the rest of the motion and of the trace.
    ///
    /// # Errors
    /// [`Trouble`] if the machine did not answer a line.
    pub fn end_with(self) -> Result<(String, Motion, Vec<u8>), Trouble> {
        let Self { streamed, mut watch, .. } = self;
        let end = streamed.end()?;
        watch.add(&end);
        let summary = summary::of(&watch.gathered, &end);
        Ok((summary, watch.take_motion(), watch.take_trace()))
    }
}
