//! `cargo xtask lint`: formatting, clippy and the documentation, warnings being errors.

use std::process::Command;

use anyhow::Result;

use crate::process::{announce, run as run_command};
use crate::toolchain::{Toolchain, cargo};
use crate::workspace;

/// Check formatting, clippy and the documentation; warnings are errors
#[derive(clap::Args)]
#[command(after_help = "\
The same checks run over the host's packages and over the firmware. Clippy for the firmware needs the target in the
default toolchain (`rustup target add thumbv6m-none-eabi`); without it lint says so, and compiles the firmware instead.")]
pub struct Args {}

const DENY_WARNINGS: [&str; 3] = ["--", "-D", "warnings"];

pub fn run(Args {}: Args) -> Result<()> {
    announce("cargo fmt --check");
    run_command(Command::new("cargo").current_dir(workspace::root()).args(["fmt", "--all", "--check"]))?;
    announce("clippy, host packages");
    run_command(cargo("clippy").arg("--all-targets").args(DENY_WARNINGS))?;
    announce("rustdoc, host packages");
    run_command(cargo("doc").arg("--no-deps").env("RUSTDOCFLAGS", "-D warnings"))?;
    firmware()
}

fn firmware() -> Result<()> {
    let toolchain = Toolchain::ensure()?;
    if let Toolchain::FromSource { .. } = toolchain {
        announce("firmware: compiled only; clippy and rustdoc need the target in the default toolchain");
        return run_command(&mut toolchain.cargo("check", workspace::FIRMWARE));
    }
    announce("clippy, firmware");
    run_command(toolchain.cargo("clippy", workspace::FIRMWARE).args(DENY_WARNINGS))?;
    announce("rustdoc, firmware");
    let mut doc = toolchain.cargo("doc", workspace::FIRMWARE);
    run_command(doc.args(["--no-deps", "--document-private-items"]).env("RUSTDOCFLAGS", "-D warnings"))
}
