//! `cargo xtask lint`: checks formatting, clippy and the documentation. Warnings are errors.

use std::process::Command;

use anyhow::Result;

use crate::other_chip;
use crate::process::{announce, run as run_command};
use crate::toolchain::{self, cargo, firmware_cargo};
use crate::variant::{Axes, Board, Contact, Driver, Port, Variant};
use crate::{web, workspace};

/// Check formatting, clippy and the documentation; warnings are errors
#[derive(clap::Args)]
#[command(after_help = "\
The same checks run over the host's packages, over the firmware and over the page. The targets of boards/stm32g474 and
of the page are left out in words where rustup cannot add them.")]
pub struct Args {
    /// Every image of the firmware and of the other boards, of which otherwise a few are looked at
    #[arg(long)]
    all: bool,
}

const DENY_WARNINGS: [&str; 3] = ["--", "-D", "warnings"];

pub fn run(Args { all }: Args) -> Result<()> {
    announce("cargo fmt --check");
    run_command(Command::new("cargo").current_dir(workspace::root()).args(["fmt", "--all", "--check"]))?;
    announce("clippy, host packages");
    run_command(cargo("clippy").arg("--all-targets").args(DENY_WARNINGS))?;
    announce("rustdoc, host packages");
    run_command(cargo("doc").arg("--no-deps").env("RUSTDOCFLAGS", "-D warnings"))?;
    with_axes("four-axes", &["--test=four_axes", "--test=emulated"])?;
    with_axes("two-axes", &["--test=two_axes"])?;
    for_browsers()?;
    firmware(all)?;
    another_chip(all)
}

/// The crates and these tests with another number of axes.
fn with_axes(feature: &str, tests: &[&str]) -> Result<()> {
    announce(&format!("clippy, crates with {feature}"));
    let crates = ["console", "motion", "controller", "sim", "report"].map(|name| format!("--package=isostep-{name}"));
    let mut clippy = cargo("clippy");
    clippy.args(crates).args(["--package=isostep", "--package=isostep-tests", "--lib", "--bins"]).args(tests);
    run_command(clippy.arg(format!("--features={feature}")).args(DENY_WARNINGS))
}

fn another_chip(all: bool) -> Result<()> {
    if let Some(why) = other_chip::missing() {
        announce(&format!("boards/stm32g474: left out, because {why}"));
        return Ok(());
    }
    announce("clippy, boards/stm32g474");
    run_command(other_chip::cargo("clippy").args(DENY_WARNINGS))?;
    if !all {
        return Ok(());
    }
    announce("rustdoc, boards/stm32g474");
    run_command(other_chip::cargo("doc").arg("--no-deps").env("RUSTDOCFLAGS", "-D warnings"))
}

fn for_browsers() -> Result<()> {
    match web::clippy() {
        Ok(mut clippy) => {
            announce("clippy, isostep-web for browsers");
            run_command(clippy.args(DENY_WARNINGS))
        }
        Err(why) => {
            announce(&format!("isostep-web for browsers: left out, because {why:#}"));
            Ok(())
        }
    }
}

fn firmware(all: bool) -> Result<()> {
    toolchain::add_target(workspace::FIRMWARE_TARGET)?;
    let other = Variant {
        board: Board::Pico,
        port: Port::Timer,
        driver: Some(Driver::Tmc2209),
        estop: Contact::Nc,
        axes: Axes::Four,
        prove: false,
    };
    let skr_pico = Variant { board: Board::SkrPico, ..Variant::default() };
    let [proving, proving_timer] = [Port::Pio, Port::Timer].map(Variant::proving);
    clippy(workspace::FIRMWARE, &Variant::default().features())?;
    rustdoc(workspace::FIRMWARE, &Variant::default().features())?;
    for variant in [other, skr_pico, proving] {
        clippy(workspace::FIRMWARE, &variant.features())?;
    }
    clippy(workspace::BENCH_FIRMWARE, &[])?;
    clippy(QEMU_BOARD, &[])?;
    if !all {
        return Ok(());
    }
    clippy(workspace::FIRMWARE, &proving_timer.features())?;
    for variant in [other, skr_pico, proving, proving_timer] {
        rustdoc(workspace::FIRMWARE, &variant.features())?;
    }
    rustdoc(workspace::BENCH_FIRMWARE, &[])?;
    rustdoc(QEMU_BOARD, &[])?;
    for axes in ["two-axes", "four-axes"] {
        clippy(QEMU_BOARD, &[axes])?;
        rustdoc(QEMU_BOARD, &[axes])?;
    }
    Ok(())
}

const QEMU_BOARD: &str = "qemu-lm3s6965";

fn clippy(package: &str, features: &[&str]) -> Result<()> {
    announce(&format!("clippy, {}", named(package, features)));
    run_command(firmware_cargo("clippy", package, features).args(DENY_WARNINGS))
}

fn rustdoc(package: &str, features: &[&str]) -> Result<()> {
    announce(&format!("rustdoc, {}", named(package, features)));
    let mut doc = firmware_cargo("doc", package, features);
    run_command(doc.args(["--no-deps", "--document-private-items"]).env("RUSTDOCFLAGS", "-D warnings"))
}

fn named(package: &str, features: &[&str]) -> String {
    features.iter().fold(package.to_owned(), |name, feature| format!("{name} +{feature}"))
}
