//! `cargo xtask web`: builds the page with the simulated machine, and tests it in Chromium.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use isostep_sim::{Config, trace};

use crate::process::{self, announce};
use crate::toolchain::{self, cargo};
use crate::{node, workspace};

/// What browsers run.
pub const TARGET: &str = "wasm32-unknown-unknown";
/// Chromium by the names that it has on systems.
const CHROMIUMS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// Build the page: the simulated machine in a browser
#[derive(clap::Args)]
#[command(after_help = "\
A folder of static files, target/web, which any file server may have, and which loads nothing from elsewhere.

It needs the Rust target wasm32-unknown-unknown, which it adds by rustup, and Node.js 20 or later with npm.

Examples:
  cargo xtask web --serve            and serve it on this computer: http://127.0.0.1:8000
  cargo xtask web --out page         into another folder, which is emptied first
  cargo xtask web --test             and the tests of the page in Chromium; pictures of it in target/web-shots")]
pub struct Args {
    /// The folder
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Test the page in Chromium too
    #[arg(long)]
    test: bool,
    /// Serve the page on the loopback address, until Ctrl-C [default port: 8000]
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = "8000")]
    serve: Option<u16>,
}

pub fn run(args: Args) -> Result<()> {
    let out = match args.out {
        Some(out) => std::path::absolute(out)?,
        None => default_out(),
    };
    build(&out)?;
    println!("{}: {:.0} kB", workspace::shown(&out), size_bytes(&out)? as f64 / 1e3);
    if args.test {
        in_chromium(&out)?;
    }
    args.serve.map_or(Ok(()), |port| serve(&out, port))
}

/// A stage of `cargo xtask test`.
pub fn test() -> Result<()> {
    let out = default_out();
    build(&out)?;
    in_chromium(&out)
}

/// What the user has to install before the page can be tested; `None` if it can.
pub fn missing() -> Option<&'static str> {
    chromium().is_none().then_some("install Chromium, on Debian by `apt-get install chromium`")
}

fn default_out() -> PathBuf {
    workspace::target_dir().join("web")
}

fn dir() -> PathBuf {
    workspace::root().join("web")
}

fn build(out: &Path) -> Result<()> {
    ensure_replaceable(out)?;
    toolchain::add_target(TARGET)?;
    announce(&format!("isostep-web for {TARGET}"));
    process::run(&mut machine("rustc"))?;
    let module = workspace::target_dir().join(TARGET).join("browser").join("isostep_web.wasm");
    write_bindings(&module)?;
    node::install(&dir())?;
    announce("types of the page, and its files");
    process::run(&mut npm("check"))?;
    process::run(npm("build").arg("--").arg(out))
}

fn serve(page: &Path, port: u16) -> Result<()> {
    process::run(Command::new("node").arg(dir().join("serve.mjs")).arg(page).arg(port.to_string()))
}

/// The folder is emptied, so it must be new, or hold a page.
fn ensure_replaceable(out: &Path) -> Result<()> {
    let is_empty = out.read_dir().is_ok_and(|mut files| files.next().is_none());
    ensure!(
        !out.exists() || is_empty || out.join("machine_bg.wasm").is_file(),
        "{} holds something else than a page, and would be emptied: name a new folder",
        out.display()
    );
    Ok(())
}

/// Cargo for the machine on the page. Paths of this computer are left out of what panics say.
fn machine(verb: &str) -> Command {
    let mut command = cargo(verb);
    command.args(["--package=isostep-web", "--lib", "--profile=browser", "--target", TARGET]);
    if verb == "rustc" {
        command.args(["--crate-type", "cdylib"]);
    }
    command.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS", toolchain::short_paths());
    command
}

/// Clippy for what only a browser sees.
///
/// # Errors
/// Without the target.
pub fn clippy() -> Result<Command> {
    toolchain::add_target(TARGET)?;
    Ok(machine("clippy"))
}

/// Writes what JavaScript sees of the module, by a tool that has packages of its own.
fn write_bindings(module: &Path) -> Result<()> {
    let target = workspace::target_dir().join("bindgen");
    let manifest = dir().join("bindgen").join("Cargo.toml");
    announce("the JavaScript of the machine (a tool is compiled once, some minutes)");
    let mut tool = Command::new("cargo");
    tool.current_dir(workspace::root()).args(["run", "--quiet", "--locked", "--manifest-path"]).arg(manifest);
    tool.arg("--target-dir").arg(target).arg("--").arg(module).arg(dir().join("machine"));
    process::run(&mut tool)
}

fn npm(script: &str) -> Command {
    let mut command = node::npm_in(&dir(), "run");
    command.args(["--silent", script]);
    command
}

fn size_bytes(folder: &Path) -> Result<u64> {
    let sizes = folder.read_dir()?.map(|entry| -> Result<u64> {
        let entry = entry?;
        let data = entry.metadata()?;
        if data.is_dir() { size_bytes(&entry.path()) } else { Ok(data.len()) }
    });
    sizes.sum()
}

/// Runs the tests of the page on this folder.
fn in_chromium(page: &Path) -> Result<()> {
    let chromium = chromium().with_context(|| missing().unwrap_or_default())?;
    let (native, shots) = (workspace::target_dir().join("web-parking.csv"), workspace::target_dir().join("web-shots"));
    write_native_trace(&native)?;
    announce(&format!("the page in Chromium, pictures in {}", workspace::shown(&shots)));
    let mut tests = Command::new("node");
    tests.arg(dir().join("test").join("page.mjs")).arg("--page").arg(page).arg("--chromium").arg(chromium);
    process::run(tests.arg("--trace").arg(native).arg("--shots").arg(shots))
}

/// The trace that the page's must equal.
fn write_native_trace(to: &Path) -> Result<()> {
    let program = fs::read(workspace::root().join("programs").join("parking.nc"))?;
    let outcome = isostep_sim::run(&program, &Config { keep_waves: false, ..Config::default() })?;
    let file = fs::File::create(to).with_context(|| format!("cannot write {}", to.display()))?;
    Ok(trace::write(&outcome.edges, file)?)
}

fn chromium() -> Option<PathBuf> {
    let found = toolchain::path_dirs().flat_map(|dir| CHROMIUMS.map(|name| dir.join(name)));
    found.into_iter().find(|binary| binary.is_file())
}
