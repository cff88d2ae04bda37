//! The 1200-baud touch: asks a running board over USB to start its boot loader, so that nobody has to press BOOTSEL.

use anyhow::{Context, Result};
use serialport::{SerialPortInfo, SerialPortType};

use crate::console::port;

/// The serial number in boards/rp2040-gantry/src/usb.rs. The USB ids alone are shared by all RP2040 firmware with a
/// serial port, and firmware of another project must not be overwritten.
pub const SERIAL_NUMBER: &str = "ISOSTEP-1";
/// The rate at which a port is opened to ask for the boot loader.
pub const TOUCH_BAUD: u32 = 1200;
const USUAL_BAUD: u32 = 115_200;

/// The port of the running board.
///
/// # Errors
/// The reason why no board can be touched, in words.
pub fn running_board() -> Result<String, String> {
    let ports = port::all().map_err(|error| format!("{error:#}"))?;
    choose(&ports)
}

fn choose(ports: &[SerialPortInfo]) -> Result<String, String> {
    let mut boards = ports.iter().filter(|port| runs_isostep(port));
    match (boards.next(), boards.next()) {
        (Some(board), None) => Ok(board.port_name.clone()),
        (None, _) => Err(format!("no board runs Isostep (serial number {SERIAL_NUMBER})")),
        (Some(one), Some(other)) => {
            Err(format!("{} and {} both run Isostep: unplug all but one", one.port_name, other.port_name))
        }
    }
}

fn runs_isostep(port: &SerialPortInfo) -> bool {
    matches!(&port.port_type, SerialPortType::UsbPort(usb) if usb.serial_number.as_deref() == Some(SERIAL_NUMBER))
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
        assert_eq!(choose(&[other.clone(), plain.clone(), ours.clone()]).unwrap(), "/dev/ttyACM1");
        let none = choose(&[other, plain, port("/dev/ttyACM2", None)]).unwrap_err();
        assert!(none.contains("no board runs Isostep"), "{none}");
        let two = choose(&[ours, port("/dev/ttyACM3", Some("ISOSTEP-1"))]).unwrap_err();
        assert!(two.contains("/dev/ttyACM1 and /dev/ttyACM3") && two.contains("unplug"), "{two}");
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
}
