//! `cargo xtask mutants`: checks whether the tests notice wrong code.

use std::collections::BTreeSet;
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use isostep_trials::{AMOUNT_VARIABLE, Amount};
use oorandom::Rand64;

use crate::process::{self, announce};
use crate::{tools, workspace};

const CARGO_MUTANTS: &str = "27.1.0";
/// Exit codes of cargo-mutants when it has completed its work: no findings, missed mutants, timeouts.
const DONE: [i32; 3] = [0, 2, 3];
/// Time limit for compiling a mutant and the tests, s. A mutant of a constant function may never end.
const BUILD_TIMEOUT_S: u32 = 600;

/// Change the code in small ways, one at a time, and see whether the tests notice
#[derive(clap::Args)]
#[command(after_help = "\
Each mutant is a small change: a function that does nothing, a < for a <=, a + for a -. The tests of its crate are to fail by
it; those that they do not catch are put to slower tests, as long as fewer are caught than --least asks for. What is excluded,
and why, is in .cargo/mutants.toml.

cargo-mutants is installed under target/tools, works in a copy of the sources, and compiles it under target/mutants. A sample is
drawn from a seed: the same command tries the same mutants as long as the crate is the same. docs/testing.md has the scores.

Examples:
  cargo xtask mutants console --sample 50              50 of the console's, by chance
  cargo xtask mutants console --sample 20 --least 80   20 of them, and no failure if 16 are caught
  cargo xtask mutants profile                          all of them: hours

Each suite leaves its lists in target/mutants/PACKAGE-SUITE/mutants.out; missed.txt is what the next one begins with. A list of all
and a trial of some are of cargo-mutants itself: target/tools/bin/cargo-mutants mutants --package isostep-console --list, or with
--file or --re.")]
pub struct Args {
    /// Whose code is changed
    package: Package,
    /// So many of its mutants, chosen by chance; without it all
    #[arg(long)]
    sample: Option<usize>,
    /// Seed of the choice
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Fail when less than that is caught, percent: in a sample there may be mutants that change nothing
    #[arg(long, default_value_t = 100.0, value_parser = percent)]
    least: f64,
}

#[derive(Clone, Copy, ValueEnum)]
enum Package {
    Profile,
    Motion,
    Console,
    Controller,
}

/// Tests that are built and run together: those of these packages, or only those in these files if any are named.
struct Suite {
    packages: &'static [&'static str],
    tests: &'static [&'static str],
    /// The machine has four axes.
    four_axes: bool,
    /// Random tests try all their cases.
    has_all_cases: bool,
    /// Time limit for all test binaries together, s. A run that takes longer is considered stuck.
    timeout_s: u32,
}

const fn suite(packages: &'static [&'static str], tests: &'static [&'static str], timeout_s: u32) -> Suite {
    Suite { packages, tests, four_axes: false, has_all_cases: true, timeout_s }
}

const fn four_axes(packages: &'static [&'static str], timeout_s: u32) -> Suite {
    Suite { four_axes: true, ..suite(packages, &[], timeout_s) }
}

/// Random tests try few cases: of all of them, each mutant would take minutes.
const fn few_cases(packages: &'static [&'static str], tests: &'static [&'static str], timeout_s: u32) -> Suite {
    Suite { has_all_cases: false, ..suite(packages, tests, timeout_s) }
}

