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

/// Builds the firmware and writes its UF2 file.
pub fn firmware() -> Result<Firmware> {
    let toolchain = Toolchain::ensure()?;
    announce(&format!("firmware for {}, with {}", workspace::FIRMWARE_TARGET, toolchain.description()));
    process::run(&mut toolchain.cargo("build"))?;
    let firmware = Firmware::read(&workspace::firmware_elf())?;
    let uf2 = workspace::firmware_uf2();
    fs::write(&uf2, uf2::from_loads(&firmware.loads)).with_context(|| format!("cannot write {}", uf2.display()))?;
    Ok(firmware)
}
