//! The line that a person types on, with editing, history, the machine's status before it, and keys that act at once.

use std::borrow::Cow;
use std::path::PathBuf;
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex};

use anyhow::{Context, Result};
use rustyline::completion::Completer;
use rustyline::highlight::Highlighter;
use rustyline::hint::Hinter;
use rustyline::history::FileHistory;
use rustyline::validate::Validator;
use rustyline::{
    Cmd, ConditionalEventHandler, Editor, Event as Keys, EventContext, EventHandler, Helper, KeyEvent, RepeatCount,
};

use super::session::{Event, RESET};
use super::status;

/// File in the home folder that keeps the lines that a person typed.
const HISTORY: &str = ".isostep-history";

/// The text before the prompt. It changes while the person types.
#[derive(Clone, Default)]
pub struct Ahead(Arc<Mutex<String>>);

impl Ahead {
    /// Sets the text. Returns whether it differs from the previous one.
    pub fn set(&self, text: String) -> bool {
        let mut ahead = self.0.lock().expect("nobody panics with it");
        let is_new = *ahead != text;
        *ahead = text;
        is_new
    }

    fn get(&self) -> String {
        self.0.lock().expect("nobody panics with it").clone()
    }
}

/// The line editor, with its history and its keys.
pub struct Prompt {
    editor: Editor<Drawn, FileHistory>,
    history: PathBuf,
    ahead: Ahead,
}

impl Prompt {
    /// A prompt whose keys are sent to `typist`.
    pub fn new(typist: &Sender<Event>) -> Result<Self> {
        let mut editor = Editor::new().context("this terminal cannot be edited on")?;
        let ahead = Ahead::default();
        editor.set_helper(Some(Drawn(ahead.clone())));
        for byte in [b'!', b'~', b'?'] {
            let key = AtOnce { byte, only_first: true, typist: typist.clone() };
            editor.bind_sequence(KeyEvent::from(char::from(byte)), EventHandler::Conditional(Box::new(key)));
        }
        let reset = AtOnce { byte: RESET, only_first: false, typist: typist.clone() };
        editor.bind_sequence(KeyEvent::ctrl('X'), EventHandler::Conditional(Box::new(reset)));
        let history = std::env::home_dir().unwrap_or_default().join(HISTORY);
        // There is no history the first time.
        let _ = editor.load_history(&history);
        Ok(Self { editor, history, ahead })
    }

    /// A handle to the text before the prompt.
    pub fn ahead(&self) -> Ahead {
        self.ahead.clone()
    }

    /// Prints above the prompt, from any thread.
    pub fn printer(&mut self) -> Result<impl rustyline::ExternalPrinter + Send + use<>> {
        Ok(self.editor.create_external_printer()?)
    }

    /// Reads the next line.
    pub fn line(&mut self) -> rustyline::Result<String> {
        // The blanks are as wide as the status that is drawn in their place.
        let line = self.editor.readline(&format!("{:1$}> ", "", status::WIDTH + 1))?;
        if !line.trim().is_empty() {
            self.editor.add_history_entry(&line)?;
            // A failure to save the history must not end the console of a machine.
            let _ = self.editor.save_history(&self.history);
        }
        Ok(line)
    }
}

/// A key that acts at once.
struct AtOnce {
    byte: u8,
    /// The key acts only on an empty line; elsewhere it is an ordinary character.
    only_first: bool,
    typist: Sender<Event>,
}

impl ConditionalEventHandler for AtOnce {
    fn handle(&self, _keys: &Keys, _count: RepeatCount, _positive: bool, context: &EventContext) -> Option<Cmd> {
        if self.only_first && !context.line().is_empty() {
            return None;
        }
        // If the session has ended, sending fails, and the prompt ends at the next line.
        let _ = self.typist.send(Event::AtOnce(self.byte));
        Some(Cmd::Noop)
    }
}

/// Draws the status in place of the prompt's blanks.
struct Drawn(Ahead);

impl Highlighter for Drawn {
    fn highlight_prompt<'b, 's: 'b, 'p: 'b>(&'s self, prompt: &'p str, default: bool) -> Cow<'b, str> {
        if default { Cow::Owned(format!("{:1$.1$} > ", self.0.get(), status::WIDTH)) } else { Cow::Borrowed(prompt) }
    }
}

impl Completer for Drawn {
    type Candidate = String;
}

impl Hinter for Drawn {
    type Hint = String;
}

impl Validator for Drawn {}

impl Helper for Drawn {}