impl Suite {
    /// The argument that makes cargo compile these tests.
    fn choice(&self) -> &'static str {
        match self.tests {
            [] if self.four_axes => "--test=four_axes",
            // This selects everything except the examples in the documentation, each of which is linked separately.
            [] => "--tests",
            _ => "--test=it",
        }
    }

    /// The arguments that make the harness run these tests.
    fn files(&self) -> impl Iterator<Item = String> {
        ["--".to_owned()].into_iter().chain(self.tests.iter().map(|file| format!("{file}::")))
    }

    fn features(&self) -> &'static [&'static str] {
        if self.four_axes { &["--features=four-axes"] } else { &[] }
    }

    fn without_mutant(&self, target: &Path) -> Command {
        let mut command = Command::new("cargo");
        self.compiles_into(&mut command, target);
        command.current_dir(workspace::root()).args(["test", "--quiet"]);
        command.args(self.packages.iter().map(|package| format!("--package={package}")));
        command.arg(self.choice()).args(self.features()).args(self.files());
        command
    }

    /// Sets a build folder in which everything except the mutant is compiled already. Without debug information, linking is
    /// faster.
    fn compiles_into(&self, command: &mut Command, target: &Path) {
        command.env("CARGO_TARGET_DIR", target).env("CARGO_PROFILE_DEV_DEBUG", "0");
        let amount = if self.has_all_cases { Amount::All } else { Amount::More };
        command.env(AMOUNT_VARIABLE, amount.value());
    }
}

impl fmt::Display for Suite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "by the tests of {}", self.packages.join(", "))?;
        if self.tests.is_empty() { Ok(()) } else { write!(f, ": {}", self.tests.join(", ")) }
    }
}

impl Package {
    fn name(self) -> &'static str {
        match self {
            Self::Profile => "isostep-profile",
            Self::Motion => "isostep-motion",
            Self::Console => "isostep-console",
            Self::Controller => "isostep-controller",
        }
    }

    /// The suites, the fastest first. Each suite tests the mutants that the previous ones did not catch.
    fn suites(self) -> &'static [Suite] {
        match self {
            Self::Profile => PROFILE,
            Self::Motion => MOTION,
            Self::Console => CONSOLE,
            Self::Controller => CONTROLLER,
        }
    }
}

const WHOLE: &[&str] = &["isostep-tests"];
const PROFILE: &[Suite] = &[
    few_cases(&["isostep-profile"], &["chain", "speed_profiles", "papers", "refusals", "shaper"], 120),
    few_cases(&["isostep-profile"], &[], 240),
    suite(WHOLE, &["corpus", "chains"], 600),
    suite(&["isostep-profile"], &["chain"], 900),
];
const CONSOLE: &[Suite] = &[
    few_cases(&["isostep-console"], &[], 30),
    four_axes(&["isostep-console"], 30),
    few_cases(WHOLE, &["corpus", "dialogues"], 180),
];
const SIMULATED: Suite = suite(&["isostep-sim", "isostep-report"], &[], 90);
const MOTION: &[Suite] = &[
    SIMULATED,
    suite(WHOLE, &["dialogues"], 180),
    suite(WHOLE, &["chains", "contract", "homing", "preemption", "step_port", "real_time_orders"], 600),
    suite(WHOLE, &["rasters", "squared"], 300),
    suite(&["isostep-motion"], &[], 60),
    four_axes(WHOLE, 180),
];
const CONTROLLER: &[Suite] =
    &[SIMULATED, suite(WHOLE, &["dialogues"], 180), suite(WHOLE, &["corpus", "store", "programs"], 300)];

pub fn run(args: Args) -> Result<()> {
    let tool = Tool { binary: tools::installed("cargo-mutants", CARGO_MUTANTS)?, package: args.package };
    let all = tool.list()?;
    let all_count = all.len();
    let mut names = sample(all, args.sample.unwrap_or(all_count), args.seed);
    let mut tally = Tally::default();
    for (index, suite) in args.package.suites().iter().enumerate() {
        // More may be caught by slower tests, and the answer would be the same.
        if names.is_empty() || index > 0 && tally.score(&names) >= args.least {
            break;
        }
        announce(&format!("{} mutants of {all_count} of {}, {suite}", names.len(), args.package.name()));
        let found = tool.tries(&names, suite, index)?;
        names = found.missed.clone();
        tally.add(found);
    }
    print!("{}", tally.table(args.package.name(), &names));
    let score = tally.score(&names);
    if score >= args.least {
        return Ok(());
    }
    bail!("{} of the mutants were not caught: {score:.1} % are, and {} % are to be", names.len(), args.least)
}

