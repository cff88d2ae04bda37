//! Runs of a firmware on the emulated board: each powers it up, sends a script or a program, and has the emulator's summary and
//! its files.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, anyhow, bail};
use isostep::measure::Measured;
use isostep::measure::planned_move::{PROVED, STEPS_PER_MM};
use serde::Deserialize;

use super::candidate::Candidate;
use super::chip::Chip;
use super::edges::{self, Edge};

/// Rate at which status reports are polled over USB while the machine moves, Hz.
pub const POLL_HZ: u32 = 10;
/// The setting that gives Y a second motor.
const SECOND_MOTOR: &str = "905=2";
/// The line that every script begins with.
pub const GREETING: &str = "expect Grbl\n";
/// Machine time that a run may take in addition to its moves, s.
const PATIENCE_S: f64 = 5.0;

/// An emulated board with a firmware and a chip, and the folder for its files.
#[derive(Clone, Copy)]
pub struct Runs<'a> {
    pub candidate: &'a Candidate,
    pub chip: Chip,
    folder: &'a Path,
    /// Y has a second motor.
    pub has_second: bool,
}

/// The input of a run.
#[derive(Clone, Copy)]
pub enum Job<'a> {
    /// A script: lines to send, and answers to wait for.
    Script(&'a str),
    /// A program whose lines are sent ahead as far as the buffer allows.
    Program(&'a str),
}

/// A change of one of the tool's outputs.
#[derive(Clone, Debug, Deserialize)]
pub struct OutputChange {
    /// When it changed, ns since power-up.
    pub t_ns: f64,
    /// `pwm`, `enable`, `direction`, `flood` or `mist`.
    pub output: String,
    /// The duty of `pwm`, 0 to 1; 0 or 1 for the others.
    pub value: f64,
}

/// The figures of the tool.
#[derive(Debug, Default, Deserialize)]
pub struct ToolFigures {
    /// Causes that stopped the machine while an output was on.
    pub stops: Vec<ToolStop>,
}

/// One stop while an output was on.
#[derive(Debug, Deserialize)]
pub struct ToolStop {
    /// The cause: `X_LIMIT`, `ESTOP`, `RESET`, `CRASH` or another.
    pub input: String,
    /// Time from the cause until the last output was off; null if one stayed on.
    pub outputs_off_ns: Option<f64>,
}

/// The part of the emulator's summary that is used here.
#[derive(Debug, Deserialize)]
pub struct Summary {
    /// The failure of the run: a refused line, an alarm, or a violation of the driver's timing.
    error: Option<String>,
    /// The first alarm, `ALARM:n`.
    alarm: Option<String>,
    final_status: Option<String>,
    axes: BTreeMap<String, Axis>,
    #[serde(default)]
    second: Option<Second>,
    pub moving: Moving,
    #[serde(default)]
    pub stops: Vec<Stop>,
    #[serde(default)]
    pub replies: Vec<Line>,
    #[serde(default)]
    pub tool: ToolFigures,
    flash_cache: FlashCache,
}

/// A line that was sent.
#[derive(Debug, Deserialize)]
pub struct Line {
    pub text: String,
    /// When the last byte of the line was in the chip's USB buffer; null if it never was.
    pub arrived_ns: Option<f64>,
}

#[derive(Debug, Deserialize)]
struct FlashCache {
    /// Cycles to read a word that is not in the cache.
    miss_cycles: u32,
}

/// A carriage as counted from the edges that its driver received.
#[derive(Debug, Deserialize)]
struct Axis {
    position_steps: i64,
}

/// The steps of the second motor and of the first one of its axis.
#[derive(Debug, Deserialize)]
struct Second {
    /// Steps that only one of them made, or that they made on different cycles.
    steps_alone: u64,
}

/// The load of the core while the machine moved.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Moving {
    /// Time for which the machine moved, ns.
    pub time_ns: f64,
    /// The edges of all axes.
    pub edges: f64,
    /// Fraction of the time during which the core was awake.
    pub load: f64,
    /// All work of the core, including planning and the console.
    pub awake_cycles_per_edge: f64,
}

/// A press of a switch or a second reset byte, and how soon it stopped the machine.
#[derive(Clone, Debug, Deserialize)]
pub struct Stop {
    /// Time until the last edge.
    pub latency_ns: f64,
}

impl Summary {
    fn trouble(&self) -> Option<&str> {
        let error = self.error.as_deref()?;
        // The number of the script's line is of no use to the reader.
        let what = if error.starts_with("script line") { error.split_once("): ").map(|(_, what)| what) } else { None };
        // After an alarm, all further errors are consequences of it.
        Some(self.alarm.as_deref().unwrap_or(what.unwrap_or(error)))
    }

    /// The most steps of an axis by which the last reported position is beside that counted from the edges.
    pub fn position_error_steps(&self) -> Option<u64> {
        let reported = self.final_status.as_deref().and_then(position_mm)?;
        let counted = self.axes.values().map(|axis| axis.position_steps);
        let steps = reported.into_iter().map(|mm| (mm * STEPS_PER_MM).round() as i64);
        counted.zip(steps).map(|(counted, steps)| counted.abs_diff(steps)).max()
    }
}

