//! A machine on a pseudo-terminal for as long as somebody has work for it.

use std::path::Path;
use std::thread;

use super::bridge::{self, Drive, Tally};
use super::{Closing, Ending, Machine, Pty};
use anyhow::{Result, anyhow};

/// Runs the machine that `power_up` gives at `speed` while `client` uses the port of the path it is given; what the bridge
/// saw, and where the machine stands.
///
/// # Errors
/// The client's, or the machine's.
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
    // A machine that has failed is why its client has.
    seen.and_then(|seen| used.map(|()| seen))
}
