//! A simulated machine, and what it says to lines.

use isostep_sim::{Config, Sim};

/// The machine when it has started.
///
/// # Panics
/// If it does not come to rest.
#[must_use]
pub fn machine(config: &Config) -> Sim {
    let mut sim = Sim::new(config);
    sim.run_until_idle().unwrap();
    sim
}

/// Carries out lines one by one, and returns what the machine says to the last.
///
/// # Panics
/// If it does not come to rest.
#[track_caller]
pub fn say(sim: &mut Sim, lines: &str) -> Vec<String> {
    for line in lines.lines() {
        sim.replies();
        sim.send(format!("{line}\n").as_bytes());
        sim.run_until_idle().unwrap_or_else(|error| panic!("`{line}`: {error}"));
    }
    sim.replies()
}
