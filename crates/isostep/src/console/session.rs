//! A conversation with a machine: sends bytes when the machine has room, receives lines, and polls the status.

use std::io::ErrorKind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use isostep_sim::link::Lines;
use serialport::SerialPort;

use super::port;
use super::status::Status;
use crate::flight::Flight;
use crate::stopwatch::Stopwatch;

const POLL_S: f64 = 0.2;
/// A machine that does not answer `?` for this long is considered gone. Homing and dwells do not delay the answer.
const SILENCE_S: f64 = 5.0;
/// An Arduino restarts when its port is opened, which takes two seconds.
const GREETING_S: f64 = 4.0;
/// The longest time from the first status report to the welcome and the lines that come with it, if the machine sends
/// any.
const WELCOME_S: f64 = 0.15;
/// The longest time that answers under way take to arrive after an alarm.
const LAST_WORDS_S: f64 = 1.0;
const TICK: Duration = Duration::from_millis(20);
pub const RESET: u8 = 0x18;
/// What is sent behind it in a change of the tool is by hand.
const TOOL_CHANGE: u8 = 0xA3;
const NOT_TAKEN: &str = "the port does not take what is sent";

/// An event in a session.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// The machine sent a line.
    Heard(String),
    /// The port failed.
    Gone(String),
    /// The user typed a line.
    Typed(String),
    /// The user typed a byte that acts at once.
    AtOnce(u8),
    /// The user wants to end the session.
    Quit,
}

/// A change of the tool, in which a person jogs and measures while the lines of the program wait.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum ChangePhase {
    #[default]
    None,
    /// What is sent waits for the end of the change.
    Waits,
    /// What is sent is by hand.
    ByHand,
}

/// The sender's side of a conversation.
pub struct Session {
    port: Box<dyn SerialPort>,
    events: Receiver<Event>,
    typist: Sender<Event>,
    flight: Flight,
    status: Option<Status>,
    polled: Stopwatch,
    heard: Stopwatch,
    /// Status reports that the user asked for and that have not come yet, not counting polls.
    asked: u32,
    /// Number of status reports received.
    reports: u64,
    /// The number of the first status report that is newer than everything sent.
    fresh_from: u64,
    /// The number of the first status report that is newer than the last resume.
    resumed_from: u64,
    alarm: Option<Stopwatch>,
    change: ChangePhase,
    _reader: Reader,
}

impl Session {
    /// Opens the port.
    pub fn open(name: &str, baud: u32) -> Result<Self> {
        let port = port::open(name, baud)?;
        let reader = port.try_clone().with_context(|| format!("{name} cannot be read and written at once"))?;
        let (typist, events) = mpsc::channel();
        let heard = typist.clone();
        Ok(Self {
            port,
            events,
            typist,
            flight: Flight::default(),
            status: None,
            polled: Stopwatch::start(),
            heard: Stopwatch::start(),
            asked: 0,
            reports: 0,
            fresh_from: 0,
            resumed_from: 0,
            alarm: None,
            change: ChangePhase::None,
            _reader: Reader::start(reader, heard),
        })
    }

    /// Waits for the welcome or for a first status report, and for the lines that come with it. Returns the lines to be
    /// shown.
    pub fn greet(&mut self) -> Result<Vec<String>> {
        let waited = Stopwatch::start();
        let mut alive: Option<Stopwatch> = None;
        let mut lines = Vec::new();
        self.write(b"?")?;
        while alive.as_ref().is_none_or(|since| since.elapsed_s() < WELCOME_S) {
            if waited.elapsed_s() > GREETING_S {
                bail!("nothing answers on this port: does it speak Grbl's dialect, at this --baud?");
            }
            if let Some(Event::Heard(line)) = self.next()? {
                lines.push(line);
            }
            if self.status.is_some() || lines.iter().any(|line| line.starts_with("Grbl")) {
                alive.get_or_insert_with(Stopwatch::start);
            }
        }
        // An alarm reported before this point is an old one.
        self.alarm = None;
        Ok(lines)
    }

    /// A sender of events for threads that read what the user types.
    pub fn typist(&self) -> Sender<Event> {
        self.typist.clone()
    }

    /// The last status report.
    pub fn status(&self) -> Option<&Status> {
        self.status.as_ref()
    }

    /// The bytes and lines that were sent and answered.
    pub fn flight(&self) -> &Flight {
        &self.flight
    }

    /// An alarm was reported.
    pub fn is_alarmed(&self) -> bool {
        self.alarm.is_some()
    }

    /// An alarm has cut off the answers to what was sent before it: some controllers send no more answers then.
    pub fn is_cut_off(&self) -> bool {
        self.alarm.as_ref().is_some_and(|since| since.elapsed_s() > LAST_WORDS_S)
    }

    /// The status, if it was reported after everything sent had arrived.
    pub fn fresh_status(&self) -> Option<&Status> {
        self.status.as_ref().filter(|_| self.reports >= self.fresh_from)
    }

    /// The machine is held at rest, so that nothing goes on until somebody resumes it.
    pub fn is_held(&self) -> bool {
        self.fresh_status().is_some_and(Status::is_held)
    }

    /// The tool is being changed (the state Tool, and jogs and holds in it), as far as reports say.
    pub fn changes_tool(&self) -> bool {
        self.change != ChangePhase::None
    }

    /// What is sent now is by hand until the tool has been changed: a program has to wait.
    pub fn is_by_hand(&self) -> bool {
        self.change == ChangePhase::ByHand
    }