impl Moving {
    /// The load without that of `part`.
    pub fn less(&self, part: &Self) -> Self {
        let (time_ns, edges) = (self.time_ns - part.time_ns, self.edges - part.edges);
        let rest = |whole: f64, part: f64, of: f64| if of > 0.0 { (whole - part) / of } else { 0.0 };
        let awake = |moving: &Self| moving.awake_cycles_per_edge * moving.edges;
        Self {
            time_ns,
            edges,
            load: rest(self.load * self.time_ns, part.load * part.time_ns, time_ns),
            awake_cycles_per_edge: rest(awake(self), awake(part), edges),
        }
    }
}

impl<'a> Runs<'a> {
    pub fn new(candidate: &'a Candidate, chip: Chip, folder: &'a Path) -> Self {
        Self { candidate, chip, folder, has_second: false }
    }

    /// The same board on a machine with two motors on Y.
    pub fn with_second(self) -> Self {
        Self { has_second: true, ..self }
    }

    /// Cycles to read a word that is not in flash's cache, with the flash set up by the firmware's second stage.
    pub fn miss_cycles(&self) -> Result<u32> {
        let run = self.run(Job::Script(GREETING), 0.0)?;
        let cycles = run.map(|summary| summary.flash_cache.miss_cycles);
        cycles.map_err(|why_not| anyhow!("the firmware does not start: {why_not}"))
    }

    /// Runs `job` and returns the edges. The moves take at most `moving_s` in total.
    pub fn edges(&self, job: Job, moving_s: f64) -> Result<Measured<(Summary, Vec<Edge>)>> {
        self.recorded(job, moving_s, |summary, path| {
            let edges = self.read(path)?.collect::<Result<_, _>>();
            Ok((summary, edges.with_context(|| unreadable(path))?))
        })
    }

    /// As [`Self::edges`], but returns the edges and the changes of the tool's outputs.
    pub fn outputs(&self, job: Job, moving_s: f64) -> Result<Measured<(Vec<Edge>, Vec<OutputChange>)>> {
        let ran = self.edges(job, moving_s)?;
        let path = self.file("outputs");
        let outputs = csv::Reader::from_path(&path).and_then(|file| file.into_deserialize().collect::<Result<_, _>>());
        let outputs = outputs.with_context(|| format!("the outputs in {} cannot be read", path.display()))?;
        Ok(ran.map(|(_, edges)| (edges, outputs)))
    }

    /// Runs `job`. If the run succeeds, `judge` evaluates its summary and the file of its edges.
    pub fn recorded<T>(
        &self,
        job: Job,
        moving_s: f64,
        judge: impl FnOnce(Summary, &Path) -> Result<T>,
    ) -> Result<Measured<T>> {
        let edges = self.file("edges");
        let outputs = self.file("outputs");
        let more = ["--edges".as_ref(), edges.as_os_str(), "--outputs".as_ref(), outputs.as_os_str()];
        let judged = self.with(job, moving_s, &more)?.map(|summary| judge(summary, &edges));
        // The file has 240 MB after 10 s of 3 x 1,000,000 steps/s. Failing to remove it does no harm.
        let _ = fs::remove_file(&edges);
        match judged {
            Ok(judged) => judged.map(Ok),
            Err(why_not) => Ok(Err(why_not)),
        }
    }

    /// Runs `job`. The moves take `moving_s` in total.
    pub fn run(&self, job: Job, moving_s: f64) -> Result<Measured<Summary>> {
        self.with(job, moving_s, &[])
    }

    fn with(&self, job: Job, moving_s: f64, more: &[&OsStr]) -> Result<Measured<Summary>> {
        let (text, options): (_, &[&str]) = match job {
            Job::Script(text) => (text, &["--script"]),
            Job::Program(text) => (text, &["--stream", "counting", "--program"]),
        };
        let (job_file, json) = (self.file("job"), self.file("json"));
        let set_up = format!("send ${SECOND_MOTOR}\nexpect ok\n");
        let text = match job {
            Job::Script(text) if self.has_second => text.replacen(GREETING, &format!("{GREETING}{set_up}"), 1),
            _ => text.to_owned(),
        };
        fs::write(&job_file, text).with_context(|| format!("cannot write {}", job_file.display()))?;
        let mut command = Command::new("node");
        command.arg(&self.candidate.emulator).arg("--elf").arg(&self.candidate.elf);
        command.args(options).arg(&job_file).arg("--json").arg(&json);
        command.args(["--board", self.candidate.model.name(), "--driver", self.candidate.driver]);
        command.args(self.chip.options());
        if self.candidate.proves {
            command.args(["--enable", "open"]);
        }
        if self.has_second {
            command.args(["--second", "Y,0"]);
            if let Job::Program(_) = job {
                command.args(["--set", SECOND_MOTOR]);
            }
        }
        command.arg(format!("--poll-hz={POLL_HZ}")).arg(format!("--timeout-s={}", moving_s + PATIENCE_S)).args(more);
        // The summary of the previous run must not be taken for that of this one.
        let _ = fs::remove_file(&json);
        let output = command.output().context("cannot start node")?;
        // A run that failed is a result and has a summary. Without a summary there was no run.
        let Ok(summary) = fs::read(&json) else {
            bail!("the emulator could not run: {}", String::from_utf8_lossy(&output.stderr).trim());
        };
        let summary: Summary = serde_json::from_slice(&summary).context("the emulator's summary is not understood")?;
        let alone = summary.second.as_ref().map_or(0, |second| second.steps_alone);
        Ok(match summary.trouble() {
            None if alone > 0 => Err(format!("{alone} steps of Y's motors are not on the same cycle")),
            None => Ok(summary),
            Some(trouble) => Err(format!("{trouble}{}", last_message(&String::from_utf8_lossy(&output.stdout)))),
        })
    }

