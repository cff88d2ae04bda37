//! `cargo xtask web`: builds the page with the simulated machine, and tests it in Chromium.

mod chromium;
mod figures;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, ensure};
use isostep::web::{self, Page, Serving};

use crate::process::{self, announce};
use crate::toolchain::{self, cargo};
use crate::{node, workspace};

/// The code that browsers run.
pub const TARGET: &str = "wasm32-unknown-unknown";

/// Build the page: the simulated machine in a browser
#[derive(clap::Args)]
#[command(after_help = "\
A folder of static files, target/web, which any file server may have, and which loads nothing from elsewhere.

It needs the Rust target wasm32-unknown-unknown, which it adds by rustup, and Node.js 20 or later with npm.

Examples:
  cargo xtask web --serve            and serve it on this computer: http://127.0.0.1:8000
  cargo xtask web --serve --port     and let it operate the board on USB: `isostep web --help` says more
  cargo xtask web --install          install the tool `isostep` with the page in it, for `isostep web`
  cargo xtask web --out page         into another folder, which is emptied first
  cargo xtask web --figures          and how large and how fast it is: some minutes
  cargo xtask web --test             and the tests of the page in Chromium; pictures of it in target/web-shots")]
pub struct Args {
    /// The folder
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Test the page in Chromium too
    #[arg(long)]
    test: bool,
    /// Print how large and how fast the page is, in Chromium and beside it
    #[arg(long)]
    figures: bool,
    /// Install the tool with the page in it, by `cargo install`
    #[arg(long, conflicts_with = "out")]
    install: bool,
    /// Serve the page, until Ctrl-C
    #[arg(long)]
    serve: bool,
    #[command(flatten, next_help_heading = "With --serve")]
    serving: Serving,
}

pub fn run(args: Args) -> Result<()> {
    ensure!(args.serve || args.serving.is_default(), "how the page is served goes with --serve: add it");
    let out = match args.out {
        Some(out) => std::path::absolute(out)?,
        None => default_out(),
    };
    build(&out)?;
    println!("{}: {:.0} kB", workspace::shown(&out), size_bytes(&out)? as f64 / 1e3);
    if args.test {
        test_values()?;
        pictures()?;
        chromium::test(&out)?;
    }
    if args.figures {
        figures::print(&out)?;
    }
    if args.install {
        install(&out)?;
    }
    if args.serve { web::serve(Page::read(&out)?, args.serving) } else { Ok(()) }
}

/// Tests all of the page, in Chromium too.
pub fn test() -> Result<()> {
    test_pictures()?;
    chromium::test(&default_out())
}

/// Builds the page, and tests what it needs no browser for.
pub fn test_pictures() -> Result<()> {
    test_values()?;
    build(&default_out())?;
    pictures()
}

/// Tests what the pictures show against the steps of the same runs, once the machine is built.
fn pictures() -> Result<()> {
    announce("what the pictures of the page show, against the steps");
    process::run(&mut npm("pictures"))
}

/// Tests what the page makes of a machine's words, which needs neither a browser nor the simulated machine.
pub fn test_values() -> Result<()> {
    node::install(&dir())?;
    announce("what the page makes of a machine's words");
    process::run(&mut npm("values"))
}

pub use chromium::missing;

/// The folder of the page, unless another is named.
pub fn default_out() -> PathBuf {
    workspace::target_dir().join("web")
}

fn dir() -> PathBuf {
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

fn install(page: &Path) -> Result<()> {
    announce("the tool, with the page in it (some minutes)");
    let mut install = Command::new("cargo");
    install
        .env("ISOSTEP_PAGE", page)
        .args(["install", "--locked", "--path"])
        .arg(workspace::root().join("crates/isostep"));
    process::run(&mut install)
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
fn machine(verb: &str) -> Command {
    let mut command = cargo(verb);
    command.args(["--package=isostep-web", "--profile=browser", "--target", TARGET]);
    command.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS", toolchain::short_paths());
    command
}

/// Clippy for what only a browser sees.
///
/// # Errors
/// Without the target.
pub fn clippy() -> Result<Command> {
    toolchain::add_target(TARGET)?;
    let mut command = machine("clippy");
    command.arg("--lib");
    Ok(command)
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

fn npm(script: &str) -> Command {
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
