//! A simulated machine on a pseudo-terminal for as long as somebody has work for it.

use std::path::Path;
use std::thread;

use anyhow::{Result, anyhow};
use isostep_sim::Config;

use super::bridge::{self, Drive, Tally};
use super::simulated::Simulated;
use super::{Closing, Ending, Machine, Pty};

/// Runs the default machine at `speed` while `client` uses the port of the path it is given; what the bridge saw, and
/// where the machine stands.
///
/// # Errors
/// The client's, or the machine's.
pub fn while_running(speed: f64, client: impl FnOnce(&Path) -> Result<()>) -> Result<(Tally, Closing)> {
    let mut pty = Pty::open(None)?;
    let path = pty.path().to_owned();
    let ending = Ending::default();
    let asked = ending.clone();
    let machine = thread::spawn(move || {
        let mut machine = Simulated::new(Config { keep_record: false, ..Config::default() });
        let tally = bridge::run(&mut machine, &mut pty, Drive { speed, end_ns: u64::MAX }, &asked)?;
        Ok((tally, machine.close()?))
    });
    let used = client(&path);
    ending.ask();
    let seen = machine.join().map_err(|_| anyhow!("the simulated machine broke down"))?;
    used.and(seen)
}
