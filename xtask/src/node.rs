//! Finds Node.js and installs the packages of the emulated board.

use std::fs;
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::process::{self, announce};
use crate::workspace;

/// The same version as in tests/emulator/package.json.
const NODE_MAJOR_MIN: u32 = 20;
const REMEDY: &str =
    "the emulated board needs Node.js 20 or later with npm: https://nodejs.org, or `apt-get install nodejs npm`";

/// Checks Node's version and installs the emulator's packages, unless those of its lock file are installed already.
pub fn prepare() -> Result<()> {
    let version = process::output(Command::new("node").arg("--version"), REMEDY)?;
    if major(&version).is_none_or(|major| major < NODE_MAJOR_MIN) {
        bail!("Node.js {version} is too old: {REMEDY}");
    }
    let dir = workspace::emulator_dir();
    let lock = fs::read(dir.join("package-lock.json")).context("tests/emulator/package-lock.json cannot be read")?;
    // npm ci empties node_modules first, so a copy of the lock file inside it marks a finished installation.
    let installed_lock = dir.join("node_modules").join(".installed-package-lock.json");
    if fs::read(&installed_lock).is_ok_and(|installed| installed == lock) {
        return Ok(());
    }
    announce("npm ci in tests/emulator");
    process::run(npm("ci").args(["--no-audit", "--no-fund"]))?;
    fs::write(&installed_lock, lock).with_context(|| format!("cannot write {}", installed_lock.display()))
}

/// `npm VERB` in the emulator's folder.
pub fn npm(verb: &str) -> Command {
    let mut command = Command::new(if cfg!(windows) { "npm.cmd" } else { "npm" });
    command.current_dir(workspace::emulator_dir()).arg(verb);
    command
}

fn major(version: &str) -> Option<u32> {
    version.strip_prefix('v')?.split('.').next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::major;

    #[test]
    fn the_major_version_is_read_from_nodes_own_words() {
        assert_eq!(major("v20.11.1"), Some(20));
        assert_eq!(major("v8.0.0"), Some(8));
        assert_eq!(major("20"), None);
    }
}
