//! `cargo xtask lint`: checks formatting, clippy and the documentation. Warnings are errors.

use std::process::Command;

use anyhow::Result;

use crate::other_chip;
use crate::process::{announce, run as run_command};
use crate::toolchain::{Toolchain, cargo};
use crate::variant::{Axes, Contact, Driver, Port, Variant};
use crate::{web, workspace};

/// Check formatting, clippy and the documentation; warnings are errors
#[derive(clap::Args)]
#[command(after_help = "\
The same checks run over the host's packages and over the firmware. Clippy for the firmware needs the target in the
default toolchain (`rustup target add thumbv6m-none-eabi`); without it lint says so, and compiles the firmware instead.
The firmwares of examples/stm32g474 need thumbv7em-none-eabihf, and are left out in words where it cannot be had.")]
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
    announce("clippy, crates with four axes");
    let crates = ["console", "motion", "controller", "sim", "report"].map(|name| format!("--package=isostep-{name}"));
    let tests =
        ["--package=isostep", "--package=isostep-tests", "--lib", "--bins", "--test=four_axes", "--test=emulated"];
    run_command(cargo("clippy").args(crates).args(tests).arg("--features=four-axes").args(DENY_WARNINGS))?;
    for_browsers()?;
    firmware()?;
    another_chip()
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
        Some(mut clippy) => {
            announce("clippy, isostep-web for browsers");
            run_command(clippy.args(DENY_WARNINGS))
        }
        None => {
            announce("isostep-web for browsers: not checked; `cargo xtask web` adds the target that it needs");
            Ok(())
        }
    }
}

fn firmware() -> Result<()> {
    let toolchain = Toolchain::ensure()?;
    let other = Variant {
        port: Port::Timer,
        driver: Driver::Tmc2209,
        estop: Contact::Nc,
        axes: Axes::Four,
        prove: false,
        without_paper_laws: true,
    };
    check_firmware(&toolchain, workspace::FIRMWARE, &Variant::default().features())?;
    check_firmware(&toolchain, workspace::FIRMWARE, &other.features())?;
    for port in [Port::Pio, Port::Timer] {
        check_firmware(&toolchain, workspace::FIRMWARE, &Variant::proving(port).features())?;
    }
    check_firmware(&toolchain, workspace::BENCH_FIRMWARE, &[])?;
    check_firmware(&toolchain, "qemu-lm3s6965", &[])?;
    check_firmware(&toolchain, "qemu-lm3s6965", &["four-axes"])?;
    Ok(())
}

fn check_firmware(toolchain: &Toolchain, package: &str, features: &[&str]) -> Result<()> {
    if let Toolchain::FromSource { .. } = toolchain {
        announce(&format!("{package}: compiled only; clippy and rustdoc need the target in the default toolchain"));
        return run_command(&mut toolchain.cargo("check", package, features));
    }
    let with = features.iter().map(|feature| format!(" +{feature}")).collect::<String>();
    announce(&format!("clippy, {package}{with}"));
    run_command(toolchain.cargo("clippy", package, features).args(DENY_WARNINGS))?;
    announce(&format!("rustdoc, {package}{with}"));
    let mut doc = toolchain.cargo("doc", package, features);
    run_command(doc.args(["--no-deps", "--document-private-items"]).env("RUSTDOCFLAGS", "-D warnings"))
}
