//! `cargo xtask build`: builds the release firmware as ELF and UF2.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::firmware::Firmware;
use crate::footprint::Footprint;
use crate::process::{self, announce};
use crate::variant::Variant;
use crate::{toolchain, uf2, workspace};

/// Build the release firmware as ELF and UF2, and print its sizes
#[derive(clap::Args)]
#[command(after_help = "\
The files, for a probe and for the boot drive:
  target/thumbv6m-none-eabi/release/pico-gantry              of a Pico 2: target/thumbv8m.main-none-eabi/release/pico-gantry
  target/thumbv6m-none-eabi/release/pico-gantry.uf2

Examples:
  cargo xtask build                       steps by PIO and DMA, for DRV8825 drivers
  cargo xtask build --driver tmc2209      faster drivers, shorter pulses
  cargo xtask build --board pico2         for a Raspberry Pi Pico 2
  cargo xtask build --board skr-pico      for a BIGTREETECH SKR Pico; see docs/bring-up.md
  cargo xtask build --estop nc            an emergency stop that opens when pressed; see docs/bring-up.md
  cargo xtask build --port timer          steps by the processor

What the compiler needs is installed as `cargo xtask setup --help` says.")]
pub struct Args {
    #[command(flatten)]
    variant: Variant,
}

pub fn run(args: Args) -> Result<()> {
    let firmware = firmware(args.variant)?;
    println!("{}", workspace::shown(&args.variant.elf()));
    println!("{}", workspace::shown(&args.variant.uf2()));
    print!("{}", Footprint::new(&firmware, args.variant).table());
    Ok(())
}

/// Builds the gantry's firmware.
pub fn firmware(variant: Variant) -> Result<Firmware> {
    link(variant)?;
    finish(variant)
}

/// Links the gantry's firmware, which all variants with the same chip and features have in common. Cargo does it once.
pub fn link(variant: Variant) -> Result<()> {
    variant.check()?;
    link_package(workspace::target(variant.chip()), workspace::FIRMWARE, &variant.features())
}

/// Makes this variant of the firmware that is linked for its chip and features: what is wired to it.
pub fn finish(variant: Variant) -> Result<Firmware> {
    let (driver, contact) = (variant.driver_name(), variant.contact_name());
    announce(&format!("{}: --driver {driver} --estop {contact}", workspace::FIRMWARE));
    variant.words().write_to(&variant.elf())?;
    let firmware = Firmware::read(&variant.elf())?;
    let uf2 = variant.uf2();
    fs::write(&uf2, uf2::from_loads(&firmware.loads, variant.chip()))
        .with_context(|| format!("cannot write {}", uf2.display()))?;
    Ok(firmware)
}

/// Builds the gantry's firmware and keeps a copy of its ELF under this name, for verbs that need several builds at
/// once.
pub fn kept_firmware(variant: Variant, name: &str) -> Result<PathBuf> {
    firmware(variant)?;
    keep(&variant.elf(), name)
}

/// Keeps a copy of an ELF under this name.
pub fn keep(elf: &Path, name: &str) -> Result<PathBuf> {
    let to = kept_elf(name);
    fs::create_dir_all(workspace::target_dir().join("firmware"))?;
    fs::copy(elf, &to).with_context(|| format!("cannot copy {} to {}", elf.display(), to.display()))?;
    Ok(to)
}

/// The path of the copy with this name.
pub fn kept_elf(name: &str) -> PathBuf {
    workspace::target_dir().join("firmware").join(name).with_extension("elf")
}

/// Builds the firmware that measures its own run time.
pub fn bench_firmware() -> Result<()> {
    link_package(workspace::FIRMWARE_TARGET, workspace::BENCH_FIRMWARE, &[])
}

/// Builds a board's package for this target, with these `features`. Each build of a package for a target overwrites the previous
/// one, whatever its features.
fn link_package(target: &str, package: &str, features: &[&str]) -> Result<()> {
    toolchain::add_target(target)?;
    let with = features.iter().map(|feature| format!(" +{feature}")).collect::<String>();
    announce(&format!("{package}{with} for {target}"));
    process::run(&mut toolchain::firmware_cargo("build", target, package, features))
}
