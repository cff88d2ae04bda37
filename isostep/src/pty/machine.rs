//! What the bridge runs.

use anyhow::Result;

/// A machine with a console, run in steps.
pub trait Machine {
    /// Its time, ns since power-up.
    fn now_ns(&self) -> u64;

    /// How many bytes sent to it are still on their way.
    fn unread(&self) -> usize;

    /// The first client has opened the port, or the last one has closed it. Whether the console begins anew for that.
    fn set_open(&mut self, open: bool) -> Result<bool>;

    /// Puts bytes on the wire to it, at the present instant.
    fn send(&mut self, bytes: &[u8]) -> Result<()>;

    /// Runs to that machine time, not at all when it is past; what it said meanwhile.
    fn run_to(&mut self, at_ns: u64) -> Result<Vec<u8>>;

    /// Where it stands at the end.
    fn close(&mut self) -> Result<Closing>;
}

/// Where a machine stands at its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Closing {
    /// Its state, or its alarm in words.
    pub state: String,
    /// As it reports it.
    pub position_mm: [f64; 3],
    /// Counted from its edges, since power-up or homing.
    pub position_steps: [i32; 3],
    /// Made per axis, both ways.
    pub steps: [u64; 3],
    /// What the motors lost, where that is modelled.
    pub steps_lost: Option<u64>,
    /// Edges that a driver may misread.
    pub timing_violations: u64,
}
