//! `cargo xtask flash`: writes the firmware to a board, by the first method that reaches one.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, bail};

use crate::process::{self, announce};
use crate::variant::Variant;
use crate::{build, workspace};
use isostep::boot_loader::{self, MOUNTING_S};
use isostep::chip::Chip;

/// Put the firmware on a board
#[derive(clap::Args)]
#[command(after_help = "\
The first of these that reaches a board is used:
  1. a debug probe, by probe-rs        cargo install probe-rs-tools --locked
  2. the boot drive                    hold BOOTSEL while you plug in the USB cable: RPI-RP2, of a Pico 2 RP2350
  3. picotool, the board in BOOTSEL    https://github.com/raspberrypi/picotool
  4. a board on USB that runs Isostep  it is asked for its boot drive, then as 2 or 3: no need to press BOOTSEL.
                                       It stops what it does and frees its motors; see that nothing falls

Examples:
  cargo xtask flash
  cargo xtask flash --board pico2      a Raspberry Pi Pico 2
  cargo xtask flash --driver tmc2209   faster drivers than DRV8825
  cargo xtask flash --estop nc         an emergency stop that opens when pressed
  cargo xtask flash --logs             stay attached to the probe and print the log
  cargo xtask flash --drive /mnt/pico  the boot drive is mounted in an unusual place")]
pub struct Args {
    /// Stay attached and print the firmware's log (needs a debug probe)
    #[arg(long, conflicts_with = "drive")]
    logs: bool,
    /// Folder at which the boot drive is mounted
    #[arg(long, value_name = "DIR")]
    drive: Option<PathBuf>,
    #[command(flatten)]
    variant: Variant,
}

pub fn run(args: Args) -> Result<()> {
    let Args { variant, .. } = args;
    build::firmware(variant)?;
    if let Some(drive) = &args.drive {
        return to_named_drive(variant, drive);
    }
    let no_probe = match probe() {
        Ok(()) => return by_probe(variant, args.logs),
        Err(missing) => missing,
    };
    if args.logs {
        bail!("--logs needs a debug probe: {no_probe}");
    }
    if let Some(drive) = boot_loader::mounted(variant.chip()) {
        return to_drive(variant, &drive);
    }
    let no_picotool = match picotool() {
        Ok(()) => return by_picotool(variant),
        Err(missing) => missing,
    };
    match boot_loader::running_board(variant.chip()) {
        Ok(port) => by_touch(variant, &port),
        Err(no_board) => bail!("no board was found.\n{}", missing(variant, &no_probe, &no_picotool, &no_board)),
    }
}

/// Makes the board on `port` enter its boot loader, then continues as with a board in BOOTSEL mode.
fn by_touch(variant: Variant, port: &str) -> Result<()> {
    let chip = variant.chip();
    announce(&format!("asking the board on {port} for its boot drive (the 1200-baud touch): it frees its motors"));
    announce(&format!("waiting for the drive {}, {MOUNTING_S} s at most", chip.drive()));
    if let Some(drive) = boot_loader::drive_of(port, chip)? {
        return to_drive(variant, &drive);
    }
    if boot_loader::running_board(chip).is_ok() {
        bail!(
            "the board on {port} runs on: its firmware knows no touch yet; hold BOOTSEL while you plug in the USB cable"
        );
    }
    picotool().map_or_else(|no_picotool| bail!(not_mounted(variant, &no_picotool)), |()| by_picotool(variant))
}

/// The error when the board is in its boot loader and its drive is not mounted.
fn not_mounted(variant: Variant, no_picotool: &str) -> String {
    format!(
        "the board has left for its boot loader, but no drive {} was mounted within {MOUNTING_S} s: mount it, and name it \
         with `cargo xtask flash --drive DIR` (picotool needs no drive, but {no_picotool}), or copy {} to it. \
         Switched off and on, the board runs as before",
        variant.chip().drive(),
        workspace::shown(&variant.uf2())
    )
}

/// Each method, why it did not work, and how to make it work.
fn missing(variant: Variant, no_probe: &str, no_picotool: &str, no_board: &str) -> String {
    format!(
        "  - debug probe: {no_probe}\n  \
         - boot drive:  {} is not mounted: hold BOOTSEL while you plug in the USB cable (one that carries data), \
         wait for the drive, and name it with --drive if it is mounted in an unusual place\n  \
         - picotool:    {no_picotool}\n  \
         - on USB:      {no_board}\n\
         The file to copy by hand is {}",
        variant.chip().drive(),
        workspace::shown(&variant.uf2())
    )
}

