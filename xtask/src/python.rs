//! Finds Python and installs packages from PyPI, each list into a folder of its own.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::process::{self, announce};
use crate::workspace;

const REMEDY: &str = "tests with packages from PyPI need Python 3 with venv: https://python.org, or on Debian \
                      `apt-get install python3 python3-venv`";

/// The packages that the user has to install before those from PyPI can be; `None` if they can.
pub fn missing() -> Option<&'static str> {
    let python = process::printed(Command::new("python3").args(["-c", "import ensurepip, venv"]));
    python.is_none().then_some(REMEDY)
}

/// The Python that has the packages of this list. Installs them into the folder unless they are there already.
///
/// # Errors
/// What is missing, and where to get it.
pub fn with(requirements: &Path, venv: &Path) -> Result<PathBuf> {
    let bin = venv.join("bin").join("python");
    let wanted = fs::read(requirements).with_context(|| format!("{} cannot be read", requirements.display()))?;
    // A copy of the requirements inside it marks a finished installation.
    let finished = venv.join("installed-requirements.txt");
    if bin.exists() && fs::read(&finished).is_ok_and(|installed| installed == wanted) {
        return Ok(bin);
    }
    process::output(Command::new("python3").arg("--version"), REMEDY)?;
    announce(&format!("packages from PyPI into {}", workspace::shown(venv)));
    fs::create_dir_all(venv).with_context(|| format!("{} cannot be made", venv.display()))?;
    process::run(Command::new("python3").args(["-m", "venv", "--clear"]).arg(venv)).context(REMEDY)?;
    let mut pip = Command::new(&bin);
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement"]);
    process::run(pip.arg(requirements)).context("PyPI is needed once")?;
    fs::write(&finished, wanted).with_context(|| format!("cannot write {}", finished.display()))?;
    Ok(bin)
}
