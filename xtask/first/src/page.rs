//! Builds the page with the simulated machine.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, ensure};

use crate::process::{self, announce};
use crate::toolchain::{self, cargo};
use crate::{node, workspace};

/// The code that browsers run.
pub const TARGET: &str = "wasm32-unknown-unknown";

/// Builds the page into this folder, and prints how large it is.
///
/// # Errors
/// As [`build`].
pub fn build_and_tell(out: &Path) -> Result<()> {
    build(out)?;
    let words = format!("{}: {:.0} kB", workspace::shown(out), size_bytes(out)? as f64 / 1e3);
    Ok(writeln!(std::io::stdout().lock(), "{words}")?)
}

/// The folder of the page, unless another is named.
pub fn default_out() -> PathBuf {
    workspace::target_dir().join("web")
}

/// The sources of the page.
pub fn dir() -> PathBuf {
    workspace::root().join("web")
}

/// Builds the page into this folder.
///
/// # Errors
/// When what it needs cannot be had, and when the folder holds something else.
pub fn build(out: &Path) -> Result<()> {
    ensure_replaceable(out)?;
    toolchain::add_target(TARGET)?;
    announce(&format!("the machine for {TARGET} (some minutes the first time, then what has changed)"));
    process::run(machine("rustc").args(["--lib", "--crate-type", "cdylib"]))?;
    announce("the same with a fourth axis");
    process::run(machine("build").args(FOUR_AXES))?;
    let modules = workspace::target_dir().join(TARGET).join("browser");
    write_bindings(&modules.join("isostep_web.wasm"), &modules.join("examples").join("machine4.wasm"))?;
    node::install(&dir())?;
    announce("types of the page, and its files");
    process::run(&mut npm("check"))?;
    process::run(npm("build").arg("--").arg(out))
}

/// The folder is emptied, so it must be new, or hold a page.
fn ensure_replaceable(out: &Path) -> Result<()> {
    let is_empty = out.read_dir().is_ok_and(|mut files| files.next().is_none());
    ensure!(
        !out.exists() || is_empty || out.join("board.json").is_file(),
        "{} holds something else than a page, and would be emptied: name a new folder",
        out.display()
    );
    Ok(())
}

/// The machine with A, as a target of its own.
pub const FOUR_AXES: [&str; 2] = ["--example=machine4", "--features=four-axes"];

/// Cargo for a machine on the page. Paths of this computer are left out of what panics say.
pub fn machine(verb: &str) -> Command {
    let mut command = cargo(verb);
    command.args(["--package=isostep-web", "--profile=browser", "--target", TARGET]);
    command.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS", toolchain::short_paths());
    command
}

/// Writes what JavaScript sees of both modules. It must be the same, as the page has one JavaScript for both.
fn write_bindings(module: &Path, with_a: &Path) -> Result<()> {
    announce("the JavaScript of the machines (a tool for it is compiled once, in a minute)");
    let written = [(module, "machine"), (with_a, "machine4")].map(|(module, folder)| -> Result<_> {
        let folder = dir().join(folder);
        process::run(&mut bindgen(module, &folder))?;
        Ok(fs::read(folder.join("machine.js"))?)
    });
    let [one, other] = written;
    ensure!(
        one? == other?,
        "the machine with A has another JavaScript than that without: see what of crates/web differs by the axes"
    );
    Ok(())
}

/// The tool for it, which has packages of its own.
fn bindgen(module: &Path, folder: &Path) -> Command {
    let target = workspace::target_dir().join("bindgen");
    let manifest = dir().join("bindgen").join("Cargo.toml");
    let mut tool = Command::new("cargo");
    tool.current_dir(workspace::root()).args(["run", "--quiet", "--locked", "--manifest-path"]).arg(manifest);
    tool.arg("--target-dir").arg(target).arg("--").arg(module).arg(folder);
    tool
}

/// `npm run SCRIPT` of the page.
pub fn npm(script: &str) -> Command {
    let mut command = node::npm_in(&dir(), "run");
    command.args(["--silent", script]);
    command
}

fn size_bytes(folder: &Path) -> Result<u64> {
    files(folder)?.iter().map(|file| Ok(file.metadata()?.len())).sum()
}

/// All files in a folder and below.
pub fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = folder.read_dir()?.map(|entry| -> Result<_> {
        let path = entry?.path();
        if path.is_dir() { files(&path) } else { Ok(vec![path]) }
    });
    Ok(entries.collect::<Result<Vec<_>>>()?.concat())
}
