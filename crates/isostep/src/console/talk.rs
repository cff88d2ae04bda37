//! Sends lines that a person types or a program pipes in, in order, and shows everything that the machine sends.

use std::collections::VecDeque;
use std::io::BufRead;
use std::sync::mpsc::Sender;
use std::thread;

use anyhow::{Result, bail};
use isostep_program::changes_tool;
use isostep_sim::program::{self, ProgramError};

use super::meaning::explained;
use super::session::{Event, Session};
use super::status::Status;
use super::tool_wait::ToolWait;

/// The beginning of a message that says why a typed line is not sent.
pub const NOT_SENT: &str = "not sent";

/// What goes on when the machine is held.
const RESUMES: &str = "~ resumes it, alone on a line; so does the cycle-start button";

/// What a person may do while the machine waits for a tool.
pub const BY_HAND: &str = "jog ($J=), measure it ($TPW) or set Z (G10 L20 P0 Z); ~ goes on, the cycle-start button too";

/// Typed lines that are kept, because a comment about a tool may be in them.
const KEPT_LINES: usize = 1_000;

/// The sources of lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Typist {
    /// A person: lines are sent as the machine has room, and quitting ends it at once.
    Person,
    /// A file or a program: a line is sent when the previous one is answered, and quitting ends it when all are
    /// answered.
    Pipe,
}

/// Reads lines in a thread, because reading can block while the machine keeps sending. Its end is [`Event::Quit`].
pub fn read(input: impl BufRead + Send + 'static, typist: Sender<Event>) {
    thread::spawn(move || {
        for line in input.split(b'\n') {
            let Ok(line) = line else { break };
            let line = line.strip_suffix(b"\r").unwrap_or(&line);
            // Sending fails when the session has ended.
            let _ = typist.send(Event::Typed(String::from_utf8_lossy(line).into_owned()));
        }
        let _ = typist.send(Event::Quit);
    });
}

/// Runs until the typist quits. `show` gets every line to be shown; `tick` is called regularly.
///
/// # Errors
/// Errors of the port and of `show`.
pub fn run(
    session: &mut Session,
    typist: Typist,
    mut show: impl FnMut(&str) -> Result<()>,
    mut tick: impl FnMut(&Session) -> Result<()>,
) -> Result<()> {
    let (mut waiting, mut by_hand) = (VecDeque::new(), VecDeque::new());
    let mut has_quit = false;
    let mut is_hold_reported = false;
    let (mut typed, mut tool) = (VecDeque::new(), None);
    loop {
        if session.changes_tool() && typist == Typist::Person {
            send_by_hand(session, &mut by_hand, &mut show)?;
        } else {
            waiting.extend(by_hand.drain(..));
            send(session, typist, &mut waiting, &mut show)?;
        }
        if has_quit && (typist == Typist::Person || waiting.is_empty() && session.is_answered()) {
            return Ok(());
        }
        if typist == Typist::Pipe && session.is_cut_off() && !session.is_answered() {
            bail!("after the alarm the machine leaves {} bytes unanswered", session.flight().in_flight());
        }
        match session.next()? {
            Some(Event::Heard(line)) => {
                show(&explained(&line))?;
                let index = typed.iter().rposition(|line: &String| changes_tool(line.as_bytes()));
                tool = ToolWait::read(&line, typed.make_contiguous(), index).or(tool);
            }
            Some(Event::Typed(line)) => {
                typed.push_back(line.clone());
                if typed.len() > KEPT_LINES {
                    typed.pop_front();
                }
                let is_by_hand = session.changes_tool() && typist == Typist::Person;
                if is_by_hand { by_hand.push_back(line) } else { waiting.push_back(line) }
            }
            Some(Event::AtOnce(byte)) => session.send_at_once(byte)?,
            Some(Event::Quit) => has_quit = true,
            Some(Event::Gone(_)) | None => {}
        }
        let waits_for_tool = session.status().is_some_and(Status::is_tool) && session.is_held();
        let waits = session.is_held() && !session.is_answered() || waits_for_tool;
        if waits && !is_hold_reported {
            show(&waiting_words(waits_for_tool, tool.as_ref()))?;
        }
        // In a change of the tool it is said once, whatever is done by hand.
        let goes_on = is_hold_reported && session.changes_tool();
        if is_hold_reported && !goes_on && !session.status().is_some_and(Status::is_held) {
            tool = None;
        }
        is_hold_reported = waits || goes_on;
        tick(session)?;
    }
}

