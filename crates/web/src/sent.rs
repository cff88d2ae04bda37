//! A program under way: sent to a machine at power-up, and run in pieces of machine time.

use isostep_console::{Command, Interpreter, ReportedState, Settings};
use isostep_sim::program::{Program, stripped};
use isostep_sim::{Config, Outcome, Sim, Streamed, time};

use crate::trouble::Trouble;

pub(crate) struct Sent {
    streamed: Streamed,
    lines: usize,
}

impl Sent {
    /// Sends `program` to the machine of `config`. `only_time`: without edges, unless it homes, which needs carriages that move.
    ///
    /// # Errors
    /// [`Trouble`] with the line that cannot be.
    pub fn new(program: &[u8], config: Config, only_time: bool) -> Result<Self, Trouble> {
        let program = Program::read(program)?;
        let only_time = only_time && !program.iter().any(|line| homes(line));
        let lines = program.len();
        Ok(Self { streamed: Streamed::new(Sim::new(&Config { only_time, ..config }), program), lines })
    }

    /// Runs until `until_us` since power-up. Returns whether the program has come to its end, and what was recorded meanwhile.
    ///
    /// # Errors
    /// [`Trouble`] if it never ends.
    pub fn advance(&mut self, until_us: f64) -> Result<(bool, Outcome), Trouble> {
        let has_ended = self.streamed.run_until(time::instant_from((until_us * 1e3) as u64))?;
        Ok((has_ended, self.streamed.take_piece()))
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

    /// The last piece.
    ///
    /// # Errors
    /// [`Trouble`] if the machine did not answer a line.
    pub fn end(self) -> Result<Outcome, Trouble> {
        Ok(self.streamed.end()?)
    }
}

/// True if a line homes.
fn homes(line: &[u8]) -> bool {
    let Ok(line) = stripped(line) else { return false };
    let command = Interpreter::new().interpret(&line, ReportedState::Idle, &Settings::DEFAULT);
    line.starts_with('$') && matches!(command, Ok(Command::Home { .. }))
}
