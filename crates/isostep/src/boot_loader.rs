//! The boot loader of a chip: a running board is asked for it over USB by the 1200-baud touch, so that nobody has to press BOOTSEL.
//! It is a drive; whoever copies a UF2 file for this chip onto it gives the chip a new image.

use std::path::{Path, PathBuf};
use std::{env, fs};

use anyhow::{Context, Result, anyhow, bail};
use serialport::{SerialPortInfo, SerialPortType};

use crate::chip::Chip;
use crate::console::port;
use crate::project;
use crate::stopwatch::within;

/// The serial number in boards/pico-gantry/src/usb.rs. The USB ids alone are shared by all firmware with a serial
/// port on these chips, and firmware of another project must not be overwritten.
pub const SERIAL_NUMBER: &str = "ISOSTEP-1";
/// The rate at which a port is opened to ask for the boot loader.
pub const TOUCH_BAUD: u32 = 1200;
const USUAL_BAUD: u32 = 115_200;
/// A board takes up to two seconds to enter its boot loader, and a desktop takes longer to mount the drive.
pub const MOUNTING_S: f64 = 15.0;
/// A board that starts is on USB after a second or two.
const STARTING_S: f64 = 15.0;

/// The port of the running board with this chip.
///
/// # Errors
/// The reason why no board can be touched, in words.
pub fn running_board(chip: Chip) -> Result<String, String> {
    let ports = port::all().map_err(|error| format!("{error:#}"))?;
    choose(&ports, chip)
}

fn choose(ports: &[SerialPortInfo], chip: Chip) -> Result<String, String> {
    let mut boards = ports.iter().filter(|port| runs_isostep(port, chip));
    match (boards.next(), boards.next()) {
        (Some(board), None) => Ok(board.port_name.clone()),
        (None, _) => Err(format!("no board with an {} runs Isostep (serial number {SERIAL_NUMBER})", chip.name())),
        (Some(one), Some(other)) => {
            Err(format!("{} and {} both run Isostep: unplug all but one", one.port_name, other.port_name))
        }
    }
}

fn runs_isostep(port: &SerialPortInfo, chip: Chip) -> bool {
    let SerialPortType::UsbPort(usb) = &port.port_type else { return false };
    (usb.vid, usb.pid) == chip.usb_ids() && usb.serial_number.as_deref() == Some(SERIAL_NUMBER)
}

/// Opens the port at 1200 baud and lowers DTR, like a program that closes the port.
///
/// # Errors
/// When another program has the port open, or when the port is gone.
pub fn touch(name: &str) -> Result<()> {
    let mut port = port::open(name, TOUCH_BAUD)?;
    port.write_data_terminal_ready(false).with_context(|| format!("{name} takes no DTR"))?;
    // The system keeps a port's rate for the next program that opens it. That program would touch the new firmware when
    // it closes the port. The call may fail because the board is already gone.
    let _ = port.set_baud_rate(USUAL_BAUD);
    Ok(())
}

/// Asks the board with this chip on a port for its boot drive. Returns where the drive is mounted, if it is in time.
///
/// # Errors
/// As [`touch`].
pub fn drive_of(port: &str, chip: Chip) -> Result<Option<PathBuf>> {
    touch(port)?;
    Ok(within(MOUNTING_S, || mounted(chip)))
}

/// The drive of a chip, if one is mounted in a usual place.
pub fn mounted(chip: Chip) -> Option<PathBuf> {
    places(chip.drive()).into_iter().find(|place| is_one(place, chip))
}

/// This folder is the drive of such a chip. Every one in BOOTSEL mode describes itself in a file.
pub fn is_one(place: &Path, chip: Chip) -> bool {
    fs::read_to_string(place.join("INFO_UF2.TXT")).is_ok_and(|info| info.contains(chip.drive()))
}

/// The folders in which Linux, macOS and Windows mount a drive of this name.
fn places(name: &str) -> Vec<PathBuf> {
    let user = env::var("USER").unwrap_or_default();
    let linux = ["/media", "/run/media"].map(|dir| Path::new(dir).join(&user).join(name));
    let others = ["/media", "/mnt", "/Volumes"].map(|dir| Path::new(dir).join(name));
    let windows = ('D'..='Z').map(|letter| PathBuf::from(format!("{letter}:\\")));
    linux.into_iter().chain(others).chain(windows).collect()
}

/// Finds a board that an image for this chip could be put on: in its boot loader, on `port`, or the only one that runs Isostep.
///
/// # Errors
/// When there is none; the error says what to do.
pub fn find(port: Option<&str>, chip: Chip) -> Result<()> {
    match port {
        _ if mounted(chip).is_some() => Ok(()),
        Some(name) => port::find(name),
        None => only_board(chip).map(drop),
    }
}

fn only_board(chip: Chip) -> Result<String> {
    running_board(chip).map_err(|why| anyhow!("{why}; or hold BOOTSEL while you plug it in"))
}