    /// This line by hand may be sent: the machine waits for a tool, and nobody has resumed it since. A jog may follow another; any other
    /// line would be refused before the jog has ended.
    pub fn takes_by_hand(&self, line: &[u8]) -> bool {
        let waits = self.changes_tool() && self.reports >= self.resumed_from;
        waits && (line.starts_with(b"$J") || self.fresh_status().is_some_and(Status::is_tool))
    }

    /// Every line and every requested report has been answered.
    pub fn is_answered(&self) -> bool {
        self.flight.in_flight() == 0 && self.flight.hand_is_empty() && self.asked == 0
    }

    /// The machine has room for this line now.
    pub fn has_room(&self, line: &[u8]) -> bool {
        self.flight.has_room(line.len() + 1)
    }

    /// Sends a line with a line end added.
    pub fn send_line(&mut self, line: &[u8]) -> Result<()> {
        self.write(&[line, b"\n"].concat())
    }

    /// Sends a line that is carried out before those that wait for a change of the tool.
    pub fn send_by_hand(&mut self, line: &[u8]) -> Result<()> {
        if self.change == ChangePhase::Waits {
            self.write(&[TOOL_CHANGE])?;
            self.change = ChangePhase::ByHand;
        }
        self.flight.sent_by_hand();
        self.fresh_from = self.next_fresh();
        self.port.write_all(&[line, b"\n"].concat()).context(NOT_TAKEN)
    }

    /// Sends a byte that acts at once.
    pub fn send_at_once(&mut self, byte: u8) -> Result<()> {
        if byte == b'?' {
            self.asked += 1;
        }
        if byte == b'~' {
            self.resumed_from = self.next_fresh();
        }
        self.write(&[byte])
    }

    /// The next event within a short time. Polls the status meanwhile; reports that only the poll asked for are not
    /// returned.
    pub fn next(&mut self) -> Result<Option<Event>> {
        if self.polled.elapsed_s() >= POLL_S {
            self.polled = Stopwatch::start();
            self.write(b"?")?;
        }
        let event = match self.events.recv_timeout(TICK) {
            Ok(event) => event,
            Err(RecvTimeoutError::Timeout) => return self.silence(),
            Err(RecvTimeoutError::Disconnected) => unreachable!("we hold a sender"),
        };
        match event {
            Event::Heard(line) => Ok(self.hear(line)),
            Event::Gone(why) => bail!("the port is gone: {why}"),
            event => Ok(Some(event)),
        }
    }

    /// Asks whether everything sent has been carried out. Returns the number of the status report with the answer.
    pub fn ask_rest(&mut self) -> Result<u64> {
        self.write(b"?")?;
        Ok(self.next_fresh())
    }

    /// That report has come and the machine is at rest.
    pub fn is_at_rest(&self, report: u64) -> bool {
        self.reports >= report && !self.status.as_ref().is_some_and(Status::is_moving)
    }

    /// The number of the first report that is surely asked for from now on: one may be under way already.
    fn next_fresh(&self) -> u64 {
        self.reports + 2
    }

    fn silence(&self) -> Result<Option<Event>> {
        if self.heard.elapsed_s() > SILENCE_S {
            bail!("the machine has not answered for {SILENCE_S} s: is it still there?");
        }
        Ok(None)
    }

    fn hear(&mut self, line: String) -> Option<Event> {
        self.heard = Stopwatch::start();
        self.flight.heard(&line);
        if line.starts_with("ALARM:") {
            self.alarm.get_or_insert_with(Stopwatch::start);
        }
        if let Some(status) = Status::read(&line) {
            self.note_change(&status);
            self.status = Some(status);
            self.reports += 1;
            if self.asked == 0 {
                return None;
            }
            self.asked -= 1;
        }
        Some(Event::Heard(line))
    }

    fn note_change(&mut self, status: &Status) {
        match self.change {
            ChangePhase::None if status.is_tool() => self.change = ChangePhase::Waits,
            ChangePhase::Waits | ChangePhase::ByHand if !status.goes_on_changing() => self.change = ChangePhase::None,
            _ => {}
        }
    }

    fn write(&mut self, bytes: &[u8]) -> Result<()> {
        self.flight.sent(bytes);
        if bytes != b"?" {
            self.fresh_from = self.next_fresh();
        }
        self.port.write_all(bytes).context(NOT_TAKEN)
    }
}

/// The thread that reads the port. Dropping it frees the port.
struct Reader {
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Reader {
    fn start(port: Box<dyn SerialPort>, events: Sender<Event>) -> Self {
        let is_over = Arc::new(AtomicBool::new(false));
        let reported = is_over.clone();
        Self { is_over, thread: Some(thread::spawn(move || read(port, &events, &reported))) }
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        // A thread that panicked has already printed its message.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// Sends an event for each line from the port, until the port fails or the session ends.
fn read(mut port: Box<dyn SerialPort>, events: &Sender<Event>, is_over: &AtomicBool) {
    let mut lines = Lines::default();
    let mut bytes = [0; 256];
    // Sending an event fails when nobody receives any more; reading then ends at once.
    while !is_over.load(Ordering::Relaxed) {
        let heard = match port.read(&mut bytes) {
            Ok(0) => return drop(events.send(Event::Gone("it was closed at the other end".to_owned()))),
            Ok(count) => lines.push(&bytes[..count]),
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => Vec::new(),
            Err(error) => return drop(events.send(Event::Gone(error.to_string()))),
        };
        for line in heard {
            let _ = events.send(Event::Heard(line));
        }
    }
}
