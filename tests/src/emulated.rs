//! The firmware, unmodified, in an emulated RP2040: `tests/emulator`, run as a program.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::{env, fs};

use isostep_sim::world::Edge;
use isostep_sim::{Port, compare};
use serde_json::Value;

use crate::root;

/// One run of the emulated board; its files are in a folder named after the test.
pub struct Board {
    folder: PathBuf,
    command: Command,
}

/// What a run left behind.
pub struct Run {
    /// Whether everything went through.
    pub ok: bool,
    /// What it printed: the summary, and before it the transcript of a script.
    pub printed: String,
    /// The figures of a program's run; null for a script.
    pub figures: Value,
    /// Every STEP edge.
    pub edges: Vec<Edge>,
}

impl Board {
    /// A board at power-up, with the firmware that `cargo xtask test` built.
    ///
    /// # Panics
    /// When `ISOSTEP_ELF` does not say where the firmware is.
    pub fn new(test: &str) -> Self {
        Self::stepped_by(Port::Pio, test)
    }

    /// A board at power-up, with the firmware that steps by `port`.
    ///
    /// # Panics
    /// When `ISOSTEP_ELF`, or `ISOSTEP_TIMER_PORT_ELF`, does not say where that firmware is.
    pub fn stepped_by(port: Port, test: &str) -> Self {
        let variable = match port {
            Port::Pio => "ISOSTEP_ELF",
            Port::Timer => "ISOSTEP_TIMER_PORT_ELF",
        };
        let elf = env::var_os(variable);
        let elf = elf.unwrap_or_else(|| panic!("{variable} names the firmware: run these by `cargo xtask test`"));
        let folder = root().join("target/emulated").join(test);
        fs::create_dir_all(&folder).expect("a folder for the run's files");
        let mut command = Command::new("node");
        command.arg(root().join("tests/emulator/run.mjs")).arg("--elf").arg(elf);
        Self { folder, command }
    }

    /// More of the emulator's options.
    #[must_use]
    pub fn with(mut self, options: &[&str]) -> Self {
        self.command.args(options);
        self
    }

    /// Streams a program.
    pub fn program(mut self, path: &Path) -> Run {
        let figures = self.folder.join("figures.json");
        let output = self.run("--program", path, Some(&figures));
        let figures = serde_json::from_slice(&fs::read(figures).expect("the run's figures")).expect("JSON");
        self.ended(&output, figures)
    }

    /// Holds a dialogue: see `node tests/emulator/run.mjs --help`.
    pub fn script(mut self, script: &str) -> Run {
        let path = self.folder.join("script.txt");
        fs::write(&path, script).expect("the script");
        let output = self.run("--script", &path, None);
        self.ended(&output, Value::Null)
    }

    fn run(&mut self, what: &str, path: &Path, figures: Option<&Path>) -> Output {
        let trace = self.trace();
        self.command.arg(what).arg(path).arg("--trace").arg(trace);
        if let Some(figures) = figures {
            self.command.arg("--json").arg(figures);
        }
        self.command.output().expect("node runs")
    }

    fn ended(&self, output: &Output, figures: Value) -> Run {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let trace = fs::File::open(self.trace()).unwrap_or_else(|error| panic!("{error}: {}", text(&output.stderr)));
        let edges = compare::read(trace).expect("a step trace");
        Run { ok: output.status.success(), printed: text(&output.stdout), figures, edges }
    }

    fn trace(&self) -> PathBuf {
        self.folder.join("trace.csv")
    }
}
