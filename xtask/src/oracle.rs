//! Holds the emulated Cortex-M33 against Unicorn's, one instruction after the other.

use std::fs::File;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};

use crate::process::{self, announce};
use crate::{node, python, workspace};

/// Half of them are the firmware's.
const INSTRUCTIONS: &str = "100000";

/// Carries out random instructions on both, those of this firmware among them.
///
/// # Errors
/// An instruction after which registers, flags or memory differ, and what is missing to find out.
pub fn check(elf: &Path) -> Result<()> {
    node::prepare()?;
    let support = workspace::emulator_dir().join("support");
    let folder = workspace::target_dir().join("oracle");
    let python = python::with(&support.join("requirements.txt"), &folder.join("venv"))?;
    let cases = folder.join("cases.json");
    announce(&format!("{INSTRUCTIONS} instructions of a Cortex-M33 on Unicorn, and then on the emulated board's"));
    let written = || File::create(&cases).with_context(|| format!("{} cannot be written", cases.display()));
    let mut oracle = Command::new(python);
    oracle.arg(support.join("m33-cases.py")).arg("--elf").arg(elf).args(["--count", INSTRUCTIONS]);
    process::run(oracle.stdout(written()?))?;
    let read = File::open(&cases).with_context(|| format!("{} cannot be read", cases.display()))?;
    process::run(Command::new("node").arg(support.join("m33-compare.mjs")).stdin(read))
}
