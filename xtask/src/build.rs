//! `cargo xtask build`: the release firmware, as ELF and UF2.

use std::fs;

use anyhow::{Context, Result};

use crate::firmware::Firmware;
use crate::footprint::Footprint;
use crate::process::{self, announce};
use crate::toolchain::Toolchain;
use crate::{uf2, workspace};

/// Build the release firmware as ELF and UF2, and print its sizes
#[derive(clap::Args)]
#[command(after_help = "\
The files, for a probe and for the boot drive:
  target/thumbv6m-none-eabi/release/rp2040-gantry
  target/thumbv6m-none-eabi/release/rp2040-gantry.uf2

The compiler is found or installed as `cargo xtask setup --help` says.")]
pub struct Args {}

pub fn run(Args {}: Args) -> Result<()> {
    let firmware = firmware()?;
    println!("{}", workspace::shown(&workspace::firmware_elf()));
    println!("{}", workspace::shown(&workspace::firmware_uf2()));
    print!("{}", Footprint::new(&firmware).table());
    Ok(())
}

/// Builds the gantry's firmware, without features.
pub fn firmware() -> Result<Firmware> {
    build_firmware(workspace::FIRMWARE, &[])
}

/// Builds a board's package with `features` of its own on, and writes its UF2 file beside the ELF: the last build of a
/// package is the one that lies there, whatever its features.
pub fn build_firmware(package: &str, features: &[&str]) -> Result<Firmware> {
    let toolchain = Toolchain::ensure()?;
    let with = features.iter().map(|feature| format!(" +{feature}")).collect::<String>();
    announce(&format!("{package}{with} for {}, with {}", workspace::FIRMWARE_TARGET, toolchain.description()));
    process::run(toolchain.cargo("build", package).arg(format!("--features={}", features.join(","))))?;
    let firmware = Firmware::read(&workspace::elf(package))?;
    let uf2 = workspace::uf2(package);
    fs::write(&uf2, uf2::from_loads(&firmware.loads)).with_context(|| format!("cannot write {}", uf2.display()))?;
    Ok(firmware)
}
