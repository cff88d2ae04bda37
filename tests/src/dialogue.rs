//! Dialogues as text: what is sent to a simulated machine, what it answers, and what it does, in the files of
//! `tests/dialogues`. `tests/dialogues/README.md` describes the format.

mod parse;
mod pattern;
mod run;
mod step;

use std::fs;

pub use parse::{Dialogue, dialogues};
pub use run::carry_out;

/// Carries out the dialogue of this name in a file of `tests/dialogues`.
///
/// # Panics
/// If the file does not have it, at a line that is no step, and where the machine does otherwise than is written.
pub fn carry_out_file(file: &str, name: &str) {
    let path = crate::root().join("tests/dialogues").join(file);
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let dialogues = dialogues(&text).unwrap_or_else(|error| panic!("tests/dialogues/{file}:{error}"));
    let dialogue = dialogues.iter().find(|dialogue| dialogue.name == name);
    let dialogue = dialogue.unwrap_or_else(|| panic!("tests/dialogues/{file} has no `=== {name}`"));
    carry_out(dialogue).unwrap_or_else(|error| panic!("{name}, tests/dialogues/{file}:{error}"));
}
