//! The console for a person at a terminal.

use std::thread;

use anyhow::{Context, Result, anyhow};
use rustyline::ExternalPrinter;
use rustyline::error::ReadlineError;

use super::prompt::{Ahead, Prompt};
use super::session::{Event, Session};
use super::talk::{self, Typist};

/// Makes the prompt redraw without a new line above it: moves the cursor up and down again.
const REDRAW: &str = "\x1b[A\n";

/// Runs until the person ends it.
///
/// # Errors
/// Errors of the port and of the terminal.
pub fn run(mut session: Session, name: &str) -> Result<()> {
    println!("{name}: Ctrl-X resets; on an empty line ! holds, ~ resumes, ? reports at once; Ctrl-D ends");
    let typist = session.typist();
    let mut prompt = Prompt::new(&typist)?;
    let (mut printer, ahead) = (prompt.printer()?, prompt.ahead());
    update(&ahead, &session);
    let talk = thread::spawn(move || {
        let ended = talk(&mut session, &mut printer, &ahead);
        if let Err(error) = &ended {
            // This thread cannot end the prompt.
            let _ = printer.print(format!("{error:#}: press Enter to end"));
        }
        ended
    });
    while let Some(line) = next_line(&mut prompt)? {
        if typist.send(Event::Typed(line)).is_err() {
            break;
        }
    }
    let _ = typist.send(Event::Quit);
    talk.join().map_err(|_| anyhow!("the session broke down"))?
}

fn talk(session: &mut Session, printer: &mut impl ExternalPrinter, ahead: &Ahead) -> Result<()> {
    let printer = std::cell::RefCell::new(printer);
    let print = |text: String| printer.borrow_mut().print(text).context("the terminal is gone");
    talk::run(
        session,
        Typist::Person,
        |line| print(format!("{line}\n")),
        |session| if update(ahead, session) { print(REDRAW.to_owned()) } else { Ok(()) },
    )
}

/// Updates the status before the prompt. Returns whether the prompt has to be redrawn.
fn update(ahead: &Ahead, session: &Session) -> bool {
    session.status().is_some_and(|status| ahead.set(status.to_string()))
}

/// The next line; `None` when the person ends the console.
fn next_line(prompt: &mut Prompt) -> Result<Option<String>> {
    loop {
        match prompt.line() {
            Ok(line) => return Ok(Some(line)),
            Err(ReadlineError::Eof) => return Ok(None),
            Err(ReadlineError::Interrupted) => println!("Ctrl-X resets the machine, Ctrl-D ends this console"),
            Err(error) => return Err(error).context("the terminal cannot be read"),
        }
    }
}