/// Copies an image onto the drive of a board, which starts it by itself.
///
/// # Errors
/// When it cannot be copied.
pub fn copy(image: &Path, drive: &Path) -> Result<()> {
    println!("copying {} to {}", project::shown(image), drive.display());
    fs::copy(image, drive.join("firmware.uf2")).with_context(|| format!("cannot copy to {}", drive.display())).map(drop)
}

/// Puts `image` on the board on `port`, or on the only one with its chip that runs Isostep or is in its boot loader already. Returns
/// the port on which it is afterwards.
///
/// # Errors
/// When there is no board, or its drive is not mounted; the error says what to do.
pub fn put(image: &Path, port: Option<&str>) -> Result<String> {
    let chip = Chip::of_image(image)?;
    let drive = match mounted(chip) {
        Some(drive) => drive,
        None => {
            let name = port.map_or_else(|| only_board(chip), |port| Ok(port.to_owned()))?;
            println!("asking the board on {name} for its boot drive: it stops what it does and frees its motors");
            drive_of(&name, chip)?.with_context(|| {
                format!("no drive {} was mounted within {MOUNTING_S} s: hold BOOTSEL while you plug in the USB cable, mount the drive, and start anew", chip.drive())
            })?
        }
    };
    copy(image, &drive)?;
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

#[cfg(test)]
mod tests {
    use serialport::UsbPortInfo;

    use super::*;

    fn port(name: &str, serial_number: Option<&str>) -> SerialPortInfo {
        let serial_number = serial_number.map(str::to_owned);
        let usb = UsbPortInfo { vid: 0x2E8A, pid: 0x000A, serial_number, manufacturer: None, product: None };
        SerialPortInfo { port_name: name.into(), port_type: SerialPortType::UsbPort(usb) }
    }

    #[test]
    fn the_only_board_that_runs_isostep_is_found_among_other_rp2040s() {
        let (ours, other) = (port("/dev/ttyACM1", Some("ISOSTEP-1")), port("/dev/ttyACM0", Some("E6605838831A2B2C")));
        let plain = SerialPortInfo { port_name: "/dev/ttyS0".into(), port_type: SerialPortType::Unknown };
        let choose = |ports: &[SerialPortInfo]| choose(ports, Chip::Rp2040);
        assert_eq!(choose(&[other.clone(), plain.clone(), ours.clone()]).unwrap(), "/dev/ttyACM1");
        let none = choose(&[other, plain, port("/dev/ttyACM2", None)]).unwrap_err();
        assert!(none.contains("no board with an RP2040 runs Isostep"), "{none}");
        let two = choose(&[ours.clone(), port("/dev/ttyACM3", Some("ISOSTEP-1"))]).unwrap_err();
        assert!(two.contains("/dev/ttyACM1 and /dev/ttyACM3") && two.contains("unplug"), "{two}");
        let mut pico_2 = port("/dev/ttyACM4", Some("ISOSTEP-1"));
        if let SerialPortType::UsbPort(usb) = &mut pico_2.port_type {
            usb.pid = 0x0009;
        }
        let both = [ours, pico_2];
        assert_eq!(choose(&both).unwrap(), "/dev/ttyACM1");
        assert_eq!(super::choose(&both, Chip::Rp2350).unwrap(), "/dev/ttyACM4");
    }

    #[test]
    fn a_port_that_is_not_there_says_so() {
        let error = touch("/dev/there-is-no-such-port").unwrap_err();
        assert!(error.to_string().contains("/dev/there-is-no-such-port: "), "{error:#}");
    }

    /// A pseudo-terminal has no modem lines. A port that is not on USB is not mistaken for a board that was touched.
    #[cfg(unix)]
    #[test]
    fn a_port_without_dtr_is_not_touched() {
        let (_master, name) = serialport::TTYPort::pair()
            .map(|(master, slave)| (master, serialport::SerialPort::name(&slave).unwrap()))
            .unwrap();
        let error = touch(&name).unwrap_err();
        assert!(error.to_string().starts_with(&name), "{error:#}");
    }

    #[test]
    fn a_boot_drive_is_told_by_its_description() {
        let dir = env::temp_dir().join(format!("isostep-drive-{}", std::process::id()));
        fs::create_dir_all(&dir).unwrap();
        let is_of = || Chip::ALL.map(|chip| is_one(&dir, chip));
        assert_eq!(is_of(), [false; 2]);
        let describe = |text| fs::write(dir.join("INFO_UF2.TXT"), text).unwrap();
        describe("UF2 Bootloader v2.0\nModel: Raspberry Pi RP2\nBoard-ID: RPI-RP2\n");
        assert_eq!(is_of(), [true, false]);
        describe("UF2 Bootloader v1.0\nModel: Raspberry Pi RP2350\nBoard-ID: RP2350\n");
        assert_eq!(is_of(), [false, true]);
        fs::remove_dir_all(dir).unwrap();
    }
}
