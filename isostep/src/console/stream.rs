//! Sends a whole program as fast as the machine accepts it.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result, bail, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use signal_hook::consts::SIGINT;
use signal_hook::flag;

use super::meaning::explained;
use super::session::{Event, RESET, Session};
use crate::project;
use crate::stopwatch::Stopwatch;

/// A program to be sent.
pub struct Program {
    name: String,
    lines: Vec<Vec<u8>>,
}

impl Program {
    /// Reads the program, and refuses a program that must not be sent.
    pub fn read(path: &Path) -> Result<Self> {
        let name = project::shown(path);
        let bytes = std::fs::read(path).with_context(|| format!("{name} cannot be read"))?;
        let lines = isostep_sim::program::lines(&bytes).with_context(|| name.clone())?;
        Ok(Self { name, lines })
    }

    /// The line of this number, counted from 1, as an error names it.
    fn place(&self, number: u64) -> String {
        match self.lines.get((number - 1) as usize) {
            Some(line) => format!("{}:{number}: `{}`", self.name, String::from_utf8_lossy(line).trim()),
            None => "none".to_owned(),
        }
    }
}

/// Streams the program by counting characters, and waits until the machine is at rest.
///
/// # Errors
/// When a line is refused or an alarm occurs, after which no further line is sent; when Ctrl-C ends it.
pub fn run(session: &mut Session, program: &Program) -> Result<()> {
    let (bar, stopwatch) = (bar(program), Stopwatch::start());
    let interrupt = Interrupt::new()?;
    let mut stream = Stream { session, program, sent: 0, refusal: None, alarm: None, stopped: false, interrupt };
    let ended = stream.run(&bar);
    bar.finish_and_clear();
    ended?;
    let flight = session.flight();
    println!(
        "{}: {} lines answered in {:.1} s, at most {} bytes ahead; {}",
        program.name,
        flight.answered,
        stopwatch.elapsed_s(),
        flight.most,
        session.status().map_or_else(String::new, ToString::to_string)
    );
    Ok(())
}

fn bar(program: &Program) -> ProgressBar {
    let template = "{bar:20} {pos}/{len} lines, {elapsed} gone, {eta} left   {msg}";
    let style = ProgressStyle::with_template(template).expect("a template of ours");
    ProgressBar::new(program.lines.len() as u64).with_style(style)
}

struct Stream<'a> {
    session: &'a mut Session,
    program: &'a Program,
    sent: usize,
    /// The first line that was refused, and why.
    refusal: Option<String>,
    /// The first alarm.
    alarm: Option<String>,
    /// Whether Ctrl-C has ended the stream.
    stopped: bool,
    interrupt: Interrupt,
}

impl Stream<'_> {
    fn run(&mut self, bar: &ProgressBar) -> Result<()> {
        while self.fill()? || self.session.flight().in_flight() > 0 {
            if self.session.is_cut_off() {
                break;
            }
            self.look(bar)?;
        }
        // Waits until everything that was accepted is carried out.
        let report = self.session.ask_rest()?;
        while !self.session.is_at_rest(report) {
            self.look(bar)?;
        }
        self.verdict()
    }

    fn verdict(&self) -> Result<()> {
        match (&self.alarm, &self.refusal) {
            (Some(alarm), Some(refusal)) => bail!("{alarm}\n  {refusal}"),
            (Some(trouble), None) | (None, Some(trouble)) => bail!("{trouble}"),
            (None, None) => {
                let total = self.program.lines.len();
                ensure!(!self.stopped || self.sent == total, "ended by Ctrl-C after line {} of {total}", self.sent);
                Ok(())
            }
        }
    }

    /// Sends the lines that there is room for. Returns whether more lines remain.
    fn fill(&mut self) -> Result<bool> {
        let in_trouble = self.stopped || self.refusal.is_some() || self.alarm.is_some();
        while !in_trouble && let Some(line) = self.program.lines.get(self.sent) {
            if !self.session.has_room(line) {
                return Ok(true);
            }
            self.session.send_line(line)?;
            self.sent += 1;
        }
        Ok(false)
    }

    /// Waits a short while for the next event and handles it.
    fn look(&mut self, bar: &ProgressBar) -> Result<()> {
        if let Some(Event::Heard(line)) = self.session.next()? {
            self.hear(&line, bar)?;
        }
        if self.interrupt.came() {
            if self.stopped {
                self.session.send_at_once(RESET)?;
                bail!("the machine was reset by Ctrl-C, and its position is not trusted: home it");
            }
            bar.println("no further line is sent; Ctrl-C again resets the machine at once");
            self.stopped = true;
        }
        bar.set_position(self.session.flight().answered);
        if let Some(status) = self.session.status() {
            bar.set_message(status.to_string());
        }
        Ok(())
    }

    fn hear(&mut self, line: &str, bar: &ProgressBar) -> Result<()> {
        ensure!(!line.starts_with("Grbl"), "the machine was reset after line {} of the program", self.sent);
        if line == "ok" {
            return Ok(());
        }
        let number = self.session.flight().answered;
        if line.starts_with("error:") {
            let place = self.program.place(number);
            self.refusal.get_or_insert_with(|| format!("{place} was refused: {}", explained(line)));
        } else if line.starts_with("ALARM:") {
            self.alarm.get_or_insert_with(|| explained(line));
        } else {
            bar.suspend(|| println!("{line}"));
        }
        Ok(())
    }
}

/// Whether Ctrl-C was pressed since the last look.
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
