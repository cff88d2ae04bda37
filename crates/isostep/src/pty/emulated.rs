//! The emulated board behind the bridge's interface: a Node process that runs only as far as it is asked.

use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::process::CommandExt;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use anyhow::{Context, Result, anyhow, bail, ensure};
use isostep_console::AXIS_NAMES;
use isostep_sim::AXES;
use serde_json::Value;

use super::{Closing, Machine};

const STEP_NS: u64 = 10_000_000;
const BOOT_MAX_NS: u64 = 10_000_000_000;
const REPLY_MAX_NS: u64 = 1_000_000_000;
/// More than the time that the board takes to notice that its port is opened or closed.
const OPENING_NS: u64 = 5_000_000;

/// A board that `tests/emulator/src/live.mjs` emulates, connected by two pipes.
pub struct Emulated {
    child: Child,
    /// Closing this pipe ends the board.
    requests: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
    now_ns: u64,
    unsent: usize,
    outbox: Vec<u8>,
    said: Vec<u8>,
    is_open: bool,
    /// The board notices when its port is opened and closed. A USB port does; a UART's three wires do not.
    has_dtr: bool,
}

impl Emulated {
    /// Powers up the board that `command` starts, waits for its welcome, and sends it the settings. `has_dtr` says that
    /// its console is on USB.
    ///
    /// # Errors
    /// When it does not start, or does not answer.
    pub fn start(command: &mut Command, has_dtr: bool, settings: &[(u16, f32)]) -> Result<Self> {
        // It runs in its own process group, so that Ctrl-C reaches only this process, which then asks the board for its
        // summary.
        command.arg("--live").stdin(Stdio::piped()).stdout(Stdio::piped()).process_group(0);
        let mut child = command.spawn().context("node cannot be started")?;
        let requests = child.stdin.take();
        let answers = BufReader::new(child.stdout.take().context("node gives no output")?);
        let mut board = Self {
            child,
            requests,
            answers,
            now_ns: 0,
            unsent: 0,
            outbox: Vec::new(),
            said: Vec::new(),
            is_open: true,
            has_dtr,
        };
        board.said = board.run_until_said("Grbl", BOOT_MAX_NS)?;
        for (number, value) in settings {
            board.send(format!("${number}={value}\n").as_bytes())?;
            board.run_until_said("ok", REPLY_MAX_NS)?;
        }
        if has_dtr {
            // A client that is waiting already must receive none of this: neither an old welcome nor half a reply to a
            // line it sends after that.
            board.set_open(false)?;
            board.said.clear();
        }
        Ok(board)
    }

    /// Runs until the board knows whether the port is open. A host's open() does not return earlier either.
    fn set_dtr(&mut self, on: bool) -> Result<()> {
        self.is_open = on;
        self.ask(if on { "dtr on" } else { "dtr off" })?;
        let said = self.advance(self.now_ns + OPENING_NS)?;
        self.said.extend(said);
        Ok(())
    }

    fn run_until_said(&mut self, words: &str, max_ns: u64) -> Result<Vec<u8>> {
        let end_ns = self.now_ns + max_ns;
        let mut said = Vec::new();
        while self.now_ns < end_ns {
            said.extend(self.advance(self.now_ns + STEP_NS)?);
            let text = String::from_utf8_lossy(&said);
            if text.contains(words) && text.ends_with('\n') {
                return Ok(said);
            }
        }
        let text = String::from_utf8_lossy(&said);
        bail!("the emulated board says {text:?} instead of `{words}` within {} s", max_ns / 1_000_000_000)
    }

    fn ask(&mut self, request: &str) -> Result<()> {
        let requests = self.requests.as_mut().context("the emulated board has ended")?;
        // If the board has ended, reading its answer reports why.
        let _ = requests.write_all(format!("{request}\n").as_bytes());
        Ok(())
    }

    fn answer(&mut self) -> Result<String> {
        let mut answer = String::new();
        self.answers.read_line(&mut answer)?;
        ensure!(answer.ends_with('\n'), "the emulated board ended without a word: {}", self.child.wait()?);
        Ok(answer)
    }

    fn advance(&mut self, at_ns: u64) -> Result<Vec<u8>> {
        let bytes = if self.outbox.is_empty() { "-".to_owned() } else { hex(&self.outbox) };
        self.outbox.clear();
        self.ask(&format!("run {at_ns} {bytes}"))?;
        let answer = self.answer()?;
        let words: Vec<_> = answer.split_whitespace().collect();
        let &[now, unsent, bytes] = words.as_slice() else {
            let summary: Value = serde_json::from_str(&answer).with_context(|| format!("not an answer: {answer}"))?;
            bail!("the emulated board: {}", summary["error"].as_str().unwrap_or("it ended"));
        };
        (self.now_ns, self.unsent) = (now.parse()?, unsent.parse()?);
        unhex(bytes.trim_start_matches('-')).ok_or_else(|| anyhow!("not bytes: {bytes}"))
    }
}

