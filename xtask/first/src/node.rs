//! Finds Node.js and installs the packages of the emulated board and of the page.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::process::{self, announce};
use crate::workspace;

/// The same version as in tests/emulator/package.json and web/package.json.
const NODE_MAJOR_MIN: u32 = 20;
const REMEDY: &str = "the emulated board and the page need Node.js 20 or later with npm: https://nodejs.org, or `apt-get install nodejs npm`";

/// Prepares the emulated board.
pub fn prepare() -> Result<()> {
    install(&workspace::emulator_dir())
}

/// Checks Node's version and installs the packages of a folder, unless those of its lock file are installed already.
pub fn install(dir: &Path) -> Result<()> {
    let version = process::output(Command::new("node").arg("--version"), REMEDY)?;
    if major(&version).is_none_or(|major| major < NODE_MAJOR_MIN) {
        bail!("Node.js {version} is too old: {REMEDY}");
    }
    let lock = dir.join("package-lock.json");
    let lock = fs::read(&lock).with_context(|| format!("{} cannot be read", workspace::shown(&lock)))?;
    // npm ci empties node_modules first, so a copy of the lock file inside it marks a finished installation.
    let installed_lock = dir.join("node_modules").join(".installed-package-lock.json");
    if fs::read(&installed_lock).is_ok_and(|installed| installed == lock) {
        return Ok(());
    }
    announce(&format!("npm ci in {}", workspace::shown(dir)));
    process::run(npm_in(dir, "ci").args(["--no-audit", "--no-fund", "--ignore-scripts"]))?;
    fs::write(&installed_lock, lock).with_context(|| format!("cannot write {}", installed_lock.display()))
}

/// `npm VERB` in the emulator's folder.
pub fn npm(verb: &str) -> Command {
    npm_in(&workspace::emulator_dir(), verb)
}

/// One file of the emulator's own tests.
pub fn of_emulator(test: &str) -> Command {
    let mut command = Command::new("node");
    command.current_dir(workspace::emulator_dir()).args(["--test", test]);
    command
}

/// `npm VERB` in a folder.
pub fn npm_in(dir: &Path, verb: &str) -> Command {
    let mut command = Command::new(if cfg!(windows) { "npm.cmd" } else { "npm" });
    command.current_dir(dir).arg(verb);
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
