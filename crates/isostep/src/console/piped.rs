//! The console for lines from a file or a program instead of a person.

use std::io::BufRead;

use anyhow::{Result, bail};

use super::meaning::explained;
use super::session::{Event, Session};
use super::talk::{self, Typist};

/// Sends the lines of `input`, each when the previous one is answered, and passes every line that the machine sends to
/// `show`. Ends when the machine is at rest.
///
/// # Errors
/// When a line is refused or an alarm occurs.
pub fn run(session: &mut Session, input: impl BufRead + Send + 'static, mut show: impl FnMut(&str)) -> Result<()> {
    talk::read(input, session.typist());
    let mut unsent = 0;
    talk::run(
        session,
        Typist::Pipe,
        |line| {
            unsent += u32::from(line.starts_with(talk::NOT_SENT));
            show(line);
            Ok(())
        },
        |_| Ok(()),
    )?;
    let report = session.ask_rest()?;
    while !session.is_at_rest(report) {
        if let Some(Event::Heard(line)) = session.next()? {
            show(&explained(&line));
        }
    }
    let refused = session.flight().refused;
    match (session.is_alarmed(), refused, unsent) {
        (true, ..) => bail!("an alarm came"),
        (false, 0, 0) => Ok(()),
        (false, refused, 0) => bail!("lines refused: {refused} of {}", session.flight().answered),
        (false, _, unsent) => bail!("lines not fit to be sent: {unsent}"),
    }
}
