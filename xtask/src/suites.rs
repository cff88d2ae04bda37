//! Runs `cargo test` and shows how far it is: which test of which suite. What a suite prints is shown if it fails.

use std::collections::VecDeque;
use std::io::{BufRead, BufReader, IsTerminal, Read};
use std::process::{Command, Stdio};
use std::sync::mpsc::{self, Sender};
use std::thread;

use anyhow::{Context, Result, bail};
use isostep::stopwatch::Stopwatch;
use serde_json::Value;

/// How often a long suite says how far it is, where lines cannot be overwritten.
const SAID_EVERY_S: f64 = 20.0;
/// What is kept of a suite's output.
const LINES_KEPT: usize = 2_000;

/// Runs the suites that these arguments of `cargo test` name. `tests` makes the command without them.
pub fn run(stage: &str, tests: impl Fn() -> Command, args: &[&str]) -> Result<()> {
    let (own, of_tests) = args.split_at(args.iter().position(|arg| *arg == "--").unwrap_or(args.len()));
    let suites = compiled(tests().args(own))?;
    let mut command = tests();
    command.args(own).args(of_tests).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().context("cannot start cargo test")?;
    let (lines, received) = mpsc::channel();
    let readers = [
        reader(child.stderr.take().expect("it is piped"), lines.clone(), Line::Err),
        reader(child.stdout.take().expect("it is piped"), lines, Line::Out),
    ];
    let mut progress = Progress::new(stage, suites);
    received.iter().for_each(|line| progress.take(line));
    for reader in readers {
        reader.join().expect("it only reads");
    }
    let status = child.wait()?;
    progress.end(status.success());
    if !status.success() {
        bail!("`cargo test {}` failed ({status})", args.join(" "));
    }
    Ok(())
}

/// Compiles the suites, with cargo's own progress, and returns how many there are.
fn compiled(command: &mut Command) -> Result<usize> {
    // Cargo runs examples in the documentation if no kind of test is asked for.
    let has_doc_tests = !command.get_args().any(|arg| arg == "--lib" || arg.to_string_lossy().starts_with("--test"));
    command.args(["--no-run", "--message-format=json-render-diagnostics"]);
    let output = command.stderr(Stdio::inherit()).output().context("cannot start cargo test")?;
    if !output.status.success() {
        bail!("the tests cannot be compiled ({})", output.status);
    }
    let built = String::from_utf8_lossy(&output.stdout).into_owned();
    let suites = built.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok()).filter(is_suite);
    Ok(suites.map(|suite| if has_doc_tests && suite["target"]["doctest"] == true { 2 } else { 1 }).sum())
}

fn is_suite(message: &Value) -> bool {
    message["executable"].is_string() && message["profile"]["test"] == true
}

enum Line {
    Out(String),
    Err(String),
}

fn reader(from: impl Read + Send + 'static, to: Sender<Line>, kind: fn(String) -> Line) -> thread::JoinHandle<()> {
    thread::spawn(move || {
        let lines = BufReader::new(from).split(b'\n').map_while(Result::ok);
        for line in lines {
            // The receiver takes lines until all readers have ended.
            let _ = to.send(kind(String::from_utf8_lossy(&line).into_owned()));
        }
    })
}

struct Progress<'a> {
    stage: &'a str,
    suites: usize,
    begun: usize,
    name: String,
    tests: usize,
    done: usize,
    output: VecDeque<String>,
    since_said: Stopwatch,
    is_terminal: bool,
}

impl<'a> Progress<'a> {
    fn new(stage: &'a str, suites: usize) -> Self {
        Self {
            stage,
            suites,
            begun: 0,
            name: String::new(),
            tests: 0,
            done: 0,
            output: VecDeque::new(),
            since_said: Stopwatch::start(),
            is_terminal: std::io::stderr().is_terminal(),
        }
    }

