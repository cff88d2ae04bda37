//! Runs the unmodified firmware in an emulated RP2040 or RP2350: starts the program `tests/emulator`.

mod live;
mod process;

use std::path::{Path, PathBuf};
use std::{env, fs};

use isostep_controller::least_times;
use isostep_motion::DriverTiming;
use isostep_sim::world::Edge;
use isostep_sim::{AXES, Config, Port};
use serde_json::Value;

use crate::root;
pub use live::Live;
use process::Process;

/// One run of the emulated board. Its files are in a folder named after the test.
pub struct Board {
    folder: PathBuf,
    /// The emulator's command line.
    options: Vec<String>,
}

/// The results of a run.
pub struct Run {
    /// True if the run succeeded.
    pub ok: bool,
    /// The output of the emulator: the transcript if it ran a script, then the summary.
    pub printed: String,
    /// The figures of the run.
    pub figures: Value,
    /// Every STEP edge; the fourth axis is 3, whatever number of axes this is compiled for.
    pub edges: Vec<Edge>,
    /// Every change of the tool's outputs.
    pub outputs: Vec<OutputChange>,
}

/// A change of one of the tool's outputs.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputChange {
    /// When the output changed, ns since power-up.
    pub t_ns: f64,
    /// `pwm`, `enable`, `direction`, `flood` or `mist`.
    pub output: String,
    /// The duty of `pwm`, 0 to 1; 0 or 1 for the others.
    pub value: f64,
}

impl OutputChange {
    /// Parses a row below the header.
    fn read(row: &str) -> Self {
        let mut fields = row.split(',');
        let mut next = || fields.next().expect("three fields");
        let (t_ns, output, value) = (next(), next(), next());
        let number = |text: &str| text.parse().expect("a number");
        Self { t_ns: number(t_ns), output: output.to_owned(), value: number(value) }
    }
}

/// Parses a row of a trace below its header.
fn edge(row: &str) -> Edge {
    let mut fields = row.split(',');
    let mut next = || fields.next().expect("four fields");
    let t_ns = next().parse().expect("a time");
    let axis = "XYZA".find(next()).expect("an axis");
    let mut number = || next().parse().expect("a number");
    Edge { t_ns, axis, direction: number(), position_steps: number() }
}

impl Run {
    /// The number of steps that each axis made, A the last.
    #[must_use]
    pub fn steps(&self) -> [usize; 4] {
        std::array::from_fn(|axis| self.edges.iter().filter(|edge| edge.axis == axis).count())
    }
}

/// The simulated machine that is to do the same: it has the drivers of the emulated board, and the least times of its chip.
#[must_use]
pub fn config() -> Config {
    let driver = if is_skr_pico() { DriverTiming::TMC2209 } else { DriverTiming::DRV8825 };
    let least_times = if is_pico_2() { least_times::RP2350 } else { least_times::RP2040 };
    Config { driver, least_times, ..Config::default() }
}

/// The environment variable that names whose pins the emulated board has, if not those of a Pico.
const BOARD: &str = "ISOSTEP_BOARD";

/// Whose pins the emulated board has.
#[must_use]
pub fn board() -> String {
    env::var(BOARD).unwrap_or_else(|_| "pico".to_owned())
}

/// True if the emulated board is an SKR Pico, whose drivers have a UART.
#[must_use]
pub fn is_skr_pico() -> bool {
    board() == "skr-pico"
}

/// True if the emulated board is a Pico 2, whose chip has another clock.
#[must_use]
pub fn is_pico_2() -> bool {
    board() == "pico2"
}

/// The cycle of the chip's clock that is so many ns after another. Its edges are on cycles, of which an RP2350's are no whole ns.
#[must_use]
pub fn cycles(ns: u64) -> u64 {
    let clock_ghz = if is_pico_2() { 0.150 } else { 0.125 };
    (ns as f64 * clock_ghz).round() as u64
}

impl Board {
    /// A board at power-up, with the firmware that `cargo xtask test` built.
    ///
    /// # Panics
    /// When `ISOSTEP_ELF` is not set to the path of the firmware.
    pub fn new(test: &str) -> Self {
        Self::stepped_by(Port::Pio, test)
    }

    /// A board at power-up, with the firmware that steps by `port`.
    ///
    /// # Panics
    /// When `ISOSTEP_ELF` or, for the timer port, `ISOSTEP_TIMER_PORT_ELF` is not set to the path of that firmware.
    pub fn stepped_by(port: Port, test: &str) -> Self {
        Self::of_firmware(Self::elf_variable(port), test)
    }

    /// A board at power-up, with the firmware that this environment variable names.
    ///
    /// # Panics
    /// When it is not set.
    pub fn of_firmware(variable: &str, test: &str) -> Self {
        Self::wired(variable, AXES, &board(), test)
    }

    /// A board of four axes, whatever number this is compiled for: with three there is an image for one port.
    ///
    /// # Panics
    /// When the firmware is not named.
    pub fn of_four_axes(port: Port, test: &str) -> Self {
        let variable = if AXES == 4 { Self::elf_variable(port) } else { "ISOSTEP_FOUR_AXES_ELF" };
        Self::wired(variable, 4, &board(), test)
    }

