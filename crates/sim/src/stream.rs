//! A sender: streams a program to the controller's console as real senders do, and records the dialogue.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use embassy_futures::select::{Either, select};
use embassy_time::Timer;
use embedded_io_async::Read;
use isostep_console::report::messages;
use isostep_program::tool_comment;

use crate::config::{Config, Streaming};
use crate::link::{Lines, Pipe};
use crate::program::Program;
use crate::time::Clock;

/// The messages of the controller in addition to the answers to lines.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Said {
    /// When it was complete, ns since power-up.
    pub t_ns: u64,
    /// The line of the file that the first line without an answer was made from, from 1.
    pub line: usize,
    /// The text without its line end.
    pub text: String,
}

/// A line that the controller refused.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
#[non_exhaustive]
pub struct Refusal {
    /// Line number in the file, from 1.
    pub line: usize,
    /// The lines that were sent before it.
    #[serde(skip)]
    pub sent_before: usize,
    /// Its text.
    pub text: String,
    /// The number after `error:`.
    pub code: u8,
    /// The controller's message about this line, if there was one in addition to the number.
    pub words: Option<String>,
}

/// A line at which the machine waited for the operator: M0 or M6.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Pause {
    /// Line number in the file, from 1.
    pub line: usize,
    /// Its text.
    pub text: String,
    /// When it was resumed, ns since power-up.
    pub t_ns: u64,
    /// The controller's message about it, such as the tool to put in.
    pub words: Option<String>,
    /// The comment of the program about that tool.
    pub comment: Option<String>,
}

/// A change of the tool behind whose line the program waits: M6 with `$341`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
enum AwaitedTool {
    #[default]
    None,
    /// A message asks for a tool, and its line has no answer yet.
    Asked,
    /// The line is answered, and the operator has not acted.
    Waits,
    /// The operator has said that the tool is in.
    Resumed,
    /// The machine asks whether to go on without a measured length.
    Warned,
    /// The tool was not measured, for this reason.
    Missed(String),
}

/// The dialogue of streaming a program.
#[derive(Clone, Debug, Default)]
pub struct Dialogue {
    /// Everything that the controller sent except `ok` and `error:N`.
    pub said: Vec<Said>,
    /// The lines that were refused.
    pub refusals: Vec<Refusal>,
    /// The lines that waited for the operator.
    pub pauses: Vec<Pause>,
    /// The number after the first `ALARM:`.
    pub alarm: Option<u8>,
    /// Lines sent.
    pub sent: usize,
    /// Lines replied to.
    pub answered: usize,
    /// True if sending stopped before the program's end.
    pub cut_short: bool,
    /// True if the sender has nothing left to do.
    pub done: bool,
    tool: AwaitedTool,
    /// The last pause at which a tool is put in behind the answer to its line.
    tool_pause: Option<Pause>,
    /// Messages about the line that is answered next.
    about_line: Vec<String>,
    /// True if the next message is about the preceding alarm.
    about_alarm: bool,
}

impl Dialogue {
    /// Number of the line that waits for its answer, from 1, if there is one.
    pub(crate) fn waiting_line(&self) -> Option<usize> {
        (self.answered < self.sent).then_some(self.answered + 1)
    }

    /// Notes that the line without an answer waits for the operator.
    pub(crate) fn note_pause(&mut self, program: &Program, t_ns: u64) {
        let words = self.words();
        let pause = self.pause(program, t_ns, words);
        self.pauses.push(pause);
        self.tool = AwaitedTool::None;
    }

    /// Notes that the operator says that the tool is in, if the machine waits for one. Returns whether it does.
    pub(crate) fn resume_tool(&mut self, t_ns: u64) -> bool {
        if !matches!(self.tool, AwaitedTool::Waits | AwaitedTool::Warned) {
            return false;
        }
        self.tool = AwaitedTool::Resumed;
        let pauses = self.tool_pause.take();
        self.pauses.extend(pauses.map(|pause| Pause { t_ns, ..pause }));
        true
    }