    fn take(&mut self, line: Line) {
        match line {
            Line::Err(line) => match begins(&line) {
                Some(name) => self.begin(name),
                // That cargo has nothing to compile, as the run before has.
                None if line.trim_start().starts_with("Finished") || line.trim().is_empty() => {}
                None => self.keep(line),
            },
            Line::Out(line) => {
                match tests(&line) {
                    Some(tests) => {
                        (self.tests, self.done) = (tests, 0);
                        self.output.clear();
                    }
                    None if is_result(&line) => {
                        self.done += 1;
                        if self.is_terminal || self.since_said.elapsed_s() > SAID_EVERY_S {
                            self.say();
                        }
                    }
                    None => {}
                }
                self.keep(line);
            }
        }
    }

    fn begin(&mut self, name: &str) {
        name.clone_into(&mut self.name);
        self.begun += 1;
        self.say();
    }

    fn keep(&mut self, line: String) {
        self.output.push_back(line);
        if self.output.len() > LINES_KEPT {
            self.output.pop_front();
        }
    }

    fn say(&mut self) {
        let Self { stage, suites, begun, name, tests, done, .. } = self;
        let of = if (1..*tests).contains(done) { format!(", test {done} of {tests}") } else { String::new() };
        let said = format!("{stage}: suite {begun} of {suites}, {name}{of}");
        if self.is_terminal {
            // The line is overwritten by the next.
            eprint!("\r\x1b[K{said}");
        } else {
            eprintln!("{said}");
        }
        self.since_said = Stopwatch::start();
    }

    fn end(&self, is_ok: bool) {
        if self.is_terminal {
            eprint!("\r\x1b[K");
        }
        if !is_ok {
            self.output.iter().for_each(|line| eprintln!("{line}"));
        }
    }
}

/// The suite that begins with this line of cargo's.
fn begins(line: &str) -> Option<&str> {
    let line = line.trim_start();
    match line.strip_prefix("Running ") {
        // The path of the executable follows in brackets.
        Some(suite) => Some(suite.split(" (").next().unwrap_or(suite)),
        None => line.starts_with("Doc-tests ").then_some(line),
    }
}

/// The number of tests in a suite, of which it tells at its beginning.
fn tests(line: &str) -> Option<usize> {
    line.strip_prefix("running ")?.split(' ').next()?.parse().ok()
}

fn is_result(line: &str) -> bool {
    line.starts_with("test ")
        && !line.starts_with("test result")
        && [" ok", "FAILED"].iter().any(|end| line.ends_with(end))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cargo_prints_is_understood() {
        assert_eq!(begins("     Running unittests src/lib.rs (target/debug/deps/a-12)"), Some("unittests src/lib.rs"));
        assert_eq!(begins("   Doc-tests isostep_console"), Some("Doc-tests isostep_console"));
        assert_eq!(begins("    Finished `test` profile"), None);
        assert_eq!(super::tests("running 5 tests"), Some(5));
        assert_eq!(super::tests("running away"), None);
        assert!(is_result("test names::are_read ... ok"));
        assert!(!is_result("test slow ... ignored, needs Node"));
        assert!(!is_result("test result: ok. 3 passed; 0 failed"));
    }

    #[test]
    fn the_output_of_the_suite_that_fails_is_kept() {
        let mut progress = Progress::new("host tests", 2);
        let err = |line: &str| Line::Err(line.to_owned());
        let out = |line: &str| Line::Out(line.to_owned());
        for line in [err("Running a.rs (a)"), out("running 1 test"), out("test one ... ok"), err("Running b.rs (b)")] {
            progress.take(line);
        }
        for line in [out("running 2 tests"), out("test two ... ok"), out("test three ... FAILED"), out("why")] {
            progress.take(line);
        }
        assert_eq!((progress.begun, progress.tests, progress.done), (2, 2, 2));
        assert_eq!(progress.output, ["running 2 tests", "test two ... ok", "test three ... FAILED", "why"]);
    }
}
