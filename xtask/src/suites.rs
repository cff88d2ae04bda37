//! Has cargo compile tests, runs their executables, and shows how far they are: which test of which suite. What a suite
//! prints is shown if it fails.

use std::collections::VecDeque;
use std::io::{self, BufRead, BufReader, IsTerminal};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Mutex;

use anyhow::{Context, Result, bail};
use isostep::stopwatch::Stopwatch;
use serde_json::Value;

use crate::side_by_side::{self, lock};
use crate::workspace;

/// Cargo runs one suite after the other, and most end with one long test, during which a processor would be idle.
const AT_ONCE: usize = 2;
/// How often a long suite says how far it is, where lines cannot be overwritten.
const SAID_EVERY_S: f64 = 20.0;
/// What is kept of a suite's output.
const LINES_KEPT: usize = 2_000;

/// Runs the suites that these arguments of `cargo test` name. `tests` makes the command without them. After one that fails
/// no other begins.
pub fn run(stage: &str, tests: impl Fn() -> Command, args: &[&str]) -> Result<()> {
    let (own, of_tests) = args.split_at(args.iter().position(|arg| *arg == "--").unwrap_or(args.len()));
    let mut suites = compiled(tests().args(own))?;
    suites.iter_mut().for_each(|suite| _ = suite.command.args(of_tests.iter().skip(1)));
    // Cargo runs examples in the documentation if no kind of test is asked for.
    if !own.iter().any(|arg| *arg == "--lib" || arg.starts_with("--test")) {
        let mut command = tests();
        command.args(own).arg("--doc");
        suites.push(Suite { name: "examples in the documentation".to_owned(), command, is_alone: true });
    }
    run_all(stage, suites)
}

/// An executable with tests, or the examples in the documentation.
struct Suite {
    name: String,
    command: Command,
    /// Whether another that ran at the same time would disturb it, or would win nothing.
    is_alone: bool,
}

/// Compiles the suites, with cargo's own progress. They are in the order of their paths, those that run alone at the end.
fn compiled(cargo: &mut Command) -> Result<Vec<Suite>> {
    cargo.args(["--no-run", "--message-format=json-render-diagnostics"]);
    let output = cargo.stderr(Stdio::inherit()).output().context("cannot start cargo test")?;
    if !output.status.success() {
        bail!("the tests cannot be compiled ({})", output.status);
    }
    let built = String::from_utf8_lossy(&output.stdout).into_owned();
    let messages = built.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let mut suites: Vec<_> = messages.filter_map(|message| suite(&message)).collect();
    for (variable, value) in cargo.get_envs().filter_map(|(variable, value)| Some((variable, value?))) {
        suites.iter_mut().for_each(|suite| _ = suite.command.env(variable, value));
    }
    suites.sort_by(|one, other| (one.is_alone, &one.name).cmp(&(other.is_alone, &other.name)));
    Ok(suites)
}

/// The suite of which cargo says by this message that it is compiled. It runs as it would by cargo.
fn suite(message: &Value) -> Option<Suite> {
    if message["profile"]["test"] != true {
        return None;
    }
    let mut command = Command::new(message["executable"].as_str()?);
    let package = Path::new(message["manifest_path"].as_str()?).parent()?;
    command.current_dir(package).env("CARGO_MANIFEST_DIR", package);
    let name = workspace::shown(Path::new(message["target"]["src_path"].as_str()?));
    // The tool's machines are paced to the wall clock, which no other package reads.
    Some(Suite { name, command, is_alone: package == workspace::root().join("crates/isostep") })
}

fn run_all(stage: &str, suites: Vec<Suite>) -> Result<()> {
    let screen = Mutex::new(Screen::new(stage, suites.len()));
    let (alone, together) = (1..).zip(suites).partition::<Vec<_>, _>(|(_, suite)| suite.is_alone);
    let run = |(number, suite)| run_one(number, suite, &screen);
    let outcome = side_by_side::run::<AT_ONCE, _>(together, run).and_then(|()| side_by_side::run::<1, _>(alone, run));
    lock(&screen).clear();
    outcome
}

fn run_one(number: usize, Suite { name, mut command, .. }: Suite, screen: &Mutex<Screen>) -> Result<()> {
    let mut progress = Progress::new(number, name);
    lock(screen).say(&progress);
    let (printed, end) = io::pipe()?;
    command.stdout(end.try_clone()?).stderr(end);
    let mut child = command.spawn().with_context(|| format!("cannot start {}", progress.name))?;
    // It has the end that is written to, and would keep it open.
    drop(command);
    for line in BufReader::new(printed).split(b'\n').map_while(Result::ok) {
        if progress.take(String::from_utf8_lossy(&line).into_owned()) {
            lock(screen).say_sometimes(&progress);
        }
    }
    let status = child.wait()?;
    if !status.success() {
        lock(screen).show(&progress.output);
        bail!("{} failed ({status})", progress.name);
    }
    Ok(())
}

/// How far a suite is.
struct Progress {
    number: usize,
    name: String,
    tests: usize,
    done: usize,
    output: VecDeque<String>,
}

