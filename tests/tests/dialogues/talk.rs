//! Functions for a dialogue with the simulated machine.

use embassy_time::Duration;
use isostep_sim::{Config, Sim};

use crate::heard::Heard;

/// A machine 50 ms after power-up. Its messages have not been read yet.
pub fn switched_on(config: &Config) -> Sim {
    let mut sim = Sim::new(config);
    sim.run_for(Duration::from_millis(50)).unwrap();
    sim
}

/// A machine that has just sent its welcome.
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

/// Sends a line and returns everything received until nothing moves.
#[track_caller]
pub fn say(sim: &mut Sim, line: &str) -> Heard {
    sim.send(line.as_bytes());
    sim.send(b"\n");
    sim.run_until_idle().unwrap_or_else(|error| panic!("`{line}` came to no rest: {error}"));
    Heard::new(line.as_bytes(), sim.replies())
}

/// Sends a line and returns everything received within `wait`.
pub fn begin(sim: &mut Sim, line: &str, wait: Duration) -> Heard {
    sim.send(line.as_bytes());
    sim.send(b"\n");
    sim.run_for(wait).unwrap();
    Heard::new(line.as_bytes(), sim.replies())
}

/// The first part of a status report: state and position.
#[track_caller]
pub fn status(sim: &mut Sim) -> String {
    let heard = bytes(sim, b"?");
    heard.last_line().split('|').take(2).collect::<Vec<_>>().join("|")
}

/// Sends bytes and returns everything received within a millisecond.
pub fn bytes(sim: &mut Sim, bytes: &[u8]) -> Heard {
    sim.send(bytes);
    sim.run_for(Duration::from_millis(1)).unwrap();
    Heard::new(bytes, sim.replies())
}

/// The next status report, complete.
#[track_caller]
pub fn report(sim: &mut Sim) -> String {
    let heard = bytes(sim, b"?");
    let report = heard.iter().find(|line| line.starts_with('<'));
    report.unwrap_or_else(|| panic!("{heard:?}, where a status report was expected")).clone()
}

/// The name of the machine's state.
#[track_caller]
pub fn state(sim: &mut Sim) -> String {
    let report = report(sim);
    report[1..].split('|').next().unwrap().to_owned()
}

/// The value of a field of the status reports, in the first one that has it.
#[track_caller]
pub fn field(sim: &mut Sim, name: &str) -> String {
    let mut last = String::new();
    for _ in 0..40 {
        last = report(sim);
        let fields = last.trim_end_matches('>').split('|');
        if let Some(value) = fields.filter_map(|field| field.strip_prefix(name)).next() {
            return value.trim_start_matches(':').to_owned();
        }
    }
    panic!("no report has {name}: the last of 40 is {last}");
}

/// Sends a line that must be answered with the error, preceded only by messages.
#[track_caller]
pub fn refused(sim: &mut Sim, line: &str, code: u8) {
    let heard = say(sim, line);
    assert_eq!(heard.last_line(), format!("error:{code}"), "{heard:?}");
    let before = &heard[..heard.len() - 1];
    assert!(
        before.iter().all(|line| line.starts_with("[MSG:")),
        "{heard:?}, where messages and an error were expected"
    );
}

/// The value of a tool output that is on.
pub const ON: u16 = u16::MAX;

/// The duty for a fraction of the full one.
pub fn duty(ratio: f64) -> u16 {
    (ratio * f64::from(ON)).round() as u16
}

/// The time resolution of [`watch`], us.
pub const LOOK_US: u64 = 10;

/// The changes of the tool's outputs within `time`, each with an instant in us since power-up. The change came at most
/// [`LOOK_US`] before that instant.
pub fn watch(sim: &mut Sim, time: Duration) -> Vec<(u64, [u16; 5])> {
    let mut changes = Vec::new();
    let mut before = sim.tool();
    for _ in 0..time.as_micros() / LOOK_US {
        sim.run_for(Duration::from_micros(LOOK_US)).unwrap();
        if sim.tool() != before {
            before = sim.tool();
            changes.push((sim.now().as_micros(), before));
        }
    }
    changes
}

/// Checks that an instant from the record matches that of a change seen by [`watch`].
pub fn assert_at(seen_us: u64, at_ns: u64, what: &str) {
    let at_us = at_ns as f64 * 1e-3;
    let late_us = seen_us as f64 - at_us;
    assert!((-1.0..=LOOK_US as f64 + 1.0).contains(&late_us), "{what}: at {at_us} us, seen at {seen_us} us");
}
