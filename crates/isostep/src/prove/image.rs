//! Puts an image on the board by its boot loader: the 1200-baud touch, then a copy onto the drive that appears.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};

use crate::boot_drive;
use crate::console::port;
use crate::project;
use crate::stopwatch::within;
use crate::touch;

/// A board takes up to two seconds to enter its boot loader, and a desktop takes longer to mount the drive.
const MOUNTING_S: f64 = 15.0;
/// A board that starts is on USB after a second or two.
const STARTING_S: f64 = 15.0;

/// Whether there is a board that an image could be put on: in its boot loader, on `port`, or the only one that runs Isostep.
///
/// # Errors
/// When there is none; the error says what to do.
pub fn find(port: Option<&str>) -> Result<()> {
    match port {
        _ if boot_drive::mounted().is_some() => Ok(()),
        Some(name) => port::find(name),
        None => running_board().map(drop),
    }
}

fn running_board() -> Result<String> {
    touch::running_board().map_err(|why| anyhow::anyhow!("{why}; or hold BOOTSEL while you plug it in"))
}

/// Puts `image` on the board on `port`, or on the only one that runs Isostep or is in its boot loader already. Returns
/// the port on which it is afterwards.
///
/// # Errors
/// When there is no board, or its drive is not mounted; the error says what to do.
pub fn put(image: &Path, port: Option<&str>) -> Result<String> {
    let shown = project::shown(image);
    fs::metadata(image).with_context(|| format!("{shown} cannot be read: name a UF2 file"))?;
    let drive = match boot_drive::mounted() {
        Some(drive) => drive,
        None => {
            let name = match port {
                Some(port) => port.to_owned(),
                None => running_board()?,
            };
            println!("asking the board on {name} for its boot drive: it stops what it does and frees its motors");
            touch::touch(&name)?;
            within(MOUNTING_S, boot_drive::mounted).with_context(|| {
                format!("no drive RPI-RP2 was mounted within {MOUNTING_S} s: hold BOOTSEL while you plug in the USB cable, mount the drive, and start anew")
            })?
        }
    };
    println!("copying {shown} to {}", drive.display());
    fs::copy(image, drive.join("image.uf2")).with_context(|| format!("cannot copy to {}", drive.display()))?;
    let is_there = || match port {
        Some(port) => Path::new(port).exists().then(|| port.to_owned()),
        None => port::find_board().ok(),
    };
    match within(STARTING_S, is_there) {
        Some(port) => Ok(port),
        None => bail!(
            "the board has not come back on USB within {STARTING_S} s: unplug it, plug it in, and start anew without --image"
        ),
    }
}
