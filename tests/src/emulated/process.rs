//! Processes of the emulator. Each carries out a few runs, so that the engine compiles the emulator for the first of them only.

use std::io::{BufRead, BufReader, Write as _};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::{Mutex, PoisonError};

use crate::root;

/// Behind all that a run prints, before its exit code.
const END_OF_RUN: char = '\x04';
/// The runs of a process: the engine's code is fast for the first few boards that it has seen, and slow for any.
const RUNS: usize = 3;
/// The processes whose run has ended.
static IDLE: Mutex<Vec<Process>> = Mutex::new(Vec::new());

/// A process that carries out a run.
pub(super) struct Process {
    child: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
    runs: usize,
}

impl Process {
    /// Begins a run with these options.
    pub(super) fn begin(options: &[String]) -> Self {
        let idle = IDLE.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut process = idle.unwrap_or_else(Self::start);
        process.say(&serde_json::to_string(options).expect("strings"));
        process
    }

    fn start() -> Self {
        let mut node = Command::new("node");
        node.arg(root().join("tests/emulator/run.mjs")).arg("--serve").stdin(Stdio::piped()).stdout(Stdio::piped());
        if super::is_pico_2() {
            node.env("EMULATED_CHIP", "rp2350");
        }
        let mut child = node.spawn().expect("node, from nodejs.org, starts");
        let (requests, answers) = child.stdin.take().zip(child.stdout.take()).expect("both are pipes");
        Self { child, requests, answers: BufReader::new(answers), runs: 0 }
    }

    /// Says a line. If the process has ended, the next line that it is asked for says so.
    pub(super) fn say(&mut self, request: &str) {
        _ = writeln!(self.requests, "{request}");
    }

    /// The next line that is printed; empty if the process has ended.
    pub(super) fn line(&mut self) -> String {
        let mut line = String::new();
        self.answers.read_line(&mut line).expect("text");
        line
    }

    /// What else the run prints, and whether it succeeds. The process may be there for the next run.
    pub(super) fn end(mut self) -> (String, bool) {
        let mut printed = String::new();
        loop {
            let line = self.line();
            assert!(!line.is_empty(), "the emulator has failed:\n{printed}");
            if let Some(code) = line.strip_prefix(END_OF_RUN) {
                let is_well = code.trim() == "0";
                self.runs += 1;
                if self.runs < RUNS {
                    IDLE.lock().unwrap_or_else(PoisonError::into_inner).push(self);
                }
                return (printed, is_well);
            }
            printed += &line;
        }
    }
}

/// In the middle of a run, or behind a failure of the emulator.
impl Drop for Process {
    fn drop(&mut self) {
        _ = self.child.kill();
        _ = self.child.wait();
    }
}
