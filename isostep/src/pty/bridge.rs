//! A machine and a port, and the wall clock between them.

use anyhow::Result;
use isostep_sim::link::Lines;

use super::pace::Pace;
use super::port::Pty;
use super::{Ending, Machine};
use crate::flight::Flight;

/// What a serial port's driver buffers on the way out: a client that sends on has to wait, as with a real port.
const DRIVER_BYTES: usize = 4096;

/// What went over the port.
#[derive(Debug, Default)]
pub struct Tally {
    /// From the clients.
    pub bytes_in: u64,
    /// From the machine, whether or not anybody listened.
    pub bytes_out: u64,
    /// Of them, those that a client did not take in time.
    pub dropped_bytes: u64,
    /// How often a client came; 0 where nobody tells.
    pub clients: u32,
    /// The lines and their answers.
    pub flight: Flight,
    /// By how much wall time the machine was too slow, s.
    pub behind_s: f64,
}

/// How long, and how fast.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    /// Seconds of the machine in a second.
    pub speed: f64,
    /// Machine time at which it ends by itself, ns since power-up.
    pub end_ns: u64,
}

/// Runs the machine in time with the wall clock, its console on the port, until it is asked to end.
///
/// # Errors
/// Those of the machine and of the port.
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
        // Before the client's leaving counts: what it sent is still to be carried out.
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
