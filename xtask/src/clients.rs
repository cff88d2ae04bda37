//! Tests with G-code senders by other authors. They are installed from their registries and send to the machine on a
//! pseudo-terminal.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Context, Result, ensure};

use crate::process::{self, announce};
use crate::variant::Variant;
use crate::{build, node, python, vfd, workspace};
use isostep::flight::WINDOW_BYTES;
use isostep::pty::Emulated;
use isostep::pty::simulated::Simulated;
use isostep::pty::{self, Machine, Tally};
use isostep_sim::Config;

/// The sender with a web page, on npm.
const CNCJS: &str = "cncjs@1.11.5";
/// Speed of the machines relative to real time. Senders are fast enough for it, and so is the emulator.
const SIMULATED_SPEED: f64 = 20.0;
const EMULATED_SPEED: f64 = 10.0;
const PATIENCE: Duration = Duration::from_secs(240);
/// The place where programs/parking.nc ends, mm. The programs that are sent after it end where they begin.
const PARKING_END_MM: [f64; 3] = [175.0, 40.0, 0.0];
/// What measures tools: a plate that closes the probe's contact while Z is so low, as options of `sim` and of the
/// emulator name it.
const PLATE: &str = "Z,12,below";

/// The folder of the scripts and their requirements.
fn dir() -> PathBuf {
    workspace::root().join("tests").join("clients")
}

/// The folder into which the requirements are installed.
fn installed_dir() -> PathBuf {
    workspace::target_dir().join("clients")
}

/// The Python that has the senders.
fn installed_python() -> Result<PathBuf> {
    python::with(&dir().join("requirements.txt"), &installed_dir().join("venv"))
}

/// The folder with cncjs in its node_modules. Installs it if necessary. The version of cncjs is fixed; its dependencies
/// are the newest that it accepts.
fn installed_cncjs() -> Result<PathBuf> {
    let dir = installed_dir().join("cncjs");
    let finished = dir.join(CNCJS);
    if finished.exists() {
        return Ok(dir);
    }
    announce(&format!("{CNCJS} from npm into {}: some 230 MB", workspace::shown(&dir)));
    fs::create_dir_all(&dir).with_context(|| format!("{} cannot be made", dir.display()))?;
    // If the folder has its own package, npm does not look for one in the folders above.
    fs::write(dir.join("package.json"), r#"{ "private": true }"#)?;
    let quiet = ["install", "--no-audit", "--no-fund", "--ignore-scripts", "--loglevel=error"];
    process::run(Command::new("npm").current_dir(&dir).args(quiet).arg(CNCJS)).context("npm is needed once")?;
    fs::write(&finished, "").with_context(|| format!("cannot write {}", finished.display()))?;
    Ok(dir)
}

/// A stage of `cargo xtask test`. grbl-streamer homes a machine and streams programs with two tools that are changed,
/// without a tool, with a laser and with a spindle; it holds and resumes each of them. The first machine is simulated, the
/// second is the firmware on the emulated board.
pub fn grbl_streamer() -> Result<()> {
    let python = installed_python()?;
    let result = installed_dir().join("stream.json");
    let script = |port: &Path| {
        let mut script = Command::new(&python);
        script.arg(dir().join("stream.py")).arg(port).args(jobs()).arg(&result);
        script
    };
    let none_lost = |tally: Tally| -> Result<()> {
        let sent: serde_json::Value = serde_json::from_slice(&fs::read(&result)?)?;
        let (sent, taken) = (sent["bytes_sent"].as_u64(), tally.bytes_in);
        ensure!(sent == Some(taken), "the sender sent {sent:?} bytes and the machine took {taken}");
        Ok(())
    };
    announce("grbl-streamer, simulated machine");
    none_lost(ends_in_place(SIMULATED_SPEED, simulated_machine, script)?)?;
    build::firmware(Variant::default())?;
    node::prepare()?;
    announce("grbl-streamer, emulated board");
    none_lost(ends_in_place(EMULATED_SPEED, emulated_board, script)?)
}

/// A stage of `cargo xtask test`: a slave of pymodbus is the VFD of a simulated machine.
pub fn pymodbus() -> Result<()> {
    vfd::against_pymodbus(&installed_python()?, &dir().join("vfd.py"))
}

/// The same test with cncjs, through the interface of its web page.
pub fn cncjs() -> Result<()> {
    let installed = installed_cncjs()?;
    let script = |port: &Path| {
        let mut script = Command::new("node");
        script.arg(dir().join("cncjs.mjs")).arg(&installed).arg(port).args(jobs());
        script
    };
    announce("cncjs, simulated machine");
    ends_in_place(SIMULATED_SPEED, simulated_machine, script)?;
    build::firmware(Variant::default())?;
    node::prepare()?;
    announce("cncjs, emulated board");
    ends_in_place(EMULATED_SPEED, emulated_board, script)?;
    Ok(())
}

/// The default machine, simulated, with a plate to measure tools.
fn simulated_machine() -> Result<Simulated> {
    let plate = Some(PLATE.parse()?);
    Ok(Simulated::new(Config { plate, keep_record: false, ..Config::default() }))
}

/// The emulated board with the last firmware built, its console on USB, and a plate to measure tools.
fn emulated_board() -> Result<Emulated> {
    Emulated::start(emulator().args(["--probe-plate", PLATE]), true, &[])
}

/// The emulator with the last firmware built.
pub fn emulator() -> Command {
    let mut command = Command::new("node");
    command.arg(workspace::emulator_dir().join("run.mjs")).arg("--elf").arg(Variant::default().elf());
    command
}

/// Arguments of a script: the folder of the programs to send, and where they end.
fn jobs() -> [OsString; 2] {
    [workspace::root().join("programs").into(), PARKING_END_MM.map(|mm| mm.to_string()).join(",").into()]
}

/// Runs the script that `script` returns for a port with this machine, and returns the traffic on the port. Checks that
/// the sender keeps within Grbl's buffer, that every line is answered, that no byte from the machine is lost, and that
/// the machine stands where the programs end.
fn ends_in_place<M: Machine>(
    speed: f64,
    power_up: impl FnOnce() -> Result<M> + Send + 'static,
    script: impl FnOnce(&Path) -> Command,
) -> Result<Tally> {
    let client = |port: &Path| process::run_within(&mut script(port), PATIENCE);
    let (tally, closing) = pty::while_running(speed, power_up, client)?;
    let flight = &tally.flight;
    println!("the machine saw at most {} bytes in flight", flight.most);
    let over = flight.times_over;
    ensure!(over == 0, "{over} times more than {WINDOW_BYTES} bytes were in flight, at most {}", flight.most);
    ensure!(tally.dropped_bytes == 0, "{} bytes of the machine's were not taken", tally.dropped_bytes);
    let (lines, answered) = (flight.lines, flight.answered);
    ensure!(lines == answered, "the machine answered {answered} of {lines} lines");
    ensure!(closing.position_mm == PARKING_END_MM, "the machine stands at {:?} mm", closing.position_mm);
    let broken = closing.timing_violations;
    ensure!(broken == 0, "{broken} edges broke the driver's timing");
    // The emulated gantry has no motor model that could lose steps.
    let lost = closing.steps_lost.unwrap_or(0);
    ensure!(lost == 0, "{lost} steps lost by the motors");
    Ok(tally)
}
