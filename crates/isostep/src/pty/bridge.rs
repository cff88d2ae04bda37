//! Connects a machine with a port, and paces the machine to the wall clock.

use anyhow::Result;
use isostep_sim::link::Lines;

use super::pace::Pace;
use super::port::Pty;
use super::{Ending, Machine};
use crate::flight::Flight;

/// Size of the output buffer of a serial port's driver. A client that sends more has to wait, as with a real port.
const DRIVER_BYTES: usize = 4096;

/// Counts of the traffic on the port.
#[derive(Debug, Default)]
pub struct Tally {
    /// Bytes from the clients.
    pub bytes_in: u64,
    /// Bytes from the machine, whether or not a client read them.
    pub bytes_out: u64,
    /// The part of `bytes_out` that a client did not take in time.
    pub dropped_bytes: u64,
    /// The times that a client opened the port; 0 where the system does not report it.
    pub clients: u32,
    /// The lines and their answers.
    pub flight: Flight,
    /// The wall time by which the machine was too slow, s.
    pub behind_s: f64,
}

/// The speed of the machine and the time at which it ends.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    /// Seconds of machine time per second of wall time.
    pub speed: f64,
    /// Machine time at which the run ends by itself, ns since power-up.
    pub end_ns: u64,
}

/// Runs the machine in step with the wall clock, with its console on the port, until it is asked to end.
///
/// # Errors
/// Errors of the machine and of the port.
pub fn run(machine: &mut impl Machine, pty: &mut Pty, drive: Drive, ending: &Ending) -> Result<Tally> {
    let mut tally = Tally::default();
    let mut lines = Lines::default();
    let mut pace = Pace::new(drive.speed);
    while machine.now_ns() < drive.end_ns && !ending.is_asked() {
        let change = pty.look()?;
        if change.came {
            tally.clients += 1;
            if machine.set_open(true)? {
                tally.flight.restart();
            }
        }
        // Read before `set_open(false)`: what the client sent before it left must still be carried out.
        if machine.unread() < DRIVER_BYTES {
            let bytes = pty.read()?;
            tally.bytes_in += bytes.len() as u64;
            tally.flight.sent(&bytes);
            machine.send(&bytes)?;
        }
        let said = machine.run_to(pace.next_ns(machine.now_ns()).min(drive.end_ns))?;
        tally.bytes_out += said.len() as u64;
        for line in lines.push(&said) {
            tally.flight.heard(&line);
        }
        pty.write(&said)?;
        if change.left && !pty.is_open() {
            machine.set_open(false)?;
        }
        pace.rest(machine.now_ns());
    }
    tally.dropped_bytes = pty.dropped_bytes();
    tally.behind_s = pace.behind_s();
    Ok(tally)
}
