//! Finds and opens a serial port.

use std::io::ErrorKind as Io;
use std::time::Duration;

use anyhow::{Result, anyhow, bail, ensure};
use serialport::{Error, ErrorKind, SerialPort, SerialPortInfo, SerialPortType, UsbPortInfo};

use crate::chip::Chip;

/// Time that a read waits for a byte.
const PATIENCE: Duration = Duration::from_millis(20);
const WITHOUT_HARDWARE: &str = "without hardware: `isostep sim --pty` in another terminal, and the port it prints";

/// The serial ports of this computer, sorted by name. macOS lists each port twice; the one for calling out is kept.
pub fn all() -> Result<Vec<SerialPortInfo>> {
    let mut ports =
        serialport::available_ports().map_err(|error| anyhow!("the serial ports cannot be listed: {error}"))?;
    ports.retain(|port| !port.port_name.starts_with("/dev/tty."));
    ports.sort_by(|one, other| one.port_name.cmp(&other.port_name));
    Ok(ports)
}

/// The ports, one per line.
pub fn listed(ports: &[SerialPortInfo]) -> String {
    if ports.is_empty() {
        return format!("there is no serial port; {WITHOUT_HARDWARE}\n");
    }
    ports.iter().map(|port| format!("  {:<20} {}\n", port.port_name, kind(port))).collect()
}

fn kind(port: &SerialPortInfo) -> String {
    match &port.port_type {
        SerialPortType::UsbPort(usb) => {
            let name = usb.product.as_deref().unwrap_or("no name");
            format!("USB {:04x}:{:04x}, {name}", usb.vid, usb.pid)
        }
        SerialPortType::BluetoothPort => "Bluetooth".to_owned(),
        SerialPortType::PciPort => "PCI".to_owned(),
        SerialPortType::Unknown => "built in, or a converter".to_owned(),
    }
}

/// The port of the board, if exactly one is connected.
pub fn find_board() -> Result<String> {
    choose(&all()?)
}

fn choose(ports: &[SerialPortInfo]) -> Result<String> {
    let boards: Vec<_> = ports.iter().filter(|port| is_board(port)).collect();
    match boards.as_slice() {
        [board] => Ok(board.port_name.clone()),
        [] => bail!(
            "no board is on USB ({}): plug it in (with a data cable, not a charging one), or name a port\n{}",
            Chip::ALL.map(|chip| format!("{:04x}:{:04x}", chip.usb_ids().0, chip.usb_ids().1)).join(" or "),
            if ports.is_empty() { format!("  {WITHOUT_HARDWARE}") } else { listed(ports).trim_end().to_owned() }
        ),
        several => bail!("{} boards are there: name the port\n{}", several.len(), listed(ports).trim_end()),
    }
}

fn is_board(port: &SerialPortInfo) -> bool {
    let SerialPortType::UsbPort(UsbPortInfo { vid, pid, .. }) = &port.port_type else { return false };
    Chip::ALL.into_iter().any(|chip| chip.usb_ids() == (*vid, *pid))
}

/// Finds the port. It is not opened, which a board would see.
///
/// # Errors
/// When there is none; the error says what to do.
pub fn find(name: &str) -> Result<()> {
    let is_there = if cfg!(windows) {
        all()?.iter().any(|port| port.port_name.eq_ignore_ascii_case(name))
    } else {
        std::path::Path::new(name).exists()
    };
    ensure!(is_there, "{name}: {}", trouble(&Error::new(ErrorKind::Io(Io::NotFound), "")));
    Ok(())
}

/// Opens the port for exclusive use and raises DTR.
pub fn open(name: &str, baud: u32) -> Result<Box<dyn SerialPort>> {
    let open = |baud| serialport::new(name, baud).timeout(PATIENCE).dtr_on_open(true).open();
    // On macOS a pseudo-terminal refuses every baud rate; 0 leaves the rate unchanged.
    let opened = open(baud).or_else(|error| if cfg!(target_os = "macos") { open(0) } else { Err(error) });
    opened.map_err(|error| anyhow!("{name}: {}", trouble(&error)))
}

/// Why a port cannot be opened, and how to fix it.
fn trouble(error: &Error) -> String {
    match error.kind() {
        ErrorKind::Io(Io::NotFound) => {
            format!("there is no such port: `isostep console --list` shows them; {WITHOUT_HARDWARE}")
        }
        ErrorKind::Io(Io::PermissionDenied) if cfg!(windows) => {
            "another program has it: close that first (a sender, a serial monitor)".to_owned()
        }
        ErrorKind::Io(Io::PermissionDenied) => {
            "you may not use it: join the group that owns it (`sudo usermod -aG dialout \
                                                $USER`, on Arch uucp), then log in anew"
                .to_owned()
        }
        // On Unix this error means that another program holds a lock on the port; on Windows, that the port is gone.
        ErrorKind::NoDevice if cfg!(unix) => {
            "another program has it: close that first (a sender, a serial monitor)".to_owned()
        }
        ErrorKind::NoDevice => {
            format!("there is no such port: `isostep console --list` shows them; {WITHOUT_HARDWARE}")
        }
        _ => format!("it cannot be opened as a serial port: {error}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn port(name: &str, vid: u16, pid: u16) -> SerialPortInfo {
        let usb = UsbPortInfo { vid, pid, serial_number: None, manufacturer: None, product: Some("A thing".into()) };
        SerialPortInfo { port_name: name.into(), port_type: SerialPortType::UsbPort(usb) }
    }

    #[test]
    fn the_only_board_is_found_among_other_things() {
        let (board, other) = (port("/dev/ttyACM1", 0x2E8A, 0x000A), port("/dev/ttyUSB0", 0x1A86, 0x7523));
        assert_eq!(choose(&[other.clone(), board.clone()]).unwrap(), "/dev/ttyACM1");
        let none = choose(&[other]).unwrap_err().to_string();
        assert!(
            none.contains("no board is on USB (2e8a:000a or 2e8a:0009)") && none.contains("/dev/ttyUSB0"),
            "{none}"
        );
        assert_eq!(choose(&[port("/dev/ttyACM2", 0x2E8A, 0x0009)]).unwrap(), "/dev/ttyACM2");
        let two = choose(&[board.clone(), board]).unwrap_err().to_string();
        assert!(two.contains("2 boards") && two.contains("/dev/ttyACM1"), "{two}");
        assert!(choose(&[]).unwrap_err().to_string().contains("isostep sim --pty"));
    }

    #[test]
    fn a_port_that_is_not_there_is_reported_without_opening_it() {
        let reported = find("/dev/nope").unwrap_err().to_string();
        assert!(
            reported.starts_with("/dev/nope: there is no such port: `isostep console --list` shows them"),
            "{reported}"
        );
        if cfg!(unix) {
            find("/dev/null").unwrap();
        }
    }

    #[test]
    fn each_trouble_has_its_remedy() {
        let remedy = |kind| trouble(&Error::new(kind, "x"));
        assert!(remedy(ErrorKind::Io(Io::NotFound)).contains("no such port"));
        if cfg!(unix) {
            assert!(remedy(ErrorKind::Io(Io::PermissionDenied)).contains("dialout"));
            assert!(remedy(ErrorKind::NoDevice).contains("another program has it"));
        }
        assert!(remedy(ErrorKind::Unknown).contains("cannot be opened"));
    }
}