    /// An SKR Pico of three axes.
    ///
    /// # Panics
    /// When the firmware is not named.
    pub fn of_skr_pico(test: &str) -> Self {
        Self::wired("ISOSTEP_SKR_PICO_ELF", 3, "skr-pico", test)
    }

    /// The pins of a board with so many axes, and the firmware that this environment variable names.
    fn wired(variable: &str, axes: usize, board: &str, test: &str) -> Self {
        let elf = env::var(variable);
        let elf = elf.unwrap_or_else(|_| panic!("{variable} names the firmware: run these by `cargo xtask test`"));
        let folder = root().join("target/emulated").join(test);
        fs::create_dir_all(&folder).expect("a folder for the run's files");
        Self { folder, options: vec![format!("--elf={elf}"), format!("--axes={axes}"), format!("--board={board}")] }
    }

    /// The environment variable that names the firmware that steps by `port`.
    #[must_use]
    pub fn elf_variable(port: Port) -> &'static str {
        match port {
            Port::Pio => "ISOSTEP_ELF",
            Port::Timer => "ISOSTEP_TIMER_PORT_ELF",
        }
    }

    /// Has this image in place of its firmware.
    ///
    /// # Panics
    /// When it cannot be written.
    #[must_use]
    pub fn with_image(mut self, image: &[u8]) -> Self {
        let elf = self.folder.join("image.elf");
        fs::write(&elf, image).expect("the image");
        self.options[0] = format!("--elf={}", elf.display());
        self
    }

    /// Adds options of the emulator.
    #[must_use]
    pub fn with(mut self, options: &[&str]) -> Self {
        self.options.extend(options.iter().map(|&option| option.to_owned()));
        self
    }

    /// Streams a program.
    ///
    /// # Panics
    /// When a handler or critical section used flash.
    pub fn program(mut self, path: &Path) -> Run {
        self.run("--program", path)
    }

    /// Runs a script: see `node tests/emulator/run.mjs --help`.
    ///
    /// # Panics
    /// When a handler or critical section used flash.
    pub fn script(mut self, script: &str) -> Run {
        let path = self.folder.join("script.txt");
        fs::write(&path, script).expect("the script");
        self.run("--script", &path)
    }

    /// A board that runs only as far as it is asked.
    ///
    /// # Panics
    /// When Node does not start.
    #[must_use]
    pub fn live(self) -> Live {
        Live::start(self)
    }

    fn run(&mut self, what: &str, path: &Path) -> Run {
        let file = |name: &str| self.folder.join(name);
        let (trace, outputs, figures) = (file("trace.csv"), file("outputs.csv"), file("figures.json"));
        // The results of a previous run must not be taken for those of this one.
        let _ = fs::remove_file(&figures);
        let files = [(what, path), ("--trace", &trace), ("--json", &figures), ("--outputs", &outputs)];
        self.options.extend(files.map(|(option, path)| format!("{option}={}", path.display())));
        let (printed, ok) = Process::begin(&self.options).end();
        let figures = fs::read(figures).unwrap_or_else(|error| panic!("{error}: {printed}"));
        let figures = serde_json::from_slice(&figures).expect("JSON");
        self.assert_in_time(&figures);
        let edges = fs::read_to_string(trace).expect("the run's trace").lines().skip(1).map(edge).collect();
        let outputs = fs::read_to_string(outputs).expect("the run's outputs");
        let outputs = outputs.lines().skip(1).map(OutputChange::read).collect();
        Run { ok, printed, figures, edges, outputs }
    }

    /// Checks what must be true of every run.
    fn assert_in_time(&self, figures: &Value) {
        self.assert_deadlines_need_no_flash(figures);
        self.assert_no_alarm_is_late(&figures["late_alarms"]);
    }

    /// Checks that no interrupt handler and no code with all interrupts masked used flash, because reading flash may
    /// delay it.
    ///
    /// Two cases have no deadline and are not checked: data read in critical sections, which belongs to log lines and
    /// is read only at rest; and handlers after a fault has stopped the motors.
    fn assert_deadlines_need_no_flash(&self, figures: &Value) {
        let handlers = ["flash_in_handlers", "flash_in_handlers_data"].map(Some);
        let handlers = handlers.map(|place| place.filter(|_| figures["hard_faults"] == Value::Array(Vec::new())));
        for place in handlers.into_iter().flatten().chain(["flash_in_critical_sections"]) {
            self.assert_none(place, &figures[place]);
        }
    }

    /// Checks that the timer's alarm was never left set for an instant that had passed, because nothing would wake the
    /// tasks that wait for it.
    fn assert_no_alarm_is_late(&self, late: &Value) {
        assert_eq!(late["count"], 0, "{}: alarms were set too late: {late}", self.folder.display());
    }

    fn assert_none(&self, place: &str, tally: &Value) {
        let (folder, pcs) = (self.folder.display(), &tally["pcs"]);
        assert_eq!(
            tally["count"], 0,
            "{folder}: {place}, most often at {pcs}: addr2line -f -i -C -e ELF PC tells which function"
        );
    }
}
