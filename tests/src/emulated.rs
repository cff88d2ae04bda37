//! The firmware, unmodified, in an emulated RP2040: `tests/emulator`, run as a program.

use std::path::{Path, PathBuf};
use std::process::Command;
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
    /// Its figures.
    pub figures: Value,
    /// Every STEP edge.
    pub edges: Vec<Edge>,
    /// Every change of the tool's outputs.
    pub outputs: Vec<OutputChange>,
}

/// A change of one of the tool's outputs.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputChange {
    /// When, since power-up.
    pub t_ns: f64,
    /// `pwm`, `enable`, `direction`, `flood` or `mist`.
    pub output: String,
    /// The duty of `pwm`, of the others 0 or 1.
    pub value: f64,
}

impl OutputChange {
    /// Of a row below the header.
    fn read(row: &str) -> Self {
        let mut fields = row.split(',');
        let mut next = || fields.next().expect("three fields");
        let (t_ns, output, value) = (next(), next(), next());
        let number = |text: &str| text.parse().expect("a number");
        Self { t_ns: number(t_ns), output: output.to_owned(), value: number(value) }
    }
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
        let variable = Self::elf_variable(port);
        let elf = env::var_os(variable);
        let elf = elf.unwrap_or_else(|| panic!("{variable} names the firmware: run these by `cargo xtask test`"));
        let folder = root().join("target/emulated").join(test);
        fs::create_dir_all(&folder).expect("a folder for the run's files");
        let mut command = Command::new("node");
        command.arg(root().join("tests/emulator/run.mjs")).arg("--elf").arg(elf);
        Self { folder, command }
    }

    /// The environment variable that names the firmware that steps by `port`.
    #[must_use]
    pub fn elf_variable(port: Port) -> &'static str {
        match port {
            Port::Pio => "ISOSTEP_ELF",
            Port::Timer => "ISOSTEP_TIMER_PORT_ELF",
        }
    }

    /// More of the emulator's options.
    #[must_use]
    pub fn with(mut self, options: &[&str]) -> Self {
        self.command.args(options);
        self
    }

    /// Streams a program.
    ///
    /// # Panics
    /// When something with a deadline came from flash.
    pub fn program(mut self, path: &Path) -> Run {
        self.run("--program", path)
    }

    /// Holds a dialogue: see `node tests/emulator/run.mjs --help`.
    ///
    /// # Panics
    /// When something with a deadline came from flash.
    pub fn script(mut self, script: &str) -> Run {
        let path = self.folder.join("script.txt");
        fs::write(&path, script).expect("the script");
        self.run("--script", &path)
    }

    fn run(&mut self, what: &str, path: &Path) -> Run {
        let file = |name: &str| self.folder.join(name);
        let (trace, outputs, figures) = (file("trace.csv"), file("outputs.csv"), file("figures.json"));
        // What the run before left must not be taken for this one's.
        let _ = fs::remove_file(&figures);
        self.command.arg(what).arg(path).arg("--trace").arg(&trace).arg("--json").arg(&figures);
        self.command.arg("--outputs").arg(&outputs);
        let output = self.command.output().expect("node runs");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let figures = fs::read(figures).unwrap_or_else(|error| panic!("{error}: {}", text(&output.stderr)));
        let figures = serde_json::from_slice(&figures).expect("JSON");
        self.assert_deadlines_need_no_flash(&figures);
        let edges = compare::read(fs::File::open(trace).expect("the run's trace")).expect("a step trace");
        let outputs = fs::read_to_string(outputs).expect("the run's outputs");
        let outputs = outputs.lines().skip(1).map(OutputChange::read).collect();
        Run { ok: output.status.success(), printed: text(&output.stdout), figures, edges, outputs }
    }

    /// What comes from flash may be late by as much as flash takes. So nothing does in interrupts, nor while all of them are
    /// masked.
    ///
    /// Left out is what has no deadline: data read in critical sections, which is that of log lines, written at rest only,
    /// and handlers, once a fault has stopped the motors.
    fn assert_deadlines_need_no_flash(&self, figures: &Value) {
        let handlers = ["flash_in_handlers", "flash_in_handlers_data"].map(Some);
        let handlers = handlers.map(|place| place.filter(|_| figures["hard_faults"] == Value::Array(Vec::new())));
        for place in handlers.into_iter().flatten().chain(["flash_in_critical_sections"]) {
            self.assert_none(place, &figures[place]);
        }
    }

    fn assert_none(&self, place: &str, tally: &Value) {
        let (folder, pcs) = (self.folder.display(), &tally["pcs"]);
        assert_eq!(
            tally["count"], 0,
            "{folder}: {place}, most often at {pcs}: addr2line -f -i -C -e ELF PC tells which function"
        );
    }
}
