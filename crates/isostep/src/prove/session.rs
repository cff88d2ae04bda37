//! Talks to the proving image: a line, its replies, how long to wait for them, and what to do if they do not come.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result, anyhow, bail, ensure};

use super::link::Link;
use super::stamps::Stamps;
use crate::chip::Chip;
use crate::console::{Status, explained};

/// The version of the protocol that this tool speaks.
const PROTOCOL: u32 = 1;
/// Time that a line of the board may take, s.
const PATIENCE_S: f64 = 3.0;
/// Time that a move may take, s.
const MOVE_S: f64 = 60.0;
/// The time between two questions for the status, s.
const POLL_S: f64 = 0.02;
/// The longest that a board brakes after a reset, s.
const BRAKING_S: f64 = 10.0;
/// Grbl's soft reset, ctrl-X.
pub const RESET: &str = "\u{18}";
const GONE: &str = "the board went away: was it unplugged? Plug it in and start anew; it moved no motor, as the image never enables them";

/// An answer of the board to a line.
#[derive(Debug, PartialEq)]
pub enum Answer {
    /// It was carried out, or accepted; what was said before the `ok`.
    Done(Vec<String>),
    /// It was refused, or an alarm came: the line that says so.
    Refused(String),
}

/// The board's description of itself.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Identity {
    /// The flash's unique number, hexadecimal.
    pub id: String,
    /// The chip's identity, hexadecimal, with its revision in the highest digit; and the version of its ROM.
    pub chip: String,
    /// The step port: PIO or TIMER.
    pub port: String,
    /// Stamps of a pad that the image keeps at a time.
    pub window: usize,
    /// The chip's time when its consoles were ready, us.
    pub ready_us: Option<f64>,
}

/// A board with the proving image, at the other end of a link.
pub struct Session<'l> {
    link: &'l mut dyn Link,
    interrupted: Arc<AtomicBool>,
    /// The last alarm, until somebody takes it.
    alarm: Option<String>,
}

impl<'l> Session<'l> {
    /// The board at the other end of this link. Every wait ends with an error once `interrupted` is set.
    pub fn new(link: &'l mut dyn Link, interrupted: Arc<AtomicBool>) -> Self {
        Self { link, interrupted, alarm: None }
    }

    /// Asks who it is, and resets it if it is the proving image, or does not answer. A machine that is at work with
    /// another image goes on undisturbed.
    ///
    /// # Errors
    /// When nothing answers, or something that is not the proving image.
    pub fn greet(&mut self) -> Result<Identity> {
        // It does not answer while it sleeps, or waits for something.
        if let Ok(refused @ Answer::Refused(_)) = self.tell("$PROVE") {
            return Self::identified(refused);
        }
        self.restart()?;
        let answer = self.tell("$PROVE")?;
        Self::identified(answer)
    }

    fn identified(answer: Answer) -> Result<Identity> {
        match answer {
            Answer::Done(said) => Identity::read(&said),
            Answer::Refused(why) => bail!(
                "this board answers, but not as the proving image ({}): put that on it first, with `cargo xtask prove`, or name \
                 the file with --image; the proving image of the last release is beside the other UF2 files",
                explained(&why)
            ),
        }
    }

    /// Sends a line and waits for its `ok`. Returns what was said before.
    ///
    /// # Errors
    /// When it is refused, or no answer comes.
    pub fn ask(&mut self, line: &str) -> Result<Vec<String>> {
        match self.tell(line)? {
            Answer::Done(said) => Ok(said),
            Answer::Refused(why) => Err(anyhow!("`{line}` was refused: {}", explained(&why))),
        }
    }

    /// Sends a line and waits for its answer, whatever it is.
    ///
    /// # Errors
    /// When no answer comes.
    pub fn tell(&mut self, line: &str) -> Result<Answer> {
        self.say(&format!("{line}\n"))?;
        self.answer(line)
    }

    /// The answer to `line`, which has been sent and has to be accepted.
    ///
    /// # Errors
    /// When it is refused, or no answer comes.
    pub fn accepted(&mut self, line: &str) -> Result<()> {
        let answer = self.answer(line)?;
        ensure!(matches!(answer, Answer::Done(_)), "`{line}` was answered {answer:?}");
        Ok(())
    }

    /// Sends text and waits for nothing.
    ///
    /// # Errors
    /// When the board is gone.
    pub fn say(&mut self, text: &str) -> Result<()> {
        self.link.send(text.as_bytes()).context(GONE)
    }

