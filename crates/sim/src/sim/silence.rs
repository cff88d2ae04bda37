//! Finds the line of a program after which the console stopped answering.

use isostep_console::{Command, Interpreter, ReportedState, Settings};

use crate::program::stripped;
use crate::stream::Dialogue;

/// A line after which lines are not answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Silencer {
    /// Line number in the program, from 1.
    pub line: usize,
    /// Its text.
    pub text: String,
    /// Its effect, as the end of a sentence that begins with the line.
    pub effect: &'static str,
}

/// The last line that was answered and not refused, and that puts the console to sleep or resets it.
pub fn silencer(program: &[Vec<u8>], dialogue: &Dialogue) -> Option<Silencer> {
    let is_refused = |line: usize| dialogue.refusals.binary_search_by_key(&line, |refusal| refusal.line).is_ok();
    let answered = (1..).zip(program).take(dialogue.answered).filter(|&(line, _)| !is_refused(line));
    let mut checks = false;
    let silencers = answered.filter_map(|(line, text)| {
        let effect = effect(text, &mut checks)?;
        Some(Silencer { line, text: String::from_utf8_lossy(text).into_owned(), effect })
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
