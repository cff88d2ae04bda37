//! One console: bytes in, bytes out, real-time bytes at once.
//!
//! # Design
//! Four futures run side by side. `receive` acts on real-time bytes as they arrive and puts the rest into a pipe, which
//! is larger than the window that is advertised to senders. `execute` takes lines from the pipe, one at a time. `notify`
//! reports alarms. Only `transmit` waits for the host.
//!
//! Behind the lines of a host that sends more than the pipe holds there may be real-time bytes, which are heard only if
//! the lines before them are read. A link with flow control has its host wait while the machine works: no line is lost.
//! But where nothing goes on without a real-time byte, in a hold or asleep, and on a link that would lose bytes itself,
//! `receive` reads on, and lines are lost. Each is reported by an error. What comes behind them would be a program with a
//! gap, so no line is taken before a reset.
//!
//! A reset is the machine's, whichever console it came from: every `session` drops the line that it carries out before
//! that line is polled again, forgets the lines that wait, and greets its host. The host of another console does not
//! know of the reset until that greeting has left. What it sends before that is from before the reset, too, so the
//! `intake` of its console is shut meanwhile.

use core::cell::{Cell, RefCell};
use core::convert::Infallible;
use core::fmt;
use core::pin::pin;

use embassy_futures::select::{Either3, Either4, select, select3, select4};
use embassy_futures::yield_now;
use embassy_time::{Duration, Timer};
use embedded_io_async::{Read, Write};
use embedded_storage_async::nor_flash::NorFlash;
use isostep_console::ReportedState;
use isostep_console::report::{self, messages};
use isostep_console::{Error, LineAssembler, Realtime, StatusReporter, realtime};
use isostep_motion::{State, cold_path};

use crate::commands::After;
use crate::controller::{Controller, Mode};
use crate::input::Input;
use crate::intake::Intake;
use crate::jogs::{Fate, Jogs};
use crate::output::{Message, Output};

const CHUNK_BYTES: usize = 64;
/// The period at which a console whose pipe is full looks whether it must read on.
const LOOK: Duration = Duration::from_millis(20);

/// The treatment of bytes that are not read, by a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlowControl {
    /// It has its host wait, as USB does.
    Link,
    /// It loses them, as a UART without RTS and CTS does.
    None,
}

/// Why a console ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LinkError<R, W> {
    /// Reading failed.
    Read(R),
    /// The other side ended the link.
    Closed,
    /// Writing failed.
    Write(W),
}

pub(crate) struct Console {
    intake: Intake,
    pub(crate) input: Input,
    pub(crate) output: Output,
    jogs: Jogs,
    /// The last pause that its jogs have heard of.
    known_pause: Cell<u32>,
    flow_control: FlowControl,
    reporter: RefCell<StatusReporter>,
    /// The last reset of which its host knows: the host has asked for it, or has been told.
    known_reset: Cell<u32>,
}

/// Ends a change of the tool with the console that waits for it: nobody would go on with its line.
struct ChangeOf<'a, F: NorFlash> {
    controller: &'a Controller<'a, F>,
    input: &'a Input,
}

impl<F: NorFlash> Drop for ChangeOf<'_, F> {
    fn drop(&mut self) {
        if self.input.waits_behind_line() {
            self.controller.with(|program| program.changing = None);
        }
    }
}

impl Console {
    #[cold]
    fn new(known_reset: u32, flow_control: FlowControl) -> Self {
        Self {
            intake: Intake::new(),
            input: Input::new(),
            output: Output::new(),
            jogs: Jogs::new(),
            known_pause: Cell::new(0),
            flow_control,
            reporter: RefCell::new(StatusReporter::new()),
            known_reset: Cell::new(known_reset),
        }
    }

    /// Forgets the lines that wait, and what the host has been told of the machine.
    #[cold]
    fn forget(&self) {
        self.input.clear();
        self.jogs.forget();
        self.reporter.borrow_mut().restart();
    }
}

