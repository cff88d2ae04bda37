//! Refusals: the machine refuses a line of a program that is streamed.

use anyhow::{Result, bail};

use super::Stream;
use crate::console::Status;
use crate::console::meaning::explained;
use crate::console::talk::Typist;
use isostep_report::remarks::SHOWN_MAX;

/// A line that the machine has refused.
#[derive(Clone, Debug)]
pub struct Refused {
    /// Its number among the lines that were sent, from 1.
    pub number: usize,
    /// The line of the file that it was made from, as an error names it.
    pub place: String,
    /// The answer to it: `error:N`.
    pub answer: String,
}

impl Refused {
    fn words(&self) -> String {
        format!("{} was refused: {}", self.place, explained(&self.answer))
    }
}

/// The refused lines in words: the first of them, then how many more. After an alarm every line is refused, so that
/// only the first one matters.
pub fn listed(refused: &[Refused], is_alarmed: bool) -> Vec<String> {
    let most = if is_alarmed { 1 } else { SHOWN_MAX };
    let mut words: Vec<_> = refused.iter().take(most).map(Refused::words).collect();
    if refused.len() > most {
        words.push(format!("and {} more lines were refused", refused.len() - most));
    }
    words
}

/// The person's choice.
enum Choice {
    GoOn,
    Stop,
}

impl<S: FnMut(&str)> Stream<'_, S> {
    /// If lines were refused since the last decision: holds the machine, says what has become of the lines behind, and
    /// asks whether to go on.
    ///
    /// # Errors
    /// When the stream ends here.
    pub(super) fn decide(&mut self) -> Result<()> {
        if self.refused.len() == self.decided || self.alarm.is_some() || self.is_locked() {
            self.is_over |= self.is_locked();
            return Ok(());
        }
        if self.how.keep_going || self.is_checking {
            let words: Vec<_> = self.refused[self.decided..].iter().map(Refused::words).collect();
            words.iter().for_each(|words| self.say(words));
        } else if self.hold()? {
            self.tell();
            match self.ask()? {
                // In a change of the tool it would say that the tool is in.
                Choice::GoOn if self.session.status().is_some_and(Status::is_tool) => {}
                Choice::GoOn => self.session.send_at_once(b'~')?,
                Choice::Stop => return self.stop(),
            }
        }
        self.decided = self.refused.len();
        Ok(())
    }

    fn is_locked(&self) -> bool {
        self.session.status().is_some_and(|status| status.is_locked())
    }

    /// Holds the machine and waits until it stands still. Returns whether it does: in an alarm there is nothing to decide.
    fn hold(&mut self) -> Result<bool> {
        self.session.send_at_once(b'!')?;
        while !self.session.is_held() {
            self.look()?;
            let state = self.session.fresh_status().map_or("", |status| status.state.as_str());
            // A hold does nothing while the machine homes, and only ends a jog.
            if matches!(state, "Idle" | "Run") {
                self.session.send_at_once(b'!')?;
            }
            if self.alarm.is_some() || self.is_locked() {
                return Ok(false);
            }
        }
        self.is_hold_reported = true;
        Ok(true)
    }

    /// Says what was refused, what the machine has from behind it, and what is still to come.
    fn tell(&mut self) {
        let refused = &self.refused[self.decided..];
        let first = refused[0].number;
        let mut words: Vec<_> = refused.iter().map(Refused::words).collect();
        words.push(match self.session.status() {
            Some(status) => format!("the machine holds: {status}"),
            None => "the machine holds".to_owned(),
        });
        let (answered, sent) = (self.answered(), self.sending.sent);
        let is_refused = |number: &usize| refused.iter().any(|one| one.number == *number);
        let behind = |from: usize, to: usize| {
            let numbers = (from..=to).filter(|number| !is_refused(number));
            let texts = numbers.filter_map(|number| self.sending.line(number));
            texts.filter(|(_, text)| !text.is_empty()).map(|(number, text)| format!("  line {number} `{text}`"))
        };
        let accepted: Vec<_> = behind(first + 1, answered).collect();
        if !accepted.is_empty() {
            words.push("accepted behind it; carried out by now, or when it goes on:".to_owned());
            words.extend(accepted);
        }
        let unread: Vec<_> = behind(answered.max(first) + 1, sent).collect();
        if !unread.is_empty() {
            words.push("sent behind it; not carried out before it goes on:".to_owned());
            words.extend(unread);
        }
        words.push(match self.program.total {
            total if total == sent => "no line is still to come".to_owned(),
            total => format!("still to come: {}", self.program.span(sent + 1, total)),
        });
        words.iter().for_each(|line| self.say(line));
    }

    /// Asks the person, if there is one.
    fn ask(&mut self) -> Result<Choice> {
        let question = "g: go on without what was refused; s: stop, by a reset (g or s, then Enter)";
        if self.how.typist == Typist::Person {
            self.say(question);
        }
        self.typed.clear();
        loop {
            if self.how.typist == Typist::Pipe || self.is_input_over || self.interrupts > 0 || self.alarm.is_some() {
                return Ok(Choice::Stop);
            }
            self.look()?;
            match self.typed.pop_front().as_deref().map(str::trim) {
                Some("g" | "G" | "~") => return Ok(Choice::GoOn),
                Some("s" | "S" | "\x18") => return Ok(Choice::Stop),
                Some(_) => self.say(question),
                None => {}
            }
        }
    }

    /// Ends the stream: the machine forgets what it has not carried out.
    fn stop(&mut self) -> Result<()> {
        let (first, sent, total) = (self.refused[self.decided].number, self.sending.sent, self.program.total);
        let answered = self.answered();
        let mut words = listed(&self.refused, false);
        let stand = self.reset_machine()?;
        words.push(format!("the stream has stopped there, by a hold and a reset: {stand}"));
        if answered > first {
            words.push(format!("it may have carried out {} before the hold", self.program.span(first + 1, answered)));
        }
        if sent > answered {
            words.push(format!("{}, sent by then, were not carried out", self.program.span(answered + 1, sent)));
        }
        if total > sent {
            words.push(format!("{} were not sent", self.program.span(sent + 1, total)));
        }
        bail!("{}", words.join("\n  "))
    }
}