impl Machine for Emulated {
    fn now_ns(&self) -> u64 {
        self.now_ns
    }

    fn unread(&self) -> usize {
        self.unsent + self.outbox.len()
    }

    fn set_open(&mut self, open: bool) -> Result<bool> {
        if !self.has_dtr {
            return Ok(false);
        }
        if open && self.is_open {
            self.set_dtr(false)?;
        }
        self.set_dtr(open)?;
        Ok(open)
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.outbox.extend(bytes);
        Ok(())
    }

    fn run_to(&mut self, at_ns: u64) -> Result<Vec<u8>> {
        let mut said = std::mem::take(&mut self.said);
        said.extend(self.advance(at_ns)?);
        Ok(said)
    }

    fn close(&mut self) -> Result<Closing> {
        self.ask("end")?;
        let summary: Value = serde_json::from_str(&self.answer()?)?;
        self.requests = None;
        self.child.wait()?;
        if let Some(error) = summary["error"].as_str() {
            bail!("the emulated board: {error}");
        }
        closing(&summary).context("the emulated board's summary is not whole")
    }
}

impl Drop for Emulated {
    fn drop(&mut self) {
        // The board ends by itself when its requests are closed. If it has ended already, this only collects the
        // process.
        self.requests = None;
        let _ = self.child.wait();
    }
}

fn closing(summary: &Value) -> Option<Closing> {
    let axes = AXIS_NAMES.map(|name| &summary["axes"][name.to_string()]);
    let status = summary["final_status"].as_str().unwrap_or("<unknown|>");
    let (state, rest) = status.trim_start_matches('<').split_once('|')?;
    let places = rest.strip_prefix("MPos:").and_then(|rest| rest.split('|').next()).unwrap_or("");
    let places: Vec<f64> = places.split(',').filter_map(|place| place.parse().ok()).collect();
    let position_steps = axes.iter().map(|axis| Some(axis["position_steps"].as_i64()? as i32));
    let steps = axes.iter().map(|axis| axis["edges"].as_u64());
    Some(Closing {
        state: summary["alarm"].as_str().filter(|_| state == "Alarm").unwrap_or(state).to_owned(),
        position_mm: places.try_into().unwrap_or([f64::NAN; AXES]),
        position_steps: position_steps.collect::<Option<Vec<_>>>()?.try_into().ok()?,
        steps: steps.collect::<Option<Vec<_>>>()?.try_into().ok()?,
        steps_lost: None,
        timing_violations: summary["driver_timing"]["violations"].as_u64()?,
    })
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::with_capacity(2 * bytes.len()), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

fn unhex(text: &str) -> Option<Vec<u8>> {
    let digits = |at: usize| u8::from_str_radix(text.get(at..at + 2)?, 16).ok();
    (0..text.len()).step_by(2).map(digits).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_cross_as_hexadecimal() {
        assert_eq!(hex(b"\x00?\xff"), "003fff");
        assert_eq!(unhex("003fff"), Some(vec![0, b'?', 0xff]));
        assert_eq!((unhex(""), unhex("0"), unhex("zz")), (Some(vec![]), None, None));
    }

    #[test]
    fn the_summary_says_where_the_board_stands() {
        let axis = |steps: i64| serde_json::json!({ "position_steps": steps, "edges": steps.abs() + 7 });
        let mut summary = serde_json::json!({
            "final_status": "<Idle|MPos:1.000,-2.000,0.000|FS:0,0>", "alarm": null, "driver_timing": { "violations": 0 },
            "axes": { "X": axis(50), "Y": axis(-100), "Z": axis(0) },
        });
        let stands = closing(&summary).unwrap();
        assert_eq!((stands.state.as_str(), stands.position_mm), ("Idle", [1.0, -2.0, 0.0]));
        assert_eq!((stands.position_steps, stands.steps), ([50, -100, 0], [57, 107, 7]));
        summary["final_status"] = "<Alarm|MPos:1.000,-2.000,0.000>".into();
        summary["alarm"] = "ALARM:1".into();
        assert_eq!(closing(&summary).unwrap().state, "ALARM:1");
    }
}