impl<F: NorFlash> Controller<'_, F> {
    /// Serves one console until its link fails. Call it again when a host opens the link: it begins with the welcome.
    ///
    /// # Errors
    /// The link's own error.
    ///
    /// # Cancellation
    /// Safe: lines not yet carried out are forgotten; motion already asked for goes on to its end.
    pub async fn serve<R: Read, W: Write>(
        &self,
        rx: R,
        tx: W,
        flow_control: FlowControl,
    ) -> Result<Infallible, LinkError<R::Error, W::Error>> {
        let console = Console::new(self.resets.count(), flow_control);
        let _change = ChangeOf { controller: self, input: &console.input };
        let ended = select4(
            self.receive(&console, rx),
            self.session(&console),
            self.notify(&console),
            // It is polled last, so that a reply leaves in the poll that wrote it.
            transmit(&console, tx),
        );
        match ended.await {
            Either4::First(error) => error.map_err(|error| error.map_or(LinkError::Closed, LinkError::Read)),
            Either4::Second(never) | Either4::Third(never) => match never {},
            Either4::Fourth(error) => error.map_err(LinkError::Write),
        }
    }

    /// Acts on real-time bytes and puts the rest into the pipe, until the link ends. `Err(None)` means that the other
    /// side ended it.
    async fn receive<R: Read>(&self, console: &Console, mut rx: R) -> Result<Infallible, Option<R::Error>> {
        let mut bytes = [0; CHUNK_BYTES];
        loop {
            let n = rx.read(&mut bytes).await.map_err(Some)?;
            if n == 0 {
                return Err(None);
            }
            let mut left = &bytes[..n];
            loop {
                let ordinary = left.iter().take_while(|&&byte| realtime::classify(byte).is_none()).count();
                self.put(console, console.intake.taken(&left[..ordinary])).await;
                let Some((&byte, behind)) = left[ordinary..].split_first() else { break };
                left = behind;
                match realtime::classify(byte) {
                    Some(Realtime::Status) => self.offer_report(console),
                    Some(asked @ (Realtime::FullStatus | Realtime::Modal)) => self.offer_other(asked, console),
                    Some(Realtime::Reset) => {
                        self.machine.reset();
                        self.reset_by(console);
                        // The bytes behind it are the first that count again.
                        console.intake.begin_line();
                    }
                    Some(Realtime::ToolChange) => console.input.read_behind(),
                    Some(realtime) => {
                        if realtime == Realtime::JogCancel {
                            console.jogs.cancel(console.input.len());
                        }
                        self.real_time(realtime);
                    }
                    None => {}
                }
            }
        }
    }

    /// Puts bytes of lines into the pipe.
    async fn put(&self, console: &Console, bytes: &[u8]) {
        self.refuse_jogs(console);
        if !console.input.take(bytes) {
            cold_path(pin!(self.put_in_parts(console, bytes))).await;
        }
        self.refuse_jogs(console);
    }

    /// Waits for room, or loses the bytes for which there is none, if it must read on. A reset forgets those that wait for room, as
    /// those in the pipe.
    async fn put_in_parts(&self, console: &Console, mut bytes: &[u8]) {
        let resets = self.resets.count();
        while !bytes.is_empty() {
            match select3(self.resets.after(resets), console.input.write(bytes), self.must_read_on(console)).await {
                Either3::First(()) => break,
                Either3::Second(count) => bytes = &bytes[count..],
                Either3::Third(()) => {
                    console.intake.lose(bytes);
                    break;
                }
            }
        }
    }

    /// Waits until bytes must be read although there is no room for them.
    async fn must_read_on(&self, console: &Console) {
        let goes_on_by_itself = || {
            let is_held = matches!(self.machine.state(), State::Hold { still: true });
            !is_held && self.with(|program| program.mode != Mode::Sleep)
        };
        while console.flow_control == FlowControl::Link && goes_on_by_itself() && !console.input.waits_behind_line() {
            Timer::after(LOOK).await;
        }
    }

    /// Has the jogs refused that wait in a hold, or that came before the end of a pause. Call it before and after bytes
    /// are put into the pipe, and before a line is carried out.
    fn refuse_jogs(&self, console: &Console) {
        let pause = self.pauses.get();
        if console.known_pause.replace(pause) != pause || self.is_held() {
            console.jogs.refuse(console.input.len());
        }
    }

    pub(crate) fn offer_report(&self, console: &Console) {
        let report = self.report(console.input.free_bytes());
        let mut reporter = console.reporter.borrow_mut();
        console.output.offer(|text| reporter.write(text, &report, &self.settings()));
    }

    /// Answers a byte that asks for more than a status report.
    #[cold]
    fn offer_other(&self, asked: Realtime, console: &Console) {
        if asked == Realtime::Modal {
            return self.with(|program| {
                console.output.offer(|text| report::modal(text, &program.interpreter, &program.settings));
            });
        }
        let report = self.report(console.input.free_bytes());
        let mut reporter = console.reporter.borrow_mut();
        console.output.offer(|text| reporter.write_full(text, &report, &self.settings()));
    }

    /// Notes that this console has asked for a reset.
    fn reset_by(&self, console: &Console) {
        self.begin_restart();
        console.forget();
        console.known_reset.set(self.resets.count());
    }

    /// Runs from one welcome to the next reset, again and again.
    async fn session(&self, console: &Console) -> Infallible {
        let mut reset = self.resets.count();
        loop {
            // At every poll the first of the two decides whether the line is polled at all.
            if select(self.resets.after(reset), self.execute(console)).await.is_second() {
                // A line asked for the reset: what has been received behind it is forgotten, too, and so is the rest of
                // a line of which the beginning has been received.
                self.reset_by(console);
                console.intake.open();
            }
            reset = self.resets.count();
            if console.known_reset.get() != reset {
                console.forget();
                console.intake.shut();
            }
            cold_path(pin!(self.end_restart())).await;
        }
    }

    /// Carries out lines, until one asks for a reset.
    async fn execute(&self, console: &Console) {
        cold_path(pin!(self.greet(console))).await;
        let (mut assembler, mut length) = (LineAssembler::new(), 0);
        loop {
            console.jogs.hold(length);
            let line = console.input.read_line(&mut assembler, &mut length);
            if select(line, console.intake.lost_line()).await.is_second() {
                cold_path(pin!(self.tell_lost_line(console))).await;
                continue;
            }
            console.jogs.hold(length);
            self.refuse_jogs(console);
            let of_jog = console.jogs.fate(core::mem::take(&mut length));
            let fate = if console.input.is_sent_again() { Fate::SentAgain } else { of_jog };
            let (line, message) = (assembler.line(), assembler.message());
            match self.line(line, message, fate, &console.output).await {
                After::Restart => return,
                After::ToolChange => console.input.put_back(line.unwrap_or_default()),
                _ => {}
            }
            // The ports' queues are filled between lines, however many lines there are.
            yield_now().await;
        }
    }

    /// Answers a line that was lost. Those before it have been answered.
    async fn tell_lost_line(&self, console: &Console) {
        let mut text = Message::new();
        text.say(messages::LINES_LOST);
        text.answer(Err(Error::LineTooLong));
        console.output.send(&text).await;
    }

    /// Sends the welcome, and what follows it: what to look at, what is not as it was stored, how to unlock, or the
    /// results of the start-up lines. If the host did not know of the reset, it knows when the first message has left:
    /// from then on its lines are taken, whatever else there is to print or to store.
    async fn greet(&self, console: &Console) {
        let output = &console.output;
        let mut text = Message::new();
        text.print(|text| text.push_str(report::WELCOME));
        let is_from_elsewhere = console.intake.is_shut();
        if is_from_elsewhere {
            text.say(messages::RESET_ELSEWHERE);
            output.send(&text).await;
            output.emptied().await;
            console.input.clear();
            console.intake.open();
            console.known_reset.set(self.resets.count());
            text.clear();
        }
        if self.with(|program| program.settings.hard_limits) && self.machine.status().pressed.contains(&true) {
            text.say(messages::CHECK_LIMITS);
        }
        if self.machine.door().is_open {
            text.say(messages::CHECK_DOOR);
        }
        if let Some(loss) = self.with(|program| program.loss) {
            text.say(loss);
        }
        // Each of them may be as long as a message can be.
        output.send(&text).await;
        text.clear();
        self.with(|program| self.vfd.say_trouble(&program.settings, &mut text));
        output.send(&text).await;
        text.clear();
        let state = self.state();
        if self.fit(&mut text).is_ok() && state == ReportedState::Alarm {
            text.say(messages::HOW_TO_UNLOCK);
        }
        output.send(&text).await;
        text.clear();
        let is_ready = matches!(state, ReportedState::Idle | ReportedState::Hold { .. } | ReportedState::Door(_));
        // After a reset they are answered on the console that has asked for it.
        let is_first = !is_from_elsewhere && self.with(|program| core::mem::take(&mut program.startup_due));
        if is_first && is_ready {
            let _turn = self.turn.lock().await;
            self.start_up(&mut text, output).await;
        }
        // A reset may have ended a line before its changes were stored.
        if self.with(|program| program.unsaved.any()) {
            let _turn = self.turn.lock().await;
            let _ = self.save(&mut text).await;
            output.send(&text).await;
        }
    }
}

