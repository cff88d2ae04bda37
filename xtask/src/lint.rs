//! `cargo xtask lint`: formatting, clippy and the documentation, warnings being errors.

use anyhow::Result;

use crate::process::{self, announce};
use crate::toolchain::{Toolchain, cargo};

/// Check formatting, clippy and the documentation; warnings are errors
#[derive(clap::Args)]
#[command(after_help = "\
The same checks run over the host's packages and over the firmware. Clippy for the firmware needs the target in the
default toolchain (`rustup target add thumbv6m-none-eabi`); without it lint says so, and compiles the firmware instead.")]
pub struct Args {}

pub fn run(Args {}: Args) -> Result<()> {
    announce("cargo fmt --check");
    process::run(
        std::process::Command::new("cargo").args(["fmt", "--all", "--check"]).current_dir(crate::workspace::root()),
        "",
    )?;
    announce("clippy, host packages");
    process::run(cargo("clippy").args(["--all-targets", "--", "-D", "warnings"]), "rustup component add clippy")?;
    announce("rustdoc, host packages");
    process::run(cargo("doc").arg("--no-deps").env("RUSTDOCFLAGS", "-D warnings"), "")?;
    firmware()
}

fn firmware() -> Result<()> {
    let toolchain = Toolchain::ensure()?;
    if let Toolchain::FromSource { .. } = toolchain {
        announce(
            "firmware: no clippy, since the default toolchain lacks the target; compiling with warnings as errors",
        );
        return process::run(toolchain.cargo("check").env("RUSTFLAGS", "-D warnings"), "");
    }
    announce("clippy, firmware");
    process::run(toolchain.cargo("clippy").args(["--", "-D", "warnings"]), "rustup component add clippy")?;
    announce("rustdoc, firmware");
    process::run(
        toolchain.cargo("doc").args(["--no-deps", "--document-private-items"]).env("RUSTDOCFLAGS", "-D warnings"),
        "",
    )
}
