//! Sends a whole program as fast as the machine accepts it.
//!
//! # Design
//! Characters are counted, so the machine always has lines that it has not answered yet. When it refuses one, those
//! behind it are on their way already. So the stream holds the machine and leaves the decision to the person
//! (`refusal`). Without one it stops.

mod program;
mod refusal;
mod time;

use std::collections::VecDeque;
use std::io::BufRead;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Result, bail, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use signal_hook::consts::SIGINT;
use signal_hook::flag;

pub use self::program::Program;
use self::program::Sending;
use self::refusal::Refused;
use self::time::StreamTime;
use super::meaning::explained;
use super::session::{Event, RESET, Session};
use super::status::Status;
use super::talk::{self, BY_HAND, NOT_SENT, Typist};
use super::tool_wait::ToolWait;
use crate::stopwatch::Stopwatch;

/// The longest time that a machine takes to brake after a reset and to send its welcome.
const RESET_S: f64 = 10.0;

/// The way in which a program is streamed.
#[derive(Clone, Copy, Debug)]
pub struct How {
    /// The typist, who can be asked, and who resumes the machine where it waits.
    pub typist: Typist,
    /// Refused lines are passed over.
    pub keep_going: bool,
}

/// Streams the program by counting characters, and waits until the machine is at rest. `input` is what is typed
/// meanwhile; `show` gets every line to be shown.
///
/// # Errors
/// When a line is refused or an alarm occurs; when Ctrl-C ends it.
pub fn run(
    session: &mut Session,
    program: &Program,
    how: How,
    input: impl BufRead + Send + 'static,
    show: impl FnMut(&str),
) -> Result<()> {
    let (bar, stopwatch) = (bar(program), Stopwatch::start());
    talk::read(input, session.typist());
    let is_checking = session.status().is_some_and(|status| status.state == "Check");
    let mut stream = Stream {
        session,
        program,
        sending: program.sending()?,
        how,
        show,
        bar: &bar,
        refused: Vec::new(),
        decided: 0,
        alarm: None,
        is_over: false,
        is_checking,
        typed: VecDeque::new(),
        is_input_over: false,
        is_hold_reported: false,
        asked: None,
        hand: None,
        time: StreamTime::start(),
        interrupts: 0,
        is_interrupt_reported: false,
        reset: None,
        interrupt: Interrupt::new()?,
    };
    let ended = stream.run();
    bar.finish_and_clear();
    let Stream { mut show, .. } = stream;
    ended?;
    let flight = session.flight();
    show(&format!(
        "{}: {} lines answered in {:.1} s, at most {} bytes ahead; {}",
        program.name,
        flight.answered,
        stopwatch.elapsed_s(),
        flight.most,
        session.status().map_or_else(String::new, ToString::to_string)
    ));
    Ok(())
}

fn bar(program: &Program) -> ProgressBar {
    let template = "{bar:20} {pos}/{len} lines, {prefix}   {msg}";
    let style = ProgressStyle::with_template(template).expect("a template of ours");
    ProgressBar::new(program.total as u64).with_style(style).with_prefix("just begun")
}

/// A tool that M6 asks for.
struct ToolAtLine {
    tool: ToolWait,
    /// The line that does, as an error names it.
    place: String,
}

struct Stream<'a, S> {
    session: &'a mut Session,
    program: &'a Program,
    sending: Sending<'a>,
    how: How,
    show: S,
    bar: &'a ProgressBar,
    refused: Vec<Refused>,
    /// The number of refused lines that the stream has gone on from.
    decided: usize,
    /// The first alarm.
    alarm: Option<String>,
    /// No further line is sent.
    is_over: bool,
    /// The machine is in check mode (`$C`), in which nothing moves.
    is_checking: bool,
    /// Lines that were typed and are not carried out yet.
    typed: VecDeque<String>,
    is_input_over: bool,
    /// The person knows that the machine is held.
    is_hold_reported: bool,
    /// The tool that M6 has asked for.
    asked: Option<ToolAtLine>,
    /// A line by hand that is not answered yet.
    hand: Option<String>,
    time: StreamTime,
    /// The times that Ctrl-C was pressed.
    interrupts: u32,
    is_interrupt_reported: bool,
    /// While we reset the machine: whether it has sent its welcome.
    reset: Option<bool>,
    interrupt: Interrupt,
}