async fn transmit<W: Write>(console: &Console, mut tx: W) -> Result<Infallible, W::Error> {
    let mut bytes = [0; CHUNK_BYTES];
    loop {
        let mut n = console.output.read(&mut bytes).await;
        if !console.input.is_empty() {
            // The next line waits already: its answer leaves in the same packet.
            yield_now().await;
            n += console.output.read_more(&mut bytes[n..]);
        }
        tx.write_all(&bytes[..n]).await?;
        tx.flush().await?;
    }
}

impl<R: fmt::Display, W: fmt::Display> fmt::Display for LinkError<R, W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read(error) => write!(f, "reading from the console failed: {error}"),
            Self::Closed => write!(f, "the console was closed"),
            Self::Write(error) => write!(f, "writing to the console failed: {error}"),
        }
    }
}

impl<R: fmt::Debug + fmt::Display, W: fmt::Debug + fmt::Display> core::error::Error for LinkError<R, W> {}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::string::ToString;

    use super::*;

    #[test]
    fn the_end_of_a_link_says_what_failed() {
        let texts = [LinkError::Read("no"), LinkError::Closed, LinkError::Write("full")].map(|error| error.to_string());
        assert_eq!(
            texts,
            ["reading from the console failed: no", "the console was closed", "writing to the console failed: full"]
        );
    }
}