impl Progress {
    fn new(number: usize, name: String) -> Self {
        Self { number, name, tests: 0, done: 0, output: VecDeque::new() }
    }

    /// Whether a test has ended by this line.
    fn take(&mut self, line: String) -> bool {
        if let Some(tests) = tests(&line) {
            (self.tests, self.done) = (tests, 0);
            self.output.clear();
        }
        let is_result = is_result(&line);
        self.done += usize::from(is_result);
        self.output.push_back(line);
        if self.output.len() > LINES_KEPT {
            self.output.pop_front();
        }
        is_result
    }
}

/// Where all suites of a stage say how far they are.
struct Screen<'a> {
    stage: &'a str,
    suites: usize,
    since_said: Stopwatch,
    is_terminal: bool,
}

impl<'a> Screen<'a> {
    fn new(stage: &'a str, suites: usize) -> Self {
        Self { stage, suites, since_said: Stopwatch::start(), is_terminal: io::stderr().is_terminal() }
    }

    fn say(&mut self, Progress { number, name, tests, done, .. }: &Progress) {
        let of = if (1..*tests).contains(done) { format!(", test {done} of {tests}") } else { String::new() };
        // On a terminal the line is overwritten by the next.
        self.clear();
        eprint!(
            "{}: suite {number} of {}, {name}{of}{}",
            self.stage,
            self.suites,
            if self.is_terminal { "" } else { "\n" }
        );
        self.since_said = Stopwatch::start();
    }

    fn say_sometimes(&mut self, progress: &Progress) {
        if self.is_terminal || self.since_said.elapsed_s() > SAID_EVERY_S {
            self.say(progress);
        }
    }

    fn clear(&self) {
        if self.is_terminal {
            eprint!("\r\x1b[K");
        }
    }

    fn show(&self, output: &VecDeque<String>) {
        self.clear();
        output.iter().for_each(|line| eprintln!("{line}"));
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
    fn what_tests_print_is_understood() {
        assert_eq!(super::tests("running 5 tests"), Some(5));
        assert_eq!(super::tests("running away"), None);
        assert!(is_result("test names::are_read ... ok"));
        assert!(!is_result("test slow ... ignored, needs Node"));
        assert!(!is_result("test result: ok. 3 passed; 0 failed"));
    }

    #[test]
    fn the_tests_of_a_suite_are_counted_and_what_it_prints_is_kept() {
        let mut progress = Progress::new(1, "a".to_owned());
        let lines = ["Doc-tests", "running 3 tests", "test two ... ok", "test three ... FAILED", "why"];
        let are_results = lines.map(|line| progress.take(line.to_owned()));
        assert_eq!(are_results, [false, false, true, true, false]);
        assert_eq!((progress.tests, progress.done), (3, 2));
        assert_eq!(progress.output, &lines[1..]);
    }

    /// What cargo says of the suite `tests/b.rs` of the package in this folder.
    fn message(folder: &Path) -> Value {
        serde_json::json!({
            "profile": { "test": true },
            "executable": "/a-12",
            "manifest_path": folder.join("Cargo.toml"),
            "target": { "src_path": folder.join("tests/b.rs") },
        })
    }

    #[test]
    fn a_suite_runs_in_the_folder_of_its_package() {
        let folder = workspace::root().join("crates/a");
        let Suite { name, command, .. } = suite(&message(&folder)).unwrap();
        assert_eq!(Path::new(&name), Path::new("crates/a/tests/b.rs"));
        assert_eq!(command.get_program(), "/a-12");
        assert_eq!(command.get_current_dir(), Some(&*folder));
        assert_eq!(command.get_envs().next(), Some(("CARGO_MANIFEST_DIR".as_ref(), Some(folder.as_os_str()))));
        assert!(suite(&serde_json::json!({ "profile": { "test": false }, "executable": "/a" })).is_none());
    }

    #[test]
    fn the_tools_suites_run_alone() {
        let is_alone = |folder| suite(&message(&workspace::root().join(folder))).unwrap().is_alone;
        assert_eq!(["crates/isostep", "crates/sim", "tests"].map(is_alone), [true, false, false]);
    }

    /// Each of these suites is this executable, which is asked for one test or for something that it does not know.
    fn suites(args: &[&str]) -> Vec<Suite> {
        let suite = |arg: &&str| {
            let mut command = Command::new(std::env::current_exe().unwrap());
            command.args([arg, "--exact"]);
            Suite { name: (*arg).to_owned(), command, is_alone: false }
        };
        args.iter().map(suite).collect()
    }

    const PASSES: &str = "suites::tests::what_tests_print_is_understood";

    #[test]
    fn suites_run_and_the_one_that_fails_is_named() {
        run_all("all pass", suites(&[PASSES; 3])).unwrap();
        let error = run_all("the last fails", suites(&[PASSES, PASSES, "--unknown"])).unwrap_err().to_string();
        assert!(error.starts_with("--unknown failed ("), "{error}");
        let missing = Suite { name: "missing".to_owned(), command: Command::new("/no/such/program"), is_alone: true };
        let error = run_all("the only one cannot start", vec![missing]).unwrap_err().to_string();
        assert_eq!(error, "cannot start missing");
    }
}