    /// The line that has asked for a tool that was not measured, its text, and why.
    pub(crate) fn missed_tool(&self) -> Option<(usize, String, String)> {
        let AwaitedTool::Missed(why) = &self.tool else { return None };
        self.pauses.last().map(|pause| (pause.line, pause.text.clone(), why.clone()))
    }

    fn pause(&self, program: &Program, t_ns: u64, words: Option<String>) -> Pause {
        let (line, text) = self.next_line(program);
        let tool = words.as_deref().and_then(asked_tool);
        let comment = tool.and_then(|tool| tool_comment(program, self.answered, tool));
        Pause { line, text, t_ns, words, comment }
    }

    fn must_stop(&self) -> bool {
        self.alarm.is_some() || !self.refusals.is_empty()
    }

    /// The line of the file that the line answered next was made from, and that line.
    fn next_line(&self, program: &Program) -> (usize, String) {
        let text = program.get(self.answered).map_or(String::new(), |line| String::from_utf8_lossy(line).into_owned());
        (program.number(self.answered + 1), text)
    }

    /// The messages about the line that is answered next. A message comes before the answer it belongs to.
    fn words(&mut self) -> Option<String> {
        let words = std::mem::take(&mut self.about_line);
        (!words.is_empty()).then(|| words.join("; "))
    }

    fn answer(&mut self, program: &Program, refused: Option<u8>) {
        let (line, text) = self.next_line(program);
        let words = self.words();
        if let Some(code) = refused {
            self.refusals.push(Refusal { line, sent_before: self.answered, text, code, words });
            self.tool = AwaitedTool::None;
        } else if self.tool == AwaitedTool::Asked {
            self.tool_pause = Some(self.pause(program, 0, words));
            self.tool = AwaitedTool::Waits;
        } else {
            // Lines behind that of the tool are answered when it is in.
            self.tool = AwaitedTool::None;
        }
        self.answered += 1;
    }

    fn note_tool(&mut self, words: &str) {
        let is_resumed = self.tool == AwaitedTool::Resumed;
        if asked_tool(words).is_some() {
            self.tool = AwaitedTool::Asked;
        } else if is_resumed && words == messages::MEASURE_FIRST {
            self.tool = AwaitedTool::Warned;
        } else if is_resumed && [messages::PROBE_MISSED, messages::PROBE_TOUCHES].contains(&words) {
            self.tool = AwaitedTool::Missed(words.to_owned());
        }
    }

    fn take_note(&mut self, program: &Program, t_ns: u64, text: String) {
        if let Some(code) = number_after(&text, "ALARM:") {
            self.alarm.get_or_insert(code);
            self.about_alarm = true;
            self.tool = AwaitedTool::None;
        } else if let Some(words) = text.strip_prefix("[MSG:").and_then(|text| text.strip_suffix(']'))
            && !std::mem::take(&mut self.about_alarm)
        {
            self.note_tool(words);
            self.about_line.push(words.to_owned());
        }
        self.said.push(Said { t_ns, line: program.number(self.answered + 1), text });
    }
}

/// The number of the tool that a message of M6 asks for; 0 if it has none.
pub fn asked_tool(words: &str) -> Option<u32> {
    if words.starts_with(messages::CHANGE_TOOL) {
        return Some(0);
    }
    let number = words.strip_prefix("M6: put in tool ")?;
    number.split(|letter: char| !letter.is_ascii_digit()).next()?.parse().ok()
}

/// Streams lines, each no earlier than the streaming mode allows. Sends no further line after a refusal or an alarm.
pub struct Sender {
    clock: Clock,
    config: Config,
    tx: Pipe,
    rx: Pipe,
    partial: Lines,
    program: Program,
    /// Length of each line without an answer, including its line end; and the sum of all.
    in_flight: VecDeque<usize>,
    in_flight_bytes: usize,
    dialogue: Rc<RefCell<Dialogue>>,
}

