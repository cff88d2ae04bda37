//! A program that is streamed piece by piece of time, so that somebody may look at it, or stop it, in between; and which of its lines
//! has silenced the console, if one has.

use std::cell::RefCell;
use std::rc::Rc;

use embassy_time::Instant;
use isostep_console::{Command, Interpreter, ReportedState, Settings};
use isostep_motion::State;

use super::{Progress, Sim, SimError};
use crate::executor::{Priority, Rest, RunError};
use crate::outcome::Outcome;
use crate::program::{Program, stripped};
use crate::stream::{Dialogue, Refusal, Sender};

/// A machine to which a program is sent. If it waits for the operator, it is resumed at once.
///
/// However it is cut into pieces, the run is that of [`run`](crate::run), to the byte.
pub struct Streamed {
    sim: Sim,
    program: Program,
    dialogue: Rc<RefCell<Dialogue>>,
    limit: Instant,
}

impl Streamed {
    /// Begins to send `program`, from the present state of `sim` on.
    pub fn new(mut sim: Sim, program: Program) -> Self {
        let dialogue = Rc::new(RefCell::new(Dialogue::default()));
        let clock = sim.executor.clock().clone();
        let pipes = (sim.consoles[0].to_controller.clone(), sim.consoles[0].from_controller.clone());
        let sender = Sender::new(clock, sim.config.clone(), pipes, program.clone(), dialogue.clone());
        sim.executor.spawn_at(Priority::World, "sender", sender.run());
        let limit = sim.now() + sim.config.time_limit;
        Self { sim, program, dialogue, limit }
    }

    /// Runs until `horizon`, and returns whether the machine has come to its end before: nothing can happen any more.
    ///
    /// # Errors
    /// [`RunError::TimeLimit`] when the program takes longer than the configuration allows; [`RunError::Livelock`].
    pub fn run_until(&mut self, horizon: Instant) -> Result<bool, RunError> {
        let until = horizon.min(self.limit);
        while self.sim.executor.run_until_quiescent(until)? == Rest::Quiescent {
            if !self.resumes() {
                return Ok(true);
            }
            self.sim.send(b"~");
            self.limit = self.sim.now() + self.sim.config.time_limit;
        }
        if until == self.limit {
            return Err(RunError::TimeLimit { limit: until, waiting: self.sim.executor.waiting() });
        }
        Ok(false)
    }

    /// Notes what the operator has done, if the machine has waited for that, and goes on with `~`.
    fn resumes(&self) -> bool {
        let mut dialogue = self.dialogue.borrow_mut();
        match self.sim.machine.state() {
            State::Hold { still: true } if dialogue.waiting_line().is_some() => {
                dialogue.note_pause(&self.program, self.sim.now_ns());
                true
            }
            State::Idle => dialogue.resume_tool(self.sim.now_ns()),
            _ => false,
        }
    }

    /// Its progress.
    pub fn progress(&self) -> Progress {
        Progress { answered: self.dialogue.borrow().answered, t_ns: self.sim.now_ns() }
    }

    /// The machine, to look at.
    pub fn sim(&self) -> &Sim {
        &self.sim
    }

    /// The lines refused so far.
    pub fn refusals(&self) -> Vec<Refusal> {
        self.dialogue.borrow().refusals.clone()
    }

    /// The record since it was asked last, of moves those that nothing can change any more: see
    /// [`verify::Gathered`](crate::verify::Gathered). The dialogue is not in it.
    pub fn take_piece(&mut self) -> Outcome {
        Outcome { program: self.program.clone(), ..self.sim.take_piece() }
    }

    /// The rest after the last piece, and how it ended. Follows the rotors until they stand still.
    ///
    /// # Errors
    /// [`SimError::Silenced`], [`SimError::Unanswered`] and [`SimError::ToolNotMeasured`].
    pub fn end(self) -> Result<Outcome, SimError> {
        let Self { sim, program, dialogue, .. } = self;
        let dialogue = dialogue.take();
        if let Some((line, text, why)) = dialogue.missed_tool() {
            return Err(SimError::ToolNotMeasured { line, text, why });
        }
        if !dialogue.done && dialogue.alarm.is_none() {
            return Err(sim.unanswered(&program, &dialogue));
        }
        sim.world.borrow_mut().come_to_rest();
        let record = sim.world.borrow_mut().take_record();
        Ok(sim.outcome_of(record, (program, dialogue)))
    }
}

/// A line after which lines are not answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Silencer {
    /// Line number in the file, from 1.
    pub line: usize,
    /// Its text.
    pub text: String,
    /// Its effect, as the end of a sentence that begins with the line.
    pub effect: &'static str,
}

/// The last line that was answered and not refused, and that puts the console to sleep or resets it.
pub fn silencer(program: &Program, dialogue: &Dialogue) -> Option<Silencer> {
    let is_refused = |index: usize| dialogue.refusals.iter().any(|refusal| refusal.sent_before == index);
    let answered = program.iter().enumerate().take(dialogue.answered).filter(|(index, _)| !is_refused(*index));
    let mut checks = false;
    let silencers = answered.filter_map(|(index, text)| {
        let effect = effect(text, &mut checks)?;
        Some(Silencer { line: program.number(index + 1), text: String::from_utf8_lossy(text).into_owned(), effect })
    });
    silencers.last()
}

/// The effect of a line that silences the console. `checks` is whether G-code is only checked, `$C`.
fn effect(text: &[u8], checks: &mut bool) -> Option<&'static str> {
    let line = stripped(text).ok()?;
    match Interpreter::new().interpret(&line, ReportedState::Idle, &Settings::DEFAULT).ok()? {
        Command::Sleep => Some("puts the machine to sleep"),
        Command::Restore { .. } => Some("resets the console"),
        Command::ToggleCheck => {
            *checks = !*checks;
            (!*checks).then_some("ends checking and resets the console")
        }
        _ => None,
    }
}
