//! Lines that are no G-code, and what each line answers.

use super::machine::{Model, Startup, State};
use super::words::Word;

/// The request of a line.
#[derive(Clone, Debug, PartialEq)]
pub enum Asked {
    /// A block of G-code.
    Block(Vec<Word>),
    /// `$J=`.
    Jog(Vec<Word>),
    /// `$n=v`.
    Set(u16, f64),
    /// `$N0=`, `$N1=`.
    Startup(usize, Startup),
    /// `$I=`.
    Build(String),
    /// `$X`.
    Unlock,
    /// `$H`, or the axis of `$HX`.
    Home(Option<usize>),
    /// `$C`.
    Check,
    /// `$RST=`, with its last letter.
    Restore(char),
    /// A line that is refused with this number in every state in which it may be sent.
    Refused(u8),
}

/// A line and its meaning.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// As it is sent.
    pub text: String,
    /// Its meaning.
    pub asked: Asked,
}

impl Model {
    /// The answer to a line, without messages and alarms.
    pub fn line(&mut self, line: &Line) -> Vec<String> {
        let mut said = Vec::new();
        let mut restarts = false;
        let answer = match &line.asked {
            Asked::Block(words) => self.block(words),
            Asked::Jog(words) => self.jog(words),
            Asked::Refused(code) => Err(*code),
            Asked::Set(number, value) => {
                let answer = self.at_rest().and_then(|()| self.settings.set(*number, *value));
                self.judge_settings();
                answer
            }
            Asked::Startup(index, startup) => self.set_startup(*index, startup),
            Asked::Build(text) => self.at_rest().map(|()| self.build.clone_from(text)),
            Asked::Unlock if matches!(self.state, State::Alarm(_) | State::Unfit) => {
                self.settings.check().inspect(|()| {
                    self.state = State::Idle;
                    self.modes.stop_tool();
                    self.follow_carriage();
                })
            }
            Asked::Unlock => Ok(()),
            Asked::Home(axis) => self.home(*axis, &mut said),
            Asked::Check => match self.state {
                State::Alarm(_) | State::Unfit => Err(8),
                State::Idle => {
                    (self.state, self.in_spindle_before_check) = (State::Check, self.in_spindle);
                    Ok(())
                }
                State::Check => {
                    restarts = true;
                    Ok(())
                }
            },
            Asked::Restore(what) => {
                restarts = self.at_rest().is_ok();
                self.at_rest().map(|()| self.restore(*what))
            }
        };
        said.push(answer.err().map_or("ok".to_owned(), |code| format!("error:{code}")));
        if restarts {
            said.extend(self.reset());
        }
        said
    }

    fn at_rest(&self) -> Result<(), u8> {
        if self.state == State::Check { Err(8) } else { Ok(()) }
    }

    fn set_startup(&mut self, index: usize, startup: &Startup) -> Result<(), u8> {
        if self.state != State::Idle {
            return Err(8);
        }
        self.block(&startup.words)?;
        if startup.words.is_empty() && self.modes.inverse_time {
            // As in Grbl, an empty one is carried out too, and a feed of G93 is that of one block.
            self.modes.feed = 0;
        }
        self.startup[index] = startup.clone();
        Ok(())
    }

    fn home(&mut self, axis: Option<usize>, said: &mut Vec<String>) -> Result<(), u8> {
        self.at_rest()?;
        if self.settings.get(22) == 0.0 {
            return Err(5);
        }
        self.settings.check()?;
        if matches!(self.state, State::Alarm(_)) {
            self.modes.stop_tool();
        }
        self.state = State::Idle;
        for homes in (0..3).filter(|&homes| axis.is_none_or(|axis| axis == homes)) {
            (self.homed[homes], self.carriage[homes]) = (true, 0);
        }
        self.follow_carriage();
        if axis.is_none() {
            said.extend(self.start_up());
        }
        Ok(())
    }

    /// Restores what was there at first. Settings are restored elsewhere: the values depend on the machine.
    fn restore(&mut self, what: char) {
        if what == '$' && self.state == State::Unfit {
            self.state = State::Idle;
        }
        if what == '#' {
            (self.systems, self.places, self.startup) = ([[0; 3]; 9], [[0; 3]; 2], Default::default());
            self.tools.clear();
        }
    }
}
