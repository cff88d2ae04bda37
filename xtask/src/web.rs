//! `cargo xtask web`: builds the page with the simulated machine, and tests it in Chromium.

mod chromium;
mod figures;

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, ensure};
use isostep::web::{self, Page, Serving};
use xtask_first::page::{self, dir, machine, npm};

use crate::process::{self, announce};
use crate::{node, toolchain, workspace};

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
    page::build_and_tell(&out)?;
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
pub use xtask_first::page::{FOUR_AXES, TARGET, build, default_out, files};

fn install(page: &Path) -> Result<()> {
    announce("the tool, with the page in it (some minutes)");
    let mut install = Command::new("cargo");
    install
        .env("ISOSTEP_PAGE", page)
        .args(["install", "--locked", "--path"])
        .arg(workspace::root().join("crates/isostep"));
    process::run(&mut install)
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
