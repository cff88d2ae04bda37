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
The same checks run over the host's packages, over the firmware and over the page. The targets of examples/stm32g474 and
of the page are left out in words where rustup cannot add them.")]
pub struct Args {}

const DENY_WARNINGS: [&str; 3] = ["--", "-D", "warnings"];

pub fn run(Args {}: Args) -> Result<()> {
    announce("cargo fmt --check");
    run_command(Command::new("cargo").current_dir(workspace::root()).args(["fmt", "--all", "--check"]))?;
    announce("clippy, host packages");
    run_command(cargo("clippy").arg("--all-targets").args(DENY_WARNINGS))?;
    announce("rustdoc, host packages");
    run_command(cargo("doc").arg("--no-deps").env("RUSTDOCFLAGS", "-D warnings"))?;
    announce("clippy, crates without paper-laws");
    let crates = ["profile", "motion", "console", "controller"].map(|name| format!("--package=isostep-{name}"));
    run_command(cargo("clippy").args(crates).args(["--no-default-features", "--all-targets"]).args(DENY_WARNINGS))?;
    with_axes("four-axes", &["--test=four_axes", "--test=emulated"])?;
    with_axes("two-axes", &["--test=two_axes"])?;
    for_browsers()?;
    firmware()?;
    another_chip()
}

/// The crates and these tests with another number of axes.
fn with_axes(feature: &str, tests: &[&str]) -> Result<()> {
    announce(&format!("clippy, crates with {feature}"));
    let crates = ["console", "motion", "controller", "sim", "report"].map(|name| format!("--package=isostep-{name}"));
    let mut clippy = cargo("clippy");
    clippy.args(crates).args(["--package=isostep", "--package=isostep-tests", "--lib", "--bins"]).args(tests);
    run_command(clippy.arg(format!("--features={feature}")).args(DENY_WARNINGS))
}

fn another_chip() -> Result<()> {
    if let Some(why) = other_chip::missing() {
        announce(&format!("examples/stm32g474: left out, because {why}"));
        return Ok(());
    }
    for features in other_chip::FEATURES {
        announce(&format!("clippy, examples/stm32g474 {}", features.join(" ")));
        run_command(other_chip::cargo("clippy", features).args(DENY_WARNINGS))?;
    }
    announce("rustdoc, examples/stm32g474");
    run_command(other_chip::cargo("doc", &[]).arg("--no-deps").env("RUSTDOCFLAGS", "-D warnings"))
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

fn firmware() -> Result<()> {
    toolchain::add_target(workspace::FIRMWARE_TARGET)?;
    let other = Variant {
        board: Board::Pico,
        port: Port::Timer,
        driver: Some(Driver::Tmc2209),
        estop: Contact::Nc,
        axes: Axes::Four,
        prove: false,
        without_paper_laws: true,
    };
    check_firmware(workspace::FIRMWARE, &Variant::default().features())?;
    check_firmware(workspace::FIRMWARE, &other.features())?;
    let skr_pico = Variant { board: Board::SkrPico, ..Variant::default() };
    check_firmware(workspace::FIRMWARE, &skr_pico.features())?;
    for port in [Port::Pio, Port::Timer] {
        check_firmware(workspace::FIRMWARE, &Variant::proving(port).features())?;
    }
    check_firmware(workspace::BENCH_FIRMWARE, &[])?;
    for features in [&[][..], &["two-axes"], &["four-axes"]] {
        check_firmware("qemu-lm3s6965", features)?;
    }
    Ok(())
}

fn check_firmware(package: &str, features: &[&str]) -> Result<()> {
    let with = features.iter().map(|feature| format!(" +{feature}")).collect::<String>();
    announce(&format!("clippy, {package}{with}"));
    run_command(firmware_cargo("clippy", package, features).args(DENY_WARNINGS))?;
    announce(&format!("rustdoc, {package}{with}"));
    let mut doc = firmware_cargo("doc", package, features);
    run_command(doc.args(["--no-deps", "--document-private-items"]).env("RUSTDOCFLAGS", "-D warnings"))
}
