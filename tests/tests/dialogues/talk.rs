//! How a test talks with the simulated machine.

use embassy_time::Duration;
use isostep_sim::{Config, Sim};

/// A machine 50 ms after power-up; what it said so far is still to be heard.
pub fn switched_on(config: &Config) -> Sim {
    let mut sim = Sim::new(config);
    sim.run_for(Duration::from_millis(50)).unwrap();
    sim
}

/// A machine that has just said its welcome.
pub fn powered_up(config: &Config) -> Sim {
    let mut sim = switched_on(config);
    assert_eq!(sim.replies(), ["Grbl 1.1h ['$' for help]"]);
    sim
}

/// The default machine, homed.
pub fn homed() -> Sim {
    let mut sim = powered_up(&Config::default());
    assert_eq!(say(&mut sim, "$H"), ["ok"]);
    sim
}

/// Sends a line and returns what was heard until nothing moves.
pub fn say(sim: &mut Sim, line: &str) -> Vec<String> {
    sim.send(line.as_bytes());
    sim.send(b"\n");
    sim.run_until_idle().unwrap();
    sim.replies()
}

/// Sends a line and returns what was heard a little later.
pub fn begin(sim: &mut Sim, line: &str, wait: Duration) -> Vec<String> {
    sim.send(line.as_bytes());
    sim.send(b"\n");
    sim.run_for(wait).unwrap();
    sim.replies()
}

/// The first part of a status report: state and position.
pub fn status(sim: &mut Sim) -> String {
    sim.send(b"?");
    sim.run_for(Duration::from_millis(1)).unwrap();
    let reply = sim.replies().pop().expect("a status report");
    reply.split('|').take(2).collect::<Vec<_>>().join("|")
}
