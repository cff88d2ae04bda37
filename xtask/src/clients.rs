//! Senders of other makes, installed from their registries and put to the machine on a pseudo-terminal.

use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};

use crate::process::{self, announce};
use crate::workspace;

const REMEDY: &str = "the tests with real senders need Python 3 with venv: https://python.org, or on Debian \
                      `apt-get install python3 python3-venv`";
/// A machine this much faster than a real one leaves a sender time enough.
const SPEED: f64 = 20.0;
const PATIENCE: Duration = Duration::from_secs(120);
/// Where programs/parking.nc ends, mm.
const PARKING_END_MM: [f64; 3] = [175.0, 40.0, 0.0];

/// The scripts, and what they need.
fn dir() -> PathBuf {
    workspace::root().join("tests").join("clients")
}

/// What they need, installed.
fn installed_dir() -> PathBuf {
    workspace::target_dir().join("clients")
}

/// The Python that has the senders, installed unless those of the requirements are there already.
fn python() -> Result<PathBuf> {
    let venv = installed_dir().join("venv");
    let bin = if cfg!(windows) { venv.join("Scripts").join("python.exe") } else { venv.join("bin").join("python") };
    let wanted = fs::read(dir().join("requirements.txt")).context("tests/clients/requirements.txt cannot be read")?;
    // A copy of the requirements in it vouches for a finished installation.
    let finished = venv.join("installed-requirements.txt");
    if bin.exists() && fs::read(&finished).is_ok_and(|installed| installed == wanted) {
        return Ok(bin);
    }
    let python = if cfg!(windows) { "python" } else { "python3" };
    process::output(Command::new(python).arg("--version"), REMEDY)?;
    announce(&format!("senders from PyPI into {}", workspace::shown(&venv)));
    fs::create_dir_all(&venv).with_context(|| format!("{} cannot be made", venv.display()))?;
    process::run(Command::new(python).args(["-m", "venv", "--clear"]).arg(&venv)).context(REMEDY)?;
    let mut pip = Command::new(&bin);
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement"]);
    process::run(pip.arg(dir().join("requirements.txt"))).context("PyPI is needed once")?;
    fs::write(&finished, wanted).with_context(|| format!("cannot write {}", finished.display()))?;
    Ok(bin)
}

/// A stage of `cargo xtask test`: grbl-streamer homes the simulated machine and streams the parking program.
#[cfg(unix)]
pub fn stream() -> Result<()> {
    let python = python()?;
    let program = workspace::root().join("programs").join("parking.nc");
    let result = installed_dir().join("stream.json");
    let place = PARKING_END_MM.map(|mm| mm.to_string()).join(",");
    let (tally, closing) = crate::pty::while_running(SPEED, |port| {
        let mut script = Command::new(&python);
        script.arg(dir().join("stream.py")).arg(port).arg(&program).arg(place).arg(&result);
        process::run_within(&mut script, PATIENCE)
    })?;
    let flight = &tally.flight;
    println!("the machine saw at most {} bytes in flight, {} times beyond 128", flight.most, flight.times_over);
    let sent: serde_json::Value = serde_json::from_slice(&fs::read(&result)?)?;
    let (sent, taken) = (sent["bytes_sent"].as_u64(), tally.bytes_in);
    ensure!(sent == Some(taken), "the sender sent {sent:?} bytes and the machine took {taken}");
    ensure!(tally.dropped_bytes == 0, "{} bytes of the machine's were not taken", tally.dropped_bytes);
    let (lines, answered) = (flight.lines, flight.answered);
    ensure!(lines == answered, "the machine answered {answered} of {lines} lines");
    ensure!(closing.position_mm == PARKING_END_MM, "the machine stands at {:?} mm", closing.position_mm);
    match closing.steps_lost {
        Some(0) => Ok(()),
        lost => bail!("steps lost by the motors: {lost:?}"),
    }
}

/// Nothing: there are no pseudo-terminals.
#[cfg(not(unix))]
pub fn stream() -> Result<()> {
    announce("not on Windows: the machine for real senders needs a pseudo-terminal");
    Ok(())
}