/// The machine waits, and what goes on.
fn waiting_words(waits_for_tool: bool, tool: Option<&ToolWait>) -> String {
    match tool {
        Some(tool) if waits_for_tool => format!("the machine waits for {}; {BY_HAND}", tool.words()),
        Some(tool) => format!("the machine waits (Hold) for {}; {RESUMES}", tool.words()),
        None if waits_for_tool => format!("the machine waits for another tool; {BY_HAND}"),
        None => format!("the machine waits (Hold): {RESUMES}"),
    }
}

/// Sends what a person has typed in a change of the tool, past the lines that wait for its end.
fn send_by_hand(
    session: &mut Session,
    by_hand: &mut VecDeque<String>,
    show: &mut impl FnMut(&str) -> Result<()>,
) -> Result<()> {
    while let Some(line) = by_hand.front() {
        if let Some(byte) = at_once(line) {
            session.send_at_once(byte)?;
        } else {
            match cleaned(line) {
                Err(error) => show(&format!("{NOT_SENT}: {error}"))?,
                Ok(bytes) if session.takes_by_hand(&bytes) => session.send_by_hand(&bytes)?,
                Ok(_) => return Ok(()),
            }
        }
        by_hand.pop_front();
    }
    Ok(())
}

/// Sends the lines of `waiting` that may be sent now.
fn send(
    session: &mut Session,
    typist: Typist,
    waiting: &mut VecDeque<String>,
    show: &mut impl FnMut(&str) -> Result<()>,
) -> Result<()> {
    while let Some(line) = waiting.front() {
        if let Some(byte) = at_once(line) {
            // From a pipe, such a byte must wait until the lines before it are answered. A machine that is held may
            // answer none before it is resumed.
            if typist == Typist::Pipe && !session.is_answered() && !session.is_held() {
                return Ok(());
            }
            session.send_at_once(byte)?;
        } else {
            match cleaned(line) {
                Err(error) => show(&format!("{NOT_SENT}: {error}"))?,
                Ok(bytes) if may_go(session, typist, &bytes) => session.send_line(&bytes)?,
                Ok(_) => return Ok(()),
            }
        }
        waiting.pop_front();
    }
    Ok(())
}

fn may_go(session: &Session, typist: Typist, bytes: &[u8]) -> bool {
    match typist {
        Typist::Person => session.has_room(bytes),
        Typist::Pipe => session.is_answered(),
    }
}

/// The byte of a line that consists of one byte, if that byte acts at once.
pub fn at_once(line: &str) -> Option<u8> {
    match line.trim_matches(' ').as_bytes() {
        &[byte @ (b'?' | b'!' | b'~' | super::session::RESET)] => Some(byte),
        _ => None,
    }
}

/// The line without bytes that act at once, ready to be sent.
pub fn cleaned(line: &str) -> Result<Vec<u8>, String> {
    match program::lines(line.as_bytes()) {
        Ok(lines) => Ok(lines.concat()),
        Err(ProgramError::Empty) => Ok(Vec::new()),
        Err(ProgramError::Line(error)) => Err(error.to_string()),
        Err(ProgramError::Binary { byte, .. }) => Err(format!("byte 0x{byte:02x} is not text: use plain ASCII")),
        Err(ProgramError::RealTime { byte, .. }) => {
            Err(format!("'{0}' acts at once wherever it stands: send {0} alone on a line", char::from(byte)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lone_real_time_byte_acts_at_once_and_none_hides_in_a_line() {
        assert_eq!((at_once("?"), at_once(" ! "), at_once("\x18")), (Some(b'?'), Some(b'!'), Some(0x18)));
        assert_eq!((at_once("??"), at_once(""), at_once("$")), (None, None, None));
        assert_eq!(cleaned("G0 X1 (really?)"), Ok(b"G0 X1 (really )".to_vec()));
        assert_eq!(cleaned("  "), Ok(vec![]));
        assert!(cleaned("G0 X1 !").unwrap_err().contains("'!' acts at once"));
        assert!(cleaned("G0 X1 µ").unwrap_err().contains("0xc2"));
    }
}