impl Sender {
    /// A sender that writes to `tx`, reads from `rx`, and records in `dialogue`.
    pub fn new(
        clock: Clock,
        config: Config,
        (tx, rx): (Pipe, Pipe),
        program: Program,
        dialogue: Rc<RefCell<Dialogue>>,
    ) -> Self {
        let (partial, in_flight) = (Lines::default(), VecDeque::new());
        Self { clock, config, tx, rx, partial, program, in_flight, in_flight_bytes: 0, dialogue }
    }

    /// The task: sends the program and records the dialogue, until all lines are answered or one is refused.
    ///
    /// # Cancellation
    /// Dropping it stops the sending. The controller executes what was sent to its end.
    pub async fn run(mut self) {
        loop {
            self.fill();
            if self.in_flight.is_empty() && self.is_over() {
                break;
            }
            self.listen_or_poll().await;
        }
    }

    /// Notes that all lines are answered. Returns false if the machine has more to say, about a tool that is still to be put in.
    fn is_over(&self) -> bool {
        let mut dialogue = self.dialogue.borrow_mut();
        dialogue.cut_short = dialogue.sent < self.program.len();
        dialogue.done = true;
        dialogue.tool == AwaitedTool::None
    }

    /// Sends as much as the streaming mode allows.
    fn fill(&mut self) {
        let mut dialogue = self.dialogue.borrow_mut();
        while let Some(line) = self.program.get(dialogue.sent) {
            let length = line.len() + 1;
            let room = match self.config.streaming {
                Streaming::SendAndWait => self.in_flight.is_empty(),
                // A line longer than the window is sent alone.
                Streaming::CharacterCounting { window_bytes } => {
                    self.in_flight.is_empty() || self.in_flight_bytes + length <= window_bytes
                }
            };
            if dialogue.must_stop() || !room {
                return;
            }
            self.tx.push(line);
            self.tx.push(b"\n");
            self.in_flight.push_back(length);
            self.in_flight_bytes += length;
            dialogue.sent += 1;
        }
    }

    async fn listen_or_poll(&mut self) {
        let mut buffer = [0; 256];
        let heard = match self.config.poll_every {
            None => self.rx.read(&mut buffer).await,
            Some(every) => match select(self.rx.read(&mut buffer), Timer::after(every)).await {
                Either::First(heard) => heard,
                Either::Second(()) => {
                    self.tx.push(b"?");
                    return;
                }
            },
        };
        let Ok(count) = heard;
        for line in self.partial.push(&buffer[..count]) {
            self.hear(line);
        }
    }

    fn hear(&mut self, text: String) {
        let mut dialogue = self.dialogue.borrow_mut();
        let refused = number_after(&text, "error:");
        if text != "ok" && refused.is_none() {
            dialogue.take_note(&self.program, self.clock.now_ns(), text);
        } else if let Some(length) = self.in_flight.pop_front() {
            self.in_flight_bytes -= length;
            dialogue.answer(&self.program, refused);
        }
    }
}

