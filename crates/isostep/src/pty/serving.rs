//! Runs a machine on a pseudo-terminal while a client uses it.

use std::path::Path;
use std::thread;

use super::bridge::{self, Drive, Tally};
use super::{Closing, Ending, Machine, Pty};
use anyhow::{Result, anyhow};

/// Runs the machine that `power_up` returns at `speed`, while `client` uses the port whose path it receives. Returns
/// the bridge's counts and where the machine stands.
///
/// # Errors
/// The error of the machine, or that of the client.
pub fn while_running<M: Machine>(
    speed: f64,
    power_up: impl FnOnce() -> Result<M> + Send + 'static,
    client: impl FnOnce(&Path) -> Result<()>,
) -> Result<(Tally, Closing)> {
    let mut pty = Pty::open(None)?;
    let path = pty.path().to_owned();
    let ending = Ending::default();
    let asked = ending.clone();
    let machine = thread::spawn(move || {
        let mut machine = power_up()?;
        let tally = bridge::run(&mut machine, &mut pty, Drive { speed, end_ns: u64::MAX }, &asked)?;
        Ok((tally, machine.close()?))
    });
    let used = client(&path);
    ending.ask();
    let seen = machine.join().map_err(|_| anyhow!("the machine broke down"))?;
    // If both have failed, the machine's failure is the cause of the client's.
    seen.and_then(|seen| used.map(|()| seen))
}