    /// The edges in a file of a run.
    ///
    /// # Errors
    /// When it cannot be opened.
    pub fn read(&self, path: &Path) -> Result<impl Iterator<Item = io::Result<Edge>>> {
        let file = File::open(path).with_context(|| unreadable(path))?;
        Ok(edges::read(BufReader::with_capacity(1 << 20, file), self.candidate.model.chip()))
    }

    fn file(&self, extension: &str) -> PathBuf {
        self.folder.join("run").with_extension(extension)
    }
}

/// The error for a file of edges.
pub fn unreadable(path: &Path) -> String {
    format!("the edges in {} cannot be read", path.display())
}

/// Parses `<Idle|MPos:1.000,2.000,3.000|...>` into X, Y and Z.
fn position_mm(status: &str) -> Option<[f64; PROVED]> {
    let places = status.split_once("MPos:")?.1.split(['|', '>']).next()?;
    let places: Option<Vec<f64>> = places.split(',').map(|place| place.parse().ok()).collect();
    places?.try_into().ok()
}

/// The firmware's message about the error: the last message in the transcript, in brackets.
fn last_message(transcript: &str) -> String {
    let message = |line: &str| Some(line.split_once("[MSG:")?.1.trim_end_matches(']').to_owned());
    transcript.lines().filter_map(message).next_back().map_or(String::new(), |text| format!(" ({text})"))
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Summary {
        /// The summary of a run with only `replies`, which are JSON objects separated by commas.
        pub fn of_replies(replies: &str) -> Self {
            let mut summary = summary("null", "null");
            summary.replies = serde_json::from_str(&format!("[{replies}]")).unwrap();
            summary
        }
    }

    fn summary(error: &str, alarm: &str) -> Summary {
        let moving = r#"{"time_ns": 8, "edges": 1, "load": 0.5, "awake_cycles_per_edge": 20.5}"#;
        let status = r#""<Idle|MPos:1.500,0.000,-0.001|FS:0,0>""#;
        let axes = r#"{"X": {"position_steps": 1500}, "Y": {"position_steps": 0}, "Z": {"position_steps": -1}}"#;
        let text = format!(
            r#"{{"error": {error}, "alarm": {alarm}, "final_status": {status}, "axes": {axes}, "moving": {moving}, "flash_cache": {{"miss_cycles": 40}}}}"#
        );
        serde_json::from_str(&text).unwrap()
    }

    #[test]
    fn a_step_off_its_place_is_seen() {
        let mut summary = summary("null", "null");
        assert_eq!(summary.position_error_steps(), Some(0));
        summary.axes.get_mut("Y").unwrap().position_steps = 2;
        assert_eq!(summary.position_error_steps(), Some(2));
        summary.final_status = Some("<Idle|MPos:1.5".to_owned());
        assert_eq!(summary.position_error_steps(), None);
    }

    #[test]
    fn a_cruise_is_what_a_move_costs_more_than_its_ramps() {
        let moving =
            |time_ns, edges, load, awake_cycles_per_edge| Moving { time_ns, edges, load, awake_cycles_per_edge };
        let cruise = moving(400.0, 30.0, 0.5, 30.0).less(&moving(100.0, 10.0, 0.8, 50.0));
        assert_eq!((cruise.time_ns, cruise.edges, cruise.load, cruise.awake_cycles_per_edge), (300.0, 20.0, 0.4, 20.0));
    }

    #[test]
    fn an_alarm_explains_what_failed_after_it() {
        assert_eq!(summary("null", "null").trouble(), None);
        assert_eq!(summary("null", r#""ALARM:1""#).trouble(), None, "a stop that was asked for");
        assert_eq!(summary(r#""script line 9 (expect ok): got error:9""#, "null").trouble(), Some("got error:9"));
        assert_eq!(summary(r#""3 violations""#, "null").trouble(), Some("3 violations"));
        assert_eq!(summary(r#""got error:9""#, r#""ALARM:22""#).trouble(), Some("ALARM:22"));
    }

    #[test]
    fn the_last_message_is_reported_too() {
        let transcript = "    0.000001 < [MSG:first]\n    0.100000 < [MSG:a step of X was too late]\n    0.2 < ok\n";
        assert_eq!(last_message(transcript), " (a step of X was too late)");
        assert_eq!(last_message("    0.2 < ok"), "");
    }
}