fn number_after(text: &str, word: &str) -> Option<u8> {
    text.strip_prefix(word)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use embassy_time::{Duration, Instant};

    use super::*;
    use crate::executor::Executor;

    /// A console that answers every line after 1 ms and repeats it. It answers `bad` with error:20 and `crash` with an
    /// alarm.
    async fn console(mut rx: Pipe, tx: Pipe, most_waiting: Rc<RefCell<usize>>) {
        let mut lines = Lines::default();
        let mut buffer = [0; 1024];
        loop {
            let Ok(count) = rx.read(&mut buffer).await;
            let polled = buffer[..count].contains(&b'?');
            let waiting = lines.push(&buffer[..count]);
            let bytes = waiting.iter().map(|line| line.len() + 1).sum();
            let most = (*most_waiting.borrow()).max(bytes);
            most_waiting.replace(most);
            if polled {
                tx.push(b"<Idle>\r\n");
            }
            for line in waiting {
                Timer::after_millis(1).await;
                tx.push(format!("[MSG:{line}]\r\n").as_bytes());
                tx.push(match line.as_str() {
                    "bad" => b"error:20\r\n",
                    "crash" => b"ALARM:1\r\n[MSG:what to check]\r\nerror:9\r\n",
                    _ => b"ok\r\n",
                });
            }
        }
    }

    fn talk(program: &[&str], streaming: Streaming, poll_every: Option<Duration>) -> (Dialogue, usize) {
        let mut executor = Executor::new();
        let (there, back) = (Pipe::new(), Pipe::new());
        let most = Rc::default();
        executor.spawn("console", console(there.clone(), back.clone(), Rc::clone(&most)));
        let config = Config { streaming, poll_every, ..Config::default() };
        let program: Program = program.iter().map(|line| line.as_bytes().to_vec()).collect();
        let dialogue = Rc::default();
        let sender = Sender::new(executor.clock().clone(), config, (there, back), program, Rc::clone(&dialogue));
        executor.spawn("sender", sender.run());
        executor.run_until_quiescent(Instant::from_secs(10)).unwrap();
        let most = *most.borrow();
        (dialogue.take(), most)
    }

    #[test]
    fn send_and_wait_has_one_line_under_way() {
        let (dialogue, most) = talk(&["one", "three", "five"], Streaming::SendAndWait, None);
        assert!(dialogue.done && !dialogue.cut_short);
        assert_eq!((dialogue.sent, dialogue.answered, most), (3, 3, "three\n".len()));
        let said = dialogue.said.iter().map(|said| (said.t_ns / 1_000_000, said.line, said.text.as_str()));
        assert_eq!(said.collect::<Vec<_>>(), [(1, 1, "[MSG:one]"), (2, 2, "[MSG:three]"), (3, 3, "[MSG:five]")]);
    }

    #[test]
    fn character_counting_fills_the_window_and_no_more() {
        let (dialogue, most) = talk(&["12345"; 9], Streaming::CharacterCounting { window_bytes: 20 }, None);
        assert_eq!((dialogue.answered, most), (9, 18));
    }

    #[test]
    fn sending_stops_at_a_refusal_or_an_alarm() {
        let (dialogue, _) = talk(&["good", "bad", "never"], Streaming::SendAndWait, None);
        assert!(dialogue.done && dialogue.cut_short);
        let words = Some("bad".to_owned());
        assert_eq!(dialogue.refusals, [Refusal { line: 2, sent_before: 1, text: "bad".into(), code: 20, words }]);
        let (dialogue, _) = talk(&["crash", "never"], Streaming::SendAndWait, None);
        assert_eq!((dialogue.alarm, dialogue.cut_short), (Some(1), true));
    }

    #[test]
    fn what_is_said_belongs_to_the_line_that_is_answered_next() {
        let all = Streaming::CharacterCounting { window_bytes: 128 };
        let (dialogue, _) = talk(&["good", "bad", "later", "bad"], all, None);
        let refused: Vec<_> = dialogue.refusals.iter().map(|one| (one.line, one.words.as_deref())).collect();
        assert_eq!(refused, [(2, Some("bad")), (4, Some("bad"))], "later is no remedy");
        let (dialogue, _) = talk(&["crash"], all, None);
        assert_eq!(dialogue.refusals[0].words.as_deref(), Some("crash"), "nor is what to check after the alarm");
    }

    #[test]
    fn polling_asks_while_it_waits() {
        let (dialogue, _) = talk(&["a"; 4], Streaming::SendAndWait, Some(Duration::from_micros(400)));
        assert_eq!(dialogue.answered, 4);
        assert!(dialogue.said.iter().filter(|said| said.text == "<Idle>").count() >= 4);
    }
}
