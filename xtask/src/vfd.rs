//! A VFD by another author: the simulated machine talks to a slave of pymodbus on a pseudo-terminal.

use std::path::Path;
use std::process::{Child, Command};
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use isostep::pty::Pty;
use isostep::stopwatch::Stopwatch;
use isostep_sim::{Config, Sim};

use crate::process::announce;

/// In real time; the machine's time stands meanwhile.
const STARTS_WITHIN_S: f64 = 20.0;
const ANSWERS_WITHIN_S: f64 = 2.0;
const LOOK: Duration = Duration::from_millis(2);
/// The reply to a read of five words, and to a write.
const READ_BYTES: usize = 15;
const WRITE_BYTES: usize = 8;

/// Ends the slave with the test.
struct Slave(Child);

impl Drop for Slave {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Runs the spindle both ways against the slave, and stops it. Every request has to be answered.
pub fn against_pymodbus(python: &Path, script: &Path) -> Result<()> {
    announce("pymodbus, simulated machine");
    let mut pty = Pty::open(None)?;
    let _slave = Slave(Command::new(python).arg(script).arg(pty.path()).spawn().context("Python does not start")?);
    let started = Stopwatch::start();
    while !pty.is_open() {
        pty.look()?;
        ensure!(started.elapsed_s() < STARTS_WITHIN_S, "the slave does not open {}", pty.path().display());
        look();
    }
    let mut config = Config::default();
    (config.settings.spindle_type, config.settings.spindle_max_rpm) = (2, 24_000.0);
    let mut sim = Sim::new(&config);
    sim.connect_vfd(move |sent| exchange(&mut pty, sent).unwrap_or_default());
    // It is asked before anything turns.
    run_ms(&mut sim, 200)?;
    for (line, report) in [("M3 S12000", "0,12000,12000"), ("M4 S6000", "0,6000,6000"), ("S18000", "0,18000,18000")] {
        says(&mut sim, line, report)?;
    }
    says(&mut sim, "M5", "0,0,0")?;
    sim.send(b"$VFD\n");
    run_ms(&mut sim, 100)?;
    let replies = sim.replies().join(" ");
    ensure!(replies.contains(" 0 times again"), "not every request was answered: {replies}");
    Ok(())
}

/// Sends a line, and half a second later expects the speeds in the report.
fn says(sim: &mut Sim, line: &str, speeds: &str) -> Result<()> {
    sim.send(format!("{line}\n").as_bytes());
    run_ms(sim, 500)?;
    sim.send(b"?");
    run_ms(sim, 1)?;
    let replies = sim.replies();
    let is_so = replies.iter().any(|reply| reply == "ok")
        && replies.iter().any(|reply| reply.contains(&format!("|FS:{speeds}")) && reply.starts_with("<Idle"));
    ensure!(is_so, "after {line} the machine says {replies:?}, and not {speeds}");
    Ok(())
}

/// Goes on in virtual time.
fn run_ms(sim: &mut Sim, ms: u64) -> Result<()> {
    Ok(sim.run_to(sim.now_ns() + ms * 1_000_000)?)
}

/// Waits until there may be something to see.
#[expect(clippy::disallowed_methods, reason = "the slave is another process, and runs in real time")]
fn look() {
    thread::sleep(LOOK);
}

/// The reply to a frame.
fn exchange(pty: &mut Pty, sent: &[u8]) -> Result<Vec<u8>> {
    let wanted = if sent.get(1) == Some(&3) { READ_BYTES } else { WRITE_BYTES };
    pty.write(sent)?;
    let (mut heard, asked) = (Vec::new(), Stopwatch::start());
    while heard.len() < wanted && asked.elapsed_s() < ANSWERS_WITHIN_S {
        heard.extend(pty.read()?);
        look();
    }
    Ok(heard)
}