    /// The answer to `line`, which has been sent.
    ///
    /// # Errors
    /// When none comes.
    pub fn answer(&mut self, line: &str) -> Result<Answer> {
        let mut said = Vec::new();
        loop {
            let heard = self.hear(PATIENCE_S)?.with_context(|| {
                format!(
                    "the board has not answered `{line}` for {PATIENCE_S} s: unplug it, plug it in again, and start anew; its motors \
                     were never enabled"
                )
            })?;
            if heard == "ok" {
                return Ok(Answer::Done(said));
            }
            if heard.starts_with("error:") {
                return Ok(Answer::Refused(heard));
            }
            // A report comes between lines, wherever somebody has asked for one.
            if !heard.starts_with('<') {
                said.push(heard);
            }
        }
    }

    /// The next line from the board; `None` if there is none within `patience_s`.
    fn hear(&mut self, patience_s: f64) -> Result<Option<String>> {
        ensure!(!self.interrupted.load(Ordering::Relaxed), "it was interrupted; what was measured until then is lost");
        let heard = self.link.line(patience_s).context(GONE)?;
        if let Some(alarm) = heard.as_deref().filter(|line| line.starts_with("ALARM:")) {
            self.alarm = Some(alarm.to_owned());
        }
        Ok(heard)
    }

    /// Waits until the machine is at rest, or in an alarm.
    ///
    /// # Errors
    /// When it moves for longer than any move of a measurement.
    pub fn rest(&mut self) -> Result<Status> {
        let from_s = self.now_s();
        while self.now_s() - from_s < MOVE_S {
            let status = self.status()?;
            if matches!(status.state.as_str(), "Idle" | "Alarm") {
                return Ok(status);
            }
            self.wait(POLL_S)?;
        }
        bail!("the machine still moves after {MOVE_S} s: reset it (Ctrl-X in `isostep console`), and start anew")
    }

    /// The machine's report of now.
    ///
    /// # Errors
    /// When it reports nothing.
    pub fn status(&mut self) -> Result<Status> {
        self.say("?")?;
        loop {
            let heard =
                self.hear(PATIENCE_S)?.with_context(|| format!("no status report came within {PATIENCE_S} s"))?;
            if let Some(status) = Status::read(&heard) {
                return Ok(status);
            }
        }
    }

    /// Lets this time pass.
    ///
    /// # Errors
    /// When the board is gone, or the user has interrupted.
    pub fn wait(&mut self, wait_s: f64) -> Result<()> {
        let until_s = self.now_s() + wait_s;
        while self.now_s() < until_s {
            self.hear(until_s - self.now_s())?;
        }
        Ok(())
    }

    /// The alarm that came since the last call.
    pub fn take_alarm(&mut self) -> Option<String> {
        self.alarm.take()
    }

    /// Time, s.
    pub fn now_s(&self) -> f64 {
        self.link.now_s()
    }

    /// Resets the machine and waits for its welcome.
    ///
    /// # Errors
    /// When none comes.
    pub fn restart(&mut self) -> Result<()> {
        self.say(RESET)?;
        let from_s = self.now_s();
        while self.now_s() - from_s < BRAKING_S {
            if self.hear(POLL_S)?.is_some_and(|line| line.starts_with("Grbl")) {
                // What was said with the welcome is no answer to the next line.
                while self.hear(POLL_S)?.is_some() {}
                self.alarm = None;
                return Ok(());
            }
        }
        bail!(
            "nothing answers by Grbl's dialect within {BRAKING_S} s of a reset: is it the board's port, and does it run Isostep? Unplug \
             it, plug it in again, and start anew"
        )
    }

    /// Sends reset bytes: the first has it brake, the second has it stand. Errors do not count, because what goes away
    /// moves nothing either. This is the end of every measurement, whatever came before.
    pub fn calm(&mut self) {
        self.interrupted.store(false, Ordering::Relaxed);
        for _ in 0..2 {
            let _ = self.say(RESET).and_then(|()| self.link.line(POLL_S));
        }
    }

    /// Arms the three stampers. Two of them stamp the first edge of their pads, leave out `skip`, and stamp the next ones;
    /// the third keeps the last of as many.
    ///
    /// # Errors
    /// When it is refused.
    pub fn arm(&mut self, pads: [u8; 3], skip: u32) -> Result<()> {
        self.ask(&arming(pads, skip)).map(drop)
    }

