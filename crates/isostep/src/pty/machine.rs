//! The interface between the bridge and a machine.

use anyhow::Result;
use isostep_sim::AXES;

/// A machine with a console, run in steps of time.
pub trait Machine {
    /// Machine time, ns since power-up.
    fn now_ns(&self) -> u64;

    /// The number of bytes sent to the machine that have not arrived yet.
    fn unread(&self) -> usize;

    /// Notes that the first client has opened the port, or that the last one has closed it. Returns whether the console
    /// restarts because of that.
    fn set_open(&mut self, open: bool) -> Result<bool>;

    /// Sends bytes to the machine, starting now.
    fn send(&mut self, bytes: &[u8]) -> Result<()>;

    /// Runs to this machine time, or not at all if it has passed. Returns what the machine has sent meanwhile.
    fn run_to(&mut self, at_ns: u64) -> Result<Vec<u8>>;

    /// Ends the machine, and returns where it stands.
    fn close(&mut self) -> Result<Closing>;
}

/// The state of a machine at its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Closing {
    /// The state, or the alarm in words.
    pub state: String,
    /// The position that the machine reports.
    pub position_mm: [f64; AXES],
    /// The position counted from the edges since power-up or homing.
    pub position_steps: [i32; AXES],
    /// Steps made per axis, in both directions.
    pub steps: [u64; AXES],
    /// Steps that the motors lost, where that is modelled.
    pub steps_lost: Option<u64>,
    /// Number of edges that a motor driver may misread.
    pub timing_violations: u64,
}