impl<S: FnMut(&str)> Stream<'_, S> {
    fn run(&mut self) -> Result<()> {
        while self.fill()? || self.session.flight().in_flight() > 0 {
            if self.session.is_cut_off() {
                break;
            }
            self.look()?;
            self.act()?;
            self.decide()?;
        }
        // Waits until everything that was accepted is carried out.
        let report = self.session.ask_rest()?;
        while !self.session.is_at_rest(report) || self.session.is_held() || self.session.changes_tool() {
            self.look()?;
            self.act()?;
        }
        self.verdict()
    }

    fn verdict(&self) -> Result<()> {
        let (sent, total) = (self.sending.sent, self.program.total);
        let mut trouble: Vec<String> = self.alarm.iter().cloned().collect();
        trouble.extend(refusal::listed(&self.refused, self.alarm.is_some()));
        if sent < total && (self.is_over || !trouble.is_empty()) {
            let by = if trouble.is_empty() { "ended by Ctrl-C: " } else { "" };
            trouble.push(format!("{by}{} were not sent", self.program.span(sent + 1, total)));
        }
        ensure!(trouble.is_empty(), "{}", trouble.join("\n  "));
        Ok(())
    }

    /// Sends the lines that there is room for. Returns whether more lines remain.
    fn fill(&mut self) -> Result<bool> {
        self.sending.forget_before(self.first_in_question());
        while !self.is_over
            && let Some(line) = self.sending.next()
        {
            // A line that is sent now would be taken for one by hand.
            if self.session.is_by_hand() || !self.session.has_room(line) {
                return Ok(true);
            }
            self.session.send_line(line)?;
            self.sending.go_on();
        }
        Ok(false)
    }

    /// The first line that may still be asked for: it has no answer yet, or what is to become of those behind it is not decided.
    fn first_in_question(&self) -> usize {
        self.refused.get(self.decided).map_or(self.answered() + 1, |refused| refused.number)
    }

    /// Lines answered.
    fn answered(&self) -> usize {
        self.session.flight().answered as usize
    }

    /// Waits a short while for the next event and notes it.
    fn look(&mut self) -> Result<()> {
        match self.session.next()? {
            Some(Event::Heard(line)) => self.hear(&line)?,
            Some(Event::Typed(line)) => self.typed.push_back(line),
            Some(Event::Quit) => self.is_input_over = true,
            Some(Event::AtOnce(_) | Event::Gone(_)) | None => {}
        }
        self.interrupts += u32::from(self.interrupt.came());
        self.draw();
        Ok(())
    }

    /// Draws the bar, but only if something has changed: drawing wipes out what is being typed.
    fn draw(&mut self) {
        let answered = self.session.flight().answered;
        self.time.look(self.session.status().is_some_and(Status::is_held) || self.session.changes_tool());
        if self.bar.position() != answered {
            self.bar.set_prefix(self.time.words(answered, self.program.total));
            self.bar.set_position(answered);
        }
        let status = self.session.status().map_or_else(String::new, ToString::to_string);
        if self.bar.message() != status {
            self.bar.set_message(status);
        }
    }

    fn hear(&mut self, line: &str) -> Result<()> {
        if line.starts_with("Grbl") {
            ensure!(self.reset.is_some(), "the machine was reset after line {} of the program", self.last_sent());
            self.reset = Some(true);
            self.hand = None;
        } else if let Some(hand) = self.hand.take_if(|_| line == "ok" || line.starts_with("error:")) {
            self.say(&format!("{} (`{hand}`)", explained(line)));
        } else if line.starts_with("error:") && self.reset.is_none() {
            let number = self.answered();
            let place = self.place(number).unwrap_or_default();
            self.refused.push(Refused { number, place, answer: line.to_owned() });
        } else if line.starts_with("ALARM:") {
            self.alarm.get_or_insert_with(|| explained(line));
            self.is_over = true;
        } else if line != "ok" {
            // What Grbl says to `$C`.
            self.is_checking = line == "[MSG:Enabled]" || self.is_checking && line != "[MSG:Disabled]";
            self.note_tool(line);
            self.say(line);
        }
        Ok(())
    }

    /// Notes the tool that a message of M6 asks for: it comes before the answer to its line.
    fn note_tool(&mut self, message: &str) {
        let number = self.answered() + 1;
        let in_file = self.sending.line(number).map(|(number, _)| number);
        if let Some(tool) = self.program.tool_wait(message, in_file) {
            self.asked = Some(ToolAtLine { tool, place: self.place(number).unwrap_or_default() });
        }
    }

    /// A line that was sent, as an error names it.
    fn place(&self, number: usize) -> Option<String> {
        self.sending.line(number).map(|line| self.program.place(&line))
    }

    /// The line of the file that was sent last, 0 for none.
    fn last_sent(&self) -> usize {
        self.sending.line(self.sending.sent).map_or(self.sending.sent, |(number, _)| number)
    }

    fn say(&mut self, line: &str) {
        let show = &mut self.show;
        self.bar.suspend(|| show(line));
    }

    /// Does what was typed, and says when the machine waits for somebody.
    fn act(&mut self) -> Result<()> {
        if self.interrupts > 1 {
            let stand = self.reset_machine()?;
            bail!("reset by Ctrl-C after line {} of {}: {stand}", self.sending.sent, self.program.total);
        }
        if self.interrupts == 1 && !self.is_interrupt_reported {
            (self.is_interrupt_reported, self.is_over) = (true, true);
            let resume = if self.session.is_held() { "~ resumes what was sent; " } else { "" };
            self.say(&format!("no further line is sent; {resume}Ctrl-C again resets the machine at once"));
        }
        while let Some(line) = self.typed.pop_front() {
            match talk::at_once(&line) {
                // What is piped in was written before anybody knew when the machine waits.
                Some(_) if self.how.typist == Typist::Pipe && !self.session.is_held() => {
                    self.typed.push_front(line);
                    break;
                }
                // It would be lost while the machine jogs or measures.
                Some(b'~') if self.session.changes_tool() && (self.hand.is_some() || !self.session.is_held()) => {
                    self.typed.push_front(line);
                    break;
                }
                Some(byte) => {
                    self.session.send_at_once(byte)?;
                    self.is_hold_reported = false;
                }
                None if line.trim().is_empty() => {}
                None if self.session.changes_tool() => {
                    if !self.send_by_hand(&line)? {
                        self.typed.push_front(line);
                        break;
                    }
                }
                None => self.say(&format!("{NOT_SENT}: `{line}`: while a program is streamed only ! ~ and ? act")),
            }
        }
        self.tell_hold();
        Ok(())
    }

    /// Sends a typed line, past those of the program, which wait for the new tool. Returns false if it has to wait.
    fn send_by_hand(&mut self, line: &str) -> Result<bool> {
        match talk::cleaned(line) {
            Err(error) => self.say(&format!("{NOT_SENT}: {error}")),
            Ok(bytes) if self.hand.is_some() || !self.session.takes_by_hand(&bytes) => return Ok(false),
            Ok(bytes) => {
                self.session.send_by_hand(&bytes)?;
                self.hand = Some(line.trim().to_owned());
            }
        }
        Ok(true)
    }

    fn tell_hold(&mut self) {
        let is_held = self.session.status().is_some_and(Status::is_held);
        if self.is_hold_reported && !is_held && !self.session.changes_tool() {
            self.asked = None;
        }
        self.is_hold_reported &= is_held || self.session.changes_tool();
        if !self.session.is_held() || self.is_hold_reported {
            return;
        }
        self.is_hold_reported = true;
        let how = match (self.how.typist, self.is_input_over) {
            (Typist::Person, false) => "type ~ and Enter to go on, Ctrl-C to end",
            (Typist::Pipe, false) => "a line that is ~ alone, or the cycle-start button, goes on",
            (_, true) => "the cycle-start button, or ~ on another console, goes on",
        };
        let by_hand = if self.session.changes_tool() { format!("; {BY_HAND}") } else { String::new() };
        self.say(&format!("the machine waits {}: {how}{by_hand}", self.reason()));
    }

    /// Why it waits: for which tool, or in which state, and at which line.
    fn reason(&self) -> String {
        if let Some(ToolAtLine { tool, place }) = &self.asked {
            return format!("for {}; at {place}", tool.words());
        }
        let state = self.session.status().map_or("", |status| status.state.as_str());
        let place = self.place(self.answered() + 1).map_or(String::new(), |place| format!(" at {place}"));
        format!("({state}){place}")
    }

    /// Resets the machine, and waits until it stands still. Returns where it stands.
    fn reset_machine(&mut self) -> Result<String> {
        (self.reset, self.is_over) = (Some(false), true);
        self.session.send_at_once(RESET)?;
        let (since, mut interrupts) = (Stopwatch::start(), self.interrupts);
        while self.reset == Some(false) && since.elapsed_s() < RESET_S {
            self.look()?;
            if self.interrupts > interrupts {
                // The second reset before the first has ended is a stop at once.
                interrupts = self.interrupts;
                self.session.send_at_once(RESET)?;
            }
        }
        let report = self.session.ask_rest()?;
        while !self.session.is_at_rest(report) {
            self.look()?;
        }
        let alarm = self.alarm.as_ref().map_or(String::new(), |alarm| format!("; {alarm}"));
        Ok(self.session.status().map_or_else(String::new, |status| match status.is_locked() {
            true => format!("it is locked, and its position is not trusted: home it ($H){alarm}"),
            false => format!("it stands still with its outputs off, and its position is kept: {status}"),
        }))
    }
}

/// Ctrl-C was pressed since the last look.
struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    fn new() -> Result<Self> {
        let pressed = Arc::new(AtomicBool::new(false));
        flag::register(SIGINT, pressed.clone())?;
        Ok(Self(pressed))
    }

    fn came(&self) -> bool {
        self.0.swap(false, Ordering::Relaxed)
    }
}