    /// The stamps of the three stampers, which were armed to leave out `skip` edges.
    ///
    /// # Errors
    /// When what comes is not stamps.
    pub fn read(&mut self, skip: u32) -> Result<[Stamps; 3]> {
        let mut of = |stamper| Stamps::read(&self.ask(&format!("$PROVE=READ,{stamper}"))?, skip);
        Ok([of(0)?, of(1)?, of(2)?])
    }

    /// The numbers between brackets that follow `word`, as `[LOAD:12,34]` has.
    ///
    /// # Errors
    /// When they do not come.
    pub fn numbers<const N: usize>(&mut self, line: &str, word: &str) -> Result<[f64; N]> {
        let said = self.ask(line)?;
        let fields =
            field(&said, word).with_context(|| format!("`{line}` was answered without [{word}:...]: {said:?}"))?;
        let numbers: Vec<f64> = fields.split(',').filter_map(|number| number.trim().parse().ok()).collect();
        numbers.try_into().map_err(|_| anyhow!("`{line}` was answered by [{word}:{fields}], where {N} numbers belong"))
    }
}

/// The line that arms the stampers.
pub fn arming(pads: [u8; 3], skip: u32) -> String {
    let [one, two, three] = pads;
    format!("$PROVE=ARM,{one},{two},{three},{skip}")
}

/// The content of `[word:...]` among these lines.
fn field<'s>(said: &'s [String], word: &str) -> Option<&'s str> {
    said.iter().find_map(|line| line.strip_prefix('[')?.strip_prefix(word)?.strip_prefix(':')?.strip_suffix(']'))
}

impl Identity {
    fn read(said: &[String]) -> Result<Self> {
        let text = |word| field(said, word).unwrap_or_default().to_owned();
        let number = |word| field(said, word).and_then(|number| number.parse().ok());
        let protocol = field(said, "PROVE").context("the image does not say which protocol it has")?;
        ensure!(
            protocol.parse() == Ok(PROTOCOL),
            "the image speaks protocol {protocol}, this tool {PROTOCOL}: take both from the same release"
        );
        let window = field(said, "WINDOW").and_then(|number| number.parse().ok()).filter(|window| *window >= 8);
        let identity = Self {
            id: text("ID"),
            chip: text("CHIP"),
            port: text("PORT"),
            window: window.context("the image does not say how many stamps it keeps ([WINDOW:n], 8 or more)")?,
            ready_us: number("READY"),
        };
        identity.known_chip()?;
        Ok(identity)
    }

    /// The chip, whose clock all stamps count.
    ///
    /// # Errors
    /// When this tool does not know it.
    pub fn known_chip(&self) -> Result<Chip> {
        let id = self.chip.split(',').next().and_then(|id| u32::from_str_radix(id, 16).ok());
        id.and_then(Chip::of_id).with_context(|| {
            let [one, other] = Chip::ALL.map(Chip::name);
            format!("the chip of this board is `{}`, whose clock this tool does not know: it measures an {one} or an {other}", self.chip)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(lines: &[&str]) -> Vec<String> {
        lines.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn an_identity_is_read_and_another_protocol_is_refused() {
        let lines = [
            "[PROVE:1]",
            "[ID:E6605838832A1125]",
            "[CHIP:20002927,3]",
            "[PORT:PIO]",
            "[WINDOW:2000]",
            "[READY:345678]",
        ];
        let identity = Identity::read(&said(&lines)).unwrap();
        assert_eq!(
            (identity.id.as_str(), identity.window, identity.ready_us),
            ("E6605838832A1125", 2000, Some(345_678.0))
        );
        let of_chip = |id: &str| {
            let identity = Identity::read(&said(&["[PROVE:1]", &format!("[CHIP:{id}]"), "[WINDOW:2000]"]))?;
            identity.known_chip()
        };
        assert_eq!((identity.known_chip().unwrap(), of_chip("20004927,2").unwrap()), (Chip::Rp2040, Chip::Rp2350));
        let refused = of_chip("20005927,1").unwrap_err().to_string();
        assert!(refused.starts_with("the chip of this board is `20005927,1`, whose clock"), "{refused}");
        let newer = Identity::read(&said(&["[PROVE:2]", "[WINDOW:2000]"])).unwrap_err().to_string();
        assert!(newer.contains("protocol 2, this tool 1") && newer.contains("same release"), "{newer}");
        assert!(Identity::read(&said(&["[PROVE:1]"])).unwrap_err().to_string().contains("[WINDOW:n]"));
    }
}