fn probe() -> Result<(), String> {
    match process::output(Command::new("probe-rs").arg("list"), "`cargo install probe-rs-tools --locked`") {
        Ok(list) if lists_a_probe(&list) => Ok(()),
        Ok(_) => Err("probe-rs sees none: plug one in (on Linux with its udev rules, https://probe.rs)".to_owned()),
        Err(error) => Err(format!("{error:#}")),
    }
}

/// `probe-rs list` prints a numbered line for each probe, `[0]: ...`.
fn lists_a_probe(list: &str) -> bool {
    list.lines().any(|line| line.trim_start().starts_with("[0]"))
}

fn by_probe(variant: Variant, logs: bool) -> Result<()> {
    // By the names of probe-rs.
    let chip = match variant.chip() {
        Chip::Rp2040 => "RP2040",
        Chip::Rp2350 => "RP235x",
    };
    let elf = variant.elf();
    let verbs: &[&str] = if logs { &["run"] } else { &["download", "reset"] };
    for verb in verbs {
        announce(&format!("probe-rs {verb}"));
        let mut command = Command::new("probe-rs");
        command.args([verb, "--chip", chip]);
        if *verb != "reset" {
            command.arg(&elf);
        }
        process::run(&mut command)?;
    }
    Ok(())
}

fn to_named_drive(variant: Variant, drive: &Path) -> Result<()> {
    let chip = variant.chip();
    if !boot_loader::is_one(drive, chip) {
        bail!(
            "{} is not the boot drive of an {} (no INFO_UF2.TXT that says {}): \
             hold BOOTSEL while you plug in the USB cable, then mount the drive",
            drive.display(),
            chip.name(),
            chip.drive()
        );
    }
    to_drive(variant, drive)
}

fn to_drive(variant: Variant, drive: &Path) -> Result<()> {
    boot_loader::copy(&variant.uf2(), drive)?;
    println!("The board restarts with the new firmware by itself.");
    Ok(())
}

fn picotool() -> Result<(), String> {
    let mut info = Command::new("picotool");
    process::output(info.arg("info"), "https://github.com/raspberrypi/picotool")
        .map(drop)
        .map_err(|error| format!("{error:#}"))
}

fn by_picotool(variant: Variant) -> Result<()> {
    announce("picotool load");
    process::run(Command::new("picotool").args(["load", "-u", "-v", "-x"]).arg(variant.uf2()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variant::Board;

    #[test]
    fn a_probe_is_recognised_in_the_list() {
        assert!(lists_a_probe("The following debug probes were found:\n[0]: Debug Probe (CMSIS-DAP) -- 2e8a:000c"));
        assert!(!lists_a_probe("No debug probes were found."));
    }

    #[test]
    fn the_serial_number_the_ids_and_the_rate_are_the_firmwares() {
        let firmware =
            |name: &str| std::fs::read_to_string(workspace::root().join("boards/pico-gantry/src").join(name)).unwrap();
        let number = format!("config.serial_number = Some(\"{}\");", boot_loader::SERIAL_NUMBER);
        assert!(firmware("usb.rs").contains(&number));
        for (chip, file) in Chip::ALL.into_iter().zip(["chip/rp2040.rs", "chip/rp2350.rs"]) {
            let (vendor, product) = chip.usb_ids();
            assert!(firmware("usb.rs").contains(&format!("const VENDOR_ID: u16 = {vendor:#06X};")));
            assert!(firmware(file).contains(&format!("pub const USB_PRODUCT_ID: u16 = {product:#06X};")), "{file}");
        }
        assert!(firmware("touch.rs").contains(&format!("const TOUCH_BAUD: u32 = {};", boot_loader::TOUCH_BAUD)));
    }

    #[test]
    fn what_is_missing_names_every_way_and_the_file() {
        let pico_2 = Variant { board: Board::Pico2, ..Variant::default() };
        let text = missing(Variant::default(), "no probe", "no picotool", "no running board");
        for part in
            ["RPI-RP2 is not", "thumbv6m", "no probe", "BOOTSEL", "no picotool", "no running board", "pico-gantry.uf2"]
        {
            assert!(text.contains(part), "{part} in {text}");
        }
        let text = not_mounted(pico_2, "no picotool");
        for part in ["no drive RP2350", "thumbv8m", "--drive", "no picotool", "pico-gantry.uf2"] {
            assert!(text.contains(part), "{part} in {text}");
        }
    }
}
