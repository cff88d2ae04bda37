//! A program that is streamed piece by piece of time, so that somebody may look at it, or stop it, in between.

use std::cell::RefCell;
use std::rc::Rc;

use embassy_time::Instant;
use isostep_motion::State;

use super::{Progress, Sim, SimError};
use crate::executor::{Priority, Rest, RunError};
use crate::outcome::Outcome;
use crate::stream::{Dialogue, Program, Refusal, Sender};

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
            if !self.waits_for_operator() {
                return Ok(true);
            }
            self.dialogue.borrow_mut().note_pause(&self.program, self.sim.now_ns());
            self.sim.send(b"~");
            self.limit = self.sim.now() + self.sim.config.time_limit;
        }
        if until == self.limit {
            return Err(RunError::TimeLimit { limit: until, waiting: self.sim.executor.waiting() });
        }
        Ok(false)
    }

    fn waits_for_operator(&self) -> bool {
        self.dialogue.borrow().waiting_line().is_some() && self.sim.machine.state() == (State::Hold { still: true })
    }

    /// How far it has come.
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

    /// What was recorded since it was asked last, of moves those that nothing can change any more: see
    /// [`verify::Gathered`](crate::verify::Gathered). The dialogue is not in it.
    pub fn take_piece(&mut self) -> Outcome {
        self.sim.take_piece()
    }

    /// What is left after the last piece, and how it ended. Follows the rotors until they stand still.
    ///
    /// # Errors
    /// [`SimError::Silenced`] and [`SimError::Unanswered`].
    pub fn end(self) -> Result<Outcome, SimError> {
        let Self { sim, program, dialogue, .. } = self;
        let dialogue = dialogue.take();
        if !dialogue.done && dialogue.alarm.is_none() {
            return Err(sim.unanswered(&program, &dialogue));
        }
        sim.world.borrow_mut().come_to_rest();
        let record = sim.world.borrow_mut().take_record();
        Ok(sim.outcome_of(record, (program, dialogue)))
    }
}