fn percent(text: &str) -> Result<f64, String> {
    let percent = text.parse().ok().filter(|percent| (0.0..=100.0).contains(percent));
    percent.ok_or_else(|| "a percentage is 0 to 100".to_owned())
}

/// A random choice of `most` names, in their original order.
fn sample(names: Vec<String>, most: usize, seed: u64) -> Vec<String> {
    let mut random = Rand64::new(seed.into());
    let mut chosen: Vec<_> = names.into_iter().enumerate().collect();
    // Only the first places are shuffled, and they are the choice.
    let most = most.min(chosen.len());
    for place in 0..most {
        let other = random.rand_range(place as u64..chosen.len() as u64);
        chosen.swap(place, other as usize);
    }
    chosen.truncate(most);
    chosen.sort();
    chosen.into_iter().map(|(_, name)| name).collect()
}

struct Tool {
    binary: PathBuf,
    package: Package,
}

impl Tool {
    fn command(&self) -> Command {
        let mut command = Command::new(&self.binary);
        command.current_dir(workspace::root()).args(["mutants", "--package", self.package.name()]);
        command
    }

    fn list(&self) -> Result<Vec<String>> {
        let names = process::output(self.command().arg("--list"), "cargo xtask installs it")?;
        Ok(names.lines().map(str::to_owned).collect())
    }

    /// Runs a suite on the mutants with these names.
    fn tries(&self, names: &[String], suite: &Suite, index: usize) -> Result<Found> {
        let folder = workspace::target_dir().join("mutants");
        let output = folder.join(format!("{}-{}", self.package.name(), index + 1));
        fs::create_dir_all(&output).with_context(|| output.display().to_string())?;
        let target = folder.join("build").join(self.package.name());
        let mut command = self.command();
        suite.compiles_into(&mut command, &target);
        command.args(["--no-shuffle", "--cap-lints=true", "--colors=never", "--output"]).arg(&output);
        command.args(["--timeout", &suite.timeout_s.to_string(), "--build-timeout", &BUILD_TIMEOUT_S.to_string()]);
        command.args(suite.packages.iter().map(|package| format!("--test-package={package}")));
        command.arg(format!("--cargo-arg={}", suite.choice())).args(suite.features());
        command.args(names.iter().map(|name| format!("--re=^{}$", escaped(name))));
        command.args(files(names).iter().map(|file| format!("--file={file}")));
        if suite.packages != [self.package.name()] {
            // For its run without a mutant, cargo-mutants would use the tests of the package that it changes. So that
            // run is made here.
            announce("the same tests without a mutant");
            process::run(&mut suite.without_mutant(&target))?;
            command.arg("--baseline=skip");
        }
        command.arg("--").args(suite.files());
        let status = command.status().context("cargo-mutants")?;
        if !status.code().is_some_and(|code| DONE.contains(&code)) {
            bail!("cargo-mutants failed ({status}); what it says is in {}", workspace::shown(&output));
        }
        let found = Found::read(&output.join("mutants.out"), names)?;
        if found.count() != names.len() {
            bail!(
                "cargo-mutants has tried {} mutants of {}: the sources have changed meanwhile",
                found.count(),
                names.len()
            );
        }
        Ok(found)
    }
}

/// The files of these mutants. A name begins with its file.
fn files(names: &[String]) -> BTreeSet<&str> {
    names.iter().filter_map(|name| name.split(':').next()).collect()
}

/// A regular expression that matches exactly this text. Only special characters are escaped, because some escapes have
/// a meaning: `\<` matches the beginning of a word.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for char in text.chars() {
        if r"\.+*?()|[]{}^$".contains(char) {
            escaped.push('\\');
        }
        escaped.push(char);
    }
    escaped
}

/// The names of mutants by result.
struct Found {
    caught: Vec<String>,
    missed: Vec<String>,
    /// Mutants that run into the time limit. They count as noticed.
    timeouts: Vec<String>,
    /// Mutants that do not compile.
    unviable: Vec<String>,
}

