//! Dialogues as text: what is sent to a machine, what it answers, and what it does, in the files of `tests/dialogues`.
//! `tests/dialogues/README.md` describes the format. They are carried out on the simulated machine, on the emulated board, or on
//! both.

mod board;
mod machine;
mod parse;
mod pattern;
mod run;
mod simulated;
mod step;

use std::fs;

use isostep_sim::Port;

use board::{ByPio, ByTimer};
pub use parse::{Dialogue, On, Wrong, dialogues};
use simulated::Simulated;

/// Carries out the dialogue of this name in a file of `tests/dialogues`.
///
/// # Panics
/// If the file does not have it, at a line that is no step, and where the machine does otherwise than is written.
pub fn carry_out_file(file: &str, name: &str, on: On) {
    let path = crate::root().join("tests/dialogues").join(file);
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let dialogues = dialogues(&text).unwrap_or_else(|error| panic!("tests/dialogues/{file}:{error}"));
    let dialogue = dialogues.iter().find(|dialogue| dialogue.name == name);
    let dialogue = dialogue.unwrap_or_else(|| panic!("tests/dialogues/{file} has no `=== {name}`"));
    carry_out(dialogue, on).unwrap_or_else(|error| panic!("{name}, tests/dialogues/{file}:{error}"));
}

/// Carries out a dialogue on a machine. Whatever is heard must be written, before anything else is sent.
///
/// # Errors
/// The first line that is not so.
pub fn carry_out(dialogue: &Dialogue, on: On) -> Result<(), Wrong> {
    match on {
        On::Simulator => run::carry_out::<Simulated>(dialogue),
        On::Board(Port::Pio) => run::carry_out::<ByPio>(dialogue),
        On::Board(Port::Timer) => run::carry_out::<ByTimer>(dialogue),
    }
}
