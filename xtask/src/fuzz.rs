//! `cargo xtask fuzz`: tests with bytes that no sender would send. They are chosen by the code that they reach.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result};
use clap::ValueEnum;

use crate::process::{self, announce};
use crate::{tools, workspace};

const CARGO_FUZZ: &str = "0.13.2";
/// An input that takes longer than this counts as a finding, s.
const TIMEOUT_S: u32 = 30;
/// Memory that a long run needs, MB. The simulated machine leaks some of its memory, because it is allocated for the
/// program's lifetime as on a board.
const MEMORY_MB: u32 = 6_000;

/// Look for bytes that break console, store, planner, blends or machine
#[derive(clap::Args)]
#[command(after_help = "\
libFuzzer makes up bytes, and keeps those that reach code that no others have reached. It begins with tests/fuzz/corpus; what it finds
goes to target/fuzz/corpus, and what breaks something to tests/fuzz/artifacts. It works with the stable toolchain and a C++ compiler, on
Linux and macOS. cargo-fuzz is installed under target/tools. tests/fuzz/README.md tells what each target checks.

`cargo test -p isostep-tests corpus::` puts tests/fuzz/corpus to the same targets without a fuzzer.

Examples:
  cargo xtask fuzz                                        five minutes each
  cargo xtask fuzz planner --minutes 60
  cargo xtask fuzz planner --file tests/fuzz/artifacts/planner/crash-0123     again what broke it
  cargo xtask fuzz planner --keep                         put what reaches anything new into tests/fuzz/corpus")]
pub struct Args {
    /// The fuzzer; without it all, one after the other
    target: Option<Target>,
    /// Time for which each is fuzzed, minutes
    #[arg(long, default_value_t = 5)]
    minutes: u64,
    /// Only put the bytes of a file to it, once
    #[arg(long, requires = "target")]
    file: Option<PathBuf>,
    /// Do not fuzz: keep in tests/fuzz/corpus the fewest files that reach all that was reached
    #[arg(long, conflicts_with = "file")]
    keep: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Target {
    /// Bytes to the console's lines, words, settings and reports
    Console,
    /// The content of flash, changes of it, and power cuts
    Store,
    /// Moves that flow, holds and overrides
    Planner,
    /// The same with blends at their corners
    Blends,
    /// Bytes, time and switches to the whole machine in the simulator
    Machine,
}

impl Target {
    fn name(self) -> &'static str {
        match self {
            Self::Console => "console",
            Self::Store => "store",
            Self::Planner => "planner",
            Self::Blends => "blends",
            Self::Machine => "machine",
        }
    }

    /// Longest input, bytes. Longer inputs find hardly anything more.
    fn bytes_max(self) -> u32 {
        match self {
            Self::Console | Self::Store => 1_024,
            Self::Planner | Self::Blends => 768,
            Self::Machine => 256,
        }
    }
}

pub fn run(args: Args) -> Result<()> {
    let fuzzer = Fuzzer { cargo_fuzz: tools::installed("cargo-fuzz", CARGO_FUZZ)? };
    let Some(target) = args.target else {
        return Target::value_variants().iter().try_for_each(|target| fuzzer.fuzzes(*target, &args));
    };
    match &args.file {
        Some(file) => process::run(fuzzer.run(target).arg(file.canonicalize().context(file.display().to_string())?)),
        None => fuzzer.fuzzes(target, &args),
    }
}

struct Fuzzer {
    cargo_fuzz: PathBuf,
}

impl Fuzzer {
    fn fuzzes(&self, target: Target, args: &Args) -> Result<()> {
        let kept = workspace::root().join("tests/fuzz/corpus").join(target.name());
        let found = workspace::target_dir().join("fuzz/corpus").join(target.name());
        fs::create_dir_all(&found).with_context(|| found.display().to_string())?;
        let mut command = self.run(target);
        if args.keep {
            announce(&format!("{}: what reaches anything new goes to {}", target.name(), workspace::shown(&kept)));
            command.args([&kept, &found]).args(["--", "-set_cover_merge=1"]);
            // Keeps files by the code that they reach and not by how often they reach it. That leaves a few files
            // instead of a thousand.
            return process::run(command.args(["-use_counters=0", "-use_cmp=0"]));
        }
        announce(&format!("{}: {} min", target.name(), args.minutes));
        // New inputs are stored in the first folder.
        command.args([&found, &kept]).arg("--");
        command.arg(format!("-max_total_time={}", 60 * args.minutes));
        command.arg(format!("-max_len={}", target.bytes_max()));
        command.arg(format!("-timeout={TIMEOUT_S}"));
        command.arg(format!("-rss_limit_mb={MEMORY_MB}"));
        process::run(command.arg("-print_final_stats=1"))
    }

    /// The command that runs the target. Files or folders of bytes are still to be added to it.
    fn run(&self, target: Target) -> Command {
        let mut command = Command::new(&self.cargo_fuzz);
        // It runs without a sanitizer, because sanitizers need a nightly compiler and would only find errors in unsafe
        // code.
        command.current_dir(workspace::root()).args([
            "run",
            "--sanitizer",
            "none",
            "--fuzz-dir",
            "tests/fuzz",
            "--target-dir",
        ]);
        command.arg(workspace::target_dir().join("fuzz")).arg(target.name());
        command
    }
}