impl Found {
    fn count(&self) -> usize {
        [&self.caught, &self.missed, &self.timeouts, &self.unviable].map(Vec::len).iter().sum()
    }

    /// Reads the results of these mutants. Others are ignored, because cargo-mutants tries every mutant that leaves a field
    /// out of an expression in these files, even if it is not requested.
    fn read(folder: &Path, names: &[String]) -> Result<Self> {
        let of = |file: &str| -> Result<Vec<String>> {
            let path = folder.join(file);
            let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
            let is_asked_for = |name: &&str| names.iter().any(|asked| asked == name);
            Ok(text.lines().filter(is_asked_for).map(str::to_owned).collect())
        };
        let (caught, missed) = (of("caught.txt")?, of("missed.txt")?);
        Ok(Self { caught, missed, timeouts: of("timeout.txt")?, unviable: of("unviable.txt")? })
    }
}

/// The results from all suites.
#[derive(Default)]
struct Tally {
    caught: BTreeSet<String>,
    timeouts: BTreeSet<String>,
    unviable: BTreeSet<String>,
}

impl Tally {
    fn add(&mut self, found: Found) {
        self.caught.extend(found.caught);
        self.timeouts.extend(found.timeouts);
        self.unviable.extend(found.unviable);
    }

    /// The share of the mutants that compile that are caught, percent.
    fn score(&self, missed: &[String]) -> f64 {
        let caught = self.caught.len() + self.timeouts.len();
        if missed.is_empty() { 100.0 } else { 100.0 * caught as f64 / (caught + missed.len()) as f64 }
    }

    fn table(&self, package: &str, missed: &[String]) -> String {
        let (caught, timeouts, score) = (self.caught.len(), self.timeouts.len(), self.score(missed));
        let viable = caught + timeouts + missed.len();
        let mut table = String::from("crate                viable  caught  timeouts  missed  unviable   score\n");
        table += &format!("{package:<20} {viable:>6}  {caught:>6}  {timeouts:>8}  {:>6}", missed.len());
        table += &format!("  {:>8}  {score:>5.1} %\n", self.unviable.len());
        missed.iter().for_each(|name| table += &format!("missed: {name}\n"));
        table
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_is_of_its_seed_and_in_order() {
        let names: Vec<_> = (0..100).map(|number| format!("{number:02}")).collect();
        let first = sample(names.clone(), 10, 1);
        assert_eq!(first, sample(names.clone(), 10, 1));
        assert_ne!(first, sample(names.clone(), 10, 2));
        assert!(first.len() == 10 && first.is_sorted() && first.windows(2).all(|pair| pair[0] != pair[1]));
        assert_eq!(sample(names.clone(), 200, 1), names);
    }

    #[test]
    fn files_are_named_once() {
        let names =
            ["src/b.rs:1:2: delete !", "src/a.rs:3:4: replace a::b", "src/b.rs:5:6: delete -"].map(str::to_owned);
        assert_eq!(files(&names).into_iter().collect::<Vec<_>>(), ["src/a.rs", "src/b.rs"]);
    }

    #[test]
    fn a_name_is_taken_as_it_is() {
        assert_eq!(
            escaped("a.rs:1:2: replace <a>::f(b) -> [c] with x"),
            r"a\.rs:1:2: replace <a>::f\(b\) -> \[c\] with x"
        );
    }

    #[test]
    fn a_timeout_counts_as_caught_and_what_does_not_compile_not_at_all() {
        let of = |count: usize| (0..count).map(|number| number.to_string()).collect::<Vec<_>>();
        let mut tally = Tally::default();
        tally.add(Found { caught: of(17), missed: of(2), timeouts: vec!["t".into()], unviable: of(5) });
        let table = tally.table("a", &["m".into(), "n".into()]);
        let row = table.lines().nth(1).unwrap().split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(row, "a 20 17 1 2 5 90.0 %");
        assert!(table.ends_with("missed: m\nmissed: n\n"));
        assert_eq!(Tally::default().score(&[]), 100.0, "of none");
    }
}
