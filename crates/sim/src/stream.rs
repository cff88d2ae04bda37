//! A sender: streams a program to the controller's console as real ones do, and keeps the dialogue.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use embassy_futures::select::{Either, select};
use embassy_time::Timer;
use embedded_io_async::Read;

use crate::config::{Config, Streaming};
use crate::link::{Lines, Pipe};
use crate::time::Clock;

/// Who said a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Speaker {
    /// The sender.
    Sender,
    /// The controller.
    Controller,
}

/// A line of the dialogue.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Utterance {
    /// When it was complete, ns since power-up.
    pub t_ns: u64,
    /// Who said it.
    pub speaker: Speaker,
    /// Without its line end.
    pub text: String,
}

/// A line that the controller refused.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Refusal {
    /// Which line of the program, from 1.
    pub line: usize,
    /// Its text.
    pub text: String,
    /// The number after `error:`.
    pub code: u8,
}

/// What came of streaming a program.
#[derive(Clone, Debug, Default)]
pub struct Dialogue {
    /// All that was said.
    pub transcript: Vec<Utterance>,
    /// The lines that were refused.
    pub refusals: Vec<Refusal>,
    /// The number after `ALARM:`, of the first.
    pub alarm: Option<u8>,
    /// Lines replied to.
    pub answered: usize,
    /// Whether sending stopped before the program's end.
    pub cut_short: bool,
    /// Whether the sender has nothing left to do.
    pub done: bool,
}

/// Streams `lines` and returns when each was answered. After a refusal or an alarm no further line is sent.
pub struct Sender {
    clock: Clock,
    config: Config,
    tx: Pipe,
    rx: Pipe,
    partial: Lines,
    program: Vec<Vec<u8>>,
    sent: usize,
    /// Length of each line not yet answered, and its end.
    in_flight: VecDeque<usize>,
    dialogue: Rc<RefCell<Dialogue>>,
}

impl Sender {
    /// Sends by `tx`, listens at `rx`, notes in `dialogue`.
    pub fn new(
        clock: Clock,
        config: Config,
        (tx, rx): (Pipe, Pipe),
        program: Vec<Vec<u8>>,
        dialogue: Rc<RefCell<Dialogue>>,
    ) -> Self {
        let partial = Lines::default();
        Self { clock, config, tx, rx, partial, program, sent: 0, in_flight: VecDeque::new(), dialogue }
    }

    /// The task: sends the program and notes what is said, until all is answered or a line is refused.
    ///
    /// # Cancellation
    /// Dropping it stops the sending; what was sent is carried out, and the axes go on to its end.
    pub async fn run(mut self) {
        loop {
            self.fill();
            if self.in_flight.is_empty() {
                break;
            }
            self.listen_or_poll().await;
        }
        let mut dialogue = self.dialogue.borrow_mut();
        dialogue.cut_short = self.sent < self.program.len();
        dialogue.done = true;
    }

    /// Sends as much as the streaming mode allows.
    fn fill(&mut self) {
        while let Some(line) = self.program.get(self.sent) {
            let refused = {
                let dialogue = self.dialogue.borrow();
                dialogue.alarm.is_some() || !dialogue.refusals.is_empty()
            };
            let length = line.len() + 1;
            let room = match self.config.streaming {
                Streaming::SendAndWait => self.in_flight.is_empty(),
                // A line longer than the window goes alone.
                Streaming::CharacterCounting { window_bytes } => {
                    self.in_flight.is_empty() || self.in_flight.iter().sum::<usize>() + length <= window_bytes
                }
            };
            if refused || !room {
                return;
            }
            self.say(Speaker::Sender, String::from_utf8_lossy(line).into_owned());
            self.tx.push(line);
            self.tx.push(b"\n");
            self.in_flight.push_back(length);
            self.sent += 1;
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
        if let Some(code) = number_after(&text, "ALARM:") {
            self.dialogue.borrow_mut().alarm.get_or_insert(code);
        }
        let refused = number_after(&text, "error:");
        if (text == "ok" || refused.is_some()) && self.in_flight.pop_front().is_some() {
            let mut dialogue = self.dialogue.borrow_mut();
            dialogue.answered += 1;
            let line = dialogue.answered;
            if let Some(code) = refused {
                let text = String::from_utf8_lossy(&self.program[line - 1]).into_owned();
                dialogue.refusals.push(Refusal { line, text, code });
            }
        }
        self.say(Speaker::Controller, text);
    }

    fn say(&self, speaker: Speaker, text: String) {
        let t_ns = self.clock.now_ns();
        self.dialogue.borrow_mut().transcript.push(Utterance { t_ns, speaker, text });
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

    /// A console that answers every line after 1 ms: `bad` with error:20, `crash` with an alarm.
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
                tx.push(match line.as_str() {
                    "bad" => b"error:20\r\n",
                    "crash" => b"ALARM:1\r\nok\r\n",
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
        let program = program.iter().map(|line| line.as_bytes().to_vec()).collect();
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
        assert_eq!((dialogue.answered, most), (3, "three\n".len()));
        let said: Vec<_> = dialogue.transcript.iter().map(|line| (line.t_ns / 1_000_000, line.text.as_str())).collect();
        assert_eq!(said, [(0, "one"), (1, "ok"), (1, "three"), (2, "ok"), (2, "five"), (3, "ok")]);
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
        assert_eq!(dialogue.refusals, [Refusal { line: 2, text: "bad".into(), code: 20 }]);
        let (dialogue, _) = talk(&["crash", "never"], Streaming::SendAndWait, None);
        assert_eq!((dialogue.alarm, dialogue.cut_short), (Some(1), true));
    }

    #[test]
    fn polling_asks_while_it_waits() {
        let (dialogue, _) = talk(&["a"; 4], Streaming::SendAndWait, Some(Duration::from_micros(400)));
        assert_eq!(dialogue.answered, 4);
        assert!(dialogue.transcript.iter().filter(|line| line.text == "<Idle>").count() >= 4);
    }
}
